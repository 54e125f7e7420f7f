//! Vertices with exactly the same position.

use crate::mesh::DVec3;

/// For each vertex the first of `members` with the same position (itself if it is not a member),
/// and the number of members that are later copies. Positions are compared exactly; 0 and −0 are
/// equal.
pub(super) fn position_classes(
    positions: &[DVec3],
    members: impl ExactSizeIterator<Item = u32>,
) -> (Vec<u32>, usize) {
    const EMPTY: u32 = u32::MAX;
    let mut class: Vec<u32> = (0..positions.len() as u32).collect();
    let mask = (2 * members.len()).next_power_of_two() - 1;
    let mut table = vec![EMPTY; mask + 1];
    let mut copies = 0;
    for v in members {
        let p = positions[v as usize];
        let mut slot = hash(p) as usize & mask;
        loop {
            let first = table[slot];
            if first == EMPTY {
                table[slot] = v;
                break;
            }
            if positions[first as usize] == p {
                if first != v {
                    class[v as usize] = first;
                    copies += 1;
                }
                break;
            }
            slot = (slot + 1) & mask;
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
        let (class, copies) = position_classes(&p, 0..6);
        assert_eq!(class, [0, 1, 0, 1, 4, 0]);
        assert_eq!(copies, 3);
        let (class, copies) = position_classes(&p, [2, 3, 5].into_iter());
        assert_eq!(class, [0, 1, 2, 3, 4, 2]);
        assert_eq!(copies, 1);
    }
}
