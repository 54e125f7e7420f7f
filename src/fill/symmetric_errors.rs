//! Errors of pseudo-holes that are filled with the help of a symmetry of the mesh.

use rayon::prelude::*;

use crate::cancel::is_cancelled;
use crate::fill::context::FillContext;
use crate::fill::counterpart::Image;
use crate::fill::hole::PlannedHole;
use crate::fill::pseudo_hole::{Disc, Surroundings};
use crate::fill::restored::Restored;
use crate::fill::surface_choice::{Counterpart, TENSIONS};
use crate::mesh::{DVec3, VertexId};
use crate::symmetry::Isometry;

/// Vertices around a hole to which a symmetry is fitted, over those of its rim: about six rings.
const NEAR: usize = 6;
/// Maximum number of pseudo-holes of a hole on which a symmetry is tried.
const DISCS: usize = 16;
/// Number of pseudo-holes after which it is looked whether the rest can change the outcome.
const AT_ONCE: usize = 4;
/// Smallest share of the vertices in a hole that have a counterpart. With 0.3 the geometric mean of the ratios on
/// `real/` is 0.72 instead of 0.75, but one fill, of a hole of which a quarter has no counterpart, has twice
/// the error.
const HOLE_COVERED: f64 = 0.75;
/// The same in and around a pseudo-hole, and of pseudo-holes that are compared one by one.
const COVERED: [f64; 2] = [0.3, 0.6];
/// Part of the error without symmetry up to which a counterpart is used.
const WORTH: f64 = 0.9;
/// Smallest part of the pseudo-holes that must gain by a whole counterpart: where a few large errors
/// become smaller and most of the others larger, the hole itself rarely gains.
const MAJORITY: f64 = 0.5;

/// Squared errors of `g2` with and without the counterparts under a symmetry, on pseudo-holes.
pub(super) struct SymmetricErrors {
    isometry: Isometry,
    /// Median distance of the counterpart from the surroundings of the hole, over the hole radius.
    distance: f64,
    /// Share of the new vertices of the hole that have a counterpart.
    covered: f64,
    /// Of all pseudo-holes, by [`TENSIONS`].
    moments: [Moments; TENSIONS.len()],
    /// Part of the pseudo-holes that gain by a whole counterpart, by [`TENSIONS`].
    gaining: [f64; TENSIONS.len()],
}

/// Mean squares of the errors s without a counterpart and of the effects u of a whole one, relative to
/// the radius.
#[derive(Clone, Copy, Default)]
struct Moments {
    ss: f64,
    su: f64,
    uu: f64,
    /// Share of the vertices in and around the pseudo-holes that have a counterpart.
    known: f64,
}

impl Moments {
    /// Sum of the squared errors with a share of the counterpart, `Σ (s + share u)²`.
    fn error(&self, share: f64) -> f64 {
        self.ss + share * (2.0 * self.su + share * self.uu)
    }

    /// The share of least error.
    fn share(&self) -> f64 {
        let share = -self.su / self.uu;
        // no effect: any share would do
        if share.is_finite() {
            share.clamp(0.0, 1.0)
        } else {
            0.0
        }
    }

    /// Whether enough of the counterpart is known to compare it.
    fn is_comparable(&self) -> bool {
        self.known >= COVERED[1]
    }

    /// Whether a whole counterpart lowers the error.
    fn gains(&self) -> bool {
        self.error(1.0) < self.ss
    }

    /// Squared error with the best share, relative to that without a counterpart.
    fn ratio(&self) -> f64 {
        let ratio = self.error(self.share()) / self.ss;
        if ratio.is_finite() {
            ratio.max(0.0)
        } else {
            1.0
        }
    }
}

