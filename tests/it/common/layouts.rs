//! Rims to be joined in arrangements that the samples do not show.

use std::f64::consts::{FRAC_PI_4, TAU};

use meniscus::mesh::{BoundaryLoop, DVec3, Mesh, boundary_loops};
use meniscus::random::SplitMix;
use meniscus::shapes::{
    TriangleMesh, Tube, cut_where, ellipsoid, plane, sphere, torus, tube_onto_plane, tubes,
};

/// Surfaces and where their rims to be joined are.
pub struct Layout {
    pub name: String,
    pub shape: TriangleMesh,
    /// A point near the middle of each rim.
    pub rims: Vec<DVec3>,
}

impl Layout {
    pub fn mesh(&self) -> Mesh {
        let (positions, triangles) = self.shape.clone();
        Mesh::from_triangles(positions, &triangles).expect("an oriented manifold")
    }

    /// The loops whose middles are nearest to the points.
    pub fn gap<'a>(&self, loops: &'a [BoundaryLoop], mesh: &Mesh) -> Vec<&'a BoundaryLoop> {
        let middle = |l: &BoundaryLoop| {
            l.vertices.iter().map(|&v| mesh.position(v)).sum::<DVec3>() / l.edges() as f64
        };
        let nearest = |p: &DVec3| {
            // of loops around one another the smaller one
            let far = |l: &&BoundaryLoop| middle(l).distance(*p) + 0.01 * l.perimeter;
            let found = loops.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
            found.expect("a loop")
        };
        let gap: Vec<_> = self.rims.iter().map(nearest).collect();
        let mut numbers: Vec<_> = gap.iter().map(|l| l.id).collect();
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!(
            numbers.len(),
            self.rims.len(),
            "{}: rims mixed up",
            self.name
        );
        gap
    }

    pub fn loops(mesh: &Mesh) -> Vec<BoundaryLoop> {
        boundary_loops(mesh)
    }
}

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn tube(mouth: DVec3, axis: DVec3, radius: f64, around: usize) -> Tube {
    Tube {
        mouth,
        axis,
        radius,
        around,
    }
}

fn of_tubes(name: &str, list: &[Tube]) -> Layout {
    Layout {
        name: name.into(),
        shape: tubes(list),
        rims: list.iter().map(|t| t.mouth).collect(),
    }
}

fn mapped(mut shape: TriangleMesh, map: impl Fn(DVec3) -> DVec3) -> TriangleMesh {
    for p in &mut shape.0 {
        *p = map(*p);
    }
    shape
}

fn turned_over(mut shape: TriangleMesh) -> TriangleMesh {
    for t in &mut shape.1 {
        t.swap(1, 2);
    }
    shape
}

fn together(parts: Vec<TriangleMesh>) -> TriangleMesh {
    let mut all: TriangleMesh = (Vec::new(), Vec::new());
    for (positions, triangles) in parts {
        let first = all.0.len() as u32;
        all.0.extend(positions);
        all.1.extend(triangles.iter().map(|t| t.map(|v| v + first)));
    }
    all
}

/// Tubes along `directions` whose mouths are `reach` from the origin.
fn star(name: &str, directions: &[DVec3], reach: f64, radius: f64, n: usize) -> Layout {
    let list: Vec<Tube> = directions
        .iter()
        .map(|d| tube(reach * d.normalize(), 1.2 * d.normalize(), radius, n))
        .collect();
    of_tubes(name, &list)
}

/// All of them.
pub fn all() -> Vec<Layout> {
    let mut list = two_tubes();
    list.extend(many_tubes());
    list.extend(others());
    list
}

/// Two tubes and a bar beside the gap between them, where a surface of least `∫ H²` swells; the rims to be
/// joined.
pub fn with_obstacle() -> (Mesh, Vec<BoundaryLoop>) {
    let (y, z) = (DVec3::Y, DVec3::Z);
    let layout = of_tubes(
        "obstacle",
        &[
            tube(2.0 * z, z, 0.5, 20),
            tube(-2.0 * z, -z, 0.5, 20),
            tube(v(0.9, -3.0, 0.0), 6.0 * y, 0.15, 8),
        ],
    );
    let mesh = layout.mesh();
    let is_near = |l: &BoundaryLoop| (mesh.position(l.vertices[0]).z.abs() - 2.0).abs() < 0.01;
    let gap = boundary_loops(&mesh).into_iter().filter(is_near).collect();
    (mesh, gap)
}

