//! Attributes of patches, which continue those around them.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use robust::{Coord, orient2d};

use crate::fill::harmonic::Harmonic;
use crate::fill::options::{FillOptions, PatchTexture};
use crate::fill::result::FilledHole;
use crate::fill::texture::{Extension, RimColors, Uncharted, append_own_charts, overlapping};
use crate::mesh::{
    Attributes, Column, DVec3, FaceId, FaceTag, Mesh, NO_VALUE, TEXTURE_NUMBER, Topology, VertexId,
    columns_named, row_count,
};

/// How patches look, besides their shape.
#[derive(Clone, Debug)]
pub(super) struct Look {
    /// Whether the faces of each patch get a group.
    pub labels: bool,
    pub texture: PatchTexture,
    /// The colours along all rims. They are read when they are needed, because images may be large.
    colors: Arc<OnceLock<RimColors>>,
}

impl Look {
    pub fn new(options: &FillOptions) -> Self {
        Self {
            labels: options.label_patches,
            texture: options.patch_texture,
            colors: Arc::default(),
        }
    }

    /// The colours along the rims of the patches, which are the same for all triangulations.
    fn colors(&self, mesh: &Mesh, patches: &[PatchData<'_>]) -> &RimColors {
        self.colors.get_or_init(|| {
            let corners = |edge: &[RimCorner; 2]| edge.map(|at| at.corner as u32);
            let rim = |patch: &PatchData<'_>| patch.rim.iter().map(corners).collect();
            let rims: Vec<Vec<[u32; 2]>> = patches.iter().map(rim).collect();
            let of_corners = with_texture_of_corners(mesh);
            RimColors::read(of_corners.as_ref().unwrap_or(&mesh.attributes), &rims)
        })
    }

    /// Whether patches may get images of their own.
    pub fn makes_images(&self, mesh: &Mesh) -> bool {
        self.texture.makes_images() && mesh.attributes.has_texture()
    }

    /// Reads the colours that the patches over `holes` may need, so that they are known later.
    pub fn prepare(&self, mesh: &Mesh, holes: &[FilledHole], topology: &Topology) {
        if self.makes_images(mesh) {
            let patch = |hole| PatchData::new(mesh, hole, topology, &[]);
            let patches: Vec<PatchData<'_>> = holes.iter().map(patch).collect();
            self.colors(mesh, &patches);
        }
    }
}

/// The attributes of a mesh with patches over `holes`, whose filled form has these faces and positions,
/// and for holes whose patches could get no texture the reason.
///
/// Numbers of vertices continue harmonically from the rims, labels are those of the nearest rim
/// vertex, normals those of the patch. Texture coordinates continue harmonically where the rim lies in
/// one chart and has room in its image; other patches get a chart in an image of their own. Those of vertices do
/// likewise, and are zero in a patch that can get no chart.
/// Numbers of faces continue likewise. Else faces have the data of the face across the first edge of their first
/// rim, and the tags of `holes` among `tags`.
pub(super) fn filled_attributes(
    mesh: &Mesh,
    holes: &[FilledHole],
    tags: &[FaceTag],
    topology: &Topology,
    positions: &[DVec3],
    look: &Look,
) -> (Attributes, Vec<(usize, String)>) {
    let of_corners = with_texture_of_corners(mesh);
    let of_vertices = of_corners.is_some();
    let mut attributes = of_corners.unwrap_or_else(|| mesh.attributes.clone());
    attributes.tags = tags.to_vec();
    if !tags.is_empty() {
        // tags of patches in a mesh without tags
        attributes.faces.tags.resize(mesh.face_count(), 0);
        let aside = mesh.non_orientable.len();
        attributes.non_orientable.tags.resize(aside, 0);
    }
    if attributes == Attributes::default() {
        return (attributes, Vec::new());
    }
    let mut patches = Vec::with_capacity(holes.len());
    let mut extensions = Vec::with_capacity(holes.len());
    // continuations of texture coordinates of vertices that are no extensions of a chart
    let mut others = Vec::with_capacity(holes.len());
    for hole in holes {
        let mut patch = PatchData::new(mesh, hole, topology, positions);
        patch.prepare_equation(&mesh.attributes);
        patch.vertices(&mut attributes);
        patch.faces(&mut attributes);
        let tag = (!tags.is_empty()).then_some(hole.tag);
        let (first, like) = (hole.faces.start, hole.like.index());
        attributes.append_triangles(first, like, tag, &patch.triangles);
        let extends = look.texture.extends();
        let continued = (extends || of_vertices).then(|| patch.continuation(&attributes));
        let continued = continued.flatten();
        let is_chart = |c: &Extension| extends && patch.is_chart(&attributes, c);
        if continued.as_ref().is_some_and(is_chart) {
            extensions.push(continued);
            others.push(None);
        } else {
            extensions.push(None);
            others.push(continued);
        }
        patch.normals(&mut attributes);
        // its factor is large
        patch.equation = None;
        patches.push(patch);
    }
    if look.texture == PatchTexture::Auto {
        let overlap = overlapping(&attributes, mesh.face_count(), &extensions);
        for (i, overlaps) in overlap.into_iter().enumerate() {
            let is_wrong =
                overlaps || extensions[i].is_some() && look.colors(mesh, &patches).is_blank(i);
            if is_wrong && let Some(extension) = extensions[i].take() {
                others[i] = Some(extension);
            }
        }
    }
    for (patch, extension) in patches.iter().zip(&extensions) {
        if let Some(extension) = extension {
            patch.extend(&mut attributes, extension);
        }
    }
    let mut failed = Vec::new();
    if look.texture.makes_images() {
        let rest = patches.iter().enumerate().zip(&extensions);
        let rest = rest.filter(|((_, patch), e)| e.is_none() && patch.has_texture(&attributes));
        let uncharted: Vec<Uncharted<'_>> = rest
            .map(|((hole, patch), _)| Uncharted {
                hole,
                faces: patch.hole.faces.clone(),
                triangles: &patch.triangles,
                rim: patch.rim_ends(),
            })
            .collect();
        if !uncharted.is_empty() {
            let colors = look.colors(mesh, &patches);
            failed = append_own_charts(&mut attributes, &uncharted, positions, colors);
        }
    }
    let is_wanted = look.texture != PatchTexture::None;
    if of_vertices && is_wanted {
        for (patch, other) in patches.iter().zip(&others) {
            if let Some(other) = other.as_ref().filter(|_| patch.is_bare(&attributes)) {
                patch.extend(&mut attributes, other);
            }
        }
    }
    for patch in &patches {
        patch.number_no_image(&mut attributes);
    }
    if of_vertices {
        for (i, patch) in patches.iter().enumerate() {
            let is_left = is_wanted && patch.is_continuous(&attributes);
            if is_left || !patch.is_bare(&attributes) {
                continue;
            }
            patch.blank(&mut attributes);
            if is_wanted && failed.iter().all(|(hole, _)| *hole != i) {
                failed.push((i, "its rim crosses a seam of the texture".to_owned()));
            }
        }
        let triangles: Vec<[u32; 3]> = topology.triangles().collect();
        attributes.return_texture(mesh, &triangles);
    }
    (attributes, failed)
}

/// The attributes of a mesh with the texture coordinates of vertices as those of corners, if it has such.
fn with_texture_of_corners(mesh: &Mesh) -> Option<Attributes> {
    let triangles = mesh.topology.triangles();
    let aside = &mesh.non_orientable;
    mesh.attributes.with_texture_of_corners(triangles, aside)
}

/// A patch and what its attributes continue.
struct PatchData<'a> {
    hole: &'a FilledHole,
    positions: &'a [DVec3],
    triangles: Vec<[u32; 3]>,
    /// The edges of the patch with a given face beyond them: their ends, and the corners there of the
    /// face.
    rim: Vec<[RimCorner; 2]>,
    /// Whether the patch has no other boundary, also not with another patch.
    is_closed: bool,
    /// The equation of its new vertices, once it is prepared.
    equation: Option<Harmonic>,
}

