//! Generators of test and demonstration surfaces.
//!
//! Every shape is a function of its arguments alone, so the same call gives the same bits
//! everywhere. Faces are oriented outwards (open surfaces: as documented), triangles are near to
//! equilateral, and, unless stated otherwise, meshes are irregular: jittered, then evened out.

mod blends;
mod closed;
mod cut;
mod demo;
mod flip;
mod implicit;
mod open;
mod outline;
mod painted;
mod relax;
mod samples;

pub use blends::{Tube, four_cylinders, three_y, tube_onto_plane, tubes};
pub use closed::{cube, ellipsoid, icosphere, sphere, torus};
pub use cut::{Hole, HoleShape, cut_holes, cut_where};
pub use demo::{demo, demo_body};
pub use implicit::implicit_surface;
pub use open::{catenoid, cylinder, graph, plane};
pub use samples::{SAMPLES, Sample};

use crate::mesh::DVec3;

/// Vertex positions and triangles.
pub type TriangleMesh = (Vec<DVec3>, Vec<[u32; 3]>);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Topology, self_intersections};
    use crate::random::SplitMix;

    /// Checks that the shape is an oriented manifold without self-intersections or slivers, and
    /// returns its topology.
    fn check((positions, triangles): &TriangleMesh, min_angle: f64) -> Topology {
        let topology = Topology::from_triangles(positions.len(), triangles).expect("manifold");
        assert_eq!(
            self_intersections(positions, triangles, None, 1),
            [[0; 2]; 0]
        );
        let mut least = f64::INFINITY;
        for t in triangles {
            let p = t.map(|v| positions[v as usize]);
            for k in 0..3 {
                let (u, v) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
                least = least.min(u.angle_between(v).to_degrees());
            }
        }
        assert!(least > min_angle, "an angle of {least} degrees");
        topology
    }

    fn euler(t: &Topology) -> i32 {
        let signed = |n: usize| i32::try_from(n).expect("small");
        signed(t.vertex_count()) - signed(t.halfedge_count() / 2) + signed(t.face_count())
    }

    fn volume((positions, triangles): &TriangleMesh) -> f64 {
        let at = |v: u32| positions[v as usize];
        let six: f64 = triangles
            .iter()
            .map(|t| at(t[0]).dot(at(t[1]).cross(at(t[2]))))
            .sum();
        six / 6.0
    }

    #[test]
    fn icospheres() {
        for f in [1, 2, 3, 7] {
            let shape = icosphere(f);
            let t = check(&shape, 40.0);
            assert_eq!(shape.0.len() as u32, 10 * f * f + 2);
            assert_eq!(euler(&t), 2);
            assert!(shape.0.iter().all(|p| (p.length() - 1.0).abs() < 1e-15));
        }
        assert!((volume(&icosphere(20)) / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 5e-3);
    }

    #[test]
    fn cubes() {
        for across in [1, 2, 5] {
            let shape = cube(across);
            let t = check(&shape, 44.9);
            assert_eq!(shape.0.len(), 6 * across * across + 2);
            assert_eq!(t.face_count(), 12 * across * across);
            assert_eq!(euler(&t), 2);
            assert!(shape.0.iter().all(|p| p.abs().max_element() == 1.0));
            assert!((volume(&shape) - 8.0).abs() < 1e-12);
        }
    }

    #[test]
    fn closed_surfaces_lie_where_they_should() {
        let ball = sphere(2000, 1);
        assert_eq!(euler(&check(&ball, 25.0)), 2);
        assert!(ball.0.iter().all(|p| (p.length() - 1.0).abs() < 1e-15));
        assert!((1900..2100).contains(&ball.0.len()));

        let axes = [1.5, 1.0, 0.7];
        let egg = ellipsoid(axes, 2000, 1);
        assert_eq!(euler(&check(&egg, 15.0)), 2);
        let on = |p: &DVec3| ((*p / DVec3::from_array(axes)).length() - 1.0).abs() < 1e-14;
        assert!(egg.0.iter().all(on));
        assert!((1800..2200).contains(&egg.0.len()), "{}", egg.0.len());

        let ring = torus(2.0_f64.sqrt(), 1.0, 3000, 1);
        assert_eq!(euler(&check(&ring, 15.0)), 0);
        let off = |p: &DVec3| ((p.x.hypot(p.y) - 2.0_f64.sqrt()).hypot(p.z) - 1.0).abs();
        assert!(ring.0.iter().all(|p| off(p) < 1e-14));
        assert!((2700..3300).contains(&ring.0.len()), "{}", ring.0.len());
        for s in [&ball, &egg, &ring] {
            assert!(volume(s) > 0.0, "faces point outwards");
        }
    }

    #[test]
    fn open_surfaces_lie_where_they_should() {
        let square = plane(1.0, 20, 1);
        let t = check(&square, 20.0);
        assert_eq!((euler(&t), t.boundary_loops().len()), (1, 1));
        assert!(
            square
                .0
                .iter()
                .all(|p| p.z == 0.0 && p.abs().max_element() <= 0.5)
        );
        let up = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| square.0[v as usize]);
            (b - a).cross(c - a).z > 0.0
        };
        assert!(square.1.iter().all(up));

        let saddle = graph(1.4, 30, |x, y| x * x - y * y, 2);
        check(&saddle, 10.0);
        assert!(saddle.0.iter().all(|p| p.z == p.x * p.x - p.y * p.y));

        let tube = cylinder(1.0, 2.0, 40, 3);
        let t = check(&tube, 20.0);
        assert_eq!((euler(&t), t.boundary_loops().len()), (0, 2));
        assert!(tube.0.iter().all(|p| (p.x.hypot(p.y) - 1.0).abs() < 1e-15));
        let neck = catenoid(0.5, 0.6, 40, 4);
        let t = check(&neck, 20.0);
        assert_eq!((euler(&t), t.boundary_loops().len()), (0, 2));
        assert!(
            neck.0
                .iter()
                .all(|p| (p.x.hypot(p.y) - 0.5 * (p.z / 0.5).cosh()).abs() < 1e-14)
        );
        assert!(volume(&tube) > 0.0 && volume(&neck) > 0.0);
    }

    #[test]
    fn surfaces_to_be_blended_have_facing_mouths() {
        for (shape, parts, loops) in [
            (four_cylinders(32), 4, 8),
            (three_y(24), 3, 6),
            (tube_onto_plane(24), 2, 4),
        ] {
            let t = check(&shape, 20.0);
            assert_eq!(crate::mesh::components(&t).count, parts);
            assert_eq!(t.boundary_loops().len(), loops);
        }
        let (positions, triangles) = four_cylinders(32);
        assert_eq!(positions.len(), 4 * 32 * 20);
        let radius = |p: &DVec3| p.z.hypot(if p.x.abs() < p.y.abs() { p.x } else { p.y });
        assert!(positions.iter().all(|p| (radius(p) - 0.5).abs() < 1e-15));
        for t in triangles {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            let mut outwards = (a + b + c) / 3.0;
            if outwards.x.abs() > outwards.y.abs() {
                outwards.x = 0.0;
            } else {
                outwards.y = 0.0;
            }
            assert!((b - a).cross(c - a).dot(outwards) > 0.0);
        }
    }

    #[test]
    fn discs_have_the_geodesic_radius() {
        let ball = sphere(6000, 5);
        for angle in [0.4, 0.9, 1.4] {
            let centre = DVec3::new(0.3, -0.5, 0.8).normalize();
            let hole = Hole {
                centre,
                shape: HoleShape::Disc { radius: angle },
                turn: 0.0,
                seed: 0,
            };
            let cut = cut_holes(&ball, &[hole]);
            let t = check(&cut, 25.0);
            let loops = t.boundary_loops();
            assert_eq!(loops.len(), 1);
            let edge = (4.0 * std::f64::consts::PI / 6000.0_f64).sqrt();
            for &h in &loops[0] {
                let at = cut.0[t.origin(h).index()];
                assert!((at.angle_between(centre) - angle).abs() < 2.0 * edge);
            }
            let cap = cut_where(&ball, |p| p.angle_between(centre) < angle);
            assert_eq!(check(&cap, 25.0).boundary_loops().len(), 1);
        }
    }

    #[test]
    fn holes_of_every_shape_leave_one_loop() {
        let ball = sphere(6000, 5);
        let shapes = [
            HoleShape::Ragged { radius: 0.5 },
            HoleShape::Slit {
                length: 1.2,
                width: 0.2,
            },
            HoleShape::Angle {
                arm: 0.8,
                width: 0.25,
            },
            HoleShape::Star {
                outer: 0.6,
                inner: 0.25,
                points: 5,
            },
            HoleShape::Blots { radius: 0.6 },
        ];
        for shape in shapes {
            for seed in 0..8 {
                let mut rng = SplitMix::new(seed);
                let hole = Hole {
                    centre: rng.direction(),
                    shape,
                    turn: rng.range(0.0, 6.0),
                    seed,
                };
                let cut = cut_holes(&ball, &[hole]);
                let t = check(&cut, 25.0);
                assert_eq!(t.boundary_loops().len(), 1, "{shape:?} {seed}");
                assert!(ball.1.len() - cut.1.len() > 50);
            }
        }
    }

    #[test]
    fn sample_is_a_closed_creature_with_sixteen_holes() {
        let closed = demo_body();
        assert_eq!(euler(&check(&closed, 12.0)), 2);
        assert!((5_000..15_000).contains(&closed.0.len()));
        let riddled = demo();
        let t = check(&riddled, 12.0);
        assert_eq!(t.boundary_loops().len(), 16);
        assert_eq!(euler(&t), 2 - 16);
        assert_eq!(demo(), riddled);
    }
}