/// Tubes at random places and directions that do not intersect each other or the objects in front
/// of them.
pub fn random(seed: u64) -> Layout {
    let mut random = SplitMix::new(seed);
    let count = 2 + random.below(4);
    let mut list: Vec<Tube> = Vec::new();
    while list.len() < count {
        let out = random.direction();
        let mouth = random.range(0.8, 2.2) * out;
        let axis = (out + random.range(0.0, 1.2) * random.direction()).normalize();
        let radius = random.range(0.2, 0.5);
        let around = 14 + random.below(24);
        let new = tube(mouth, 1.2 * axis, radius, around);
        // along each tube and one and a half radii ahead of it
        let places = |t: &Tube| {
            let (m, a, r) = (t.mouth, t.axis, t.radius);
            (0..12).map(move |k| {
                m - 1.5 * r * a.normalize() + (a + 1.5 * r * a.normalize()) * (f64::from(k) / 11.0)
            })
        };
        let is_clear = |old: &Tube| {
            let reach = 1.25 * (old.radius + radius);
            places(old).all(|p| places(&new).all(|q| p.distance(q) > reach))
        };
        if list.iter().all(is_clear) {
            list.push(new);
        }
    }
    of_tubes(&format!("random_{seed}"), &list)
}

fn two_tubes() -> Vec<Layout> {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    vec![
        of_tubes(
            "u_turn",
            &[tube(x, 1.6 * z, 0.5, 32), tube(-x, 1.6 * z, 0.5, 32)],
        ),
        of_tubes(
            "u_turn_close",
            &[
                tube(0.6 * x, 1.6 * z, 0.5, 32),
                tube(-0.6 * x, 1.6 * z, 0.5, 32),
            ],
        ),
        of_tubes(
            "u_turn_wide",
            &[
                tube(2.0 * x, 1.6 * z, 0.5, 28),
                tube(-2.0 * x, 1.6 * z, 0.5, 28),
            ],
        ),
        of_tubes(
            "u_turn_uneven",
            &[
                tube(x, 1.6 * z, 0.5, 32),
                tube(v(-1.0, 0.0, 0.5), 1.6 * z, 0.3, 20),
            ],
        ),
        of_tubes(
            "s_bend",
            &[
                tube(v(1.0, 0.0, 1.0), 1.6 * z, 0.5, 32),
                tube(v(-1.0, 0.0, -1.0), -1.6 * z, 0.5, 32),
            ],
        ),
        of_tubes(
            "s_bend_short",
            &[
                tube(v(0.8, 0.0, 0.3), 1.2 * z, 0.5, 32),
                tube(v(-0.8, 0.0, -0.3), -1.2 * z, 0.5, 32),
            ],
        ),
        of_tubes(
            "far",
            &[
                tube(3.0 * z, 1.6 * z, 0.5, 24),
                tube(-3.0 * z, -1.6 * z, 0.5, 24),
            ],
        ),
        of_tubes("elbow", &[tube(x, x, 0.4, 28), tube(y, y, 0.4, 28)]),
        of_tubes(
            "elbow_tight",
            &[tube(0.55 * x, x, 0.5, 28), tube(0.55 * y, y, 0.5, 28)],
        ),
        of_tubes(
            "elbow_far",
            &[tube(3.0 * x, x, 0.4, 24), tube(3.0 * y, y, 0.3, 24)],
        ),
        of_tubes(
            "acute",
            &[
                tube(x, x, 0.3, 24),
                tube(v(0.5, 1.0, 0.0), v(0.5, 0.86, 0.0), 0.3, 24),
            ],
        ),
        of_tubes("radii", &[tube(z, z, 0.2, 16), tube(O, -2.0 * z, 1.0, 50)]),
        of_tubes(
            "radii_flat",
            &[tube(0.1 * z, z, 0.3, 20), tube(O, -2.0 * z, 1.0, 50)],
        ),
        of_tubes(
            "counts",
            &[tube(0.7 * z, z, 0.5, 10), tube(-0.7 * z, -z, 0.5, 80)],
        ),
        of_tubes(
            "narrow_gap",
            &[tube(0.05 * z, z, 0.5, 32), tube(-0.05 * z, -z, 0.5, 32)],
        ),
        of_tubes(
            "overshot",
            &[
                tube(v(-0.5, 1.2, 0.0), -x, 0.4, 24),
                tube(v(0.5, -1.2, 0.0), -x, 0.4, 24),
            ],
        ),
        of_tubes(
            "skew_axes",
            &[
                tube(v(1.0, 0.0, 0.8), x, 0.4, 26),
                tube(v(0.0, 1.0, -0.8), y + 0.3 * z, 0.5, 30),
            ],
        ),
    ]
}

