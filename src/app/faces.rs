//! The selection of faces: brush strokes, lassos and operations on the whole selection.

use std::sync::Arc;

use rayon::prelude::*;

use super::document::Document;
use crate::mesh::{
    DVec3, FaceId, Flaw, Mesh, connected_faces, face_flags, face_list, faces_near, grow, invert,
    shrink, smooth_border,
};
use crate::render::{Camera, Picker, Projector};

/// A stamp of the brush: face, point, and radius in units of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrushStamp {
    /// The face under the centre of the brush.
    pub face: FaceId,
    /// The point on it.
    pub point: DVec3,
    /// The radius.
    pub radius: f64,
}

/// A closed line drawn over a view.
#[derive(Clone, Debug, PartialEq)]
pub struct Lasso {
    /// Corners, in pixels from the upper left.
    pub corners: Vec<[f64; 2]>,
    /// Size of the view in the same pixels.
    pub size: [f64; 2],
    /// The camera of the view.
    pub camera: Camera,
    /// Whether hidden faces are selected too.
    pub through: bool,
}

/// A change of the selection. `take` removes faces instead of adding them.
#[derive(Clone, Debug, PartialEq)]
pub enum FaceEdit {
    /// Part of a stroke of the brush. All parts of a stroke are one change.
    Paint {
        /// Stamps.
        stamps: Vec<BrushStamp>,
        /// Whether faces are removed.
        take: bool,
    },
    /// A lasso.
    Lasso {
        /// The line.
        lasso: Lasso,
        /// Whether faces are removed.
        take: bool,
    },
    /// The faces with a flaw are added.
    Flawed(Flaw),
    /// The faces that were found in the background, in ascending order.
    Found {
        /// The mesh.
        mesh: Arc<Mesh>,
        /// The faces.
        faces: Vec<u32>,
        /// Whether faces are removed.
        take: bool,
    },
    /// A face with its neighbours. If it is selected already, the connected part of the selection
    /// grows (or shrinks) by one ring.
    Spread {
        /// The face.
        face: FaceId,
        /// Whether the selection shrinks.
        take: bool,
    },
    /// Grow by one ring.
    Grow,
    /// Shrink by one ring.
    Shrink,
    /// Select the other faces.
    Invert,
    /// Remove ears and fill notches.
    Smooth,
    /// Clear the selection.
    Clear,
}

impl FaceEdit {
    /// The label in the undo list.
    pub fn label(&self) -> &'static str {
        match self {
            Self::Paint { take: false, .. } => "paint faces",
            Self::Paint { take: true, .. } => "unpaint faces",
            Self::Lasso { .. } => "lasso",
            Self::Flawed(_) => "select flawed faces",
            Self::Found { .. } => "select faces",
            Self::Spread { .. } => "spread the selection",
            Self::Grow => "grow the selection",
            Self::Shrink => "shrink the selection",
            Self::Invert => "invert the selection",
            Self::Smooth => "smooth the selection's border",
            Self::Clear => "clear the selection",
        }
    }
}

/// The selection after a change. [`FaceEdit::Lasso`] and [`FaceEdit::Flawed`] change nothing: their
/// faces are found in the background first.
pub fn edited(document: &Document, edit: &FaceEdit) -> Vec<u32> {
    let mesh = &document.mesh;
    let now = &document.faces;
    let whole = |change: &dyn Fn(&mut Vec<bool>)| {
        let mut flags = face_flags(now, mesh.face_count());
        change(&mut flags);
        face_list(&flags)
    };
    match edit {
        FaceEdit::Paint { stamps, take } => {
            let mut faces: Vec<u32> = stamps
                .iter()
                .flat_map(|stamp| faces_near(mesh, stamp.face, stamp.point, stamp.radius))
                .collect();
            faces.sort_unstable();
            faces.dedup();
            joined(now, &faces, *take)
        }
        FaceEdit::Found { faces, take, .. } => joined(now, faces, *take),
        FaceEdit::Lasso { .. } | FaceEdit::Flawed(_) => now.to_vec(),
        FaceEdit::Spread { face, take } => whole(&|flags| spread(mesh, flags, *face, *take)),
        FaceEdit::Grow => whole(&|flags| grow(&mesh.topology, flags)),
        FaceEdit::Shrink => whole(&|flags| shrink(&mesh.topology, flags)),
        FaceEdit::Invert => whole(&|flags| invert(flags)),
        FaceEdit::Smooth => whole(&|flags| smooth_border(&mesh.topology, flags, 10)),
        FaceEdit::Clear => Vec::new(),
    }
}

/// The union of two ascending lists, or the first without the second.
fn joined(now: &[u32], faces: &[u32], take: bool) -> Vec<u32> {
    let mut out = Vec::with_capacity(now.len() + faces.len());
    let (mut i, mut j) = (0, 0);
    while i < now.len() || j < faces.len() {
        let a = now.get(i).copied().unwrap_or(u32::MAX);
        let b = faces.get(j).copied().unwrap_or(u32::MAX);
        if a < b || (a <= b && !take) {
            out.push(a);
        } else if b < a && !take {
            out.push(b);
        }
        i += usize::from(a <= b);
        j += usize::from(b <= a);
    }
    out
}