impl SymmetricErrors {
    /// Those of the symmetry with the least error. `restored` are the first pseudo-holes and `errors`
    /// their mean squared errors without symmetry, by [`TENSIONS`]. `None` if no symmetry is worth while.
    pub fn least(
        context: FillContext<'_>,
        hole: &PlannedHole,
        surroundings: &Surroundings,
        mut restored: Vec<Restored>,
        errors: &[f64],
    ) -> Option<Self> {
        let near = surroundings
            .near
            .iter()
            .take(NEAR * hole.rims.vertices.len());
        let near: Vec<VertexId> = near.map(|&v| surroundings.vertices[v as usize]).collect();
        let symmetries = context.symmetries().iter();
        let all = symmetries.filter_map(|symmetry| {
            if is_cancelled() {
                return None;
            }
            let (isometry, distance) = context.fitted(symmetry, &near)?;
            let distance = distance / hole.rims.radius();
            if errors.iter().all(|error| distance * distance > *error) {
                return None;
            }
            let covered = context.covered(&isometry, hole.patch.new_points());
            if covered < HOLE_COVERED {
                return None;
            }
            let discs = &surroundings.discs[..surroundings.discs.len().min(DISCS)];
            let count = discs.len();
            if restored.len() < count {
                restored.extend(Restored::all(surroundings, &discs[restored.len()..]));
            }
            let images = context.images(&isometry, surroundings, discs);
            let mut found = Vec::new();
            for (discs, restored) in discs.chunks(AT_ONCE).zip(restored.chunks(AT_ONCE)) {
                let pairs = discs.par_iter().zip(restored);
                let of_pair =
                    |(disc, restored)| moments(context, &isometry, &images, disc, restored);
                found.par_extend(pairs.map(of_pair));
                if is_hopeless(&found, count - found.len()) {
                    return None;
                }
            }
            Self::on(&found, isometry, [distance, covered])
        });
        let least = |one: &Self| {
            let ratios = (0..TENSIONS.len()).filter(|&k| one.is_worth(k));
            ratios.map(|k| one.ratio(k)).fold(f64::INFINITY, f64::min)
        };
        all.map(|one| (least(&one), one))
            .filter(|one| one.0 < 1.0)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|one| one.1)
    }

    /// On those pseudo-holes that have a counterpart. `None` if fewer than a third have one.
    fn on(
        discs: &[Option<[Moments; TENSIONS.len()]>],
        isometry: Isometry,
        [distance, covered]: [f64; 2],
    ) -> Option<Self> {
        let found: Vec<_> = discs.iter().flatten().collect();
        if found.is_empty() || 3 * found.len() < discs.len() {
            return None;
        }
        let mut sums = [Moments::default(); TENSIONS.len()];
        let mut gaining = [0.0; TENSIONS.len()];
        let comparable = found.iter().filter(|one| one[0].is_comparable());
        let comparable: Vec<_> = comparable.collect();
        let total: f64 = found.iter().map(|one| one[0].known * one[0].known).sum();
        for k in 0..TENSIONS.len() {
            let gains = comparable.iter().filter(|one| one[k].gains());
            gaining[k] = gains.count() as f64 / comparable.len().max(1) as f64;
            for Moments { ss, su, uu, known } in found.iter().map(|one| one[k]) {
                // pseudo-holes with a whole counterpart say most about a whole counterpart
                let weight = known * known / total;
                sums[k].ss += weight * ss;
                sums[k].su += weight * su;
                sums[k].uu += weight * uu;
            }
        }
        Some(Self {
            isometry,
            distance,
            covered,
            moments: sums,
            gaining,
        })
    }

    /// Squared error to expect of the hole, relative to that without a counterpart: the error is
    /// lower in the part of the hole that has one.
    pub fn ratio(&self, tension: usize) -> f64 {
        let moments = self.moments[tension];
        if self.is_worth(tension) {
            1.0 - self.covered * (1.0 - moments.ratio())
        } else {
            1.0
        }
    }

    /// Whether the counterpart is to be used: the error with it is less, most pseudo-holes gain, and it
    /// fits the surroundings of the hole itself better than the error without it.
    fn is_worth(&self, tension: usize) -> bool {
        let moments = &self.moments[tension];
        moments.ratio() <= WORTH * WORTH
            && self.gaining[tension] >= MAJORITY
            && self.distance * self.distance <= moments.ss
    }

    /// What fills the hole by symmetry. `None` if the counterpart is not worth while.
    pub fn counterpart(&self, tension: usize) -> Option<Counterpart> {
        self.is_worth(tension).then(|| Counterpart {
            isometry: self.isometry,
            share: self.moments[tension].share(),
        })
    }
}

/// Whether no tension can make a counterpart better, for any results on `left` further pseudo-holes.
fn is_hopeless(found: &[Option<[Moments; TENSIONS.len()]>], left: usize) -> bool {
    let some = found.iter().flatten();
    if 3 * (some.clone().count() + left) < found.len() + left {
        return true;
    }
    let comparable = || some.clone().filter(|one| one[0].is_comparable());
    let is_lost = |k: usize| {
        let gains = comparable().filter(|one| one[k].gains()).count() + left;
        (gains as f64) < MAJORITY * (comparable().count() + left) as f64
    };
    (0..TENSIONS.len()).all(is_lost)
}