const O: DVec3 = DVec3::ZERO;

fn many_tubes() -> Vec<Layout> {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    // ends along a helix, as on a roll
    let roll: Vec<Tube> = (0..4)
        .map(|k| {
            let (sin, cos) = (1.1 * f64::from(k)).sin_cos();
            let out = v(cos, sin, 0.0);
            tube(0.9 * out + (0.9 * f64::from(k) - 1.35) * z, out, 0.3, 20)
        })
        .collect();
    vec![
        star("three_odd", &[x, y, v(-1.0, -1.0, 1.0)], 1.0, 0.35, 24),
        star(
            "three_side",
            &[v(1.0, 0.2, 0.0), v(0.8, 0.9, 0.2), v(0.6, 0.0, 1.0)],
            1.3,
            0.3,
            20,
        ),
        star(
            "five_odd",
            &[
                x,
                v(-0.8, 0.5, 0.1),
                v(-0.3, -1.0, 0.4),
                v(0.2, 0.3, 1.0),
                v(0.3, 0.2, -1.0),
            ],
            1.0,
            0.35,
            22,
        ),
        of_tubes("rolled", &roll),
        of_tubes(
            "tripod",
            &[0.0, 1.0, 2.0].map(|k| {
                let (sin, cos) = (TAU * k / 3.0).sin_cos();
                tube(0.9 * v(cos, sin, 0.0), z, 0.4, 24)
            }),
        ),
        of_tubes(
            "manifold_row",
            &[
                tube(v(-1.5, 0.0, 0.5), z, 0.4, 22),
                tube(v(0.0, 0.0, 0.5), z, 0.4, 22),
                tube(v(1.5, 0.0, 0.5), z, 0.4, 22),
                tube(v(0.0, 0.0, -1.0), -z, 0.6, 32),
            ],
        ),
        of_tubes(
            "three_radii",
            &[
                tube(x, x, 0.2, 14),
                tube(v(-0.6, 0.9, 0.0), v(-0.6, 0.9, 0.0), 0.35, 22),
                tube(v(-0.6, -1.2, 0.3), v(-0.5, -1.0, 0.3), 0.6, 36),
            ],
        ),
    ]
}

