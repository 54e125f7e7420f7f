//! The load report of a finished mesh.

use super::{ComponentReport, Defect, DefectKind, LoadReport, Repaired, Triangles};
use crate::mesh::union_find::unite;
use crate::mesh::{DVec3, FaceId, HalfedgeId, Mesh, Soup, VertexId, components, is_slit, sides};

/// A triangle whose height is below this times its longest edge has zero area up to the rounding of
/// its coordinates (files usually have eight decimals).
const FLAT: f64 = 1e-8;

/// Collects defects, at most [`Defect::LIMIT`] of each kind.
struct Defects<'a> {
    soup: &'a Soup,
    triangles: &'a Triangles,
    list: Vec<Defect>,
    of_kind: usize,
}

impl Defects<'_> {
    fn push(&mut self, kind: DefectKind, position: DVec3, face: Option<u32>, vertex: Option<u32>) {
        if self.list.last().is_none_or(|d| d.kind != kind) {
            self.of_kind = 0;
        }
        self.of_kind += 1;
        if self.of_kind <= Defect::LIMIT {
            self.list.push(Defect {
                kind,
                position,
                file_face: face,
                file_vertex: vertex,
            });
        }
    }

    /// Defects at triangles of the file.
    fn push_triangles(&mut self, kind: DefectKind, triangles: impl Iterator<Item = u32>) {
        for t in triangles.take(Defect::LIMIT) {
            let corners = self.triangles.corners[t as usize];
            let sum: DVec3 = corners
                .iter()
                .map(|&v| self.soup.positions[v as usize])
                .sum();
            let face = self.triangles.file_face(t as usize);
            self.push(kind, sum / 3.0, Some(face), Some(corners[0]));
        }
    }
}

/// Builds the load report of a mesh.
pub(super) fn summarize(
    soup: &Soup,
    triangles: &Triangles,
    repaired: &Repaired,
    mesh: &Mesh,
) -> LoadReport {
    let at = |v: u32| soup.positions[v as usize];
    let mut defects = Defects {
        soup,
        triangles,
        list: Vec::new(),
        of_kind: 0,
    };
    for &f in &triangles.degenerate {
        let vertex = soup.face(f as usize).first().copied();
        let position = vertex.map_or(DVec3::ZERO, at);
        defects.push(DefectKind::DegenerateFace, position, Some(f), vertex);
    }
    defects.push_triangles(
        DefectKind::DegenerateFace,
        repaired.collapsed.iter().copied(),
    );
    defects.push_triangles(
        DefectKind::DuplicateFace,
        repaired.duplicates.iter().copied(),
    );
    let faces = mesh.topology.faces();
    let flat: Vec<u32> = faces
        .filter(|&f| is_flat(mesh.corners(f)))
        .map(|f| repaired.triangles.origin(f.index()) as u32)
        .collect();
    defects.push_triangles(DefectKind::ZeroAreaFace, flat.iter().copied());
    defects.push_triangles(DefectKind::FlippedFace, repaired.flipped.iter().copied());
    for &(t, [a, b]) in &repaired.cut_edges {
        let face = triangles.file_face(t as usize);
        let middle = at(a).midpoint(at(b));
        defects.push(DefectKind::NonManifoldEdge, middle, Some(face), Some(a));
    }
    let mut on_cut: Vec<u32> = repaired.cut_edges.iter().flat_map(|e| e.1).collect();
    on_cut.sort_unstable();
    let split: Vec<u32> = repaired
        .split
        .iter()
        .map(|s| s.0)
        .filter(|v| on_cut.binary_search(v).is_err())
        .collect();
    for &v in &split {
        defects.push(DefectKind::NonManifoldVertex, at(v), None, Some(v));
    }
    let (pinched, isolated) = special_vertices(mesh);
    for &v in &pinched {
        let file = repaired.source.as_ref().map_or(v.0, |of| of[v.index()]);
        defects.push(DefectKind::PinchedHole, mesh.position(v), None, Some(file));
    }
    let apart = distances_welded(soup, repaired);
    let mut notes = soup.notes.clone();
    if let Some(farthest) = apart.iter().copied().reduce(f64::max) {
        let count = apart.len();
        notes.push(format!(
            "{count} vertices welded with others up to {farthest:.1e} away"
        ));
    }
    let loops = mesh.topology.boundary_loops();
    let corner = |h: &HalfedgeId| mesh.position(mesh.topology.origin(*h));
    let polygons = loops.iter().map(|rim| rim.iter().map(corner).collect());
    let slits = polygons
        .filter(|points: &Vec<DVec3>| is_slit(points))
        .count();
    if slits > 0 {
        notes.push(format!(
            "{slits} of {} boundary loops are slits without area: stitching joins their sides",
            loops.len()
        ));
    }
    let parts = component_reports(mesh, &loops, &repaired.non_orientable_sheet);
    let mut sheets = repaired.non_orientable_sheet.clone();
    sheets.sort_unstable();
    sheets.dedup();
    defects.push_triangles(DefectKind::OneSidedComponent, sheets.into_iter());

    LoadReport {
        file_vertices: soup.positions.len(),
        file_faces: soup.face_count(),
        vertices: mesh.vertex_count(),
        faces: mesh.face_count() + mesh.non_orientable.len(),
        polygons_triangulated: triangles.polygons,
        duplicate_faces: repaired.duplicates.len(),
        degenerate_faces: triangles.degenerate.len() + repaired.collapsed.len(),
        zero_area_faces: flat.len(),
        welded_vertices: repaired.welded,
        welded_apart: apart.len(),
        isolated_vertices: isolated,
        flipped_faces: repaired.flipped.len(),
        non_manifold_edges: repaired.cut_edges.len(),
        split_vertices: split.len(),
        pinched_vertices: pinched.len(),
        appended_vertices: repaired.split.iter().map(|s| s.1 as usize).sum(),
        non_orientable_faces: mesh.non_orientable.len(),
        components: parts,
        defects: defects.list,
        attributes: mesh.attributes.summary(),
        notes,
        file_to_mesh: repaired.file_to_mesh.clone(),
    }
}

