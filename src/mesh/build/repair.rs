//! The repairs, from index triples to a topology.

use rustc_hash::FxHashSet;

use super::edges::{ends, following};
use super::fans::{
    Fans, corners_as_triangles, cut_parallel_edges, fans, has_pillow, join_pinches, name_vertices,
};
use super::join::{NONE, Sheets};
use super::weld::position_classes;
use crate::mesh::{DVec3, Topology, TopologyError, sides};

/// Triangles of the mesh with the corresponding triangles of the file.
#[derive(Default)]
pub(super) struct Faces {
    /// Corners, as vertices of the mesh.
    pub corners: Vec<[u32; 3]>,
    /// The triangle of the file for each triangle; empty if the numbers are equal.
    origin: Option<Vec<u32>>,
}

impl Faces {
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Whether they have the numbers of the triangles of the file, and all of them are here.
    pub fn are_those_of_file(&self) -> bool {
        self.origin.is_none() && !self.is_empty()
    }

    /// The triangle of the file for face `i`.
    pub fn origin(&self, i: usize) -> usize {
        self.origin.as_ref().map_or(i, |of| of[i] as usize)
    }
}

/// The repaired connectivity and the repaired places, in faces and vertices of the file.
pub(super) struct Repaired {
    pub triangles: Faces,
    pub non_orientable: Faces,
    /// The lowest face of the sheet of each non-orientable face.
    pub non_orientable_sheet: Vec<u32>,
    /// The file vertex of each mesh vertex; empty if the numbers are equal.
    pub source: Option<Vec<u32>>,
    pub file_to_mesh: Option<Vec<u32>>,
    pub welded: usize,
    /// Faces removed as copies of earlier ones.
    pub duplicates: Vec<u32>,
    /// Faces removed because welding left them fewer than three vertices.
    pub collapsed: Vec<u32>,
    pub flipped: Vec<u32>,
    /// Face and vertices of each edge that was cut.
    pub cut_edges: Vec<(u32, [u32; 2])>,
    /// Vertices that were split, with the number of copies appended.
    pub split: Vec<(u32, u32)>,
}

impl Repaired {
    fn untouched(triangles: &[[u32; 3]]) -> Self {
        Self {
            triangles: Faces {
                corners: triangles.to_vec(),
                origin: None,
            },
            non_orientable: Faces::default(),
            non_orientable_sheet: Vec::new(),
            source: None,
            file_to_mesh: None,
            welded: 0,
            duplicates: Vec::new(),
            collapsed: Vec::new(),
            flipped: Vec::new(),
            cut_edges: Vec::new(),
            split: Vec::new(),
        }
    }
}

/// Builds an oriented manifold of the triangles. Returns early if nothing needs repair.
///
/// # Errors
/// A repair failed, which is an internal error.
pub(super) fn repair(
    positions: &[DVec3],
    exploded: bool,
    triangles: &[[u32; 3]],
    tolerance: f64,
) -> Result<(Topology, Repaired), TopologyError> {
    let n = positions.len();
    if exploded || is_exploded(n, triangles) {
        return repair_exploded(positions, triangles, tolerance);
    }
    if let Ok(topology) = Topology::from_triangles(n, triangles)
        && !has_pillow(&topology)
    {
        let rim: Vec<u32> = topology
            .halfedges()
            .filter(|&h| topology.is_boundary(h))
            .map(|h| topology.origin(h).0)
            .collect();
        if position_classes(positions, rim.into_iter(), tolerance).1 == 0 {
            return Ok((topology, Repaired::untouched(triangles)));
        }
    }
    repair_slowly(positions, triangles, None, tolerance)
}

/// Whether every vertex is used by a single face, as in a file without an index list.
fn is_exploded(vertices: usize, triangles: &[[u32; 3]]) -> bool {
    if triangles.len() < 2 || vertices < 3 * triangles.len() {
        return false;
    }
    let mut seen = vec![false; vertices];
    triangles
        .iter()
        .flatten()
        .all(|&v| !std::mem::replace(&mut seen[v as usize], true))
}