fn others() -> Vec<Layout> {
    let (x, z) = (DVec3::X, DVec3::Z);
    let mut list = Vec::new();
    // a tube that comes down on a hole in a plane at an angle
    let square = cut_where(&plane(4.0, 52, 1), |p| p.length() < 0.9);
    let slanted = v(FRAC_PI_4.sin(), 0.0, FRAC_PI_4.cos());
    list.push(Layout {
        name: "oblique".into(),
        shape: together(vec![
            square,
            tubes(&[tube(1.1 * slanted, 1.2 * slanted, 0.4, 32)]),
        ]),
        rims: vec![O, 1.1 * slanted],
    });
    list.push(Layout {
        name: "low_tube".into(),
        shape: mapped(
            tube_onto_plane(28),
            |p| if p.z > 0.5 { p - 0.5 * z } else { p },
        ),
        rims: vec![O, 0.1 * z],
    });
    // thick-walled ends: the inner wall looks inwards
    let walls = |low: f64| {
        together(vec![
            tubes(&[tube(O, -1.6 * z, 1.0, 48)]),
            turned_over(tubes(&[tube(low * z, -1.6 * z, 0.5, 26)])),
        ])
    };
    list.push(Layout {
        name: "lip".into(),
        shape: walls(0.05),
        rims: vec![O, 0.05 * z],
    });
    list.push(Layout {
        name: "lip_uneven".into(),
        shape: walls(0.6),
        rims: vec![O, 0.6 * z],
    });
    // a tube that reaches into another one
    list.push(Layout {
        name: "inside".into(),
        shape: tubes(&[tube(O, 1.6 * z, 1.0, 48), tube(0.3 * z, -1.6 * z, 0.4, 22)]),
        rims: vec![O, 0.3 * z],
    });
    // rims that are not plane
    let wavy = |p: DVec3| {
        let angle = p.y.atan2(p.x);
        let lift = 0.25 * (2.0 * angle).sin() * (1.5 - p.z.abs()).clamp(0.0, 1.0);
        p + lift * z
    };
    list.push(Layout {
        name: "wavy".into(),
        shape: mapped(
            tubes(&[tube(0.6 * z, z, 0.5, 30), tube(-0.6 * z, -z, 0.5, 36)]),
            wavy,
        ),
        rims: vec![0.6 * z, -0.6 * z],
    });
    let slant = |p: DVec3| p + 0.8 * p.x * (1.8 - p.z.abs()).clamp(0.0, 1.0) * z;
    list.push(Layout {
        name: "slanted_ends".into(),
        shape: mapped(
            tubes(&[tube(0.8 * z, z, 0.5, 30), tube(-0.8 * z, -z, 0.5, 30)]),
            slant,
        ),
        rims: vec![0.8 * z, -0.8 * z],
    });
    let axes = [1.0, 0.7, 0.5];
    list.push(Layout {
        name: "ellipsoid_zone".into(),
        shape: cut_where(&ellipsoid(axes, 1600, 3), |p| (p.x - 0.1).abs() < 0.35),
        rims: vec![0.45 * x, -0.25 * x],
    });
    list.push(Layout {
        name: "ellipsoid_slanted".into(),
        shape: cut_where(&ellipsoid(axes, 1600, 4), |p| {
            (p.x + 0.6 * p.y + 0.3 * p.z).abs() < 0.25
        }),
        rims: vec![0.25 * x, -0.25 * x],
    });
    let ball = |at: DVec3, to: DVec3, seed: u64| {
        let cut = cut_where(&sphere(900, seed), |p| p.dot(to) > 0.8);
        mapped(cut, |p| p + at)
    };
    list.push(Layout {
        name: "two_spheres".into(),
        shape: together(vec![ball(1.6 * x, -x, 5), ball(-1.6 * x, x, 6)]),
        rims: vec![0.7 * x, -0.7 * x],
    });
    list.push(Layout {
        name: "two_spheres_turned".into(),
        shape: together(vec![
            ball(1.8 * x, v(-0.8, 0.6, 0.0), 5),
            ball(-1.8 * x, v(0.8, 0.6, 0.0), 6),
        ]),
        rims: vec![v(1.1, 0.5, 0.0), v(-1.1, 0.5, 0.0)],
    });
    list.push(Layout {
        name: "torus_two_zones".into(),
        shape: cut_where(&torus(1.0, 0.35, 1800, 7), |p| p.y.abs() < 0.4),
        rims: [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
            .map(|(a, b)| v(0.9 * a, 0.4 * b, 0.0))
            .to_vec(),
    });
    list.push(Layout {
        name: "torus_half".into(),
        shape: cut_where(&torus(1.0, 0.35, 1800, 8), |p| p.y < 0.0),
        rims: vec![x, -x],
    });
    list.push(Layout {
        name: "tube_to_sphere".into(),
        shape: together(vec![
            cut_where(&sphere(1200, 9), |p| p.dot(v(0.6, 0.0, 0.8)) > 0.85),
            tubes(&[tube(2.0 * z, z, 0.3, 20)]),
        ]),
        rims: vec![v(0.55, 0.0, 0.73), 2.0 * z],
    });
    list
}
