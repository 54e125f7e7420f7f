//! Warnings about a result, with the data behind them.
//!
//! A warning has a stable code for scripts, a message for users and, if there is one, a remedy.
//! Neither contains an option of the command line or a button: the front ends add those.

use std::fmt;
use std::ops::Deref;

use serde::ser::{Serialize, SerializeMap, Serializer};

use crate::energy::{Order, WellPosed};
use crate::mesh::{DVec3, LoopId};

/// Maximum number of pairs of intersecting triangles that are counted.
pub const MAX_PAIRS: usize = 100;

/// A problem of a result that the user should check.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// The flow of the energy is not strictly parabolic at some points of the surface.
    NotParabolic {
        /// The worst class found.
        class: WellPosed,
        /// Number of points of this class.
        count: usize,
        /// Number of sample points.
        samples: usize,
        /// The worst point.
        at: DVec3,
        /// Mean curvature there.
        h: f64,
        /// Gaussian curvature there.
        k: f64,
        /// Minimum of the symbol over all directions there.
        symbol: f64,
        /// Normal curvature in the direction of that minimum.
        direction: f64,
    },
    /// The energy is a multiple of `K`, for which every surface is stationary.
    StationaryEnergy,
    /// The flow of the energy is of second order, but the patch is to continue the tangent planes at
    /// its rim.
    SmoothRim,
    /// The surface pinches off, or triangles shrink to zero area.
    Pinched {
        /// Place of the pinch.
        at: DVec3,
        /// Order of the flow of the energy.
        order: Order,
    },
    /// No step lowers the energy any more.
    StepSizeCollapsed,
    /// The flow ended at the maximum number of steps.
    StepLimit {
        /// Accepted steps.
        steps: usize,
        /// Whether the scheme was the mixed one without correction.
        mixed: bool,
    },
    /// Vertices do not move because any further step would fold the surface.
    Frozen {
        /// Number of these vertices.
        vertices: usize,
    },
    /// Input vertices that the surface can interpolate only with a fold.
    Unreached {
        /// Number of these vertices.
        vertices: usize,
    },
    /// The surface intersects itself or the mesh.
    SelfIntersection {
        /// Pairs of intersecting triangles, at most [`MAX_PAIRS`].
        pairs: usize,
        /// One of the places.
        at: DVec3,
        /// Accepted steps up to the last shape without an intersection, which is kept. `None` if
        /// the first shape already has one.
        kept_step: Option<usize>,
    },
    /// Edges of the surface are folded by more than 150°, or triangles have no area.
    Folded {
        /// Number of folded edges and of triangles without area.
        edges: usize,
        /// One of the places.
        at: DVec3,
    },
    /// The hole is a slit without area, and so are the triangles of its patch.
    Slit,
    /// A part of the mesh passes through the hole.
    PassedThrough {
        /// A place where it does.
        at: DVec3,
    },
    /// Vertices of the surface are far from the rim: outside a cube about the box of the rim and the
    /// faces around it whose edges are twice the diagonal of that box.
    Escaped {
        /// Number of far vertices.
        vertices: usize,
        /// One of the places.
        at: DVec3,
    },
    /// The surface model gave an unsound or wrinkled surface, which was repaired or replaced.
    Replaced {
        /// The model, in words.
        model: String,
        /// The one that replaced it, or this model on another triangulation; `None` if it was only repaired.
        by: Option<String>,
        /// Whether the defects of the result were removed by moving vertices near them.
        is_repaired: bool,
        /// Pairs of intersecting triangles of the first.
        pairs: usize,
        /// Vertices of the first that are far from the rim.
        escaped: usize,
        /// Folded edges of the first.
        folds: usize,
        /// How many times as much as the second the first bends, if that is far more.
        bending: Option<f64>,
        /// The largest distance of the first from the rim in radii of the hole, if that is far more than that of the
        /// second.
        reach: Option<f64>,
    },
    /// The patch of a hole does not join some islands in it.
    IslandsLeft {
        /// Their outer boundaries.
        islands: Vec<LoopId>,
        /// Reason why the patch does not join the islands.
        why: WhyLeft,
    },
    /// The result has more pairs of intersecting triangles than the input has.
    IntersectingResult {
        /// Pairs of the result.
        pairs: usize,
        /// Pairs of the input.
        of_input: usize,
    },
    /// Sharp edges between flat parts of a refined mesh become round.
    RoundedEdges {
        /// Number of edges.
        edges: usize,
        /// The middle of one of them.
        at: DVec3,
    },
    /// The patch could get no texture although faces around it have one.
    NoTexture {
        /// Reason why the patch has no texture.
        reason: String,
    },
    /// A change during a flow was refused.
    ChangeRefused {
        /// The message.
        text: String,
    },
    /// The flow failed; the last valid shape is kept.
    FlowFailed {
        /// Reason why the flow failed.
        reason: String,
    },
}

