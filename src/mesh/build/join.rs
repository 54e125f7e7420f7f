//! Faces joined across edges, and their orientation.
//!
//! Two faces that are the only ones at an edge are joined. If more faces meet at an edge, pairs with
//! the same orientation come first, unless faces elsewhere in the file have different orientations;
//! then pairs with a contact face, pairs of the same sheet and the flattest pair. A pair is not joined
//! if the result could not be oriented. One union-find structure with parities stores sheets and
//! their orientation.
//!
//! If two solids touch, a face of one has the same corners as a face of the other and the opposite
//! orientation. These *contact faces* are no duplicates: without one of them a solid would be open.

use super::edges::{EdgeTable, ends, opposite};
use crate::mesh::DVec3;
use crate::mesh::union_find::{find, unite};

/// No corner-edge.
pub(super) const NONE: u32 = u32::MAX;

/// With more than this many faces at an edge only neighbours in file order are considered as pairs.
const PAIRS_LIMIT: usize = 64;

/// Cosine above which a doubled face that is attached at a single edge is a flap and not part of
/// the surface: it is bent by more than 45 degrees.
const FLAP_COS: f64 = -std::f64::consts::FRAC_1_SQRT_2;

/// Faces joined to sheets.
pub(super) struct Sheets {
    /// The corner-edge on the other side of each corner-edge, or [`NONE`].
    pub mate: Vec<u32>,
    /// Faces that are removed because an earlier one has the same corners.
    pub dropped: Vec<bool>,
    /// Edges with more than two faces, each as one of its corner-edges.
    pub non_manifold: Vec<u32>,
    /// The corner-edges at these edges. Only they can have the same two vertices as another edge.
    pub crowded: Vec<u32>,
    /// Whether each face is a contact face.
    contact: Vec<bool>,
    /// Whether two faces that are the only ones at their edge run through it in the same direction.
    is_mixed: bool,
    /// Union-find: parent × 2 + whether flipped relative to the parent. The root is the lowest
    /// face.
    link: Vec<u32>,
    /// Whether the sheet of each root cannot be oriented.
    non_orientable: Vec<bool>,
}

impl Sheets {
    pub fn new(faces: usize) -> Self {
        Self {
            mate: vec![NONE; 3 * faces],
            dropped: vec![false; faces],
            non_manifold: Vec::new(),
            crowded: Vec::new(),
            contact: vec![false; faces],
            is_mixed: false,
            link: (0..faces as u32).map(|f| 2 * f).collect(),
            non_orientable: vec![false; faces],
        }
    }

    /// The lowest face of the sheet, and whether `face` has the opposite orientation.
    pub fn find(&mut self, face: u32) -> (u32, bool) {
        let (mut f, mut turned) = (face, 0);
        loop {
            let link = self.link[f as usize];
            if link >> 1 == f {
                return (f, turned == 1);
            }
            let up = self.link[(link >> 1) as usize];
            let skip = (up & !1) | ((up ^ link) & 1);
            self.link[f as usize] = skip;
            turned ^= skip & 1;
            f = skip >> 1;
        }
    }

    /// Joins two sheets; false if they are already one sheet with contradicting orientation.
    fn unite(&mut self, f: u32, g: u32, turned: bool) -> bool {
        let ((f, s), (g, t)) = (self.find(f), self.find(g));
        let odd = s ^ t ^ turned;
        if f == g {
            return !odd;
        }
        let (low, high) = (f.min(g), f.max(g));
        self.link[high as usize] = 2 * low + u32::from(odd);
        self.non_orientable[low as usize] |= self.non_orientable[high as usize];
        true
    }

    /// Whether the face belongs to a sheet that cannot be oriented.
    pub fn is_non_orientable(&mut self, face: u32) -> bool {
        let (root, _) = self.find(face);
        self.non_orientable[root as usize]
    }