/// A vertex on a rim and a corner of a given face at it.
#[derive(Clone, Copy)]
struct RimCorner {
    vertex: u32,
    corner: usize,
}

impl RimCorner {
    fn face(self) -> usize {
        self.corner / 3
    }
}

impl<'a> PatchData<'a> {
    fn new(mesh: &Mesh, hole: &'a FilledHole, topology: &Topology, positions: &'a [DVec3]) -> Self {
        let faces = || hole.faces.clone().map(FaceId::from);
        let triangles = faces().map(|f| topology.face_vertices(f).map(|v| v.0));
        let (mut rim, mut is_closed) = (Vec::new(), true);
        for h in faces().flat_map(|f| topology.face_halfedges(f)) {
            let beyond = topology.face(h.twin());
            if beyond.is_some() && beyond.index() < mesh.face_count() {
                let corners = topology.face_vertices(beyond);
                rim.push([topology.origin(h), topology.target(h)].map(|v| {
                    let k = corners.iter().position(|&c| c == v);
                    RimCorner {
                        vertex: v.0,
                        corner: 3 * beyond.index() + k.expect("the faces share the edge"),
                    }
                }));
            } else if !(beyond.is_some() && hole.faces.contains(&beyond.index())) {
                is_closed = false;
            }
        }
        Self {
            hole,
            positions,
            triangles: triangles.collect(),
            rim,
            is_closed,
            equation: None,
        }
    }

