//! Where on a surface the flow of an energy is not well posed, face by face.

use crate::mesh::{DVec3, FaceId, Topology};
use crate::solver::energy::{Energy, WellPosed, scan_well_posedness};
use crate::solver::survey::each_point;
use crate::subdivision::{Rule, TableCache, elements};

/// What the flow is on each of `faces`: the worst class over the quadrature points of the limit
/// surface. `length` is the size of the region, as of [`scan_well_posedness`].
pub fn ill_posed_faces(
    topology: &Topology,
    positions: &[DVec3],
    faces: &[FaceId],
    energy: &Energy,
    length: f64,
) -> Vec<WellPosed> {
    let calm = if energy.is_uniformly_parabolic() {
        WellPosed::Strict
    } else {
        WellPosed::Stationary
    };
    let mut classes = vec![calm; faces.len()];
    if energy.is_uniformly_parabolic() {
        return classes;
    }
    // elements come in an order of their own
    let mut place: Vec<(FaceId, usize)> = faces.iter().enumerate().map(|(i, &f)| (f, i)).collect();
    place.sort_unstable();
    let local = elements(topology, faces, Rule::Three, &mut TableCache::default());
    for e in 0..local.len() {
        let mut samples = Vec::with_capacity(3);
        each_point(&local, e, positions, |_, p| samples.push([p.mean, p.gauss]));
        let scan = scan_well_posedness(energy, &samples, length, TOLERANCE);
        let found = place.binary_search_by_key(&local.faces[e], |(f, _)| f.0);
        if let (Ok(at), Some(worst)) = (found, scan.worst) {
            classes[place[at].1] = worst.class;
        }
    }
    classes
}

/// Symbols smaller than this, relative to their scale, count as zero.
pub(super) const TOLERANCE: f64 = 1e-9;