    /// Finds the contact faces. Two faces are in contact if they have the same corners and opposite
    /// orientation, and each edge of the contact area has equally many faces of both directions, at
    /// least two each. At least one edge of the area has other faces too.
    fn find_contacts(&mut self, triangles: &[[u32; 3]], table: &EdgeTable) {
        let turned = |c: u32, d: u32| ends(triangles, c) != ends(triangles, d);
        // the other face with the same corners; NONE if there are none or several
        let mut twin = vec![NONE; triangles.len()];
        let mut apexes: Vec<(u32, u32)> = Vec::new();
        for group in table.groups(triangles).filter(|group| group.len() > 1) {
            apexes.clear();
            apexes.extend(group.iter().map(|&c| (opposite(triangles, c), c)));
            apexes.sort_unstable();
            for same in apexes.chunk_by(|x, y| x.0 == y.0) {
                if let [(_, c), (_, d)] = *same
                    && turned(c, d)
                {
                    (twin[c as usize / 3], twin[d as usize / 3]) = (d / 3, c / 3);
                }
            }
        }
        if twin.iter().all(|&f| f == NONE) {
            return;
        }
        // contact areas: faces with a twin, united across edges
        let mut area: Vec<u32> = (0..triangles.len() as u32).collect();
        let of_twins = |group: &[u32]| -> Vec<u32> {
            let faces = group.iter().map(|&c| c / 3);
            faces.filter(|&f| twin[f as usize] != NONE).collect()
        };
        for group in table.groups(triangles) {
            for pair in of_twins(group).windows(2) {
                unite(&mut area, pair[0], pair[1]);
            }
        }
        let (mut is_sound, mut meets_others) = (vec![true; area.len()], vec![false; area.len()]);
        for group in table.groups(triangles) {
            let twins = of_twins(group);
            let Some(&f) = twins.first() else { continue };
            let root = find(&mut area, f) as usize;
            let back = group.iter().filter(|&&c| turned(group[0], c)).count();
            is_sound[root] &= group.len() >= 4 && 2 * back == group.len();
            meets_others[root] |= twins.len() < group.len();
        }
        for f in (0..triangles.len()).filter(|&f| twin[f] != NONE) {
            let root = find(&mut area, f as u32) as usize;
            self.contact[f] = is_sound[root] && meets_others[root];
        }
    }

    /// Removes faces with the same corners as an earlier face, except contact faces. Returns the faces
    /// of which a copy with opposite orientation was removed, ascending.
    fn drop_duplicates(&mut self, triangles: &[[u32; 3]], table: &EdgeTable) -> Vec<u32> {
        let mut doubled = Vec::new();
        let mut apexes: Vec<(u32, u32)> = Vec::new();
        for group in table.groups(triangles) {
            if group.len() < 2 {
                continue;
            }
            apexes.clear();
            apexes.extend(group.iter().map(|&c| (opposite(triangles, c), c)));
            apexes.sort_unstable();
            let mut first = apexes[0];
            for &(apex, c) in &apexes[1..] {
                let face = c as usize / 3;
                if apex == first.0 && !self.contact[face] {
                    if !self.dropped[face] && ends(triangles, c) != ends(triangles, first.1) {
                        doubled.push(first.1 / 3);
                    }
                    self.dropped[face] = true;
                } else {
                    first = (apex, c);
                }
            }
        }
        doubled.sort_unstable();
        doubled.dedup();
        doubled
    }

    /// Joins faces across the edges of a mesh whose corners are `triangles`.
    pub fn join_mesh(
        &mut self,
        triangles: &[[u32; 3]],
        at: impl Fn(u32) -> DVec3,
        vertices: usize,
    ) {
        let table = EdgeTable::new(triangles, vertices, 0..3 * triangles.len() as u32);
        self.find_contacts(triangles, &table);
        let doubled = self.drop_duplicates(triangles, &table);
        let mut crowded: Vec<Vec<u32>> = Vec::new();
        let mut suspects: Vec<(u32, u32)> = Vec::new();
        let mut lone = vec![0u8; doubled.len()];
        let mut group = Vec::new();
        for whole in table.groups(triangles) {
            group.clear();
            group.extend(whole.iter().filter(|&&c| !self.dropped[c as usize / 3]));
            match group[..] {
                [c] => {
                    if let Ok(i) = doubled.binary_search(&(c / 3)) {
                        lone[i] += 1;
                    }
                }
                [c, d] => {
                    let hinge = [c, d].map(|c| doubled.binary_search(&(c / 3)).is_ok());
                    match hinge {
                        [true, false] => suspects.push((c, d)),
                        [false, true] => suspects.push((d, c)),
                        _ => self.join_edge(triangles, c, d),
                    }
                }
                [] => {}
                _ => {
                    self.non_manifold.push(group[0]);
                    self.crowded.extend(&group);
                    crowded.push(group.clone());
                }
            }
        }
        for (c, d) in suspects {
            let i = doubled.binary_search(&(c / 3)).expect("pushed as doubled");
            if lone[i] == 2 && fold(triangles, &at, c, d) > FLAP_COS {
                self.non_manifold.push(c);
                self.crowded.extend([c, d]);
            } else {
                self.join_edge(triangles, c, d);
            }
        }
        self.join_crowded(triangles, &at, &crowded);
    }

