//! Built-in sample surfaces, by name.

use super::painted::{paint_egg, paint_ring, painted_egg};
use super::{
    Hole, HoleShape, TriangleMesh, catenoid, cut_holes, demo, four_cylinders, graph, sphere,
    three_y, torus, tube_onto_plane,
};
use crate::mesh::{DVec3, Soup};

/// A sample surface.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Name on the command line.
    pub name: &'static str,
    /// Title in a menu.
    pub title: &'static str,
    /// A description.
    pub about: &'static str,
    make: fn() -> TriangleMesh,
    /// Adds colours or a texture.
    paint: fn(&mut Soup),
}

/// The paint of a sample without colours.
fn plain(_: &mut Soup) {}

/// All samples; the first is the one to begin with.
pub static SAMPLES: [Sample; 10] = [
    Sample {
        name: "creature",
        title: "Creature with sixteen holes",
        about: "slits, stars, blots and ragged rims across strongly curved places",
        make: upright_creature,
        paint: plain,
    },
    Sample {
        name: "sphere",
        title: "Sphere with five holes",
        about: "filled under H^2 it is the sphere again",
        make: sphere_with_holes,
        paint: plain,
    },
    Sample {
        name: "egg",
        title: "Painted egg with three holes",
        about: "a texture in two charts; two of the holes are on their seam",
        make: egg_with_holes,
        paint: paint_egg,
    },
    Sample {
        name: "ring",
        title: "Coloured ring with three holes",
        about: "colours of vertices, which continue into the patches",
        make: ring_with_holes,
        paint: paint_ring,
    },
    Sample {
        name: "torus",
        title: "Torus with four holes",
        about: "the Clifford torus, whose Willmore energy is 2 pi^2",
        make: torus_with_holes,
        paint: plain,
    },
    Sample {
        name: "catenoid",
        title: "Catenoid with a window",
        about: "a minimal surface, stationary under the area and under H^2",
        make: catenoid_with_window,
        paint: plain,
    },
    Sample {
        name: "saddle",
        title: "Saddle with a hole",
        about: "negative curvature; H^2*K^2 is ill-posed on parts of it",
        make: saddle_with_hole,
        paint: plain,
    },
    Sample {
        name: "four-cylinders",
        title: "Four cylinders to blend",
        about: "Fig. 2 of the paper: join the four mouths in the middle",
        make: || four_cylinders(32),
        paint: plain,
    },
    Sample {
        name: "three-y",
        title: "Three tubes in a Y",
        about: "join the three mouths in the middle",
        make: || three_y(32),
        paint: plain,
    },
    Sample {
        name: "tube-onto-plane",
        title: "Tube above a plane",
        about: "join the tube's lower end to the hole below it",
        make: || tube_onto_plane(32),
        paint: plain,
    },
];

impl Sample {
    /// The sample of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        SAMPLES.iter().find(|s| s.name == name)
    }

    /// The surface as a polygon soup, as a file of it would give.
    pub fn soup(&self) -> Soup {
        let (positions, triangles) = (self.make)();
        let mut soup = Soup {
            positions,
            offsets: (0..=triangles.len() as u32).map(|i| 3 * i).collect(),
            corners: triangles.into_iter().flatten().collect(),
            ..Soup::default()
        };
        (self.paint)(&mut soup);
        soup
    }
}

/// Its legs downwards along −y, as viewers take it.
fn upright_creature() -> TriangleMesh {
    let (positions, triangles) = demo();
    let turned = positions.iter().map(|p| DVec3::new(p.x, p.z, -p.y));
    (turned.collect(), triangles)
}

fn hole(centre: [f64; 3], shape: HoleShape, seed: u64) -> Hole {
    Hole {
        centre: DVec3::from_array(centre),
        shape,
        turn: 0.3,
        seed,
    }
}