/// Welds all positions that are equal within `tolerance`. If the result is a manifold, it is the
/// intended mesh.
fn repair_exploded(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    tolerance: f64,
) -> Result<(Topology, Repaired), TopologyError> {
    let mut used = vec![false; positions.len()];
    for &v in triangles.iter().flatten() {
        used[v as usize] = true;
    }
    let members: Vec<u32> = (0..positions.len() as u32)
        .filter(|&v| used[v as usize])
        .collect();
    let (class, copies) = position_classes(positions, members.into_iter(), tolerance);
    let welded: Vec<[u32; 3]> = triangles
        .iter()
        .map(|t| t.map(|v| class[v as usize]))
        .collect();
    let mut source = Vec::with_capacity(positions.len() - copies);
    let mut file_to_mesh: Vec<u32> = Vec::with_capacity(positions.len());
    for v in 0..positions.len() {
        let first = class[v] as usize;
        if first == v {
            file_to_mesh.push(source.len() as u32);
            source.push(v as u32);
        } else {
            file_to_mesh.push(file_to_mesh[first]);
        }
    }
    let corners: Vec<[u32; 3]> = welded
        .iter()
        .map(|t| t.map(|v| file_to_mesh[v as usize]))
        .collect();
    let topology = match Topology::from_triangles(source.len(), &corners) {
        Ok(topology) if !has_pillow(&topology) => topology,
        _ => return repair_slowly(positions, triangles, Some(&welded), tolerance),
    };
    if copies == 0 {
        return Ok((topology, Repaired::untouched(&corners)));
    }
    let repaired = Repaired {
        source: Some(source),
        file_to_mesh: Some(file_to_mesh),
        welded: copies,
        ..Repaired::untouched(&corners)
    };
    Ok((topology, repaired))
}

/// All repairs. `own` are the corners of the file. `welded`, given for exploded files, has one
/// vertex for each position.
fn repair_slowly(
    positions: &[DVec3],
    own: &[[u32; 3]],
    welded: Option<&[[u32; 3]]>,
    tolerance: f64,
) -> Result<(Topology, Repaired), TopologyError> {
    let n = positions.len();
    let at = |v: u32| positions[v as usize];
    let faces = own.len() as u32;
    let mut sheets = Sheets::new(own.len());
    let mut collapsed = Vec::new();
    let mut by_position = welded.unwrap_or(own).to_vec();
    for f in 0..faces {
        let t = by_position[f as usize];
        if t[0] == t[1] || t[1] == t[2] || t[2] == t[0] {
            sheets.dropped[f as usize] = true;
            collapsed.push(f);
        }
    }
    sheets.join_mesh(&by_position, at, n);
    let seams = if welded.is_none() {
        let needles = join_seams(&mut sheets, positions, own, &mut by_position, tolerance);
        collapsed.extend(needles.iter().flatten());
        collapsed.sort_unstable();
        needles.is_some()
    } else {
        false
    };
    let duplicates = (0..faces)
        .filter(|&f| sheets.dropped[f as usize] && collapsed.binary_search(&f).is_err())
        .collect();
    let mut cut_edges = sheets.non_manifold.clone();
    let mut fans = if cut_edges.is_empty() && !seams {
        fans(own, &by_position, &sheets.mate)
    } else {
        let suspects = (!seams).then(|| std::mem::take(&mut sheets.crowded));
        let (fans, parallel) =
            cut_parallel_edges(own, &by_position, &mut sheets, suspects.as_deref());
        cut_edges.extend(parallel);
        fans
    };
    let non_orientable: Vec<bool> = (0..faces).map(|f| sheets.is_non_orientable(f)).collect();
    cut_edges.sort_unstable();
    cut_edges.dedup();
    let flipped = faces_to_turn(&mut sheets, &non_orientable, own, positions);
    let kept = |f: &u32| !sheets.dropped[*f as usize] && !non_orientable[*f as usize];
    let origin: Vec<u32> = (0..faces).filter(kept).collect();
    let oriented = |corners: &[[u32; 3]]| -> Vec<[u32; 3]> {
        let turn = |f: u32| {
            let t = corners[f as usize];
            if flipped.binary_search(&f).is_ok() {
                [t[0], t[2], t[1]]
            } else {
                t
            }
        };
        origin.iter().map(|&f| turn(f)).collect()
    };
    let position_of_fan = label_fans(&fans, &by_position);
    let split = oriented(&corners_as_triangles(&fans.of_corner));
    let open: Vec<u32> = (0..3 * faces)
        .filter(|&c| sheets.mate[c as usize] == NONE && kept(&(c / 3)))
        .flat_map(|c| [c, following(c)])
        .map(|c| fans.of_corner[c as usize])
        .collect();
    join_pinches(&mut fans, &split, &position_of_fan, &open)?;

    let used: Vec<bool> = sheets.dropped.iter().map(|d| !d).collect();
    let names = name_vertices(&fans, own.as_flattened(), n, &used);
    let named: Vec<[u32; 3]> = corners_as_triangles(&fans.of_corner)
        .iter()
        .enumerate()
        .map(|(f, t)| {
            if used[f] {
                t.map(|fan| names.of_fan[fan as usize])
            } else {
                [NONE; 3]
            }
        })
        .collect();
    let corners = oriented(&named);
    let aside: Vec<u32> = (0..faces)
        .filter(|&f| non_orientable[f as usize] && used[f as usize])
        .collect();
    let identity = names
        .file_to_mesh
        .iter()
        .enumerate()
        .all(|(v, &m)| m == v as u32);
    let topology = Topology::from_triangles(names.source.len(), &corners)?;
    let repaired = Repaired {
        triangles: Faces {
            corners,
            origin: Some(origin),
        },
        non_orientable_sheet: aside.iter().map(|&f| sheets.find(f).0).collect(),
        non_orientable: Faces {
            corners: aside.iter().map(|&f| named[f as usize]).collect(),
            origin: Some(aside),
        },
        source: Some(names.source),
        file_to_mesh: (!identity).then_some(names.file_to_mesh),
        welded: names.welded,
        duplicates,
        collapsed,
        flipped,
        cut_edges: cut_edges
            .iter()
            .map(|&c| (c / 3, <[u32; 2]>::from(ends(own, c))))
            .collect(),
        split: names.copied,
    };
    Ok((topology, repaired))
}

