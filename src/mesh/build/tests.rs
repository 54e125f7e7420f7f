//! Each kind of bad input, made here, and invariants over random soups.

use super::*;
use crate::mesh::{
    Column, DVec3, FaceTag, Topology, boundary_loops, check_mesh, color_columns, row_count,
};
use crate::random::SplitMix;

/// An octahedron subdivided three times and projected to the unit sphere, 258 vertices.
fn sphere() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut p: Vec<DVec3> = [
        [1., 0., 0.],
        [-1., 0., 0.],
        [0., 1., 0.],
        [0., -1., 0.],
        [0., 0., 1.],
        [0., 0., -1.],
    ]
    .map(DVec3::from)
    .to_vec();
    let mut t = vec![
        [0, 2, 4],
        [2, 1, 4],
        [1, 3, 4],
        [3, 0, 4],
        [2, 0, 5],
        [1, 2, 5],
        [3, 1, 5],
        [0, 3, 5],
    ];
    for _ in 0..3 {
        let mut middles = std::collections::BTreeMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in t {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(a, b): (u32, u32)| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    p.push(p[a as usize].midpoint(p[b as usize]).normalize());
                    p.len() as u32 - 1
                })
            });
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        t = finer;
    }
    (p, t)
}

/// Edges of the hole in `open_sphere`.
const RIM: usize = 20;

/// The sphere without its faces around the vertices of greatest z.
fn open_sphere() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (p, mut t) = sphere();
    t.retain(|t| t.iter().all(|&v| p[v as usize].z < 0.8));
    // no vertex is left over by this
    let mut used = vec![u32::MAX; p.len()];
    let mut kept = Vec::new();
    for v in t.iter_mut().flatten() {
        let old = *v as usize;
        if used[old] == u32::MAX {
            used[old] = kept.len() as u32;
            kept.push(p[old]);
        }
        *v = used[old];
    }
    (kept, t)
}

fn soup(positions: Vec<DVec3>, triangles: &[[u32; 3]]) -> Soup {
    Soup {
        positions,
        corners: triangles.as_flattened().to_vec(),
        offsets: (0..=triangles.len() as u32).map(|f| 3 * f).collect(),
        ..Soup::default()
    }
}

/// Builds, checks what holds for every input, and returns the result.
fn sound(soup: &Soup) -> (Mesh, LoadReport) {
    let (mesh, report) = build(soup).expect("can be built");
    if let Err(fault) = check_mesh(&mesh) {
        panic!(
            "{fault} in {:?} of {:?}",
            mesh.topology.triangles().collect::<Vec<_>>(),
            soup
        );
    }
    for v in 0..soup.positions.len() {
        let m = report
            .file_to_mesh
            .as_ref()
            .map_or(v, |map| map[v] as usize);
        assert_eq!(
            mesh.positions[m], soup.positions[v],
            "vertex {v} was moved or lost"
        );
    }
    assert_eq!(
        mesh.vertex_count(),
        soup.positions.len() - report.welded_vertices + report.appended_vertices
    );
    assert_eq!(mesh.face_count() + mesh.non_orientable.len(), report.faces);
    let parts = &report.components;
    assert_eq!(parts.iter().map(|c| c.faces).sum::<usize>(), report.faces);
    for part in parts.iter().filter(|c| c.orientable) {
        // closed by discs, an oriented surface has an even Euler characteristic, at most 2
        let closed = part.euler + i64::try_from(part.loops).expect("few loops");
        assert!(closed <= 2 && closed % 2 == 0, "{part:?}");
    }
    (mesh, report)
}

fn loop_sizes(mesh: &Mesh) -> Vec<(usize, bool)> {
    boundary_loops(mesh)
        .iter()
        .map(|l| (l.edges(), l.is_outer_boundary))
        .collect()
}

