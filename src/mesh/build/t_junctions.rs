//! T-junctions: boundary vertices that lie on boundary edges of other faces.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::weld::position_classes;
use crate::mesh::attributes::append_between;
use crate::mesh::{
    Column, DVec3, FaceData, FaceId, HalfedgeId, Mesh, NO_VALUE, Soup, TriangleBvh, VertexId,
    row_count,
};

/// Minimum distance of a vertex on an edge from its ends, in tolerances: a part of the edge then turns by at most 1/8.
const APART: f64 = 8.0;

/// A boundary edge.
struct Edge {
    /// The place of its first end in the list of corners, in the direction of its face.
    corner: u32,
    ends: [VertexId; 2],
    /// Vertices on the edge, each with its part of the way to the second end, ascending.
    inner: Vec<(f64, VertexId)>,
}

impl Edge {
    /// The ends with the vertices between them.
    fn chain(&self) -> impl Iterator<Item = VertexId> + '_ {
        let inner = self.inner.iter().map(|&(_, v)| v);
        let [a, b] = self.ends;
        std::iter::once(a).chain(inner).chain([b])
    }
}

/// Divides faces at the boundary vertices within `tolerance` of their boundary edges, but not of the ends of these, if
/// that lets a part of the edge coincide with another boundary edge. `soup` are the faces of the mesh as written. One
/// part replaces a face, the others follow all faces. New corners have texture coordinates and normals between those
/// of the ends.
pub(super) fn split_edges(mesh: &Mesh, soup: &mut Soup, tolerance: f64) {
    let mut edges = boundary_edges(mesh);
    let mut rim: Vec<VertexId> = edges.iter().flat_map(|edge| edge.ends).collect();
    rim.sort_unstable();
    rim.dedup();
    let (class, _) = position_classes(&mesh.positions, rim.iter().map(|v| v.0), tolerance);
    let class = |v: VertexId| class[v.index()];
    rim.retain(|&v| class(v) == v.0);
    find_inner_vertices(mesh, &mut edges, &rim, class, tolerance);
    keep_joined(&mut edges, class);
    if edges.iter().any(|edge| !edge.inner.is_empty()) {
        divide(soup, &edges);
    }
}

fn boundary_edges(mesh: &Mesh) -> Vec<Edge> {
    let topology = &mesh.topology;
    let boundary = topology.halfedges().filter(|&h| topology.is_boundary(h));
    let edge = |h: HalfedgeId| {
        let inner = h.twin();
        let ends = [topology.origin(inner), topology.target(inner)];
        let face = topology.face(inner);
        let mut corners = topology.face_vertices(face).into_iter();
        let at = corners.position(|v| v == ends[0]).expect("a corner");
        Edge {
            corner: 3 * face.0 + at as u32,
            ends,
            inner: Vec::new(),
        }
    };
    boundary.map(edge).collect()
}

fn find_inner_vertices(
    mesh: &Mesh,
    edges: &mut [Edge],
    rim: &[VertexId],
    class: impl Fn(VertexId) -> u32,
    tolerance: f64,
) {
    let segments: Vec<[u32; 3]> = edges
        .iter()
        .map(|Edge { ends: [a, b], .. }| [a.0, b.0, b.0])
        .collect();
    let bvh = TriangleBvh::new(&mesh.positions, &segments);
    // those of the face at an edge
    let corners = |edge: &Edge| mesh.topology.face_vertices(FaceId(edge.corner / 3));
    for &v in rim {
        let p = mesh.position(v);
        let reach = DVec3::splat(tolerance);
        bvh.for_each_overlapping(p - reach, p + reach, |e| {
            let edge = &mut edges[e as usize];
            let [a, b] = edge.ends.map(|end| mesh.position(end));
            let part = (p - a).dot(b - a) / (b - a).length_squared();
            let is_between = (0.0..=1.0).contains(&part)
                && [a, b].iter().all(|end| end.distance(p) > APART * tolerance)
                && corners(edge).iter().all(|&corner| class(corner) != v.0);
            if is_between && a.lerp(b, part).distance(p) <= tolerance {
                edge.inner.push((part, v));
            }
        });
    }
    for edge in edges {
        edge.inner.sort_by(|x, y| x.0.total_cmp(&y.0));
    }
}

/// Keeps the vertices on edges beside which a part of the edge coincides with another edge or a part of one.
fn keep_joined(edges: &mut [Edge], class: impl Fn(VertexId) -> u32) {
    let named = |a: VertexId, b: VertexId| {
        let (a, b) = (class(a), class(b));
        [a.min(b), a.max(b)]
    };
    loop {
        let mut count: FxHashMap<[u32; 2], u32> = FxHashMap::default();
        for edge in edges.iter() {
            for (a, b) in edge.chain().zip(edge.chain().skip(1)) {
                *count.entry(named(a, b)).or_default() += 1;
            }
        }
        let mut is_done = true;
        for edge in edges.iter_mut().filter(|edge| !edge.inner.is_empty()) {
            let parts = edge.chain().zip(edge.chain().skip(1));
            let joined: Vec<bool> = parts.map(|(a, b)| count[&named(a, b)] > 1).collect();
            let mut beside = joined.windows(2).map(|two| two[0] || two[1]);
            let before = edge.inner.len();
            edge.inner.retain(|_| beside.next() == Some(true));
            is_done &= edge.inner.len() == before;
        }
        if is_done {
            return;
        }
    }
}