    /// Prepares the equation if some of the attributes are interpolated.
    fn prepare_equation(&mut self, all: &Attributes) {
        let has_columns = all.has_vertex_columns() || !all.faces.columns.is_empty();
        let is_needed = has_columns || !all.faces.texture.is_empty();
        let new = self.hole.vertices.clone();
        if is_needed && !new.is_empty() {
            let triangles = self.triangles.iter().copied();
            self.equation = Some(Harmonic::new(triangles, new, self.positions));
        }
    }

    /// Appends the numbers of the new vertices.
    fn vertices(&mut self, attributes: &mut Attributes) {
        let Some(equation) = &mut self.equation else {
            return;
        };
        let (rim, nearest) = (equation.rim.clone(), equation.nearest.clone());
        let given = self.hole.vertices.start;
        attributes.append_interpolated(given, &rim, &nearest, |at_rim| equation.solve(at_rim));
        if let Some(axes) = columns_named(&attributes.vertices, ["nx", "ny", "nz"]) {
            let known = attributes.rows_of(rim.iter().copied());
            let columns = &mut attributes.vertices;
            let first = row_count(columns) - nearest.len();
            let pairs = rim.iter().zip(known);
            let known: Vec<(u32, usize)> = pairs.map(|(v, row)| (v.0, row as usize)).collect();
            let normals = self.surface_normals(columns, axes, &known);
            for (row, normal) in (first..).zip(normals) {
                for (k, x) in axes.into_iter().zip(normal.to_array()) {
                    columns[k].numbers.set(row, x);
                }
            }
        }
    }

    /// Appends the numbers of the new faces: the means of those at their corners, which continue harmonically
    /// from those of the faces beside the rim.
    fn faces(&mut self, attributes: &mut Attributes) {
        if attributes.faces.columns.is_empty() || self.rim.is_empty() {
            return;
        }
        let mut known: Vec<u32> = self.rim.iter().map(|[at, _]| at.face() as u32).collect();
        known.sort_unstable();
        known.dedup();
        let (rim, triangles, equation) = (&self.rim, &self.triangles, &mut self.equation);
        let first = self.hole.vertices.start;
        let like = self.hole.like.index() as u32;
        attributes.append_face_numbers(&known, like, triangles.len(), |of_known| {
            // the sum of the numbers beside each rim vertex, and their count
            let mut beside: BTreeMap<u32, [f64; 2]> = BTreeMap::new();
            for edge in rim {
                let face = edge[0].face() as u32;
                let number = of_known[known.partition_point(|&other| other < face)];
                for at in edge {
                    let [sum, count] = beside.entry(at.vertex).or_default();
                    (*sum, *count) = (*sum + number, *count + 1.0);
                }
            }
            // at vertices that are only beside other patches
            let mean = of_known.iter().sum::<f64>() / of_known.len() as f64;
            let at_rim = |v: u32| beside.get(&v).map_or(mean, |[sum, count]| sum / count);
            let inside = equation.as_mut().map_or_else(Vec::new, |equation| {
                let given: Vec<f64> = equation.rim.iter().map(|v| at_rim(v.0)).collect();
                equation.solve(&given)
            });
            let number = |v: u32| {
                let new = (v as usize).checked_sub(first);
                let new = new.and_then(|place| inside.get(place));
                new.copied().unwrap_or_else(|| at_rim(v))
            };
            let corners = triangles.iter().map(|t| t.map(number));
            corners.map(|t| t.iter().sum::<f64>() / 3.0).collect()
        });
    }