#[test]
fn clean_input_comes_through() {
    let (p, t) = open_sphere();
    let (mesh, report) = sound(&soup(p.clone(), &t));
    assert_eq!(mesh.positions, p);
    assert!(mesh.topology.triangles().eq(t.iter().copied()));
    assert_eq!(
        report,
        LoadReport {
            file_vertices: p.len(),
            file_faces: t.len(),
            vertices: p.len(),
            faces: t.len(),
            components: vec![ComponentReport {
                faces: t.len(),
                vertices: p.len(),
                loops: 1,
                orientable: true,
                euler: 1
            }],
            ..LoadReport::default()
        }
    );
    assert_eq!(loop_sizes(&mesh), [(RIM, false)]);
}

#[test]
fn refused_input() {
    let (p, t) = open_sphere();
    assert!(matches!(
        build(&soup(p.clone(), &[])),
        Err(BuildError::NoFaces { .. })
    ));
    assert!(matches!(
        build(&soup(p.clone(), &[[1, 1, 2]])),
        Err(BuildError::OnlyDegenerate { faces: 1 })
    ));
    // three vertices at two positions
    let point = [DVec3::ZERO, DVec3::X, DVec3::ZERO];
    assert!(matches!(
        build(&soup(point.to_vec(), &[[0, 1, 2]])),
        Err(BuildError::OnlyDegenerate { faces: 1 })
    ));
    let mut far = t.clone();
    far[4][1] = 9999;
    assert_eq!(
        build(&soup(p.clone(), &far)),
        Err(BuildError::IndexOutOfRange {
            face: 5,
            vertex: 10_000,
            vertices: p.len()
        })
    );
    let mut wild = p;
    wild[7].y = f64::INFINITY;
    assert!(matches!(
        build(&soup(wild, &t)),
        Err(BuildError::NotFinite { vertex: 8, .. })
    ));
}

#[test]
fn polygons() {
    // a prism without its top: six quads and a hexagon
    let ring = |z: f64| {
        (0..6).map(move |i| {
            let (s, c) = (f64::from(i) * std::f64::consts::FRAC_PI_3).sin_cos();
            DVec3::new(c, s, z)
        })
    };
    let mut corners: Vec<u32> = (0..6).rev().collect();
    let mut offsets = vec![0, 6];
    for i in 0..6 {
        let j = (i + 1) % 6;
        corners.extend([i, j, j + 6, i + 6]);
        offsets.push(corners.len() as u32);
    }
    let prism = Soup {
        positions: ring(0.0).chain(ring(1.0)).collect(),
        corners,
        offsets,
        ..Soup::default()
    };
    let (mesh, report) = sound(&prism);
    assert_eq!((report.polygons_triangulated, report.faces), (7, 16));
    assert_eq!(loop_sizes(&mesh), [(6, false)]);
}

#[test]
fn turned_faces() {
    let (p, t) = open_sphere();
    let turned: Vec<[u32; 3]> = t
        .iter()
        .enumerate()
        .map(|(i, &[a, b, c])| if i % 6 == 0 { [a, c, b] } else { [a, b, c] })
        .collect();
    let (mesh, report) = sound(&soup(p.clone(), &turned));
    assert_eq!(report.flipped_faces, t.len().div_ceil(6));
    for f in (0..t.len()).map(crate::mesh::FaceId::from) {
        let [a, b, c] = mesh.corners(f);
        assert!((b - a).cross(c - a).dot(a) > 0.0);
    }
    let inside_out: Vec<[u32; 3]> = t.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let (mesh, report) = sound(&soup(p, &inside_out));
    assert_eq!(report.flipped_faces, 0);
    assert!(mesh.topology.triangles().eq(inside_out));
    assert_eq!(loop_sizes(&mesh), [(RIM, false)]);
}

/// Every face gets vertices of its own.
fn explode(p: &[DVec3], t: &[[u32; 3]]) -> Soup {
    let positions = t.iter().flatten().map(|&v| p[v as usize]).collect();
    let own: Vec<[u32; 3]> = (0..t.len() as u32)
        .map(|f| [3 * f, 3 * f + 1, 3 * f + 2])
        .collect();
    soup(positions, &own)
}