/// A corner of the divided faces.
#[derive(Clone, Copy)]
struct Corner {
    vertex: u32,
    /// Its place in the list of corners, or that of the first end of its edge.
    place: u32,
    /// The place of the second end of its edge and its part of the way there, if it is new.
    between: Option<(u32, f64)>,
}

/// A part of a face, with the corners within each of its sides.
struct Part {
    corners: [Corner; 3],
    sides: [Vec<Corner>; 3],
}

impl Part {
    /// Triangles without corners within sides, none of which has zero area if the part has not.
    fn divided(self) -> Vec<[Corner; 3]> {
        let (mut parts, mut done) = (vec![self], Vec::new());
        while let Some(mut part) = parts.pop() {
            let Some(k) = part.sides.iter().position(|side| !side.is_empty()) else {
                done.push(part.corners);
                continue;
            };
            part.corners.rotate_left(k);
            part.sides.rotate_left(k);
            let ([a, b, c], [mut first, after, before]) = (part.corners, part.sides);
            let mut second = first.split_off(first.len() / 2);
            let middle = second.remove(0);
            parts.push(Self {
                corners: [middle, b, c],
                sides: [second, after, Vec::new()],
            });
            parts.push(Self {
                corners: [a, middle, c],
                sides: [first, Vec::new(), before],
            });
        }
        done
    }
}

/// Divides the faces at the vertices on their edges. `edges` are all boundary edges. One part replaces a face, the
/// others follow all faces.
fn divide(soup: &mut Soup, edges: &[Edge]) {
    let written = |edge: &Edge| (edge.ends[0], soup.corners[edge.corner as usize]);
    let written: FxHashMap<VertexId, u32> = edges.iter().map(written).collect();
    let at_corner: FxHashMap<u32, &Edge> = edges.iter().map(|edge| (edge.corner, edge)).collect();
    let with_inner = edges.iter().filter(|edge| !edge.inner.is_empty());
    let mut divided: Vec<u32> = with_inner.map(|edge| edge.corner / 3).collect();
    divided.sort_unstable();
    divided.dedup();
    let corner = |place: u32| Corner {
        vertex: soup.corners[place as usize],
        place,
        between: None,
    };
    let mut corners: Vec<Corner> = (0..soup.corners.len() as u32).map(corner).collect();
    let mut faces: Vec<u32> = (0..soup.face_count() as u32).collect();
    for face in divided {
        let places = [0, 1, 2].map(|k| 3 * face + k);
        let inner = |k: usize| {
            let next = places[(k + 1) % 3];
            let inner = at_corner.get(&places[k]).into_iter();
            let inner = inner.flat_map(|edge| &edge.inner);
            let corner = |&(part, v): &(f64, VertexId)| Corner {
                vertex: written[&v],
                place: places[k],
                between: Some((next, part)),
            };
            inner.map(corner).collect()
        };
        let whole = Part {
            corners: places.map(corner),
            sides: [0, 1, 2].map(inner),
        };
        let mut parts = whole.divided().into_iter();
        let first = parts.next().expect("at least one");
        corners[3 * face as usize..][..3].copy_from_slice(&first);
        for part in parts {
            corners.extend(part);
            faces.push(face);
        }
    }
    let all = &mut soup.attributes;
    let places = corners.iter().map(|c| c.place);
    let texture = with_values(&all.faces.texture, &mut all.texture, &corners);
    let normals = with_values(&all.faces.normals, &mut all.normals, &corners);
    all.faces = FaceData {
        texture,
        normals,
        ..all.faces.picked(&faces, &places)
    };
    soup.corners = corners.iter().map(|c| c.vertex).collect();
    soup.offsets = (0..=soup.corners.len() as u32).step_by(3).collect();
}

