//! Random inputs: bodies, noise, and holes of many kinds.

use std::collections::{HashMap, HashSet};

use meniscus::mesh::{self, DVec3, Mesh, Soup};
use meniscus::random::SplitMix;
use meniscus::shapes::{self, Hole, HoleShape, TriangleMesh};

/// The kinds of holes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    Disc,
    Ragged,
    Slit,
    Angle,
    Star,
    /// Most of the body is missing.
    MostGone,
    /// Many single faces are missing.
    Crumbs,
    /// The surface is cut apart along a line and opened by less than an edge length.
    Crack,
    /// Single triangles stand at the rim, turned about the rim edge.
    Ears,
    /// Some rim vertices are moved by up to three edge lengths.
    Spikes,
    /// Some rim vertices are moved almost onto their neighbours.
    Needles,
}

impl Damage {
    pub const ALL: [Self; 11] = [
        Self::Disc,
        Self::Ragged,
        Self::Slit,
        Self::Angle,
        Self::Star,
        Self::MostGone,
        Self::Crumbs,
        Self::Crack,
        Self::Ears,
        Self::Spikes,
        Self::Needles,
    ];
}

/// A random input with holes.
pub struct Input {
    pub damage: Damage,
    pub mesh: Mesh,
}

/// The input of a seed. Kinds of damage take turns. `None` if nothing is left to fill.
pub fn input(seed: u64) -> Option<Input> {
    let mut rng = SplitMix::new(seed);
    let damage = Damage::ALL[(seed % Damage::ALL.len() as u64) as usize];
    let vertices = 300 + rng.below(1500);
    let (body, edge) = noisy_body(vertices, &mut rng);
    let mut cut = damaged(&body, damage, edge, &mut rng);
    if rng.below(5) == 0 {
        let scale = DVec3::from_array([0; 3].map(|_| 100f64.powf(rng.unit())));
        cut.0.iter_mut().for_each(|p| *p *= scale);
    }
    if rng.below(5) == 0 {
        let offset = 1e4 * rng.direction();
        cut.0.iter_mut().for_each(|p| *p += offset);
    }
    let mesh = mesh::build(&soup(cut)).ok()?.0;
    (!mesh::boundary_loops(&mesh).is_empty()).then_some(Input { damage, mesh })
}

/// A body of about so many vertices with noise, and its mean edge length.
pub fn noisy_body(vertices: usize, rng: &mut SplitMix) -> (TriangleMesh, f64) {
    let mut body = body(vertices, rng);
    let edge = mean_edge(&body);
    // log-uniform from 0.01 to 0.5 edge lengths
    let noise = edge * 0.01 * 50f64.powf(rng.unit());
    for p in &mut body.0 {
        *p += noise * rng.unit() * rng.direction();
    }
    (body, edge)
}

fn body(vertices: usize, rng: &mut SplitMix) -> TriangleMesh {
    let (seed, cells) = (rng.next_u64(), (vertices as f64).sqrt().round() as usize);
    match rng.below(7) {
        0 | 1 => shapes::sphere(vertices, seed),
        2 => {
            let axes = [0; 3].map(|_| rng.range(0.4, 1.2));
            shapes::ellipsoid(axes, vertices, seed)
        }
        3 => shapes::torus(1.0, rng.range(0.3, 0.7), vertices, seed),
        4 => {
            let (a, k) = (rng.range(0.0, 0.3), rng.range(1.0, 6.0));
            shapes::graph(2.0, cells, |x, y| a * (k * x).sin() * (k * y).cos(), seed)
        }
        5 => {
            let across = (vertices as f64 / 6.0).sqrt().round() as usize;
            let (mut positions, triangles) = shapes::cube(across);
            let turn = glam::DQuat::from_rotation_arc(DVec3::Z, rng.direction());
            for p in &mut positions {
                *p = turn * *p;
            }
            (positions, triangles)
        }
        _ => {
            let slope = rng.range(0.5, 3.0);
            shapes::graph(2.0, cells, |x, _| slope * x.abs(), seed)
        }
    }
}