#[test]
fn exploded_faces_are_welded() {
    let (p, t) = open_sphere();
    for flag in [false, true] {
        let mut exploded = explode(&p, &t);
        exploded.exploded = flag;
        let (mesh, report) = sound(&exploded);
        assert_eq!(mesh.vertex_count(), p.len());
        assert_eq!(report.welded_vertices, 3 * t.len() - p.len());
        assert_eq!(loop_sizes(&mesh), [(RIM, false)]);
        // the first copy of each is kept, in file order
        let map = report.file_to_mesh.expect("indices changed");
        let mut last = 0;
        for m in map {
            assert!(m <= last);
            last = last.max(m + 1);
        }
    }
}

#[test]
fn seams_are_welded_and_touching_vertices_are_not() {
    let (p, t) = open_sphere();
    for inside_out in [false, true] {
        // the faces with x > 0 get vertices of their own, and perhaps the other orientation
        let mut positions = p.clone();
        let mut copy = vec![u32::MAX; p.len()];
        let mut t = t.clone();
        for t in &mut t {
            if t.iter().map(|&v| p[v as usize].x).sum::<f64>() > 0.0 {
                for v in t.iter_mut() {
                    if copy[*v as usize] == u32::MAX {
                        copy[*v as usize] = positions.len() as u32;
                        positions.push(p[*v as usize]);
                    }
                    *v = copy[*v as usize];
                }
                if inside_out {
                    t.swap(0, 1);
                }
            }
        }
        let (mesh, report) = sound(&soup(positions, &t));
        assert!(report.welded_vertices > 5);
        assert_eq!(report.components.len(), 1);
        assert_eq!(mesh.topology.boundary_edge_count(), RIM);
    }
    // two open spheres with one vertex of their rims at the same place stay two
    let shift = p[rim_vertex(&p, &t)];
    let mut positions = p.clone();
    positions.extend(p.iter().map(|&q| shift + shift - q));
    let mut both = t.clone();
    both.extend(t.iter().map(|t| t.map(|v| v + p.len() as u32)));
    let (_, report) = sound(&soup(positions, &both));
    assert_eq!((report.welded_vertices, report.components.len()), (0, 2));
}

fn rim_vertex(p: &[DVec3], t: &[[u32; 3]]) -> usize {
    let topology = Topology::from_triangles(p.len(), t).expect("clean");
    topology.origin(topology.boundary_loops()[0][0]).index()
}

#[test]
fn all_defects_count_also_those_that_are_not_listed() {
    let (p, mut t) = open_sphere();
    t.extend((0..250).map(|v| [v % 200, v % 200, v % 200 + 1]));
    let (_, report) = sound(&soup(p, &t));
    assert_eq!(report.defects.len(), Defect::LIMIT);
    assert_eq!((report.degenerate_faces, report.defect_count()), (250, 250));
}

#[test]
fn duplicate_and_degenerate_faces() {
    let (p, t) = open_sphere();
    let mut more = t.clone();
    more.insert(5, [3, 3, 4]);
    more.push([t[9][1], t[9][2], t[9][0]]);
    more.push([t[20][1], t[20][0], t[20][2]]);
    let (mesh, report) = sound(&soup(p, &more));
    assert_eq!((report.duplicate_faces, report.degenerate_faces), (2, 1));
    assert_eq!(report.non_manifold_edges, 0);
    assert!(mesh.topology.triangles().eq(t));
    let faces: Vec<_> = report
        .defects
        .iter()
        .map(|d| (d.kind, d.file_face))
        .collect();
    let last = more.len() as u32 - 1;
    assert_eq!(
        faces,
        [
            (DefectKind::DegenerateFace, Some(5)),
            (DefectKind::DuplicateFace, Some(last - 1)),
            (DefectKind::DuplicateFace, Some(last)),
        ]
    );
}