    /// Joins two faces that are the only ones at their edge.
    fn join_edge(&mut self, triangles: &[[u32; 3]], c: u32, d: u32) {
        self.mate[c as usize] = d;
        self.mate[d as usize] = c;
        let turned = ends(triangles, c) == ends(triangles, d);
        self.is_mixed |= turned;
        if !self.unite(c / 3, d / 3, turned) {
            let (root, _) = self.find(c / 3);
            self.non_orientable[root as usize] = true;
        }
    }

    /// Joins two faces unless the joined sheet could not be oriented.
    pub fn try_join(&mut self, triangles: &[[u32; 3]], c: u32, d: u32) {
        if self.is_non_orientable(c / 3) == self.is_non_orientable(d / 3)
            && self.unite(c / 3, d / 3, ends(triangles, c) == ends(triangles, d))
        {
            self.mate[c as usize] = d;
            self.mate[d as usize] = c;
        }
    }

    /// Closes seams: joins boundary edges whose ends are at the same positions, `triangles` naming
    /// one vertex for each position and `own` the vertices themselves.
    pub fn join_seams(
        &mut self,
        triangles: &[[u32; 3]],
        own: &[[u32; 3]],
        at: impl Fn(u32) -> DVec3,
        vertices: usize,
    ) {
        let open: Vec<u32> = (0..3 * triangles.len() as u32)
            .filter(|&c| {
                let (a, b) = ends(triangles, c);
                self.mate[c as usize] == NONE && !self.dropped[c as usize / 3] && a != b
            })
            .collect();
        let table = EdgeTable::new(triangles, vertices, open.into_iter());
        let mut crowded = Vec::new();
        for group in table.groups(triangles) {
            match *group {
                [c, d] if !may_close(triangles, own, c, d) => {}
                [c, d] => self.try_join(triangles, c, d),
                _ if group.len() > 2 => crowded.push(group.to_vec()),
                _ => {}
            }
        }
        for group in &mut crowded {
            // edges with the same two vertices were cut deliberately
            let first = group[0];
            group.retain(|&c| c == first || may_close(triangles, own, first, c));
        }
        self.join_crowded(triangles, &at, &crowded);
    }

    /// Joins faces pairwise where more than two meet at an edge.
    fn join_crowded(
        &mut self,
        triangles: &[[u32; 3]],
        at: &impl Fn(u32) -> DVec3,
        groups: &[Vec<u32>],
    ) {
        let mut pairs: Vec<([bool; 3], f64, u32, u32)> = Vec::new();
        for group in groups {
            for (i, &c) in group.iter().enumerate() {
                let reach = if group.len() > PAIRS_LIMIT {
                    1
                } else {
                    group.len()
                };
                for &d in group[i + 1..].iter().take(reach) {
                    let touching = [c, d].map(|c| self.contact[c as usize / 3]);
                    if touching[0] && opposite(triangles, c) == opposite(triangles, d) {
                        continue;
                    }
                    let turned = !self.is_mixed && ends(triangles, c) == ends(triangles, d);
                    let apart = self.find(c / 3).0 != self.find(d / 3).0;
                    let last = [turned, !touching.contains(&true), apart];
                    pairs.push((last, fold(triangles, at, c, d), c, d));
                }
            }
        }
        pairs.sort_unstable_by(|x, y| {
            x.0.cmp(&y.0)
                .then(x.1.total_cmp(&y.1))
                .then((x.2, x.3).cmp(&(y.2, y.3)))
        });
        for (_, _, c, d) in pairs {
            if self.mate[c as usize] == NONE && self.mate[d as usize] == NONE {
                self.try_join(triangles, c, d);
            }
        }
    }
}

/// Whether welding two boundary edges closes a seam, and does not sew two copies of one face
/// together or undo a cut.
fn may_close(triangles: &[[u32; 3]], own: &[[u32; 3]], c: u32, d: u32) -> bool {
    let ((a, b), (p, q)) = (ends(own, c), ends(own, d));
    opposite(triangles, c) != opposite(triangles, d) && (a, b) != (p, q) && (a, b) != (q, p)
}

/// Cosine of the angle between two faces at their common edge: −1 if they are coplanar, 1 if one is
/// folded onto the other.
fn fold(triangles: &[[u32; 3]], at: &impl Fn(u32) -> DVec3, c: u32, d: u32) -> f64 {
    let (a, b) = ends(triangles, c);
    let edge = (at(b) - at(a)).normalize_or_zero();
    let away = |c: u32| {
        let u = at(opposite(triangles, c)) - at(a);
        (u - edge * u.dot(edge)).normalize_or_zero()
    };
    away(c).dot(away(d))
}