/// Errors of a pseudo-hole by [`TENSIONS`], relative to its radius, where it has a counterpart. The
/// symmetry is fitted to its surroundings, whose `images` are those under the symmetry. `None` if too much of the counterpart is missing.
fn moments(
    context: FillContext<'_>,
    symmetry: &Isometry,
    images: &[Option<Image>],
    disc: &Disc,
    restored: &Restored,
) -> Option<[Moments; TENSIONS.len()]> {
    let images = disc.vertices.iter().map(|&v| images[v as usize]);
    let images: Vec<Option<Image>> = images.collect();
    let isometry = context.fitted_to_disc(symmetry, &images[disc.ends[0]..])?;
    let there = images.iter();
    let there = there.map(|image| context.counterpart_of(&isometry, image.as_ref()?));
    let there: Vec<Option<DVec3>> = there.collect();
    let known = there.iter().flatten().count() as f64 / there.len() as f64;
    if known < COVERED[0] {
        return None;
    }
    let mut moments = [(); TENSIONS.len()].map(|()| Moments {
        known,
        ..Moments::default()
    });
    let scale = 1.0 / (disc.normals.len() as f64 * disc.radius * disc.radius);
    let of_reference = restored.along_normals(disc, &there);
    let pairs = restored.errors.iter().zip(&of_reference).zip(&there);
    for ((errors, steps), _) in pairs.filter(|pair| pair.1.is_some()) {
        for (k, sum) in moments.iter_mut().enumerate() {
            // the step towards the minimum of the energy of x − share y, by shares
            let (s, u) = (errors[k], -steps[k]);
            sum.ss += scale * s * s;
            sum.su += scale * s * u;
            sum.uu += scale * u * u;
        }
    }
    let is_finite = |one: &Moments| (one.ss + one.su + one.uu).is_finite();
    moments.iter().all(is_finite).then_some(moments)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outcome_is_known_early_only_if_no_further_pseudo_hole_can_change_it() {
        let of = |su: f64, known: f64| {
            let moments = Moments {
                ss: 1.0,
                su,
                uu: 1.0,
                known,
            };
            Some([moments; TENSIONS.len()])
        };
        let [gain, loss, unclear] = [of(-0.9, 1.0), of(0.0, 1.0), of(0.0, 0.5)];
        // every outcome of `left` more pseudo-holes
        let can_gain = |found: &[Option<[Moments; TENSIONS.len()]>], left: usize| {
            (0..4usize.pow(left as u32)).any(|code| {
                let kinds = [gain, loss, unclear, None];
                let more = (0..left as u32).map(|digit| kinds[code / 4usize.pow(digit) % 4]);
                let all: Vec<_> = found.iter().copied().chain(more).collect();
                let isometry = Isometry::about(DVec3::ZERO, glam::DMat3::IDENTITY);
                let errors = SymmetricErrors::on(&all, isometry, [0.0, 1.0]);
                errors.is_some_and(|errors| errors.gaining[0] >= MAJORITY)
            })
        };
        for code in 0..256 {
            let kinds = [gain, loss, unclear, None];
            let found: Vec<_> = (0..4).map(|digit| kinds[code >> (2 * digit) & 3]).collect();
            for left in 0..4 {
                let (is_known, can_gain) = (is_hopeless(&found, left), can_gain(&found, left));
                assert!(!(is_known && can_gain));
                // all gain or lose
                if code & 0b1010_1010 == 0 {
                    assert_eq!(is_known, !can_gain);
                }
            }
        }
    }

    #[test]
    fn the_share_has_the_least_error() {
        let moments = Moments {
            ss: 4.0,
            su: -2.0,
            uu: 1.6,
            known: 1.0,
        };
        assert_eq!(moments.share(), 1.0);
        let moments = Moments { uu: 4.0, ..moments };
        assert_eq!(moments.share(), 0.5);
        assert_eq!(moments.ratio(), 0.75);
        for share in [0.4, 0.6] {
            assert!(moments.error(share) > moments.error(0.5));
        }
        // an effect in the wrong direction, and none
        assert_eq!(Moments { su: 1.0, ..moments }.share(), 0.0);
        assert_eq!(
            Moments {
                su: 0.0,
                uu: 0.0,
                ..moments
            }
            .ratio(),
            1.0
        );
    }
}