/// Triangulators of CAD surfaces write such faces along the borders of patches.
#[test]
fn needles_between_the_copies_of_an_edge_are_removed() {
    let (p, t) = sphere();
    let [a, b, c] = t[40];
    // face 40 has its own vertices, and needles [a, a, b] are loose, beside it, or in a chain of two
    let of_needles: [&[[usize; 3]]; 3] = [&[[3, 4, 5]], &[[1, 0, 3]], &[[1, 0, 3], [1, 3, 4]]];
    for needles in of_needles {
        let mut positions = p.clone();
        positions.extend([a, b, c, a, b, a].map(|v| p[v as usize]));
        let copy = |i: usize| (p.len() + i) as u32;
        let mut faces = t.clone();
        faces[40] = [0, 1, 2].map(copy);
        faces.extend(needles.iter().map(|needle| needle.map(copy)));
        let (mesh, report) = sound(&soup(positions, &faces));
        assert_eq!(mesh.face_count(), t.len());
        assert_eq!(mesh.topology.boundary_edge_count(), 0);
        assert_eq!(report.degenerate_faces, needles.len());
        assert_eq!(report.components.len(), 1);
    }
}

#[test]
fn a_vertex_on_an_edge_keeps_its_flat_face() {
    let (mut p, mut t) = open_sphere();
    let [a, b, c] = t[40];
    let middle = p.len() as u32;
    p.push(p[a as usize].midpoint(p[b as usize]));
    t[40] = [a, middle, c];
    t.extend([[middle, b, c], [b, middle, a]]);
    let (mesh, report) = sound(&soup(p, &t));
    assert_eq!(report.zero_area_faces, 1);
    assert_eq!(report.components.len(), 1);
    assert_eq!(loop_sizes(&mesh), [(RIM, false)]);
}

#[test]
fn fins_are_cut_off_and_not_filled() {
    let (p, t) = open_sphere();
    let topology = Topology::from_triangles(p.len(), &t).expect("clean");
    let rim = topology.boundary_loops()[0][0];
    let tip = p.len() as u32;
    // inside the surface; at the rim, as one face or as two back to back
    let [a, b, _] = t[50];
    let (c, d) = (topology.origin(rim).0, topology.target(rim).0);
    let fins: [&[[u32; 3]]; 2] = [&[[a, b, tip]], &[[c, d, tip], [d, c, tip]]];
    for fin in fins {
        let mut positions = p.clone();
        let foot = p[fin[0][0] as usize].midpoint(p[fin[0][1] as usize]);
        positions.push(foot * 1.3);
        let mut finned = t.clone();
        finned.extend(fin);
        let (mesh, report) = sound(&soup(positions, &finned));
        assert_eq!(report.non_manifold_edges, 1);
        assert_eq!((report.split_vertices, report.appended_vertices), (0, 2));
        assert_eq!(report.duplicate_faces, fin.len() - 1);
        let mut sizes = loop_sizes(&mesh);
        sizes.sort_unstable();
        assert_eq!(sizes, [(3, true), (RIM, false)]);
    }
}

#[test]
fn solids_touching_at_an_edge_or_a_vertex_come_apart() {
    let cube = |o: [f64; 3]| -> Vec<DVec3> {
        (0..8)
            .map(|i| {
                DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2))
                    + DVec3::from(o)
            })
            .collect()
    };
    let quads: [[u32; 4]; 6] = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    // the second cube meets the first in an edge, or in a corner
    for (offset, split) in [([1., 1., 0.], 0), ([1., 1., 1.], 1)] {
        let mut positions = cube([0.; 3]);
        let mut index = Vec::new();
        for q in cube(offset) {
            index.push(positions.iter().position(|&p| p == q).unwrap_or_else(|| {
                positions.push(q);
                positions.len() - 1
            }) as u32);
        }
        let mut triangles = Vec::new();
        for [a, b, c, d] in quads {
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        let first = triangles.clone();
        triangles.extend(first.iter().map(|t| t.map(|v| index[v as usize])));
        let shared = 16 - positions.len();
        let shared_corners = soup(positions.clone(), &triangles);
        for (input, exploded) in [
            (shared_corners, false),
            (explode(&positions, &triangles), true),
        ] {
            let (mesh, report) = sound(&input);
            assert_eq!(mesh.topology.boundary_edge_count(), 0);
            assert_eq!(mesh.vertex_count(), 16);
            assert_eq!(report.components.len(), 2);
            assert_eq!(report.non_manifold_edges, shared - 1);
            if !exploded {
                assert_eq!(
                    (report.appended_vertices, report.split_vertices),
                    (shared, split)
                );
            }
        }
    }
}