/// Why a patch does not join an island.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhyLeft {
    /// Its faces have the opposite orientation of those around the hole.
    InsideOut,
    /// No orientable surface joins it.
    OneSided,
    /// No first patch joins it.
    NoPatch,
    /// The start surface that joins it crosses itself or the mesh, or is folded.
    Unsound,
}

impl Warning {
    /// A stable name of this kind of warning, for scripts.
    pub fn code(&self) -> &'static str {
        match self {
            Self::NotParabolic { class, .. } => match class {
                WellPosed::Undefined => "undefined-derivatives",
                WellPosed::IllPosed => "ill-posed",
                _ => "degenerate",
            },
            Self::StationaryEnergy => "stationary-energy",
            Self::SmoothRim => "smooth-rim",
            Self::Pinched { .. } => "pinched",
            Self::StepSizeCollapsed => "step-size-collapsed",
            Self::StepLimit { .. } => "step-limit",
            Self::Frozen { .. } => "frozen",
            Self::Unreached { .. } => "unreached",
            Self::SelfIntersection { .. } => "self-intersection",
            Self::Folded { .. } => "folded",
            Self::Slit => "slit",
            Self::PassedThrough { .. } => "passed-through",
            Self::Escaped { .. } => "escaped",
            Self::Replaced { .. } => "surface-replaced",
            Self::IslandsLeft { .. } => "islands-left",
            Self::IntersectingResult { .. } => "intersecting-result",
            Self::RoundedEdges { .. } => "rounded-edges",
            Self::NoTexture { .. } => "no-texture",
            Self::ChangeRefused { .. } => "change-refused",
            Self::FlowFailed { .. } => "flow-failed",
        }
    }

    /// Whether it is about a patch that is left with a defect: it intersects itself or the mesh, is folded or
    /// far from its rim.
    pub fn is_unsound(&self) -> bool {
        matches!(
            self,
            Self::SelfIntersection { .. } | Self::Folded { .. } | Self::Slit | Self::Escaped { .. }
        )
    }

    /// The remedy, if there is one.
    pub fn hint(&self) -> Option<&'static str> {
        Some(match self {
            Self::Pinched {
                order: Order::Second,
                ..
            } => "use a fourth-order energy such as H^2, or move the rims closer together",
            Self::Pinched { .. } => {
                "use another energy, add tension, or move the rims closer together"
            }
            Self::SmoothRim => "use G0 at the rims, or a fourth-order energy such as H^2",
            Self::StepSizeCollapsed => "try another energy or a fixed time step",
            Self::StepLimit { mixed: false, .. } => "allow more steps",
            Self::StepLimit { mixed: true, .. } => {
                "allow more steps, or use the corrected mixed scheme, whose vertices do not drift \
                 along the surface"
            }
            Self::Frozen { .. } => "increase the tension, or use a finer mesh there",
            Self::Unreached { .. } => "check whether the mesh is folded there",
            Self::SelfIntersection {
                kept_step: None, ..
            } => {
                "join rims whose patches intersect by one patch (blend), or use a flatter surface such as diffusion"
            }
            Self::SelfIntersection { .. } => {
                "use another energy, add tension, or join fewer rims at a time"
            }
            Self::IslandsLeft { why, .. } => match why {
                WhyLeft::InsideOut => {
                    "flip the component of that loop and join both loops, or remove that component"
                }
                _ => "remove these components if they are no part of the surface",
            },
            Self::IntersectingResult { .. } => "increase the tension",
            Self::RoundedEdges { .. } => "keep sharp edges by their angle",
            Self::Escaped { .. } => "use another surface model or energy, or add tension",
            Self::Folded { .. } => {
                "check whether the rim is folded there, or erase the faces there"
            }
            Self::Slit => "stitch its sides instead of filling it",
            Self::PassedThrough { .. } => "leave the hole open, or remove that part",
            _ => return None,
        })
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotParabolic {
                class,
                count,
                samples,
                at,
                h,
                k,
                symbol,
                direction,
            } => {
                let what = match class {
                    WellPosed::Undefined => "has no finite second derivatives",
                    WellPosed::IllPosed => "is ill-posed (short wavelengths grow)",
                    _ => "is degenerate (no smoothing in some direction)",
                };
                write!(
                    f,
                    "the flow of this energy {what} at {count} of {samples} points; worst at \
                     H = {h:.6e}, K = {k:.6e}: symbol {symbol:.3e} in the direction of normal \
                     curvature {direction:.3e}, near {}",
                    Place(*at)
                )
            }
            Self::StationaryEnergy => f.write_str(
                "this energy is a multiple of K, whose integral depends only on the rim, so every \
                 surface is stationary; the first patch is kept",
            ),
            Self::SmoothRim => f.write_str(
                "the flow of this energy is of second order, so its surface depends only on the \
                 position of the rim; it crumples if it has to continue tangent planes",
            ),
            Self::Pinched { at, order } => {
                let reason = if *order == Order::Second {
                    "because this energy has no minimum between rims so far apart; the last shape \
                     with an open neck is kept"
                } else {
                    "or triangles shrink to zero area there; the last shape before that is kept"
                };
                let at = Place(*at);
                write!(
                    f,
                    "not converged: the surface pinches off near {at}, {reason}"
                )
            }
            Self::StepSizeCollapsed => f.write_str(
                "not converged: the time step collapsed because no step lowers the energy; the \
                 last valid shape is kept",
            ),
            Self::StepLimit { steps, .. } => {
                write!(
                    f,
                    "not converged: the flow ended at the maximum number of steps, {steps}"
                )
            }
            Self::Frozen { vertices } => write!(
                f,
                "{} no further, because the surface would fold there",
                counted(*vertices, "vertex moves", "vertices move")
            ),
            Self::Unreached { vertices } => write!(
                f,
                "the surface misses {}, because it would fold there",
                counted(*vertices, "input vertex", "input vertices")
            ),
            Self::Folded { edges, at } => write!(
                f,
                "the surface is folded by more than 150 degrees, or has triangles without area: \
                 {}, near {}",
                counted(*edges, "place", "places"),
                Place(*at)
            ),
            Self::Slit => f.write_str("the hole is a slit, and its patch has no area"),
            Self::PassedThrough { at } => write!(
                f,
                "a part of the mesh passes through the hole, near {}: every surface over the hole \
                 intersects it",
                Place(*at)
            ),
            Self::Escaped { vertices, at } => write!(
                f,
                "vertices of the surface far from the rim, beyond twice its size: {vertices}, one \
                 near {}",
                Place(*at)
            ),
            Self::Replaced {
                model,
                by,
                is_repaired,
                pairs,
                escaped,
                folds,
                bending,
                reach,
            } => {
                let defects = [
                    (*pairs, counted_pairs(*pairs)),
                    (
                        *escaped,
                        counted(
                            *escaped,
                            "vertex far from the rim",
                            "vertices far from the rim",
                        ),
                    ),
                    (*folds, counted(*folds, "folded edge", "folded edges")),
                ];
                let defects = defects.into_iter().filter(|defect| defect.0 > 0);
                let defects: Vec<String> = defects.map(|defect| defect.1).collect();
                let has = (!defects.is_empty()).then(|| format!("has {}", defects.join(", ")));
                let bends = bending.map(|ratio| format!("bends {ratio:.0} times as much"));
                let reaches =
                    reach.map(|reach| format!("is up to {reach:.1} hole radii away from the rim"));
                let reasons: Vec<String> = bends.into_iter().chain(reaches).chain(has).collect();
                let reasons = reasons.join(" and ");
                let removed = "removed by moving vertices near them";
                let Some(by) = by else {
                    return write!(f, "the surface by {model} {reasons}, {removed}");
                };
                write!(
                    f,
                    "filled by {by} instead of {model}, whose surface {reasons}"
                )?;
                if *is_repaired {
                    write!(f, "; other defects were {removed}")?;
                }
                Ok(())
            }
            Self::SelfIntersection {
                pairs,
                at,
                kept_step: None,
            } => write!(
                f,
                "the surface intersects itself or the mesh: {}",
                pairs_near(*pairs, *at)
            ),
            Self::SelfIntersection {
                pairs,
                at,
                kept_step: Some(step),
            } => write!(
                f,
                "not converged: the surface intersects itself or the mesh ({}); the last shape \
                 without an intersection, after step {step}, is kept",
                pairs_near(*pairs, *at)
            ),
            Self::IslandsLeft { islands, why } => {
                let loops: Vec<String> = islands.iter().map(ToString::to_string).collect();
                let noun = match islands.len() {
                    1 => "island at loop",
                    _ => "islands at loops",
                };
                let reason = match why {
                    WhyLeft::InsideOut => "whose faces have the opposite orientation",
                    WhyLeft::OneSided => "to which no orientable surface leads",
                    WhyLeft::NoPatch => "between which no first patch can be made",
                    WhyLeft::Unsound => {
                        "because a surface that joins them crosses itself or the mesh"
                    }
                };
                let loops = loops.join(", ");
                write!(f, "the patch does not join the {noun} {loops}, {reason}")
            }
            Self::IntersectingResult { pairs, of_input } => write!(
                f,
                "two sheets of the mesh are too close together for a smooth surface through its \
                 vertices: the result has {pairs} pairs of intersecting triangles, the input \
                 {of_input}"
            ),
            Self::RoundedEdges { edges, at } => write!(
                f,
                "sharp edges between flat parts of the mesh become round: {edges}, one near {}",
                Place(*at)
            ),
            Self::NoTexture { reason } => write!(f, "the patch has no texture: {reason}"),
            Self::ChangeRefused { text } | Self::FlowFailed { reason: text } => f.write_str(text),
        }
    }
}