    /// The unit normals of the patch at its new vertices, on the side of the normals in the columns
    /// `axes` at the rim vertices `known`, which are pairs of a vertex and a row.
    fn surface_normals(
        &self,
        columns: &[Column],
        axes: [usize; 3],
        known: &[(u32, usize)],
    ) -> Vec<DVec3> {
        let mut at_vertex: BTreeMap<u32, DVec3> = BTreeMap::new();
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|v| self.positions[v as usize]);
            for &v in triangle {
                *at_vertex.entry(v).or_default() += (b - a).cross(c - a);
            }
        }
        let given = |row: usize| DVec3::from(axes.map(|k| columns[k].numbers.get(row)));
        let of_patch = |v: u32| {
            at_vertex
                .get(&v)
                .map_or(DVec3::ZERO, |n| n.normalize_or_zero())
        };
        let agreement = known.iter().map(|&(v, row)| given(row).dot(of_patch(v)));
        let side = if agreement.sum::<f64>() < 0.0 {
            -1.0
        } else {
            1.0
        };
        let new = self.hole.vertices.clone();
        new.map(|v| side * of_patch(v as u32)).collect()
    }

    /// The row of each rim vertex in a list of corners; `None` if a corner has none, or the two faces
    /// beside a vertex have different values.
    fn rows_at_rim(&self, list: &[u32], columns: &[Column]) -> Option<BTreeMap<u32, u32>> {
        let mut rows = BTreeMap::new();
        if list.is_empty() {
            return None;
        }
        for at in self.rim.iter().flatten() {
            let row = list[at.corner];
            let first = *rows.entry(at.vertex).or_insert(row);
            let is_same = |c: &Column| c.numbers.are_same(first as usize, row as usize);
            if row == NO_VALUE || !columns.iter().all(is_same) {
                return None;
            }
        }
        Some(rows)
    }

    /// The texture coordinates of the patch that continue those of its rim, if these do not jump.
    fn continuation(&mut self, attributes: &Attributes) -> Option<Extension> {
        let columns = &attributes.texture;
        let rim = self.rows_at_rim(&attributes.faces.texture, columns)?;
        if !self.is_closed || columns.len() < 2 {
            return None;
        }
        let number = |k: usize, row: u32| columns[k].numbers.get(row as usize);
        let mut new = vec![Vec::new(); columns.len()];
        if let Some(equation) = &mut self.equation {
            for (k, values) in new.iter_mut().enumerate() {
                let at_rim = |v: &VertexId| Some(number(k, *rim.get(&v.0)?));
                let at_rim: Option<Vec<f64>> = equation.rim.iter().map(at_rim).collect();
                *values = equation.solve(&at_rim?);
            }
        }
        let first = self.hole.vertices.start;
        let at = |v: u32| {
            let [x, y] = [0, 1].map(|k| match rim.get(&v) {
                Some(&row) => number(k, row),
                None => new[k][v as usize - first],
            });
            Coord { x, y }
        };
        let triangles = self.triangles.iter().map(|t| t.map(at)).collect();
        let mut beside: Vec<usize> = self.rim.iter().map(|[at, _]| at.face()).collect();
        beside.sort_unstable();
        beside.dedup();
        Some(Extension {
            rim,
            new,
            triangles,
            like: self.hole.like.index(),
            beside,
        })
    }

    /// Whether the rim lies in one chart and the patch does not overlap itself there.
    fn is_chart(&self, attributes: &Attributes, continued: &Extension) -> bool {
        if self.hole.loops.len() > 1 || !self.has_one_image(attributes) {
            return false;
        }
        let place = |row: u32| {
            let [x, y] = [0, 1].map(|k| attributes.texture[k].numbers.get(row as usize));
            Coord { x, y }
        };
        let corners = &attributes.faces.texture;
        let given = |corner: usize| {
            let row = corners[corner];
            (row != NO_VALUE).then(|| place(row))
        };
        self.is_embedded(&continued.triangles, |v| place(continued.rim[&v]), given)
    }

    /// Gives the patch the texture coordinates of an extension.
    fn extend(&self, attributes: &mut Attributes, extension: &Extension) {
        let count = row_count(&attributes.texture) as u32;
        let columns = Arc::make_mut(&mut attributes.texture);
        for (column, values) in columns.iter_mut().zip(&extension.new) {
            for &value in values {
                column.numbers.push(value);
            }
        }
        self.refer(&mut attributes.faces.texture, &extension.rim, count);
    }

    /// Whether a face beside the rim has texture coordinates.
    fn has_texture(&self, attributes: &Attributes) -> bool {
        let list = &attributes.faces.texture;
        let mut corners = self.rim.iter().flatten().map(|at| at.corner);
        !list.is_empty() && corners.any(|corner| list[corner] != NO_VALUE)
    }

    /// The edges of the rim: their ends, and their corners in the given faces.
    fn rim_ends(&self) -> Vec<([u32; 2], [u32; 2])> {
        let ends = |e: &[RimCorner; 2]| (e.map(|at| at.vertex), e.map(|at| at.corner as u32));
        self.rim.iter().map(ends).collect()
    }

    /// Writes the rows of the patch's corners: those of `rows` at the rim, and the rows from `first` on
    /// at new vertices.
    fn refer(&self, list: &mut [u32], rows: &BTreeMap<u32, u32>, first: u32) {
        let corners = self.triangles.as_flattened();
        let start = self.hole.vertices.start as u32;
        for (slot, v) in list[3 * self.hole.faces.start..].iter_mut().zip(corners) {
            *slot = rows.get(v).copied().unwrap_or_else(|| first + v - start);
        }
    }

    /// Whether all faces beside the rim have the same material, or number of a texture.
    fn has_one_image(&self, attributes: &Attributes) -> bool {
        let data = &attributes.faces;
        let like = self.hole.like.index();
        let material = |face: usize| {
            let tag = data.tags.get(face);
            tag.map(|&tag| &attributes.tags[tag as usize].material)
        };
        let numbers = data.columns.iter().filter(|c| c.name == TEXTURE_NUMBER);
        let numbers: Vec<&Column> = numbers.collect();
        self.rim.iter().flatten().all(|at| {
            let face = at.face();
            let is_same = |c: &&Column| c.numbers.are_same(face, like);
            material(face) == material(like) && numbers.iter().all(is_same)
        })
    }

    /// Whether the texture coordinates do not jump along the rim.
    fn is_continuous(&self, attributes: &Attributes) -> bool {
        let rows = self.rows_at_rim(&attributes.faces.texture, &attributes.texture);
        rows.is_some()
    }

    /// Whether faces have texture coordinates, but those of the patch have none.
    fn is_bare(&self, attributes: &Attributes) -> bool {
        // all corners of a patch have some, or none
        let first = attributes.faces.texture.get(3 * self.hole.faces.start);
        first == Some(&NO_VALUE)
    }

    /// If faces have numbers of texture images, gives the patch the number -1, that of no image, if it has no texture
    /// coordinates.
    fn number_no_image(&self, attributes: &mut Attributes) {
        let is_bare = self.is_bare(attributes);
        let mut columns = attributes.faces.columns.iter_mut();
        let numbers = columns.find(|column| column.name == TEXTURE_NUMBER);
        if let Some(column) = numbers.filter(|_| is_bare) {
            for face in self.hole.faces.clone() {
                column.numbers.set(face, -1.0);
            }
        }
    }

    /// Gives all corners of the patch the texture coordinates zero.
    fn blank(&self, attributes: &mut Attributes) {
        let row = row_count(&attributes.texture) as u32;
        for column in Arc::make_mut(&mut attributes.texture) {
            column.numbers.push(0.0);
        }
        let faces = &self.hole.faces;
        attributes.faces.texture[3 * faces.start..3 * faces.end].fill(row);
    }

    /// Whether the patch lies in the plane of the texture without overlaps: its rim does not cross
    /// itself, and all triangles have the orientation of the faces beside it. `at_rim` are the coordinates of
    /// rim vertices, `given` those of given corners.
    fn is_embedded(
        &self,
        triangles: &[[Coord<f64>; 3]],
        at_rim: impl Fn(u32) -> Coord<f64>,
        given: impl Fn(usize) -> Option<Coord<f64>>,
    ) -> bool {
        let mut sides = self.rim.iter().map(|[a, _]| {
            let first = 3 * a.face();
            let [a, b, c] = [given(first)?, given(first + 1)?, given(first + 2)?];
            Some(orient2d(a, b, c))
        });
        let Some(Some(side)) = sides.next() else {
            return false;
        };
        let is_alike = |area: f64| area * side.signum() > 0.0;
        let area = |&[a, b, c]: &[Coord<f64>; 3]| orient2d(a, b, c);
        let all_alike = is_alike(side)
            && sides.all(|area| area.is_some_and(is_alike))
            && triangles.iter().map(area).all(is_alike);
        let segments = self.rim.iter().map(|ends| ends.map(|at| at.vertex));
        let segments: Vec<[u32; 2]> = segments.collect();
        all_alike && !crosses_itself(&segments, at_rim)
    }

    /// Gives the corners of the patch the normals of the surface, if all corners beside its rim have
    /// normals.
    fn normals(&self, attributes: &mut Attributes) {
        let list = &attributes.faces.normals;
        if list.is_empty() || !self.is_closed {
            return;
        }
        // where the faces beside a vertex differ, the first one counts
        let mut rows = BTreeMap::new();
        for at in self.rim.iter().flatten() {
            rows.entry(at.vertex).or_insert(list[at.corner]);
        }
        let columns = Arc::make_mut(&mut attributes.normals);
        let Some(axes) = columns_named(columns, ["nx", "ny", "nz"]) else {
            return;
        };
        if rows.values().any(|&row| row == NO_VALUE) {
            return;
        }
        let known: Vec<(u32, usize)> = rows.iter().map(|(&v, &row)| (v, row as usize)).collect();
        let first = row_count(columns) as u32;
        for normal in self.surface_normals(columns, axes, &known) {
            for (k, x) in axes.into_iter().zip(normal.to_array()) {
                columns[k].numbers.push(x);
            }
        }
        self.refer(&mut attributes.faces.normals, &rows, first);
    }
}

