//! Detects flows whose surface grows without bound, as under an energy that is not bounded below.

use super::{Curve, RunState};
use crate::mesh::{BoundaryLoop, DVec3, Mesh};
use crate::render::Bounds;

/// A patch stays within this many radii of the largest rim around the box of all rims.
const REACH: f64 = 4.0;
/// A flow whose energy has fallen by this many times its first value has no minimum.
const FALL: f64 = 10.0;
/// The energy of a sensible state has fallen by at most this many times its first value.
pub(super) const SENSIBLE_FALL: f64 = 1.0;

/// The box that a sensible surface does not leave.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    around: Bounds,
    /// The first vertex that the run added.
    first: usize,
}

impl Limits {
    /// The limits of a run that fills `loops` of `base`, or moves vertices of `base` if there are
    /// none; `None` without vertices.
    pub(super) fn new(base: &Mesh, loops: &[BoundaryLoop]) -> Option<Self> {
        let rims = loops.iter().flat_map(|l| &l.vertices);
        let rims = Bounds::of(rims.map(|&v| base.position(v)));
        let (around, reach, first) = if let Some(rims) = rims {
            let radius = loops.iter().map(|l| l.radius).fold(0.0, f64::max);
            (rims, REACH * radius, base.vertex_count())
        } else {
            let all = Bounds::of(base.positions.iter().copied())?;
            (all, all.radius(), 0)
        };
        let reach = DVec3::splat(reach);
        Some(Self {
            around: Bounds::new(around.low - reach, around.high + reach),
            first,
        })
    }

    /// Whether the surface of a state is inside.
    pub(super) fn hold(&self, state: &RunState) -> bool {
        let positions = state.positions(false);
        let own = positions.get(self.first..).unwrap_or_default();
        let Bounds { low, high, .. } = self.around;
        own.iter()
            .all(|p| p.cmpge(low).all() && p.cmple(high).all())
    }
}

/// Whether the energy falls without bound. Most energies are bounded below, and never fall by a
/// multiple of their first value.
pub(super) fn falls_without_bound(curve: &Curve) -> bool {
    let last = curve.energy.last().map(|[_, energy]| *energy);
    last.is_some_and(|energy| has_fallen(curve, energy, FALL))
}

/// Whether an energy is below the first one by more than some times its magnitude.
pub(super) fn has_fallen(curve: &Curve, energy: f64, times: f64) -> bool {
    let first = curve.energy.first();
    first.is_some_and(|[_, first]| energy < first - times * first.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_energy_that_falls_to_zero_is_bounded() {
        let curve = |values: &[f64]| Curve {
            energy: values.iter().map(|&e| [0.0, e]).collect(),
            ..Curve::default()
        };
        for bounded in [
            &[][..],
            &[0.0, 0.0],
            &[1e6, 10.0, 1e-9],
            &[-2.0, -2.5],
            &[1.0, -0.5],
        ] {
            assert!(!falls_without_bound(&curve(bounded)), "{bounded:?}");
        }
        assert!(falls_without_bound(&curve(&[-1.0, -3.0, -60.0])));
    }
}
