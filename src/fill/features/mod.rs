//! Sharp lines that end at a hole continue through it.
//!
//! ```text
//!        o---------o                 o------b------o       The lines that end at the rim are joined by
//!       /           \               /       \       \      creases, and the hole is filled in parts. Two
//!   ===a - - - - - - b===           o        * - - - c===  lines that lead to each other are joined by a
//!       \           /                \      /        /      curve. Three or more that lead to one point
//!        o---------o                  o----a-------o       meet there, in a corner.
//! ```
//!
//! Each part continues the faces on its own side of the lines.

mod lines;
#[cfg(test)]
mod tests;

use std::collections::HashSet;

use glam::DMat3;

use crate::fill::hermite::{hermite_between, length, pieces};
use crate::fill::hole::HoleRims;
use crate::fill::part::{Corner, NewVertices, rims_of_part};
use crate::mesh::{BoundaryLoop, DVec3, Mesh};
use lines::{LineEnd, line_ends};

pub(super) use lines::is_sharp;

/// Largest angle between a line and the straight way to the other line, in degrees: half a turn of 120°.
const LARGEST_DEVIATION: f64 = 60.0;
/// Largest angle between a line and the straight way to a corner, in degrees.
const LARGEST_DEVIATION_TO_CORNER: f64 = 20.0;
/// Least determinant of the mean projection across the lines of a corner: 0.3 for those of a cube, 0 for
/// parallel lines, 0.05 for lines within about 13 degrees of one direction.
const LEAST_SPREAD: f64 = 0.05;
/// Largest distance of a corner from the mean of the rim, in radii of the hole.
const FARTHEST_CORNER: f64 = 1.5;

/// A hole in parts, with creases between them.
pub(super) struct SplitHole {
    parts: Vec<Vec<Corner>>,
    pub new: NewVertices,
    /// The creases, with their ends.
    creases: Vec<Vec<DVec3>>,
}

impl SplitHole {
    /// The rims of the parts; `first` is the number in the mesh of the first new vertex.
    pub fn parts(&self, mesh: &Mesh, hole: &BoundaryLoop, first: usize) -> Vec<HoleRims> {
        let sets: Vec<HashSet<Corner>> = (self.parts.iter())
            .map(|part| part.iter().copied().collect())
            .collect();
        let part = |(k, corners): (usize, &Vec<Corner>)| {
            let mut rims = rims_of_part(mesh, hole, corners, &self.new.points, first);
            let among = |set: &HashSet<Corner>| -> Vec<usize> {
                let indices = 0..corners.len();
                indices.filter(|&i| set.contains(&corners[i])).collect()
            };
            // an edge between two corners would belong to both parts that have them
            let others = sets.iter().enumerate().filter(|(other, _)| *other != k);
            let forbidden = &mut rims.geometry.rims[0].forbidden;
            for shared in others.map(|(_, set)| among(set)) {
                for (at, &j) in shared.iter().enumerate() {
                    forbidden.extend(shared[..at].iter().map(|&i| [i as u32, j as u32]));
                }
            }
            let is_new = |&i: &usize| matches!(corners[i], Corner::New(_));
            rims.crease = (0..corners.len()).filter(is_new).collect();
            rims
        };
        self.parts.iter().enumerate().map(part).collect()
    }
}

/// Splits a hole along the continuations of the sharp lines that end at it. `None` if there are none, or
/// if they lead neither to a common point nor in pairs to each other.
pub(super) fn split(mesh: &Mesh, hole: &BoundaryLoop, density: f64) -> Option<SplitHole> {
    let ends = line_ends(mesh, hole)?;
    let n = hole.edges();
    let next = |i: usize| ends[(i + 1) % ends.len()].index;
    let edges_to_next = |i: usize| (next(i) + n - 1 - ends[i].index) % n + 1;
    if ends.len() < 2 || (0..ends.len()).any(|i| edges_to_next(i) < 2) {
        return None;
    }
    let splitter = Splitter {
        mesh,
        hole,
        ends: &ends,
        size: hole.perimeter / n as f64 / density,
    };
    let corner = if ends.len() > 2 {
        splitter.corner()
    } else {
        None
    };
    match corner {
        Some(corner) => splitter.at_corner(corner),
        None => splitter.between_pairs(),
    }
}