/// Boxes on top of each other, each with its own bottom and top of four triangles; the lowest has
/// no bottom.
fn stack(boxes: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for level in 0..=boxes {
        let z = f64::from(level);
        let ring = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        positions.extend(ring.map(|[x, y]| DVec3::new(x, y, z)));
        positions.push(DVec3::new(0.6, 0.3, z));
        let at = |i: u32| 5 * level + i % 4;
        let middle = 5 * level + 4;
        for i in 0..4 {
            if level > 0 {
                triangles.push([middle, at(i), at(i + 1)]);
                let below = |i: u32| at(i) - 5;
                triangles.extend([
                    [below(i), below(i + 1), at(i + 1)],
                    [below(i), at(i + 1), at(i)],
                ]);
            }
            if 0 < level && level < boxes {
                triangles.push([middle, at(i + 1), at(i)]);
            }
        }
    }
    (positions, triangles)
}

#[test]
fn solids_in_contact_keep_their_faces() {
    let mut random = SplitMix::new(9);
    for round in 0..20 {
        let boxes = 2 + round % 3;
        let (positions, mut triangles) = stack(boxes);
        for i in (1..triangles.len()).rev() {
            triangles.swap(i, random.below(i + 1));
        }
        for t in &mut triangles {
            t.rotate_left(random.below(3));
        }
        let shared_corners = soup(positions.clone(), &triangles);
        for input in [shared_corners, explode(&positions, &triangles)] {
            let (mesh, report) = sound(&input);
            assert_eq!((report.duplicate_faces, report.flipped_faces), (0, 0));
            assert_eq!(report.components.len(), boxes as usize);
            assert_eq!(loop_sizes(&mesh), [(4, false)]);
        }
    }
}

/// A file in which every face has a copy turned the other way has no solids in contact.
#[test]
fn double_sided_surfaces_lose_their_back() {
    let (p, t) = open_sphere();
    let mut both = t.clone();
    both.extend(t.iter().map(|&[a, b, c]| [a, c, b]));
    let (mesh, report) = sound(&soup(p, &both));
    assert_eq!(report.duplicate_faces, t.len());
    assert!(mesh.topology.triangles().eq(t));
}

/// Three sheets at an edge, all in one direction of orientation: the pair that agrees is joined,
/// although another is flatter.
#[test]
fn crowded_edges_are_joined_by_orientation_first() {
    let p = vec![
        DVec3::ZERO,
        DVec3::X,
        DVec3::Y,
        -DVec3::Y,
        DVec3::new(0.0, 0.2, 1.0),
    ];
    // the first two would be the flattest pair
    let (mesh, report) = sound(&soup(p, &[[0, 1, 2], [0, 1, 3], [1, 0, 4]]));
    assert_eq!(report.flipped_faces, 0);
    assert_eq!(mesh.topology.boundary_loops().len(), 2);
    let lengths: Vec<usize> = mesh
        .topology
        .boundary_loops()
        .iter()
        .map(Vec::len)
        .collect();
    assert!(lengths.contains(&4) && lengths.contains(&3));
}

#[test]
fn closed_surfaces_of_mixed_orientation_turn_outwards() {
    let (p, t) = sphere();
    for share in [0, 3, 7, 10] {
        let mixed = |(i, &[a, b, c]): (usize, &[u32; 3])| {
            if i % 10 < share { [a, c, b] } else { [a, b, c] }
        };
        let mixed: Vec<[u32; 3]> = t.iter().enumerate().map(mixed).collect();
        let (mesh, report) = sound(&soup(p.clone(), &mixed));
        if share == 10 {
            // consistent: it stays as it is
            assert_eq!(report.flipped_faces, 0);
            assert!(mesh.topology.triangles().eq(mixed));
        } else {
            let [a, b, c] = mesh.corners(crate::mesh::FaceId(0));
            assert!((b - a).cross(c - a).dot(a) > 0.0, "{share}");
        }
    }
}