/// The number of pairs and one of the places, in words.
pub fn pairs_near(pairs: usize, at: DVec3) -> String {
    format!("{}, one near {}", counted_pairs(pairs), Place(at))
}

/// A number of pairs, which are counted up to [`MAX_PAIRS`].
fn counted_pairs(pairs: usize) -> String {
    let more = if pairs < MAX_PAIRS { "" } else { "or more " };
    let [one, many] =
        ["pair", "pairs"].map(|noun| format!("{more}{noun} of intersecting triangles"));
    counted(pairs, &one, &many)
}

/// A number with its noun.
pub(crate) fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// A place in words.
pub(crate) struct Place(pub DVec3);

fn coordinate(x: f64) -> String {
    if x.abs() < 1e9 {
        format!("{x:.6}")
    } else {
        format!("{x:.3e}")
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0.to_array().map(coordinate);
        write!(f, "({x}, {y}, {z})")
    }
}

/// Warnings in order of occurrence, without duplicates.
///
/// Serialized as the two fields `warnings` (messages) and `warning_codes`, in the same order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Warnings(Vec<Warning>);

impl Warnings {
    /// Adds a warning unless the list contains it.
    pub fn push(&mut self, warning: Warning) {
        if !self.0.contains(&warning) {
            self.0.push(warning);
        }
    }
}