/// The rows of the values at corners, with new rows for new corners.
fn with_values(rows: &[u32], columns: &mut Arc<Vec<Column>>, corners: &[Corner]) -> Vec<u32> {
    if rows.is_empty() {
        return Vec::new();
    }
    let mut next = row_count(columns) as u32;
    let mut between = Vec::new();
    let row = |corner: &Corner| {
        let own = rows[corner.place as usize];
        let Some((end, part)) = corner.between else {
            return own;
        };
        let other = rows[end as usize];
        if own == NO_VALUE || other == NO_VALUE {
            return NO_VALUE;
        }
        between.push(([own, other], part));
        next += 1;
        next - 1
    };
    let rows = corners.iter().map(row).collect();
    if !between.is_empty() {
        let columns: &mut Vec<Column> = Arc::make_mut(columns);
        append_between(columns, &between.into_iter());
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::build::{build, stitch};
    use crate::mesh::{boundary_loops, check_mesh};
    use crate::random::SplitMix;
    use crate::shapes;

    /// A ball whose upper half has vertices of its own at the border, where `split` of the edges of its faces are
    /// divided at up to two places each.
    fn halves(split: f64) -> (Mesh, usize) {
        let (mut positions, triangles) = shapes::icosphere(4);
        let is_upper = |t: &[u32; 3]| t.iter().map(|&v| positions[v as usize].z).sum::<f64>() > 0.0;
        let (upper, lower): (Vec<_>, Vec<_>) = triangles.into_iter().partition(is_upper);
        let on_border = |v: u32| lower.as_flattened().contains(&v);
        let mut copy = FxHashMap::default();
        let mut faces = lower.clone();
        let mut random = SplitMix::new(3);
        for t in &upper {
            let mut polygon = Vec::new();
            for k in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|i| t[(k + i) % 3]);
                let mut own = |v: u32| {
                    let p = positions[v as usize];
                    *copy.entry(v).or_insert_with(|| {
                        positions.push(p);
                        positions.len() as u32 - 1
                    })
                };
                polygon.push(if on_border(a) { own(a) } else { a });
                let is_border =
                    !on_border(c) && lower.iter().any(|t| t.contains(&a) && t.contains(&b));
                if is_border && random.unit() < split {
                    let [p, q] = [a, b].map(|v| positions[v as usize]);
                    for part in [0.3, 0.8] {
                        polygon.push(positions.len() as u32);
                        positions.push(p.lerp(q, part));
                    }
                }
            }
            // a fan from the corner opposite of the divided edge
            let n = polygon.len();
            let apex = (0..n).find(|&i| t.contains(&polygon[i]) && !on_border(polygon[i]));
            let apex = apex.unwrap_or(0);
            faces.extend((1..n - 1).map(|i| [0, i, i + 1].map(|k| polygon[(apex + k) % n])));
        }
        let count = faces.len();
        (
            Mesh::from_triangles(positions, &faces).expect("manifold"),
            count,
        )
    }

    #[test]
    fn edges_are_split_at_the_vertices_on_them() {
        for split in [0.0, 0.5, 1.0] {
            let (mesh, faces) = halves(split);
            let whole = stitch(&mesh, 1e-9).expect("stitched");
            check_mesh(&whole).expect("sound");
            assert!(boundary_loops(&whole).is_empty(), "{split}");
            // each vertex within an edge divides the face on its other side
            let inner = whole.vertex_count() - shapes::icosphere(4).0.len();
            assert_eq!(whole.face_count(), faces + inner);
            assert!(split == 0.0 || inner > 20);
            let areas = whole.topology.faces().map(|f| {
                let [a, b, c] = whole.corners(f);
                (b - a).cross(c - a).length()
            });
            assert!(areas.fold(f64::INFINITY, f64::min) > 1e-5);
        }
    }

    #[test]
    fn vertices_that_touch_an_edge_without_an_edge_along_it_stay() {
        let corners = [
            [0., 0.],
            [2., 0.],
            [1., -1.],
            [1., 0.],
            [0.5, 1.],
            [1.5, 1.],
        ];
        let positions = corners.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        let mesh = Mesh::from_triangles(positions, &[[1, 0, 2], [3, 5, 4]]).expect("manifold");
        assert_eq!(stitch(&mesh, 1e-3), Ok(mesh));
        // nor is a flat face folded onto itself
        let positions = [0., 1., 2.].map(|x| DVec3::new(x, 1e-4 * x * x, 0.0));
        let mesh = Mesh::from_triangles(positions.to_vec(), &[[0, 1, 2]]).expect("manifold");
        assert_eq!(stitch(&mesh, 1e-3), Ok(mesh));
    }

    /// The texture coordinates at new corners are between those of the ends.
    #[test]
    fn new_corners_get_texture_coordinates() {
        let corners = [[0., 0.], [2., 0.], [1., -1.], [0.5, 0.], [1., 1.]];
        let positions = corners.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        let texture = |k: usize| {
            let of_rows = corners.iter().map(|c| c[k] / 4.0).collect();
            Column::decimals(["u", "v"][k], of_rows)
        };
        let mut soup = Soup {
            positions,
            corners: vec![1, 0, 2, 0, 3, 4, 3, 1, 4],
            offsets: vec![0, 3, 6, 9],
            ..Soup::default()
        };
        soup.attributes.texture = Arc::new(vec![texture(0), texture(1)]);
        soup.attributes.faces = FaceData {
            texture: soup.corners.clone(),
            ..FaceData::default()
        };
        let mesh = build(&soup).expect("a mesh").0;
        let stitched = stitch(&mesh, 1e-6).expect("stitched");
        assert_eq!(boundary_loops(&stitched).len(), 1);
        assert_eq!((mesh.face_count(), stitched.face_count()), (3, 4));
        let all = &stitched.attributes;
        for (corner, &row) in all.faces.texture.iter().enumerate() {
            let v = stitched
                .topology
                .triangles()
                .nth(corner / 3)
                .expect("a face")[corner % 3];
            let p = stitched.positions[v as usize];
            for (k, column) in all.texture.iter().enumerate() {
                assert_eq!(column.numbers.get(row as usize), p[k] / 4.0);
            }
        }
    }
}
