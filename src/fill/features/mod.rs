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
//! Each part continues the faces on its own side of the lines. Where a line continues along the rim, because
//! only the faces on one side of it are missing, the patch has a crease there. A hole that is a missing face of
//! a body with flat faces has creases along its rim, and none through it.

mod face;
mod faces;
mod lines;
#[cfg(test)]
mod tests;

use std::collections::HashSet;

use glam::DMat3;

use crate::fill::hermite::{hermite_between, length, pieces};
use crate::fill::hole::HoleRims;
use crate::fill::part::{Corner, NewVertices, rim_edges, rims_of_part};
use crate::mesh::{BoundaryLoop, DVec3, Mesh, closest_point_on_segment};
use face::FlatRim;
use faces::{Between, MissingFaces, missing_faces};
use lines::{LineEnd, line_ends};

/// Largest angle between a line and the straight way to the other line, in degrees: half a turn of 120°.
const LARGEST_DEVIATION: f64 = 60.0;
/// Largest angle between a line and the straight way to a corner, in degrees.
const LARGEST_DEVIATION_TO_CORNER: f64 = 20.0;
/// Smallest determinant of the mean projection across the lines of a corner: 0.3 for those of a cube, 0 for
/// parallel lines, 0.05 for lines within about 13 degrees of one direction.
const MIN_SPREAD: f64 = 0.05;
/// Largest distance of a corner from the mean of the rim, in radii of the hole.
const FARTHEST_CORNER: f64 = 1.5;

/// Largest distance of a rim from the line along which it runs, in lengths of its edges.
const FARTHEST_FROM_LINE: f64 = 0.25;

/// A hole in parts, one or more, with creases between them or along the rim.
pub(super) struct SplitHole {
    parts: Vec<Vec<Corner>>,
    /// Edges of the rim at which the patch has a crease, because a sharp line continues along them.
    creased: Vec<usize>,
    pub new: NewVertices,
    /// The creases through the hole, with their ends.
    creases: Vec<Vec<DVec3>>,
}

impl SplitHole {
    /// The rims of the parts; `first` is the number in the mesh of the first new vertex.
    pub fn parts(&self, mesh: &Mesh, hole: &BoundaryLoop, first: usize) -> Vec<HoleRims> {
        let sets: Vec<HashSet<Corner>> = (self.parts.iter())
            .map(|part| part.iter().copied().collect())
            .collect();
        let part = |(k, corners): (usize, &Vec<Corner>)| {
            let edges = rim_edges(hole, corners, &self.creased);
            let mut rims = rims_of_part(mesh, hole, corners, &edges, &self.new.points, first);
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
            rims.crease = without_faces(&edges).collect();
            rims
        };
        self.parts.iter().enumerate().map(part).collect()
    }
}

/// The corners of a part between two edges without faces.
fn without_faces(edges: &[Option<usize>]) -> impl Iterator<Item = usize> {
    let n = edges.len();
    (0..n).filter(move |&k| edges[k].is_none() && edges[(k + n - 1) % n].is_none())
}

/// Splits a hole along the continuations of the sharp lines that end at it. `None` if there are none, or if they lead
/// neither to a common point nor in pairs to each other. A [missing face](FlatRim::missing_face) is not split and has creases
/// along its rim; [several](missing_faces) are split along the edges between them.
pub(super) fn split(mesh: &Mesh, hole: &BoundaryLoop, density: f64) -> Option<SplitHole> {
    let size = hole.perimeter / hole.edges() as f64 / density;
    let splitter = |ends, creased| Splitter {
        mesh,
        hole,
        ends,
        creased,
        size,
    };
    let rim = FlatRim::new(mesh, hole);
    if let Some(creased) = rim.missing_face() {
        return splitter(Vec::new(), creased).cut(std::iter::empty());
    }
    let ends = line_ends(mesh, hole).unwrap_or_default();
    let along_lines = splitter(ends, Vec::new()).along_lines();
    along_lines.or_else(|| {
        let MissingFaces { creased, between } = missing_faces(&rim)?;
        splitter(Vec::new(), creased).between_faces(between)
    })
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
    ends: Vec<LineEnd>,
    /// The edges of the rim of missing faces that are creases of the patch; empty for other holes.
    creased: Vec<usize>,
    /// Length of the edges along creases.
    size: f64,
}

/// A curve between two rim vertices, by their indices: its inner points run from the second to the first.
struct Chord {
    ends: [usize; 2],
    points: Vec<DVec3>,
}