impl Deref for Warnings {
    type Target = [Warning];

    fn deref(&self) -> &[Warning] {
        &self.0
    }
}

impl Extend<Warning> for Warnings {
    fn extend<T: IntoIterator<Item = Warning>>(&mut self, more: T) {
        more.into_iter().for_each(|warning| self.push(warning));
    }
}

impl IntoIterator for Warnings {
    type Item = Warning;
    type IntoIter = std::vec::IntoIter<Warning>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl FromIterator<Warning> for Warnings {
    fn from_iter<T: IntoIterator<Item = Warning>>(all: T) -> Self {
        let mut warnings = Self::default();
        warnings.extend(all);
        warnings
    }
}

impl Serialize for Warnings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let texts: Vec<String> = self.iter().map(ToString::to_string).collect();
        let codes: Vec<&str> = self.iter().map(Warning::code).collect();
        let mut map = serializer.serialize_map(Some(2))?;
        map.serialize_entry("warnings", &texts)?;
        map.serialize_entry("warning_codes", &codes)?;
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn one_of_each() -> Vec<Warning> {
        let at = DVec3::new(1.0, -2.0, 0.5);
        let posed = |class| Warning::NotParabolic {
            class,
            count: 3,
            samples: 7,
            at,
            h: 1.0,
            k: -1.0,
            symbol: -0.5,
            direction: 2.0,
        };
        vec![
            posed(WellPosed::Degenerate),
            posed(WellPosed::IllPosed),
            posed(WellPosed::Undefined),
            Warning::StationaryEnergy,
            Warning::Pinched {
                at,
                order: Order::Second,
            },
            Warning::StepSizeCollapsed,
            Warning::StepLimit {
                steps: 5,
                mixed: true,
            },
            Warning::Frozen { vertices: 4 },
            Warning::Unreached { vertices: 4 },
            Warning::SelfIntersection {
                pairs: 1,
                at,
                kept_step: Some(6),
            },
            Warning::Slit,
            Warning::PassedThrough { at },
            Warning::Escaped { vertices: 4, at },
            Warning::IslandsLeft {
                islands: vec![LoopId::FIRST],
                why: WhyLeft::InsideOut,
            },
            Warning::IntersectingResult {
                pairs: 2,
                of_input: 1,
            },
            Warning::RoundedEdges { edges: 4, at },
            Warning::ChangeRefused { text: "no".into() },
            Warning::FlowFailed {
                reason: "no".into(),
            },
        ]
    }

