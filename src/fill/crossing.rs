//! Whether patches over several rims pass through themselves or the mesh.

use std::sync::Arc;

use crate::fill::run::Ground;
use crate::fill::shape::Shape;
use crate::mesh::{DVec3, Mesh, self_intersections};

/// Accepted steps from one look to the next at most.
const STEPS_BETWEEN: usize = 5;
/// Movement of a vertex, in mean edge lengths of the patches, after which there is a look at once.
const FAR: f64 = 0.5;
/// Pairs of triangles that are counted; it makes no difference whether there are more.
const COUNTED: usize = 100;

/// A surface that passes through itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    /// Where, at one of the places.
    pub place: DVec3,
    /// Pairs of triangles, at most 100.
    pub pairs: usize,
    /// Accepted steps up to the last shape without one, if there was one.
    pub last_clean: Option<usize>,
}

impl Crossing {
    /// How much and where.
    pub fn words(&self) -> String {
        let at = self.place;
        let (one, more) = (
            self.pairs == 1,
            if self.pairs < COUNTED { "" } else { " or more" },
        );
        let pairs = if one { "pair" } else { "pairs" };
        format!(
            "{}{more} {pairs} of triangles, one near ({:.6}, {:.6}, {:.6})",
            self.pairs, at.x, at.y, at.z
        )
    }
}

/// A shape to go back to.
#[derive(Clone, Debug)]
pub(super) struct CleanShape {
    pub shape: Arc<Shape>,
    pub positions: Vec<DVec3>,
    pub steps: usize,
}

/// Looks at the blends of a group every few steps, and after every long one.
#[derive(Debug, Default)]
pub(super) struct CrossingWatch {
    looked_at: Option<CleanShape>,
    clean: Option<CleanShape>,
    found: Option<Crossing>,
}

impl CrossingWatch {
    /// What was found at the last look.
    pub fn found(&self) -> Option<&Crossing> {
        self.found.as_ref()
    }

    /// The last shape that was looked at and did not cross.
    pub fn clean(&self) -> Option<&CleanShape> {
        self.clean.as_ref()
    }

    /// Forgets everything: the group goes on from elsewhere.
    pub fn restart(&mut self) {
        *self = Self::default();
    }

    /// Looks at a group's shape after `steps` accepted steps, if it is time or has `ended`.
    pub fn look(
        &mut self,
        ground: Ground<'_>,
        group: usize,
        shape: &Arc<Shape>,
        positions: &[DVec3],
        steps: usize,
        ended: bool,
    ) {
        let holes = &ground.plan.groups[group].holes;
        let is_blend = |&h: &usize| ground.plan.holes[h].loops.len() > 1;
        if !holes.iter().any(is_blend)
            || !(ended || self.is_due(ground.mesh, shape, positions, steps))
        {
            return;
        }
        let now = CleanShape {
            shape: Arc::clone(shape),
            positions: positions.to_vec(),
            steps,
        };
        let places = crossings(
            ground.mesh,
            &triangles(ground.mesh, shape),
            positions,
            COUNTED,
        );
        self.found = places.first().map(|&place| Crossing {
            place,
            pairs: places.len(),
            last_clean: self.clean.as_ref().map(|clean| clean.steps),
        });
        if self.found.is_none() {
            self.clean = Some(now.clone());
        }
        self.looked_at = Some(now);
    }

    fn is_due(&self, mesh: &Mesh, shape: &Arc<Shape>, positions: &[DVec3], steps: usize) -> bool {
        let Some(last) = &self.looked_at else {
            return true;
        };
        if !Arc::ptr_eq(&last.shape, shape) || steps >= last.steps + STEPS_BETWEEN {
            return true;
        }
        let pairs = last.positions.iter().zip(positions);
        let moved = pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        moved > FAR * mean_edge(mesh, shape, positions)
    }
}