/// Joins boundary edges at the same positions within `tolerance`. Afterwards `by_position` contains
/// one vertex per boundary position. Returns the removed faces, see [`drop_needles`]; `None` if no two boundary
/// vertices have the same position.
fn join_seams(
    sheets: &mut Sheets,
    positions: &[DVec3],
    own: &[[u32; 3]],
    by_position: &mut Vec<[u32; 3]>,
    tolerance: f64,
) -> Option<Vec<u32>> {
    let mut rim: Vec<u32> = (0..sheets.mate.len() as u32)
        .filter(|&c| sheets.mate[c as usize] == NONE && !sheets.dropped[c as usize / 3])
        .flat_map(|c| <[u32; 2]>::from(ends(own, c)))
        .collect();
    rim.sort_unstable();
    rim.dedup();
    let (mut class, copies) = position_classes(positions, rim.into_iter(), tolerance);
    if copies == 0 {
        return None;
    }
    let needles = drop_needles(sheets, own, &class);
    // any other edge of zero length must not be welded into a point, or its faces would be lost
    let kept = own.iter().zip(&sheets.dropped);
    for (t, _) in kept.filter(|&(_, &is_dropped)| !is_dropped) {
        for [v, w] in sides(*t) {
            if class[v as usize] == class[w as usize] {
                class[v as usize] = v;
                class[w as usize] = w;
            }
        }
    }
    *by_position = own.iter().map(|t| t.map(|v| class[v as usize])).collect();
    let at = |v: u32| positions[v as usize];
    sheets.join_seams(by_position, own, at, positions.len());
    Some(needles)
}