fn damaged(body: &TriangleMesh, damage: Damage, edge: f64, rng: &mut SplitMix) -> TriangleMesh {
    let extent = body.0.iter().map(|p| p.length()).fold(0.0, f64::max);
    let at = |rng: &mut SplitMix| {
        let inner = body
            .0
            .iter()
            .filter(|p| p.x.abs().max(p.y.abs()) < 0.7 * extent);
        let inner: Vec<&DVec3> = inner.collect();
        *inner[rng.below(inner.len())]
    };
    let shaped = |shape: HoleShape, rng: &mut SplitMix| {
        let hole = Hole {
            centre: at(rng),
            shape,
            turn: rng.range(0.0, 6.3),
            seed: rng.next_u64(),
        };
        shapes::cut_holes(body, &[hole])
    };
    let ragged = |rng: &mut SplitMix| {
        let radius = rng.range(0.15, 0.5) * extent;
        shaped(HoleShape::Ragged { radius }, rng)
    };
    match damage {
        Damage::Disc => {
            let radius = rng.range(0.1, 0.6) * extent;
            shaped(HoleShape::Disc { radius }, rng)
        }
        Damage::Ragged => ragged(rng),
        Damage::Slit => {
            let length = rng.range(0.3, 0.9) * extent;
            let width = rng.range(0.5, 4.0) * edge;
            shaped(HoleShape::Slit { length, width }, rng)
        }
        Damage::Angle => {
            let arm = rng.range(0.4, 0.8) * extent;
            let width = rng.range(0.1, 0.25) * extent;
            shaped(HoleShape::Angle { arm, width }, rng)
        }
        Damage::Star => {
            let outer = rng.range(0.3, 0.6) * extent;
            let inner = rng.range(0.3, 0.6) * outer;
            let points = 3 + rng.below(4) as u32;
            shaped(
                HoleShape::Star {
                    outer,
                    inner,
                    points,
                },
                rng,
            )
        }
        Damage::MostGone => {
            let (axis, limit) = (rng.direction(), rng.range(-0.7, 0.0) * extent);
            shapes::cut_where(body, |p| p.dot(axis) > limit)
        }
        Damage::Crumbs => {
            let share = rng.range(0.02, 0.4);
            let kept = body.1.iter().filter(|_| rng.unit() > share);
            (body.0.clone(), kept.copied().collect())
        }
        Damage::Crack => crack(body, at(rng), edge, rng),
        Damage::Ears => with_ears(body, ragged(rng), rng),
        Damage::Spikes => {
            let mut cut = ragged(rng);
            let (rim, _) = rim(&cut);
            for v in rim {
                if rng.below(10) == 0 {
                    cut.0[v as usize] += rng.range(0.5, 3.0) * edge * rng.direction();
                }
            }
            cut
        }
        Damage::Needles => {
            let mut cut = ragged(rng);
            let (_, edges) = rim(&cut);
            for [a, b] in edges {
                if rng.below(5) == 0 {
                    let to = cut.0[b as usize];
                    cut.0[a as usize] = cut.0[a as usize].lerp(to, rng.range(0.9, 0.999));
                }
            }
            cut
        }
    }
}

/// The boundary vertices and the directed boundary edges.
fn rim((_, triangles): &TriangleMesh) -> (Vec<u32>, Vec<[u32; 2]>) {
    let edges = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let all: HashSet<[u32; 2]> = triangles.iter().flat_map(edges).collect();
    let open = triangles.iter().flat_map(edges);
    let open: Vec<[u32; 2]> = open.filter(|&[a, b]| !all.contains(&[b, a])).collect();
    let mut vertices: Vec<u32> = open.iter().map(|e| e[0]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    (vertices, open)
}

/// Separates the faces of a ball on one side of a plane from those on the other side.
fn crack(body: &TriangleMesh, at: DVec3, edge: f64, rng: &mut SplitMix) -> TriangleMesh {
    let (mut positions, mut triangles) = body.clone();
    let (across, reach) = (rng.direction(), rng.range(4.0, 12.0) * edge);
    let opening = rng.unit() * 0.5 * edge * across;
    let middle = |t: &[u32; 3]| t.iter().map(|&v| body.0[v as usize]).sum::<DVec3>() / 3.0;
    let is_right = |t: &[u32; 3]| (middle(t) - at).dot(across) > 0.0;
    let mut sides: HashMap<u32, [bool; 2]> = HashMap::new();
    for t in &body.1 {
        for &v in t {
            sides.entry(v).or_default()[usize::from(is_right(t))] = true;
        }
    }
    let mut copies: HashMap<u32, u32> = HashMap::new();
    for t in triangles.iter_mut().filter(|t| is_right(t)) {
        for v in t {
            let place = body.0[*v as usize];
            if sides[v] == [true, true] && place.distance(at) < reach {
                *v = *copies.entry(*v).or_insert_with(|| {
                    positions.push(place + opening);
                    positions.len() as u32 - 1
                });
            }
        }
    }
    (positions, triangles)
}

/// Puts removed triangles back that share one edge with the rim, turned about it.
fn with_ears(body: &TriangleMesh, mut cut: TriangleMesh, rng: &mut SplitMix) -> TriangleMesh {
    let bits = |p: &DVec3| p.to_array().map(f64::to_bits);
    let kept: HashMap<[u64; 3], u32> = cut.0.iter().map(bits).zip(0..).collect();
    let index: Vec<Option<&u32>> = body.0.iter().map(|p| kept.get(&bits(p))).collect();
    let (_, edges) = rim(&cut);
    let open: HashSet<[u32; 2]> = edges.into_iter().collect();
    let mut used: Vec<u32> = Vec::new();
    for t in &body.1 {
        for k in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|j| t[(k + j) % 3]);
            let corners = [a, b, c].map(|v| index[v as usize]);
            let (Some(&a), Some(&b), None) = (corners[0], corners[1], corners[2]) else {
                continue;
            };
            let is_free = !used.contains(&a) && !used.contains(&b);
            if !open.contains(&[b, a]) || !is_free || rng.below(8) > 0 {
                continue;
            }
            let [p, q] = [a, b].map(|v| cut.0[v as usize]);
            let turn = glam::DQuat::from_axis_angle((q - p).normalize(), rng.range(-2.0, 2.0));
            used.extend([a, b]);
            cut.0.push(p + turn * (body.0[c as usize] - p));
            cut.1.push([a, b, cut.0.len() as u32 - 1]);
        }
    }
    cut
}

fn mean_edge((positions, triangles): &TriangleMesh) -> f64 {
    let lengths = triangles
        .iter()
        .map(|t| positions[t[0] as usize].distance(positions[t[1] as usize]));
    lengths.sum::<f64>() / triangles.len() as f64
}

pub fn soup((positions, triangles): TriangleMesh) -> Soup {
    Soup {
        positions,
        offsets: (0..=triangles.len() as u32).map(|k| 3 * k).collect(),
        corners: triangles.into_iter().flatten().collect(),
        ..Soup::default()
    }
}