/// Copies of a vertex that differ by rounding are one vertex, in files with and without an index
/// list.
#[test]
fn copies_that_differ_by_rounding_are_welded() {
    let (p, t) = open_sphere();
    for (noise, exploded) in [(1e-17, true), (1e-7, true), (1e-16, false)] {
        let mut random = SplitMix::new(6);
        let mut input = explode(&p, &t);
        input.exploded = exploded;
        for q in &mut input.positions {
            *q += noise * random.direction();
        }
        let (mesh, report) = build(&input).expect("can be built");
        assert_eq!(mesh.vertex_count(), p.len());
        assert_eq!(report.welded_vertices, 3 * t.len() - p.len());
        assert!(report.welded_apart > 0 && report.notes.len() == 1);
        assert_eq!(loop_sizes(&mesh), [(RIM, false)]);
        let (_, exact) = build_welded(&input, Weld::Within(0.0)).expect("can be built");
        assert_eq!(exact.welded_apart, 0);
        assert!(exact.components.len() > 1);
    }
    let (mesh, _) = build_welded(&explode(&p, &t), Weld::Within(1e-3)).expect("can be built");
    assert_eq!(mesh.vertex_count(), p.len());
}

#[test]
fn a_hole_touching_itself_keeps_its_vertex() {
    let (p, mut t) = sphere();
    // two holes that meet in vertex 10 only
    let topology = Topology::from_triangles(p.len(), &t).expect("closed");
    let around: Vec<usize> = topology
        .outgoing(crate::mesh::VertexId(10))
        .map(|h| topology.face(h).index())
        .collect();
    let mut gone = [around[0], around[3]];
    gone.sort_unstable();
    t.remove(gone[1]);
    t.remove(gone[0]);
    let (mesh, report) = sound(&soup(p, &t));
    assert_eq!((report.pinched_vertices, report.appended_vertices), (1, 0));
    assert_eq!(loop_sizes(&mesh), [(3, false), (3, false)]);
}

#[test]
fn non_orientable_surfaces_are_left_alone() {
    let n = 24u32;
    let strip: Vec<DVec3> = (0..2 * n)
        .map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i / 2) / f64::from(n);
            let side = if i % 2 == 0 { -0.3 } else { 0.3 };
            let r = 3.0 + side * (0.5 * angle).cos();
            DVec3::new(r * angle.cos(), r * angle.sin(), side * (0.5 * angle).sin())
        })
        .collect();
    let mut moebius = Vec::new();
    for i in 0..n {
        let (a, b) = (2 * i, 2 * i + 1);
        let (c, d) = if i + 1 < n { (a + 2, b + 2) } else { (1, 0) };
        moebius.extend([[a, c, b], [b, c, d]]);
    }
    assert_eq!(
        build(&soup(strip.clone(), &moebius)),
        Err(BuildError::OneSided { faces: 48 })
    );
    let (p, t) = open_sphere();
    let mut both = moebius.clone();
    both.extend(t.iter().map(|t| t.map(|v| v + strip.len() as u32)));
    let mut input = soup([strip.clone(), p].concat(), &both);
    input.attributes.faces.tags = (0..both.len() as u32).map(|f| f % 2).collect();
    input.attributes.tags = vec![FaceTag::default(); 2];
    let (mesh, report) = sound(&input);
    assert_eq!(mesh.non_orientable, moebius);
    assert_eq!(mesh.attributes.non_orientable.tags.len(), moebius.len());
    assert_eq!(mesh.attributes.faces.tags.len(), t.len());
    assert_eq!(mesh.all_triangles().count(), both.len());
    assert_eq!(
        (report.non_orientable_faces, report.isolated_vertices),
        (48, 0)
    );
    assert_eq!(
        report.components[1],
        ComponentReport {
            faces: 48,
            vertices: 48,
            loops: 1,
            orientable: false,
            euler: 0
        }
    );
    assert_eq!(loop_sizes(&mesh), [(RIM, false)]);
}

