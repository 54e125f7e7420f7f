//! Charts of a texture that continue into patches.

use std::collections::{BTreeMap, BTreeSet};

use robust::{Coord, orient2d};

use crate::mesh::{Attributes, NO_VALUE, row_count};

/// Coordinates beyond 0..=1 by more than this refer to an image that repeats.
const BEYOND: f64 = 1e-3;

/// The corners of a triangle in an image.
type Corners = [Coord<f64>; 3];

/// The texture coordinates of a patch that continue those of its rim.
pub struct Extension {
    /// The rows at the rim, by vertex.
    pub rim: BTreeMap<u32, u32>,
    /// For each column its numbers at the new vertices.
    pub new: Vec<Vec<f64>>,
    /// The corners of the triangles in the image.
    pub triangles: Vec<Corners>,
    /// The face whose material the patch has.
    pub like: usize,
    /// The given faces beside the rim.
    pub beside: Vec<usize>,
}

/// For each extension whether it covers a part of the image that given faces, the first `given`, or
/// extensions before it use. An image that repeats has no such parts, and neither has an extension whose
/// surroundings share their part of the image with others, as both sides of a mirrored mesh do.
pub fn overlapping<'a>(
    attributes: &Attributes,
    given: usize,
    extensions: &'a [Option<Extension>],
) -> Vec<bool> {
    let mut overlaps = vec![false; extensions.len()];
    let materials: Vec<&str> = {
        let like = extensions
            .iter()
            .flatten()
            .map(|e| attributes.material_of(e.like));
        let mut all: Vec<&str> = like.collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    for material in materials {
        let of_material = |face: usize| attributes.material_of(face) == material;
        let used = || {
            (0..given)
                .filter(|&f| of_material(f))
                .filter_map(|f| Some((f, corners_of(attributes, f)?)))
        };
        let is_inside = |x: f64| (-BEYOND..=1.0 + BEYOND).contains(&x);
        let mut all = used().flat_map(|(_, triangle)| triangle);
        if !all.all(|p| is_inside(p.x) && is_inside(p.y)) {
            continue;
        }
        let wanted = extensions.iter().enumerate();
        let wanted = wanted.filter_map(|(i, e)| Some((i, e.as_ref()?)));
        let wanted = wanted.filter(|(_, e)| attributes.material_of(e.like) == material);
        let wanted: Vec<(usize, &Extension)> = wanted.collect();
        let shares = sharing(attributes, &wanted, used);
        let alone = wanted.iter().filter(|(i, _)| !shares.contains(i));
        let alone: Vec<(usize, &Extension)> = alone.copied().collect();
        let own = |&(i, e): &(usize, &'a Extension)| e.triangles.iter().map(move |t| (i, t));
        let grid = Grid::new(alone.iter().flat_map(own).collect());
        for (_, triangle) in used() {
            grid.near(&triangle, |extension, other| {
                overlaps[extension] |= !overlaps[extension] && cover_each_other(&triangle, other);
            });
        }
        for (i, triangle) in wanted.iter().flat_map(own) {
            grid.near(triangle, |later, other| {
                overlaps[later] |= later > i && !overlaps[i] && cover_each_other(triangle, other);
            });
        }
    }
    overlaps
}

/// The extensions beside which at least half of the faces cover other `used` faces in the image.
fn sharing<U: Iterator<Item = (usize, Corners)>>(
    attributes: &Attributes,
    extensions: &[(usize, &Extension)],
    used: impl Fn() -> U,
) -> BTreeSet<usize> {
    let faces = extensions
        .iter()
        .flat_map(|(i, e)| e.beside.iter().map(|&f| (*i, f)));
    let beside = faces.filter_map(|(i, face)| Some((i, face, corners_of(attributes, face)?)));
    let beside: Vec<(usize, usize, Corners)> = beside.collect();
    let grid = Grid::new(
        beside
            .iter()
            .enumerate()
            .map(|(k, (_, _, t))| (k, t))
            .collect(),
    );
    let mut is_covered = vec![false; beside.len()];
    for (face, triangle) in used() {
        grid.near(&triangle, |k, other| {
            is_covered[k] |=
                !is_covered[k] && beside[k].1 != face && cover_each_other(&triangle, other);
        });
    }
    let mut counts: BTreeMap<usize, [usize; 2]> = BTreeMap::new();
    for ((i, ..), is_covered) in beside.iter().zip(is_covered) {
        counts.entry(*i).or_default()[usize::from(is_covered)] += 1;
    }
    let shares = counts
        .into_iter()
        .filter(|(_, [bare, covered])| covered >= bare);
    shares.map(|(i, _)| i).collect()
}

/// The corners of a face in the image; `None` if one has no coordinates.
fn corners_of(attributes: &Attributes, face: usize) -> Option<Corners> {
    let [u, v, ..] = &attributes.texture[..] else {
        return None;
    };
    let rows = attributes.faces.texture.get(3 * face..3 * face + 3)?;
    let is_given = |row: u32| row != NO_VALUE && (row as usize) < row_count(&attributes.texture);
    rows.iter().all(|&row| is_given(row)).then(|| {
        [0, 1, 2].map(|k| Coord {
            x: u.numbers.get(rows[k] as usize),
            y: v.numbers.get(rows[k] as usize),
        })
    })
}

/// Smallest and largest coordinates.
fn extent(triangle: &Corners) -> [[f64; 2]; 2] {
    let [a, b, c] = triangle;
    [
        [a.x.min(b.x).min(c.x), a.y.min(b.y).min(c.y)],
        [a.x.max(b.x).max(c.x), a.y.max(b.y).max(c.y)],
    ]
}

/// Whether two triangles have a common part with an area.
fn cover_each_other(a: &Corners, b: &Corners) -> bool {
    let is_apart = |a: &Corners, b: &Corners| {
        let side = orient2d(a[0], a[1], a[2]);
        // a triangle without area covers nothing
        side == 0.0
            || (0..3).any(|i| {
                let beyond = |&p: &Coord<f64>| side * orient2d(a[i], a[(i + 1) % 3], p) <= 0.0;
                b.iter().all(beyond)
            })
    };
    !is_apart(a, b) && !is_apart(b, a)
}

/// Numbered triangles in square cells.
struct Grid<'a> {
    low: [f64; 2],
    cell: f64,
    counts: [usize; 2],
    /// For each cell the triangles that reach into it, with their numbers.
    cells: Vec<Vec<(usize, &'a Corners)>>,
}

impl<'a> Grid<'a> {
    fn new(triangles: Vec<(usize, &'a Corners)>) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for (_, triangle) in &triangles {
            let [least, most] = extent(triangle);
            low = [0, 1].map(|k| low[k].min(least[k]));
            high = [0, 1].map(|k| high[k].max(most[k]));
        }
        let size = [0, 1].map(|k| high[k] - low[k]);
        let cell = (size[0] * size[1] / triangles.len().max(1) as f64).sqrt();
        let cell = cell.max(1e-3 * size[0].max(size[1])).max(f64::MIN_POSITIVE);
        let counts = size.map(|size| (size / cell) as usize + 1);
        let mut grid = Self {
            low,
            cell,
            counts,
            cells: vec![Vec::new(); counts[0] * counts[1]],
        };
        for (i, triangle) in triangles {
            for at in grid.cells_of(triangle) {
                grid.cells[at].push((i, triangle));
            }
        }
        grid
    }

    /// The cells that the extent of a triangle meets.
    fn cells_of(&self, triangle: &Corners) -> impl Iterator<Item = usize> + use<> {
        let [least, most] = extent(triangle);
        let range = |k: usize| {
            // negative numbers become 0
            let place = |x: f64| ((x - self.low[k]) / self.cell) as usize;
            let is_beyond = most[k] < self.low[k];
            let last = if is_beyond { 0 } else { place(most[k]) + 1 };
            place(least[k])..last.min(self.counts[k])
        };
        let (columns, rows, width) = (range(0), range(1), self.counts[0]);
        rows.flat_map(move |y| columns.clone().map(move |x| y * width + x))
    }

    /// Calls `meet` with the triangles whose cells a triangle meets, some of them more than once.
    fn near(&self, triangle: &Corners, mut meet: impl FnMut(usize, &Corners)) {
        for at in self.cells_of(triangle) {
            for (i, other) in &self.cells[at] {
                meet(*i, other);
            }
        }
    }
}