/// Whether two of the segments without a common end meet.
fn crosses_itself(segments: &[[u32; 2]], at: impl Fn(u32) -> Coord<f64>) -> bool {
    let ends: Vec<[Coord<f64>; 2]> = segments.iter().map(|s| s.map(&at)).collect();
    let meet = |[a, b]: [Coord<f64>; 2], [c, d]: [Coord<f64>; 2]| {
        let apart = |a: f64, b: f64, c: f64, d: f64| a.max(b) < c.min(d) || c.max(d) < a.min(b);
        if apart(a.x, b.x, c.x, d.x) || apart(a.y, b.y, c.y, d.y) {
            return false;
        }
        let side = |p, q, r| orient2d(p, q, r);
        side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0
    };
    (0..ends.len()).any(|i| {
        (i + 1..ends.len()).any(|j| {
            let is_joined = segments[i].iter().any(|v| segments[j].contains(v));
            !is_joined && meet(ends[i], ends[j])
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::{FillOptions, fill_rim_sets};
    use crate::mesh::{Numbers, boundary_loops, color_columns};
    use crate::shapes;

    /// A plane with a round hole, with texture coordinates x and y, normals, and colours.
    fn plane() -> Mesh {
        let whole = shapes::plane(2.0, 24, 3);
        let (positions, triangles) = shapes::cut_where(&whole, |p| p.length() < 0.5);
        let mut mesh = Mesh::from_triangles(positions, &triangles).expect("manifold");
        let corners: Vec<u32> = triangles.into_flattened();
        let column = |name: &str, number: &dyn Fn(&DVec3) -> f64| {
            Column::decimals(name, mesh.positions.iter().map(number).collect())
        };
        let flat =
            ["nx", "ny", "nz"].map(|name| column(name, &|_| f64::from(u8::from(name == "nz"))));
        let all = &mut mesh.attributes;
        all.texture = Arc::new(vec![column("u", &|p| p.x), column("v", &|p| p.y)]);
        all.normals = Arc::new(flat.to_vec());
        let shades = |p: &DVec3| [if p.x > 0.0 { 1.0 } else { 0.0 }, 0.2, 0.4, 1.0];
        all.vertices = color_columns(&mesh.positions.iter().map(shades).collect::<Vec<_>>());
        all.vertices.extend(flat);
        all.faces.texture.clone_from(&corners);
        all.faces.normals = corners;
        mesh
    }

    fn filled(mesh: &Mesh) -> Mesh {
        let loops = boundary_loops(mesh);
        let hole = loops.iter().find(|l| !l.is_outer_boundary).expect("a hole");
        let options = FillOptions::default();
        let filled = fill_rim_sets(mesh, &[vec![hole]], &options, &|_, _| true);
        filled.expect("filled").mesh
    }

    /// The texture coordinates of the corners of the patch; `None` without.
    fn patch_texture(given: &Mesh, mesh: &Mesh) -> Vec<Option<[f64; 2]>> {
        let all = &mesh.attributes;
        let rows = all.faces.texture[3 * given.face_count()..].iter();
        let number = |k: usize, row: u32| all.texture[k].numbers.get(row as usize);
        rows.map(|&row| (row != NO_VALUE).then(|| [number(0, row), number(1, row)]))
            .collect()
    }

    #[test]
    fn numbers_of_faces_continue_those_beside_the_rim() {
        let mut given = plane();
        let centres: Vec<DVec3> = (0..given.face_count())
            .map(|f| given.corners(FaceId::from(f)).iter().sum::<DVec3>() / 3.0)
            .collect();
        let shades = |p: &DVec3| [0.5, 0.5 + 0.25 * p.x as f32, 0.5, 1.0];
        let columns = &mut given.attributes.faces.columns;
        *columns = color_columns(&centres.iter().map(shades).collect::<Vec<_>>());
        let height = centres.iter().map(|p| p.y).collect();
        columns.push(Column::decimals("height", height));
        let labels = (0..centres.len()).map(|f| f as u32).collect();
        columns.push(Column {
            name: "label".into(),
            numbers: Numbers::U32(labels),
            is_typed: true,
        });
        let mesh = filled(&given);
        let columns = &mesh.attributes.faces.columns;
        let number = |k: usize, f: usize| columns[k].numbers.get(f);
        let label = number(4, given.face_count());
        for f in given.face_count()..mesh.face_count() {
            let centre = mesh.corners(FaceId::from(f)).iter().sum::<DVec3>() / 3.0;
            assert!((number(3, f) - centre.y).abs() < 0.12, "{f}");
            // mixed in light
            assert!((number(1, f) - (0.5 + 0.25 * centre.x)).abs() < 0.05, "{f}");
            assert!((number(0, f) - 0.5).abs() < 1e-6 && number(4, f) == label);
        }
        let rows = columns.iter().map(|column| column.numbers.len());
        assert!(rows.clone().all(|rows| rows == mesh.face_count()));
    }

    #[test]
    fn a_patch_continues_the_chart_around_it() {
        let given = plane();
        let mesh = filled(&given);
        assert!(mesh.vertex_count() > given.vertex_count() + 10);
        let triangles: Vec<[u32; 3]> = mesh.topology.triangles().collect();
        let corners = triangles[given.face_count()..].as_flattened();
        let texture = patch_texture(&given, &mesh);
        for (&v, at) in corners.iter().zip(&texture) {
            let [u, v_] = at.expect("coordinates everywhere");
            let p = mesh.positions[v as usize];
            // the equation counts edges, and the triangles are not equilateral
            let far = (p.x - u).abs().max((p.y - v_).abs());
            let is_given = (v as usize) < given.vertex_count();
            assert!(far < if is_given { 1e-15 } else { 0.08 }, "{far}");
        }
        for t in texture.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|k| t[k].expect("checked above"));
            assert!((b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0]));
        }
        // colours are between those of the rim, and normals those of the plane
        let all = &mesh.attributes;
        let numbers = |k: usize, v: usize| all.vertices[k].numbers.get(v);
        let mut shades = Vec::new();
        for v in given.vertex_count()..mesh.vertex_count() {
            shades.push(numbers(0, v));
            assert_eq!([1, 2].map(|k| numbers(k, v) as f32), [0.2, 0.4]);
            assert_eq!([3, 4].map(|k| numbers(k, v).abs() < 1e-3), [true; 2]);
            assert!((numbers(5, v) - 1.0).abs() < 1e-6);
        }
        assert!(shades.iter().all(|s| (0.0..=1.0).contains(s)));
        assert!(shades.iter().any(|s| (0.4..0.9).contains(s)));
        let rows = &all.faces.normals[3 * given.face_count()..];
        assert!(
            rows.iter()
                .all(|&row| { (all.normals[2].numbers.get(row as usize) - 1.0).abs() < 1e-6 })
        );
    }

    /// A seam through the rim, another material, or an image in which the rim crosses itself.
    #[test]
    fn a_patch_outside_one_chart_has_no_texture() {
        let seam = {
            let mut mesh = plane();
            let columns = Arc::make_mut(&mut mesh.attributes.texture);
            let count = row_count(columns) as u32;
            for column in columns.iter_mut() {
                for row in 0..count as usize {
                    let number = column.numbers.get(row);
                    column.numbers.push(number + 9.0);
                }
            }
            for f in 0..mesh.face_count() {
                if mesh.corners(FaceId::from(f)).iter().sum::<DVec3>().x > 0.0 {
                    for row in &mut mesh.attributes.faces.texture[3 * f..3 * f + 3] {
                        *row += count;
                    }
                }
            }
            mesh
        };
        let materials = {
            let mut mesh = plane();
            let tag = |name: &str| FaceTag {
                material: name.into(),
                ..FaceTag::default()
            };
            mesh.attributes.tags = ["left", "right"].map(tag).to_vec();
            let side = |f| mesh.corners(f).iter().sum::<DVec3>().x > 0.0;
            let tags = mesh.topology.faces().map(|f| u32::from(side(f))).collect();
            mesh.attributes.faces.tags = tags;
            mesh
        };
        let crossed = {
            let mut mesh = plane();
            let columns = Arc::make_mut(&mut mesh.attributes.texture);
            let squares = mesh.positions.iter().map(|p| p.x * p.x - p.y * p.y);
            columns[0] = Column::decimals("u", squares.collect());
            let twice = mesh.positions.iter().map(|p| 2.0 * p.x * p.y);
            columns[1] = Column::decimals("v", twice.collect());
            mesh
        };
        for mesh in [seam, materials, crossed] {
            let new = filled(&mesh);
            assert!(patch_texture(&mesh, &new).iter().all(Option::is_none));
            let given = &mesh.attributes.faces.texture;
            assert_eq!(new.attributes.faces.texture[..given.len()], given[..]);
        }
    }
}