fn spread(mesh: &Mesh, flags: &mut [bool], face: FaceId, take: bool) {
    let topology = &mesh.topology;
    if flags[face.index()] {
        let part = connected_faces(topology, face, flags);
        let mut other = part.clone();
        if take {
            shrink(topology, &mut other);
        } else {
            grow(topology, &mut other);
        }
        for (flag, (before, after)) in flags.iter_mut().zip(part.into_iter().zip(other)) {
            *flag = after || (*flag && !before);
        }
    } else if !take {
        flags[face.index()] = true;
        let mut one = vec![false; flags.len()];
        one[face.index()] = true;
        grow(topology, &mut one);
        for (flag, new) in flags.iter_mut().zip(one) {
            *flag |= new;
        }
    }
}

/// The faces whose centroid is inside a lasso, in ascending order. Without [`Lasso::through`] only
/// those that face the camera and are not hidden; the picker of the mesh determines that.
pub fn faces_in_lasso(mesh: &Mesh, picker: &Picker, lasso: &Lasso) -> Vec<u32> {
    let projector = Projector::new(&lasso.camera, lasso.size);
    let polygon = &lasso.corners;
    let mut boxed = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for c in polygon {
        for k in 0..2 {
            boxed[0][k] = boxed[0][k].min(c[k]);
            boxed[1][k] = boxed[1][k].max(c[k]);
        }
    }
    let inside = |p: [f64; 2]| {
        (0..2).all(|k| (boxed[0][k]..=boxed[1][k]).contains(&p[k])) && is_inside(polygon, p)
    };
    let middle = |f: u32| mesh.corners(FaceId(f)).into_iter().sum::<DVec3>() / 3.0;
    let within: Vec<u32> = (0..mesh.face_count() as u32)
        .into_par_iter()
        .filter(|&f| projector.shows(middle(f)) && projector.pixel(middle(f)).is_some_and(inside))
        .collect();
    if lasso.through || within.is_empty() {
        return within;
    }
    within
        .into_par_iter()
        .filter(|&f| {
            let [a, b, c] = mesh.corners(FaceId(f));
            let (origin, direction, far) = projector.line_to(middle(f));
            let faces_eye = (b - a).cross(c - a).dot(direction) < 0.0;
            let first = picker.first_face(&projector, origin, direction, far);
            faces_eye && first.is_none_or(|first| first.0 == f)
        })
        .collect()
}

/// Whether a closed polygon winds around a point, by the even-odd rule.
fn is_inside(polygon: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let mut inside = false;
    for (i, a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        if (a[1] > y) != (b[1] > y) {
            let at = a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
            inside ^= x < at;
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::render::Bounds;
    use crate::shapes;

    fn ball() -> Mesh {
        let (positions, triangles) = shapes::icosphere(8);
        Mesh::from_triangles(positions, &triangles).expect("closed")
    }

    #[test]
    fn lists_are_joined_and_taken_away() {
        assert_eq!(joined(&[1, 3, 5], &[2, 3, 9], false), [1, 2, 3, 5, 9]);
        assert_eq!(joined(&[1, 3, 5], &[2, 3, 9], true), [1, 5]);
        assert_eq!(joined(&[], &[4], false), [4]);
        assert!(joined(&[4], &[4], true).is_empty());
    }

    #[test]
    fn a_lasso_around_everything_takes_the_near_half_or_all() {
        let mesh = ball();
        let picker = Picker::new(&mesh.positions, &mesh.topology, &[]);
        let bounds = Bounds::of(mesh.positions.iter().copied()).expect("a box");
        let mut lasso = Lasso {
            corners: vec![[0.0, 0.0], [400.0, 0.0], [400.0, 300.0], [0.0, 300.0]],
            size: [400.0, 300.0],
            camera: Camera::fit(&bounds),
            through: true,
        };
        let all = mesh.face_count();
        assert_eq!(faces_in_lasso(&mesh, &picker, &lasso).len(), all);
        lasso.through = false;
        let near = faces_in_lasso(&mesh, &picker, &lasso);
        // from a finite distance less than half of a ball is visible
        assert!(
            (all / 4..all / 2).contains(&near.len()),
            "{} of {all}",
            near.len()
        );
        let towards_eye = -lasso.camera.forward();
        for &f in &near {
            assert!(mesh.corners(FaceId(f))[0].dot(towards_eye) > 0.0);
        }
        // the left half of the view
        lasso.corners = vec![[0.0, 0.0], [200.0, 0.0], [200.0, 300.0], [0.0, 300.0]];
        let half = faces_in_lasso(&mesh, &picker, &lasso);
        let left = -lasso.camera.right();
        assert!(half.iter().all(|f| near.contains(f)));
        let middle = |f: u32| mesh.corners(FaceId(f)).into_iter().sum::<DVec3>();
        assert!(half.iter().all(|&f| middle(f).dot(left) > -1e-9));
        assert!((near.len() / 3..=2 * near.len() / 3).contains(&half.len()));
    }

    #[test]
    fn clicks_spread_ring_by_ring_and_back() {
        let mesh = ball();
        let mut flags = vec![false; mesh.face_count()];
        let count = |flags: &[bool]| face_list(flags).len();
        spread(&mesh, &mut flags, FaceId(100), false);
        let first = count(&flags);
        assert!(first > 1);
        // a distant part does not change
        let far = (0..mesh.face_count() as u32)
            .map(FaceId)
            .max_by(|&a, &b| {
                let at = |f: FaceId| mesh.corners(f)[0].distance(mesh.corners(FaceId(100))[0]);
                at(a).total_cmp(&at(b))
            })
            .expect("faces");
        spread(&mesh, &mut flags, far, false);
        let both = flags.clone();
        spread(&mesh, &mut flags, FaceId(100), false);
        assert!(count(&flags) > count(&both));
        spread(&mesh, &mut flags, FaceId(100), true);
        assert_eq!(flags, both);
    }
}