fn sphere_with_holes() -> TriangleMesh {
    let (outer, inner) = (0.45, 0.2);
    cut_holes(
        &sphere(4000, 21),
        &[
            hole([0.5, -0.8, 0.3], HoleShape::Disc { radius: 0.42 }, 1),
            hole([0.9, 0.3, 0.3], HoleShape::Ragged { radius: 0.28 }, 2),
            hole(
                [-0.2, -0.2, 1.0],
                HoleShape::Star {
                    outer,
                    inner,
                    points: 5,
                },
                3,
            ),
            hole([-0.9, -0.4, 0.0], HoleShape::Blots { radius: 0.35 }, 4),
            hole([0.1, 0.9, -0.4], HoleShape::Disc { radius: 0.3 }, 5),
        ],
    )
}

/// Two holes on the seam, and one inside a chart.
fn egg_with_holes() -> TriangleMesh {
    let (length, width) = (0.7, 0.22);
    cut_holes(
        &painted_egg(),
        &[
            hole([0.0, 0.3, 0.9], HoleShape::Disc { radius: 0.26 }, 1),
            hole([0.7, -0.1, 0.6], HoleShape::Blots { radius: 0.28 }, 2),
            hole([0.0, -0.6, 0.8], HoleShape::Slit { length, width }, 3),
        ],
    )
}

fn ring_with_holes() -> TriangleMesh {
    cut_holes(
        &torus(1.5, 0.6, 5000, 31),
        &[
            hole([0.3, -1.6, 0.6], HoleShape::Disc { radius: 0.4 }, 1),
            hole([1.5, 0.3, 0.6], HoleShape::Blots { radius: 0.4 }, 2),
            hole([-1.2, 0.8, 0.6], HoleShape::Ragged { radius: 0.35 }, 3),
        ],
    )
}

fn torus_with_holes() -> TriangleMesh {
    let (length, width) = (0.9, 0.3);
    cut_holes(
        &torus(2f64.sqrt(), 1.0, 6000, 22),
        &[
            hole([0.0, -2.4, 0.2], HoleShape::Disc { radius: 0.45 }, 1),
            hole([1.5, -0.6, 1.0], HoleShape::Slit { length, width }, 2),
            hole([-1.5, -0.8, 0.9], HoleShape::Blots { radius: 0.45 }, 3),
            hole([0.3, 0.3, 0.1], HoleShape::Ragged { radius: 0.25 }, 4),
        ],
    )
}

fn catenoid_with_window() -> TriangleMesh {
    cut_holes(
        &catenoid(0.6, 0.8, 56, 23),
        &[hole([0.0, -0.6, 0.0], HoleShape::Disc { radius: 0.35 }, 1)],
    )
}

fn saddle_with_hole() -> TriangleMesh {
    let saddle = graph(2.4, 44, |x, y| 0.45 * (x * x - y * y), 24);
    cut_holes(
        &saddle,
        &[hole([0.05, 0.0, 0.0], HoleShape::Blots { radius: 0.5 }, 1)],
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{boundary_loops, build, self_intersections};

    #[test]
    fn samples_are_sound_and_have_the_holes_they_name() {
        let holes = [
            (1, 16),
            (1, 5),
            (1, 3),
            (1, 3),
            (1, 4),
            (1, 1),
            (1, 1),
            (4, 4),
            (3, 3),
            (2, 2),
        ];
        for (sample, (parts, holes)) in SAMPLES.iter().zip(holes) {
            let soup = sample.soup();
            let (mesh, report) = build(&soup).expect("sound");
            assert_eq!(report.defects, [], "{}", sample.name);
            assert_eq!(report.components.len(), parts, "{}", sample.name);
            let loops = boundary_loops(&mesh);
            let found = loops.iter().filter(|l| !l.is_outer_boundary).count();
            assert_eq!(found, holes, "{}", sample.name);
            let triangles: Vec<_> = mesh.topology.triangles().collect();
            assert!(
                self_intersections(&mesh.positions, &triangles, None, 1).is_empty(),
                "{}",
                sample.name
            );
            assert!(std::ptr::eq(
                Sample::named(sample.name).expect("its name finds it"),
                sample
            ));
        }
    }
}