/// Distances of the file's vertices to those they are welded with, where these differ.
fn distances_welded(soup: &Soup, repaired: &Repaired) -> Vec<f64> {
    let (Some(to_mesh), Some(source)) = (&repaired.file_to_mesh, &repaired.source) else {
        return Vec::new();
    };
    let at = |v: usize| soup.positions[v];
    let moved = to_mesh.iter().enumerate();
    let distances = moved.map(|(v, &m)| at(v).distance(at(source[m as usize] as usize)));
    distances.filter(|&d| d > 0.0).collect()
}

/// Whether the height over the longest edge is nothing but rounding.
fn is_flat([a, b, c]: [DVec3; 3]) -> bool {
    let longest = a
        .distance_squared(b)
        .max(b.distance_squared(c))
        .max(c.distance_squared(a));
    (b - a).cross(c - a).length_squared() <= (FLAT * longest).powi(2)
}

/// Vertices at which a boundary touches itself, and the number of vertices without a face.
fn special_vertices(mesh: &Mesh) -> (Vec<VertexId>, usize) {
    let topology = &mesh.topology;
    let mut in_non_orientable = vec![
        false;
        if mesh.non_orientable.is_empty() {
            0
        } else {
            mesh.vertex_count()
        }
    ];
    for &v in mesh.non_orientable.iter().flatten() {
        in_non_orientable[v as usize] = true;
    }
    let mut pinched = Vec::new();
    let mut isolated = 0;
    for v in mesh.topology.vertices() {
        let h = topology.halfedge_of_vertex(v);
        if !h.is_some() {
            isolated += usize::from(!in_non_orientable.get(v.index()).is_some_and(|&used| used));
        } else if topology.is_boundary(h)
            && topology
                .outgoing(v)
                .filter(|&h| topology.is_boundary(h))
                .count()
                > 1
        {
            pinched.push(v);
        }
    }
    (pinched, isolated)
}

fn component_reports(
    mesh: &Mesh,
    loops: &[Vec<HalfedgeId>],
    non_orientable_sheet: &[u32],
) -> Vec<ComponentReport> {
    let topology = &mesh.topology;
    let parts = components(topology);
    let empty = ComponentReport {
        faces: 0,
        vertices: 0,
        loops: 0,
        orientable: true,
        euler: 0,
    };
    let mut reports = vec![empty; parts.count];
    for (f, &c) in parts.of_face.iter().enumerate() {
        let part = &mut reports[c as usize];
        part.faces += 1;
        part.euler += 1;
        for h in topology.face_halfedges(FaceId::from(f)) {
            // each edge once: by its first half-edge, or by the only one with a face
            if h.0 & 1 == 0 || topology.is_boundary(h.twin()) {
                part.euler -= 1;
            }
        }
    }
    for v in mesh.topology.vertices() {
        let h = topology.halfedge_of_vertex(v);
        if h.is_some() {
            let inner = if topology.is_boundary(h) { h.twin() } else { h };
            let part = &mut reports[parts.of_face[topology.face(inner).index()] as usize];
            part.vertices += 1;
            part.euler += 1;
        }
    }
    for one in loops {
        let face = topology.face(one[0].twin());
        reports[parts.of_face[face.index()] as usize].loops += 1;
    }
    reports.extend(non_orientable_reports(
        &mesh.non_orientable,
        non_orientable_sheet,
    ));
    reports
}

/// The same counts for components that have no half-edges.
fn non_orientable_reports(triangles: &[[u32; 3]], sheet: &[u32]) -> Vec<ComponentReport> {
    let mut sheets = sheet.to_vec();
    sheets.sort_unstable();
    sheets.dedup();
    sheets
        .iter()
        .map(|&one| {
            let of_sheet = || {
                triangles
                    .iter()
                    .zip(sheet)
                    .filter(|p| *p.1 == one)
                    .map(|p| p.0)
            };
            let mut vertices: Vec<u32> = of_sheet().flatten().copied().collect();
            vertices.sort_unstable();
            vertices.dedup();
            let mut edges: Vec<[u32; 2]> = of_sheet()
                .flat_map(|&t| sides(t))
                .map(|[a, b]| [a.min(b), a.max(b)])
                .collect();
            edges.sort_unstable();
            let rim: Vec<[u32; 2]> = edges
                .chunk_by(|x, y| x == y)
                .filter(|same| same.len() == 1)
                .map(|same| same[0])
                .collect();
            edges.dedup();
            let faces = of_sheet().count();
            ComponentReport {
                faces,
                vertices: vertices.len(),
                loops: count_rings(&vertices, &rim),
                orientable: false,
                euler: signed(vertices.len()) - signed(edges.len()) + signed(faces),
            }
        })
        .collect()
}

/// Number of connected pieces of a set of edges.
fn count_rings(vertices: &[u32], edges: &[[u32; 2]]) -> usize {
    let place = |v: u32| vertices.partition_point(|&w| w < v);
    let mut link: Vec<u32> = (0..vertices.len() as u32).collect();
    let mut touched = vec![false; vertices.len()];
    for &[a, b] in edges {
        let (a, b) = (place(a), place(b));
        touched[a] = true;
        touched[b] = true;
        unite(&mut link, a as u32, b as u32);
    }
    (0..vertices.len())
        .filter(|&i| touched[i] && link[i] == i as u32)
        .count()
}

fn signed(count: usize) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}