impl Splitter<'_> {
    fn position(&self, i: usize) -> DVec3 {
        self.mesh.position(self.hole.vertices[i])
    }

    /// Whether the parts are missing faces, which are as long and as narrow as they are.
    fn are_faces(&self) -> bool {
        !self.creased.is_empty()
    }

    /// Creases along the lines.
    fn along_lines(&self) -> Option<SplitHole> {
        if self.ends.len() < 2 {
            return None;
        }
        let corner = if self.ends.len() > 2 {
            self.corner()
        } else {
            None
        };
        match corner.map(|corner| (corner, self.rim_vertex_at(corner))) {
            Some((corner, None)) => {
                let ends = self.ends.iter().map(|end| (end.index, end.ahead));
                self.at_corner(corner, &ends.collect::<Vec<_>>())
            }
            Some((_, Some(at))) => self.at_rim_vertex(at),
            None => self.between_pairs(),
        }
    }

    /// Creases along the edges between missing faces.
    fn between_faces(&self, between: Between) -> Option<SplitHole> {
        match between {
            Between::Edges(edges) => self.cut(edges.into_iter().map(|ends| self.edge(ends))),
            Between::Corner(ends, corner) => {
                let ahead = |i: usize| (corner - self.position(i)).normalize_or_zero();
                self.at_corner(corner, &ends.map(|i| (i, ahead(i))))
            }
        }
    }

    /// The point to which all lines lead: the nearest to them by least squares.
    fn corner(&self) -> Option<DVec3> {
        let mut across = DMat3::ZERO;
        let mut sum = DVec3::ZERO;
        for end in &self.ends {
            let d = end.ahead;
            let projection = DMat3::IDENTITY - DMat3::from_cols(d.x * d, d.y * d, d.z * d);
            across += projection;
            sum += projection * end.point;
        }
        let mean = across * (1.0 / self.ends.len() as f64);
        if mean.determinant() < MIN_SPREAD {
            return None;
        }
        let corner = across.inverse() * sum;
        let limit = LARGEST_DEVIATION_TO_CORNER.to_radians();
        let leads = |end: &LineEnd| {
            end.point.distance(corner) <= self.size || end.deviation(corner) <= limit
        };
        let is_near = corner.distance(self.hole.centroid) <= FARTHEST_CORNER * self.hole.radius;
        (is_near && self.ends.iter().all(leads)).then_some(corner)
    }

    /// A crease to a corner inside the hole from each of some vertices of the rim, in its direction. They are given
    /// by their indices and the directions in which the creases leave.
    fn at_corner(&self, corner: DVec3, ends: &[(usize, DVec3)]) -> Option<SplitHole> {
        let count = ends.len();
        let indices: Vec<usize> = ends.iter().map(|&(index, _)| index).collect();
        // no part is between lines that end at one vertex
        let is_apart = |points: &[DVec3]| self.are_faces() || self.is_apart(points);
        if indices.windows(2).any(|pair| pair[0] == pair[1]) || !is_apart(&[corner]) {
            return None;
        }
        let mut new = NewVertices::default();
        let mut creases = Vec::new();
        let mut spokes = Vec::new();
        for (i, &(index, ahead)) in ends.iter().enumerate() {
            let start = self.position(index);
            let arrive = (corner - start).normalize_or_zero();
            let points = self.points(start, ahead, corner, arrive, 1);
            // the inner half is away from the rim, so that the parts are no slivers
            if !is_apart(&points[points.len() / 2..]) {
                return None;
            }
            creases.push([&[start], &points[..], &[corner]].concat());
            let ends = [i, (i + 1) % count].map(|i| self.hole.vertices[indices[i]]);
            spokes.push((new.add_curve(&points, ends, 0.5), ends));
        }
        let middle = new.add_curve(&[corner], spokes[0].1, 1.0);
        let part = |i: usize| {
            let [from, to] = [i, (i + 1) % count];
            let [back, on] = [&spokes[from].0, &spokes[to].0];
            let rim = self.rim_between(indices[from], indices[to]);
            rim.map(Corner::Rim)
                .chain(on.clone())
                .chain(middle.clone())
                .chain(back.clone().rev())
                .collect()
        };
        Some(SplitHole {
            parts: (0..count).map(part).collect(),
            creased: self.creased.clone(),
            new,
            creases,
        })
    }

    /// A crease from each line to a corner that is a vertex of the rim.
    fn at_rim_vertex(&self, at: usize) -> Option<SplitHole> {
        let corner = self.position(at);
        let others = self.ends.iter().filter(|end| end.index != at);
        let curve = |end: &LineEnd| {
            let arrive = (corner - end.point).normalize_or_zero();
            Chord {
                ends: [at, end.index],
                points: self.points(end.point, end.ahead, corner, arrive, 2),
            }
        };
        self.cut(others.map(curve))
    }

    /// A crease from line to line, for pairs of lines whose creases do not cross.
    fn between_pairs(&self) -> Option<SplitHole> {
        let (_, pairs) = self.pairs(0, self.ends.len())?;
        let curve = |pair: [usize; 2]| {
            let [a, b] = pair.map(|i| &self.ends[i]);
            Chord {
                ends: [a.index, b.index],
                points: self.points(b.point, b.ahead, a.point, -a.ahead, 2),
            }
        };
        self.cut(pairs.into_iter().map(curve))
    }

    /// The straight edge between two vertices of the rim.
    fn edge(&self, ends: [usize; 2]) -> Chord {
        let [to, from] = ends.map(|i| self.position(i));
        let along = (to - from).normalize_or_zero();
        Chord {
            ends,
            points: self.points(from, along, to, along, 2),
        }
    }

    /// Cuts the hole along curves that do not cross. Where the rim runs along one, it has the crease.
    fn cut(&self, curves: impl Iterator<Item = Chord>) -> Option<SplitHole> {
        let (mut chords, mut creased) = (Vec::new(), self.creased.clone());
        for curve in curves {
            match self.rim_along(&curve) {
                Some(edges) => creased.extend(edges),
                None => chords.push(curve),
            }
        }
        let mut indices: Vec<usize> = chords.iter().flat_map(|chord| chord.ends).collect();
        indices.sort_unstable();
        indices.dedup();
        if !(self.are_faces() || self.are_apart(&indices)) {
            return None;
        }
        let mut new = NewVertices::default();
        let mut creases: Vec<Vec<DVec3>> = Vec::new();
        let mut parts: Vec<Vec<Corner>> = vec![(0..self.hole.edges()).map(Corner::Rim).collect()];
        for Chord { ends, points } in &chords {
            let middle = &points[points.len() / 4..points.len() - points.len() / 4];
            let is_near = |p: &DVec3| middle.iter().any(|q| p.distance(*q) < 0.5 * self.size);
            let are_apart = self.is_apart(middle) && !creases.iter().flatten().any(is_near);
            if !(are_apart || self.are_faces()) {
                return None;
            }
            let [a, b] = ends.map(|i| self.hole.vertices[i]);
            let inner = new.add_curve(points, [b, a], 1.0);
            let [from, to] = [a, b].map(|v| self.mesh.position(v));
            creases.push([&[to], &points[..], &[from]].concat());
            let [from, to] = ends.map(Corner::Rim);
            let find = |part: &[Corner], corner| part.iter().position(|&c| c == corner);
            let has_both = |part: &Vec<Corner>| find(part, from).and(find(part, to)).is_some();
            // chords that do not cross have both ends in one part
            let mut part = parts.swap_remove(parts.iter().position(has_both)?);
            let first = find(&part, from)?;
            part.rotate_left(first);
            let second = find(&part, to)?;
            let one = part[..=second].iter().copied().chain(inner.clone());
            let other = part[second..].iter().copied().chain([from]);
            parts.extend([one.collect(), other.chain(inner.rev()).collect()]);
        }
        // each part continues some faces, and has a crease
        let is_sound = |part: &Vec<Corner>| {
            let edges = rim_edges(self.hole, part, &creased);
            edges.iter().any(Option::is_some) && without_faces(&edges).next().is_some()
        };
        (self.are_faces() || parts.iter().all(is_sound)).then_some(SplitHole {
            parts,
            creased,
            new,
            creases,
        })
    }

    /// The edges of the rim between the ends of a curve, in either direction, if they run along it.
    fn rim_along(&self, Chord { ends, points }: &Chord) -> Option<Vec<usize>> {
        let [from, to] = ends.map(|i| self.position(i));
        let curve = [&[to], &points[..], &[from]].concat();
        let is_on = |&i: &usize| {
            let p = self.position(i);
            let nearest = |s: &[DVec3]| closest_point_on_segment(p, s[0], s[1]);
            let mut nearest = curve.windows(2).map(nearest);
            nearest.any(|q| p.distance(q) < FARTHEST_FROM_LINE * self.size)
        };
        let [a, b] = *ends;
        [(a, b), (b, a)].into_iter().find_map(|(from, to)| {
            let mut along: Vec<usize> = self.rim_between(from, to).collect();
            along.pop();
            along.iter().all(is_on).then_some(along)
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
            let leads = deviations.iter().all(|d| *d <= limit);
            if !leads || !a.is_as_sharp_as(b) {
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

    /// The indices of the rim's vertices from one to another.
    fn rim_between(&self, from: usize, to: usize) -> impl Iterator<Item = usize> {
        let n = self.hole.edges();
        let edges = (to + n - from) % n;
        (0..=edges).map(move |k| (from + k) % n)
    }

    /// The vertex of the rim at a point.
    fn rim_vertex_at(&self, p: DVec3) -> Option<usize> {
        let distance = |i: usize| self.position(i).distance(p);
        let nearest = (0..self.hole.edges()).min_by(|&i, &j| distance(i).total_cmp(&distance(j)));
        nearest.filter(|&i| distance(i) < 0.5 * self.size)
    }

    /// Whether at least two edges of the rim are between vertices of it with ascending indices.
    fn are_apart(&self, indices: &[usize]) -> bool {
        let n = self.hole.edges();
        let next = indices.iter().cycle().skip(1);
        let mut edges = indices.iter().zip(next).map(|(i, j)| (j + n - i) % n);
        indices.len() < 2 || edges.all(|edges| edges >= 2)
    }

    /// Whether points stay away from the rim.
    fn is_apart(&self, points: &[DVec3]) -> bool {
        let mut rim = self.hole.vertices.iter().map(|&v| self.mesh.position(v));
        rim.all(|p| points.iter().all(|q| p.distance(*q) >= 0.5 * self.size))
    }
}