/// A group's triangles, the new vertices of all its holes numbered on after those of the mesh.
fn triangles(mesh: &Mesh, shape: &Shape) -> Vec<[u32; 3]> {
    let old = mesh.vertex_count() as u32;
    let mut first = 0;
    let mut all = Vec::new();
    for hole in &shape.holes {
        let global = |v: u32| if v < old { v } else { v + first };
        all.extend(hole.triangles.iter().map(|t| t.map(global)));
        first += hole.new_vertices as u32;
    }
    all
}

fn mean_edge(mesh: &Mesh, shape: &Shape, positions: &[DVec3]) -> f64 {
    let place = |v: u32| place(mesh, positions, v);
    let (mut sum, mut count) = (0.0, 0.0);
    for t in triangles(mesh, shape) {
        for k in 0..3 {
            sum += place(t[k]).distance(place(t[(k + 1) % 3]));
            count += 1.0;
        }
    }
    sum / count
}

fn place(mesh: &Mesh, new: &[DVec3], v: u32) -> DVec3 {
    let at = v as usize;
    let given = mesh.positions.get(at).copied();
    given.unwrap_or_else(|| new[at - mesh.vertex_count()])
}

/// Where the triangles `own`, over vertices of the mesh and `new` ones numbered on after them, pass
/// through themselves or the mesh: a place for every pair, at most `limit`.
pub(super) fn crossings(mesh: &Mesh, own: &[[u32; 3]], new: &[DVec3], limit: usize) -> Vec<DVec3> {
    let place = |v: u32| place(mesh, new, v);
    let span = |t: [u32; 3]| {
        let [a, b, c] = t.map(place);
        (a.min(b).min(c), a.max(b).max(c))
    };
    let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = own.iter().fold(nothing, |(low, high), &t| {
        let (a, b) = span(t);
        (low.min(a), high.max(b))
    });
    let mut all = own.to_vec();
    all.extend(mesh.topology.triangles().filter(|&t| {
        let (a, b) = span(t);
        a.cmple(high).all() && b.cmpge(low).all()
    }));
    let mut vertices: Vec<u32> = all.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let points: Vec<DVec3> = vertices.iter().map(|&v| place(v)).collect();
    let local = |v: u32| vertices.partition_point(|&w| w < v) as u32;
    let all: Vec<[u32; 3]> = all.iter().map(|t| t.map(local)).collect();
    let subset: Vec<u32> = (0..own.len() as u32).collect();
    let pairs = self_intersections(&points, &all, Some(&subset), limit);
    let middle = |f: u32| {
        all[f as usize]
            .map(|v| points[v as usize])
            .iter()
            .sum::<DVec3>()
            / 3.0
    };
    pairs
        .iter()
        .map(|&[f, g]| middle(f).midpoint(middle(g)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Topology;
    use crate::shapes;

    #[test]
    fn crossings_with_oneself_and_the_mesh_are_found_where_they_are() {
        let (positions, faces) = shapes::sphere(500, 1);
        let topology = Topology::from_triangles(positions.len(), &faces).expect("a sphere");
        let mesh = Mesh::new(positions, topology);
        let old = mesh.vertex_count() as u32;
        let triangle = |at: DVec3, size: f64| [at, at + size * DVec3::Y, at + size * DVec3::Z];
        let look = |new: &[DVec3]| {
            let own: Vec<[u32; 3]> = (0..new.len() as u32 / 3)
                .map(|k| [0, 1, 2].map(|c| old + 3 * k + c))
                .collect();
            crossings(&mesh, &own, new, 100)
        };
        // inside, through the sphere, through one another
        assert!(look(&triangle(DVec3::ZERO, 0.5)).is_empty());
        let through = look(&triangle(DVec3::ZERO, 1.5));
        assert!(!through.is_empty());
        for place in through {
            assert!((0.6..1.2).contains(&place.length()), "{place}");
        }
        let mut two = triangle(DVec3::ZERO, 0.5).to_vec();
        two.extend([
            DVec3::new(-0.1, 0.1, 0.1),
            DVec3::new(0.1, 0.1, 0.1),
            DVec3::new(0.1, 0.12, 0.1),
        ]);
        let found = look(&two);
        assert_eq!(found.len(), 1);
        assert!(found[0].length() < 0.3);
    }
}