    #[test]
    fn codes_are_distinct_kebab_case_words() {
        let all = one_of_each();
        let codes: BTreeSet<&str> = all.iter().map(Warning::code).collect();
        assert_eq!(codes.len(), all.len());
        for code in codes {
            let kebab = |c: char| c.is_ascii_lowercase() || c == '-';
            assert!(code.chars().all(kebab), "{code}");
        }
    }

    #[test]
    fn a_replacement_names_the_defects_there_were() {
        let text = |by: Option<&str>, is_repaired, pairs, escaped, folds, bending| {
            let (model, by) = ("g2".into(), by.map(Into::into));
            Warning::Replaced {
                model,
                by,
                is_repaired,
                pairs,
                escaped,
                folds,
                bending,
                reach: None,
            }
            .to_string()
        };
        let by = Some("diffusion");
        assert_eq!(
            text(by, false, 0, 0, 1, None),
            "filled by diffusion instead of g2, whose surface has 1 folded edge"
        );
        assert_eq!(
            text(None, true, MAX_PAIRS, 2, 0, None),
            "the surface by g2 has 100 or more pairs of intersecting triangles, 2 vertices far from the \
             rim, removed by moving vertices near them"
        );
        assert_eq!(
            text(by, false, 0, 0, 0, Some(21.4)),
            "filled by diffusion instead of g2, whose surface bends 21 times as much"
        );
        assert_eq!(
            text(by, true, 0, 0, 2, Some(9.0)),
            "filled by diffusion instead of g2, whose surface bends 9 times as much and has 2 folded edges; \
             other defects were removed by moving vertices near them"
        );
    }

    /// Messages and hints contain no option of the command line and no run of blanks.
    #[test]
    fn texts_name_no_flag_and_have_single_blanks() {
        for warning in one_of_each() {
            let text = format!("{warning} {}", warning.hint().unwrap_or_default());
            assert!(!text.contains("--") && !text.contains("  "), "{text}");
        }
    }

    #[test]
    fn the_script_of_fig_2_asks_for_codes_that_exist() {
        let script = include_str!("../scripts/fig2.sh");
        let asked = script.split("    warned ").skip(1);
        let asked: Vec<&str> = asked.filter_map(|s| s.split(' ').next()).collect();
        assert_eq!(asked.len(), 3);
        let all = one_of_each();
        for code in asked {
            assert!(all.iter().any(|w| w.code() == code), "{code}");
        }
    }

    #[test]
    fn messages_give_places_and_counts() {
        let at = DVec3::new(1.0, -2.0, 0.5);
        let text = |pairs, kept_step| {
            let warning = Warning::SelfIntersection {
                pairs,
                at,
                kept_step,
            };
            warning.to_string()
        };
        assert!(text(1, Some(6)).contains(
            "1 pair of intersecting triangles, one near (1.000000, -2.000000, 0.500000)"
        ));
        assert!(text(1, Some(6)).contains("after step 6"));
        assert!(text(100, None).contains("100 or more pairs"));
    }

    #[test]
    fn a_list_has_each_warning_once_and_serializes_as_texts_and_codes() {
        let twice = [Warning::StepSizeCollapsed, Warning::StepSizeCollapsed];
        let warnings: Warnings = twice.into_iter().collect();
        assert_eq!(warnings.len(), 1);
        let json = serde_json::to_value(&warnings).expect("a map");
        assert_eq!(
            json["warning_codes"],
            serde_json::json!(["step-size-collapsed"])
        );
        let text = json["warnings"][0].as_str().expect("a text");
        assert!(text.starts_with("not converged: the time step collapsed"));
    }
}
