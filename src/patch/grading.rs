//! Growth of the triangles of large patches with the distance from the rim.
//!
//! A patch of the rim's density has about `n² / 8` vertices over a round rim of n edges. Above
//! [`MAX_EVEN`] vertices the triangles therefore grow with the distance from the rim, by as much as
//! brings the number of vertices down to [`MAX_EVEN`], but by at most [`STEEPEST`] a length; at that
//! growth the number is about 4 n. The shape far from a long rim varies slowly against its edges. A
//! density above 1 raises the limit as it raises the number of vertices.

use super::surface::{NONE, STEEPEST, Surface};
use crate::memory::{TooLittleMemory, require};

/// Patches with up to this many new vertices have the density of the rim everywhere (a round rim of 890
/// edges at density 1).
const MAX_EVEN: f64 = 100_000.0;

/// Sets the grading of a triangulation with known sizes at its rims. `density` is relative to the rim.
pub(super) fn set_grading(s: &mut Surface, density: f64) {
    s.refinement = density.max(1.0);
    s.growth = growth(s, density);
}

/// The growth (see [`Surface::growth`]).
fn growth(s: &Surface, density: f64) -> f64 {
    let strip = Strip::of(s);
    let most = MAX_EVEN * density.max(1.0).powi(2);
    if strip.vertices(0.0) <= most {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, STEEPEST);
    for _ in 0..30 {
        let middle = f64::midpoint(low, high);
        if strip.vertices(middle) <= most {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// Bytes for each vertex of a patch that the flow takes at least; the patch itself takes a tenth.
const BYTES: f64 = 4000.0;

/// Checks that there is memory for the patch that a triangulation will become, and for its flow, before
/// the patch is made.
///
/// # Errors
/// [`TooLittleMemory`].
pub(super) fn require_memory(s: &Surface) -> Result<(), TooLittleMemory> {
    require(BYTES * expected_vertices(s))
}

/// The number of vertices that a triangulation gets with the growth it has.
pub(super) fn expected_vertices(s: &Surface) -> f64 {
    Strip::of(s).vertices(s.growth)
}

/// A surface as a strip along its rims that narrows evenly to nothing, as a disc does.
struct Strip {
    area: f64,
    length: f64,
    /// Mean wanted edge length near the rims; in a finer patch, beyond the few rows in which it shrinks.
    edge: f64,
}

impl Strip {
    fn of(s: &Surface) -> Self {
        let rim = (0..s.corner.len() as u32).filter(|&h| !s.is_dead(h) && s.twin(h) == NONE);
        Self {
            area: s.area(),
            length: rim.map(|h| s.length2(h).sqrt()).sum(),
            edge: s.size[..s.rim].iter().sum::<f64>() / (s.refinement * s.rim as f64),
        }
    }

    /// The number of equilateral triangles over two: the integral of `1 / (√3/2 (e + g x)²)` over
    /// the strip, whose width at the distance x from the rim is `1 − x/D` of its length.
    fn vertices(&self, growth: f64) -> f64 {
        let depth = 2.0 * self.area / self.length;
        let per_area = 1.0 / 0.75f64.sqrt();
        if growth <= 0.0 {
            return per_area * self.area / (self.edge * self.edge);
        }
        let rise = growth * depth / self.edge;
        per_area * self.length / (growth * self.edge) * (1.0 - rise.ln_1p() / rise)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_of_all_growths_are_integrated() {
        let strip = Strip {
            area: 3.0,
            length: 4.0,
            edge: 0.01,
        };
        for growth in [1e-9, 0.02, 0.3] {
            let depth = 2.0 * strip.area / strip.length;
            let steps = 200_000;
            let width = depth / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|i| {
                    let x = (f64::from(i) + 0.5) * width;
                    let edge = strip.edge + growth * x;
                    width * strip.length * (1.0 - x / depth) / (0.75f64.sqrt() * edge * edge)
                })
                .sum();
            let found = strip.vertices(growth);
            assert!((found / sum - 1.0).abs() < 1e-5, "{growth}: {found} {sum}");
        }
        let even = strip.vertices(0.0);
        assert!((strip.vertices(1e-9) / even - 1.0).abs() < 1e-6);
    }
}