#[test]
fn attributes_follow_their_vertices_and_faces() {
    let (p, t) = open_sphere();
    let mut input = explode(&p, &t);
    let shade = |q: &DVec3| [q.x.abs() as f32, q.y.abs() as f32, q.z.abs() as f32, 1.0];
    let shades = |positions: &[DVec3]| -> Vec<[f32; 4]> { positions.iter().map(shade).collect() };
    input.attributes.vertices = color_columns(&shades(&input.positions));
    input.corners.extend([0, 0, 1]);
    input.offsets.push(input.corners.len() as u32);
    input.attributes.faces.tags = (0..=t.len() as u32).map(|f| f % 3).collect();
    input.attributes.tags = vec![FaceTag::default(); 3];
    let (mesh, report) = sound(&input);
    assert_eq!(report.degenerate_faces, 1);
    assert_eq!(mesh.colors(), shades(&mesh.positions));
    assert!(
        mesh.attributes
            .faces
            .tags
            .iter()
            .copied()
            .eq((0..t.len() as u32).map(|f| f % 3))
    );
}

/// The corners of every triangle refer to the values they had in the file, also where vertices are
/// welded, polygons triangulated, faces flipped and edges cut; writing separates the vertices again.
#[test]
fn corners_keep_their_values() {
    let mut random = SplitMix::new(5);
    let mut separate = 0;
    for round in 0..2000 {
        let places = if round % 2 == 0 { 2 } else { 3 };
        let positions: Vec<DVec3> = (0..6 + random.below(9))
            .map(|_| DVec3::from([(); 3].map(|()| random.below(places) as f64)))
            .collect();
        let mut input = Soup {
            offsets: vec![0],
            ..Soup::default()
        };
        for _ in 0..=random.below(20) {
            for _ in 0..3 + random.below(3) {
                input.corners.push(random.below(positions.len()) as u32);
            }
            input.offsets.push(input.corners.len() as u32);
        }
        let corners = input.corners.len() as u32;
        // the value of a corner says which it is; that of a vertex, its place
        input.attributes.faces.texture = (0..corners).collect();
        let label = |v: usize| (v / (1 + round % 3)) as f64;
        let labels = (0..positions.len()).map(label).collect();
        input.attributes.vertices = vec![Column::decimals("label", labels)];
        input.positions = positions;
        let Ok((mesh, _)) = build(&input) else {
            continue;
        };
        separate += usize::from(!mesh.attributes.vertex_of_row.is_empty());
        let written = mesh.written();
        let columns = &written.attributes.vertices;
        assert_eq!(row_count(columns), written.positions.len());
        let texture = &written.attributes.faces.texture;
        for (&v, &corner) in written.triangles.as_flattened().iter().zip(texture) {
            let of_file = input.corners[corner as usize] as usize;
            let at = written.positions[v as usize];
            assert_eq!(at, input.positions[of_file], "round {round}");
            assert_eq!(columns[0].numbers.get(v as usize), label(of_file));
        }
    }
    assert!(separate > 300, "{separate}");
}

/// Few vertices at few places, many faces: every defect there is, all at once.
#[test]
fn random_soups_always_become_manifolds() {
    let mut random = SplitMix::new(7);
    for round in 0..3000 {
        let vertices = 4 + random.below(9);
        let faces = 1 + random.below(30);
        let places = if round % 3 == 0 { 2 } else { 40 };
        let positions = (0..vertices)
            .map(|_| DVec3::from([(); 3].map(|()| random.below(places) as f64)))
            .collect();
        let triangles: Vec<[u32; 3]> = (0..faces)
            .map(|_| [(); 3].map(|()| random.below(vertices) as u32))
            .collect();
        let mut input = soup(positions, &triangles);
        input.exploded = round % 2 == 0;
        match build(&input) {
            Ok((_, report)) => {
                let (mesh, _) = sound(&input);
                assert_eq!(
                    report.faces + report.duplicate_faces + report.degenerate_faces,
                    faces,
                    "round {round}"
                );
                // built again, it has nothing left to repair
                let again: Vec<[u32; 3]> = mesh.topology.triangles().collect();
                assert!(Topology::from_triangles(mesh.vertex_count(), &again).is_ok());
            }
            Err(BuildError::OnlyDegenerate { .. } | BuildError::OneSided { .. }) => {}
            Err(error) => panic!("round {round}: {error}"),
        }
    }
}