/// Drops needles: faces with two or three corners at one position, named by `class`. The faces on both sides of a
/// needle are neighbours without it. Needles stay that join two other faces across their long sides, unless open
/// edges coincide at the position. So those around a pole stay. Returns the dropped faces.
fn drop_needles(sheets: &mut Sheets, own: &[[u32; 3]], class: &[u32]) -> Vec<u32> {
    let named = |c: u32| {
        let (a, b) = ends(own, c);
        [class[a as usize], class[b as usize]]
    };
    let is_long = |c: u32| named(c)[0] != named(c)[1];
    let corner_edges = |f: u32| 3 * f..3 * f + 3;
    let mut suspects: Vec<u32> = (0..own.len() as u32)
        .filter(|&f| !sheets.dropped[f as usize] && !corner_edges(f).all(is_long))
        .collect();
    let mut needles = Vec::new();
    while !suspects.is_empty() {
        let seams = ends_of_seams(sheets, named);
        let is_needle = |f: &u32| {
            let joined = |&c: &u32| is_long(c) && sheets.mate[c as usize] != NONE;
            let mut short = corner_edges(*f).filter(|&c| !is_long(c));
            corner_edges(*f).filter(joined).count() < 2
                || short.any(|c| seams.contains(&named(c)[0]))
        };
        let (found, rest): (Vec<u32>, Vec<u32>) = suspects.into_iter().partition(is_needle);
        if found.is_empty() {
            break;
        }
        for c in found.iter().copied().flat_map(corner_edges) {
            sheets.dropped[c as usize / 3] = true;
            let mate = std::mem::replace(&mut sheets.mate[c as usize], NONE);
            if mate != NONE {
                sheets.mate[mate as usize] = NONE;
            }
        }
        needles.extend(found);
        suspects = rest;
    }
    needles
}

/// The positions, by `named`, at which open edges end that coincide with others.
fn ends_of_seams(sheets: &Sheets, named: impl Fn(u32) -> [u32; 2]) -> FxHashSet<u32> {
    let open = (0..sheets.mate.len() as u32)
        .filter(|&c| sheets.mate[c as usize] == NONE && !sheets.dropped[c as usize / 3]);
    let mut edges: Vec<[u32; 2]> = open
        .map(|c| {
            let [a, b] = named(c);
            [a.min(b), a.max(b)]
        })
        .filter(|[a, b]| a != b)
        .collect();
    edges.sort_unstable();
    let coincident = edges.chunk_by(|x, y| x == y).filter(|same| same.len() > 1);
    coincident.flat_map(|same| same[0]).collect()
}

/// Faces to flip so that each sheet is oriented, ascending: a closed sheet with outward normals, an
/// open one like the majority of its faces. A sheet whose faces agree is not changed.
fn faces_to_turn(
    sheets: &mut Sheets,
    non_orientable: &[bool],
    corners: &[[u32; 3]],
    positions: &[DVec3],
) -> Vec<u32> {
    /// Of each sheet, by its lowest face.
    #[derive(Clone, Copy, Default)]
    struct Sheet {
        /// Faces like the lowest one, and the others.
        count: [usize; 2],
        is_open: bool,
        /// Six times the volume that the sheet encloses if all faces are oriented like the lowest.
        volume: f64,
    }
    let faces = non_orientable.len() as u32;
    let mut of_root = vec![Sheet::default(); faces as usize];
    for f in 0..faces {
        if sheets.dropped[f as usize] || non_orientable[f as usize] {
            continue;
        }
        let (root, turned) = sheets.find(f);
        let sheet = &mut of_root[root as usize];
        sheet.count[usize::from(turned)] += 1;
        sheet.is_open |= (3 * f..3 * f + 3).any(|c| sheets.mate[c as usize] == NONE);
        let origin = positions[corners[root as usize][0] as usize];
        let [a, b, c] = corners[f as usize].map(|v| positions[v as usize] - origin);
        let cone = a.dot(b.cross(c));
        sheet.volume += if turned { -cone } else { cone };
    }
    (0..faces)
        .filter(|&f| {
            if sheets.dropped[f as usize] || non_orientable[f as usize] {
                return false;
            }
            let (root, turned) = sheets.find(f);
            let sheet = &of_root[root as usize];
            let [like, unlike] = sheet.count;
            let is_mixed = like > 0 && unlike > 0;
            let keep_like = if is_mixed && !sheet.is_open && sheet.volume != 0.0 {
                sheet.volume > 0.0
            } else {
                like >= unlike
            };
            turned == keep_like
        })
        .collect()
}

fn label_fans(fans: &Fans, by_position: &[[u32; 3]]) -> Vec<u32> {
    let mut label = vec![0; fans.count];
    for (fan, v) in fans.of_corner.iter().zip(by_position.as_flattened()) {
        label[*fan as usize] = *v;
    }
    label
}
