//! Which vertices have the same position.

use crate::mesh::{DVec3, bounds};

/// How far two vertices may be apart to count as one. The vertex that comes first in the file stands
/// for both; no other vertex is moved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Weld {
    /// A few units in the last place of the largest coordinate: of single precision in an STL file and
    /// where all coordinates are single precision numbers, else of double precision.
    #[default]
    Auto,
    /// This length, in the units of the file; 0 welds equal positions only.
    Within(f64),
}

/// Units in the last place by which [`Weld::Auto`] lets two vertices differ.
const UNITS: f64 = 4.0;

/// [`Weld::Auto`] never exceeds this part of the extent of the mesh, however far it is from the
/// origin.
const LARGEST: f64 = 1e-6;

impl Weld {
    /// The distance for the vertices of a file, in its units. `exploded`: whether it repeats them for
    /// every face, as STL does.
    pub(crate) fn tolerance(self, positions: &[DVec3], exploded: bool) -> f64 {
        if let Self::Within(length) = self {
            return length;
        }
        let (low, high) = bounds(positions.iter().copied());
        let is_single = |p: &DVec3| p.as_vec3().as_dvec3() == *p;
        let unit = if exploded || positions.iter().all(is_single) {
            f64::from(f32::EPSILON)
        } else {
            f64::EPSILON
        };
        let size = low.abs().max(high.abs()).max_element();
        (UNITS * unit * size).min(LARGEST * low.distance(high))
    }
}

impl std::str::FromStr for Weld {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse::<f64>() {
            _ if text == "auto" => Ok(Self::Auto),
            Ok(length) if length >= 0.0 && length.is_finite() => Ok(Self::Within(length)),
            _ => Err(format!(
                "`{text}` is neither auto nor a length of 0 or more"
            )),
        }
    }
}

const EMPTY: u32 = u32::MAX;

/// For each vertex the member that stands for its position (itself if it is no member), and how
/// many members another one stands for: the nearest within `tolerance` of those before it that
/// stand for themselves. 0 and −0 are the same.
pub(super) fn position_classes(
    positions: &[DVec3],
    members: impl ExactSizeIterator<Item = u32>,
    tolerance: f64,
) -> (Vec<u32>, usize) {
    let mut class: Vec<u32> = (0..positions.len() as u32).collect();
    let mask = (2 * members.len()).next_power_of_two() - 1;
    let mut table = vec![EMPTY; mask + 1];
    let mut copies = 0;
    // cells so large that the neighbourhood of a point meets two along each axis at most
    let cell = |p: DVec3| {
        if tolerance > 0.0 {
            (p / (4.0 * tolerance)).floor()
        } else {
            p
        }
    };
    for v in members {
        let p = positions[v as usize];
        let reach = DVec3::splat(tolerance);
        let (low, high) = (cell(p - reach), cell(p + reach));
        let mut best = (f64::INFINITY, EMPTY);
        for corner in 0..8 {
            let is_high = |axis: usize| corner >> axis & 1 == 1;
            let at =
                DVec3::from_array([0, 1, 2].map(|k| if is_high(k) { high[k] } else { low[k] }));
            if (0..3).any(|k| is_high(k) && low[k] == high[k]) {
                continue;
            }
            let mut slot = hash(at) as usize & mask;
            while table[slot] != EMPTY {
                let w = table[slot];
                let distance = positions[w as usize].distance(p);
                if distance <= tolerance && (distance, w) < best {
                    best = (distance, w);
                }
                slot = (slot + 1) & mask;
            }
        }
        if best.1 == EMPTY {
            let mut slot = hash(cell(p)) as usize & mask;
            while table[slot] != EMPTY {
                slot = (slot + 1) & mask;
            }
            table[slot] = v;
        } else if best.1 != v {
            class[v as usize] = best.1;
            copies += 1;
        }
    }
    (class, copies)
}

/// A hash of the three coordinates that spreads regular grids well.
fn hash(p: DVec3) -> u64 {
    const ODD: u64 = 0x9e37_79b9_7f4a_7c15;
    let mut h = 0u64;
    for x in p.to_array() {
        // adding 0 turns −0 into 0
        h = (h ^ (x + 0.0).to_bits()).wrapping_mul(ODD);
        h ^= h >> 32;
    }
    h
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix;

    #[test]
    fn first_copy_represents() {
        let p = [
            DVec3::new(1., 2., 3.),
            DVec3::new(0., 0., 0.),
            DVec3::new(1., 2., 3.),
            DVec3::new(-0., 0., -0.),
            DVec3::new(1., 2., 3.0f64.next_up()),
            DVec3::new(1., 2., 3.),
        ];
        let (class, copies) = position_classes(&p, 0..6, 0.0);
        assert_eq!(class, [0, 1, 0, 1, 4, 0]);
        assert_eq!(copies, 3);
        let (class, copies) = position_classes(&p, [2, 3, 5].into_iter(), 0.0);
        assert_eq!(class, [0, 1, 2, 3, 4, 2]);
        assert_eq!(copies, 1);
    }

    #[test]
    fn near_copies_are_found_across_cells() {
        let mut random = SplitMix::new(4);
        let mut p: Vec<DVec3> = (0..400).map(|_| random.direction()).collect();
        for i in 0..400 {
            p.push(p[i] + 0.99e-6 * random.direction());
        }
        let (class, copies) = position_classes(&p, 0..800, 1e-6);
        assert_eq!(copies, 400);
        assert!(class[..400].iter().copied().eq(0..400));
        assert!(class[400..].iter().copied().eq(0..400));
        let (_, copies) = position_classes(&p, 0..800, 0.9e-6);
        assert_eq!(copies, 0);
    }

    #[test]
    fn tolerances_follow_the_precision_of_the_file() {
        let points = [DVec3::ZERO, DVec3::new(0.1, 0.0, 8.0)];
        let of = |exploded| Weld::Auto.tolerance(&points, exploded);
        assert_eq!(of(true), 32.0 * f64::from(f32::EPSILON));
        assert_eq!(of(false), 32.0 * f64::EPSILON);
        let single = [DVec3::ZERO, DVec3::new(0.25, 0.0, 8.0)];
        assert_eq!(Weld::Auto.tolerance(&single, false), of(true));
        let far = [DVec3::splat(1e6), DVec3::splat(1e6) + DVec3::X];
        assert_eq!(Weld::Auto.tolerance(&far, true), 1e-6);
        assert_eq!("0.5".parse(), Ok(Weld::Within(0.5)));
        assert!("-1".parse::<Weld>().is_err() && "near".parse::<Weld>().is_err());
    }
}