/// The creases, from rim to rim or from the rim to a corner, that
/// [`Features::Auto`](crate::fill::Features::Auto) makes in the patch over a hole without islands, at a
/// [density](crate::patch::PatchOptions::density). None if no sharp line continues through the hole.
pub fn creases_through(mesh: &Mesh, hole: &BoundaryLoop, density: f64) -> Vec<Vec<DVec3>> {
    split(mesh, hole, density).map_or_else(Vec::new, |split| split.creases)
}

/// A hole and the sharp lines that end at it.
struct Splitter<'a> {
    mesh: &'a Mesh,
    hole: &'a BoundaryLoop,
    ends: &'a [LineEnd],
    /// Length of the edges along creases.
    size: f64,
}

impl Splitter<'_> {
    /// The point to which all lines lead: the nearest to them by least squares.
    fn corner(&self) -> Option<DVec3> {
        let mut across = DMat3::ZERO;
        let mut sum = DVec3::ZERO;
        for end in self.ends {
            let d = end.ahead;
            let projection = DMat3::IDENTITY - DMat3::from_cols(d.x * d, d.y * d, d.z * d);
            across += projection;
            sum += projection * end.point;
        }
        let mean = across * (1.0 / self.ends.len() as f64);
        if mean.determinant() < LEAST_SPREAD {
            return None;
        }
        let corner = across.inverse() * sum;
        let limit = LARGEST_DEVIATION_TO_CORNER.to_radians();
        let leads = |end: &LineEnd| end.deviation(corner) <= limit;
        let is_near = corner.distance(self.hole.centroid) <= FARTHEST_CORNER * self.hole.radius;
        (is_near && self.ends.iter().all(leads)).then_some(corner)
    }

    /// A crease from each line to a corner.
    fn at_corner(&self, corner: DVec3) -> Option<SplitHole> {
        let count = self.ends.len();
        let mut new = NewVertices::default();
        let mut creases = Vec::new();
        let mut spokes = Vec::new();
        for (i, end) in self.ends.iter().enumerate() {
            let arrive = (corner - end.point).normalize_or_zero();
            let points = self.points(end.point, end.ahead, corner, arrive, 1);
            // the inner half is away from the rim, so that the parts are no slivers
            let inner = points[points.len() / 2..].iter().chain([&corner]);
            if !self.is_apart(inner) {
                return None;
            }
            creases.push([&[end.point], &points[..], &[corner]].concat());
            let ends = [i, (i + 1) % count].map(|i| self.hole.vertices[self.ends[i].index]);
            spokes.push((new.add_curve(&points, ends, 0.5), ends));
        }
        let middle = new.add_curve(&[corner], spokes[0].1, 1.0);
        let part = |i: usize| {
            let [from, to] = [i, (i + 1) % count];
            let [back, on] = [&spokes[from].0, &spokes[to].0];
            let rim = self.rim_between(from, to);
            rim.chain(on.clone())
                .chain(middle.clone())
                .chain(back.clone().rev())
                .collect()
        };
        Some(SplitHole {
            parts: (0..count).map(part).collect(),
            new,
            creases,
        })
    }

    /// A crease from line to line, for pairs of lines whose creases do not cross.
    fn between_pairs(&self) -> Option<SplitHole> {
        let (_, pairs) = self.pairs(0, self.ends.len())?;
        let mut new = NewVertices::default();
        let mut creases: Vec<Vec<DVec3>> = Vec::new();
        let mut parts: Vec<Vec<Corner>> = vec![(0..self.hole.edges()).map(Corner::Rim).collect()];
        for [a, b] in pairs.iter().map(|pair| pair.map(|i| &self.ends[i])) {
            // from b back to a, as the rim of the part from a to b runs
            let points = self.points(b.point, b.ahead, a.point, -a.ahead, 2);
            let middle = &points[points.len() / 4..points.len() - points.len() / 4];
            let is_near = |p: &DVec3| middle.iter().any(|q| p.distance(*q) < 0.5 * self.size);
            if !self.is_apart(middle.iter()) || creases.iter().flatten().any(is_near) {
                return None;
            }
            let ends = [b, a].map(|end| self.hole.vertices[end.index]);
            let chord = new.add_curve(&points, ends, 1.0);
            creases.push([&[b.point], &points[..], &[a.point]].concat());
            let [from, to] = [a, b].map(|end| Corner::Rim(end.index));
            let find = |part: &Vec<Corner>, corner| part.iter().position(|&c| c == corner);
            let found = |part| Some([find(part, from)?, find(part, to)?]);
            // creases that do not cross have both ends in one part
            let k = parts.iter().position(|part| found(part).is_some())?;
            let mut part = parts.swap_remove(k);
            let first = find(&part, from)?;
            part.rotate_left(first);
            let second = find(&part, to)?;
            let one = part[..=second].iter().copied().chain(chord.clone());
            let other = part[second..].iter().copied().chain([from]);
            parts.extend([one.collect(), other.chain(chord.rev()).collect()]);
        }
        Some(SplitHole {
            parts,
            new,
            creases,
        })
    }

    /// The pairs of the lines with these numbers that lead to each other best without crossing, and the
    /// sum of their deviations.
    fn pairs(&self, from: usize, to: usize) -> Option<(f64, Vec<[usize; 2]>)> {
        if from == to {
            return Some((0.0, Vec::new()));
        }
        let with = |k: usize| {
            let [a, b] = [from, k].map(|i| &self.ends[i]);
            let deviations = [a.deviation(b.point), b.deviation(a.point)];
            let limit = LARGEST_DEVIATION.to_radians();
            if !a.is_as_sharp_as(b) || deviations.iter().any(|d| !(*d <= limit)) {
                return None;
            }
            let (inner, pairs) = self.pairs(from + 1, k)?;
            let (outer, others) = self.pairs(k + 1, to)?;
            let sum = deviations[0] + deviations[1] + inner + outer;
            Some((sum, [vec![[from, k]], pairs, others].concat()))
        };
        let choices = (from + 1..to).step_by(2).filter_map(with);
        choices.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The inner points of a curve with at least `least` edges.
    fn points(
        &self,
        from: DVec3,
        leave: DVec3,
        to: DVec3,
        arrive: DVec3,
        least: usize,
    ) -> Vec<DVec3> {
        let curve = hermite_between(from, leave, to, arrive);
        let count = pieces(length(&curve), self.size, least);
        (1..count).map(|i| curve(i as f64 / count as f64)).collect()
    }

    /// The corners along the rim from the end of a line to that of another.
    fn rim_between(&self, from: usize, to: usize) -> impl Iterator<Item = Corner> {
        let n = self.hole.edges();
        let [from, to] = [from, to].map(|i| self.ends[i].index);
        let edges = (to + n - from) % n;
        (0..=edges).map(move |k| Corner::Rim((from + k) % n))
    }

    /// Whether points stay away from the rim. Those of a crease do not where the rim itself runs along
    /// the sharp line, because only the faces on one side of it are missing.
    fn is_apart<'a>(&self, points: impl Iterator<Item = &'a DVec3> + Clone) -> bool {
        let mut rim = self.hole.vertices.iter().map(|&v| self.mesh.position(v));
        rim.all(|p| points.clone().all(|q| p.distance(*q) >= 0.5 * self.size))
    }
}
