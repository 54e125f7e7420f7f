//! Differential geometry of a Loop limit surface: at a point, over a region, and through points.
//!
//! Signs: the normal `n` points to the side from which faces appear counter-clockwise. The mean
//! curvature `H = (k1 + k2) / 2` is negative on a sphere with outward normal, the Gaussian
//! curvature `K = k1 k2` positive. Flipping the orientation flips `n` and `H`, not `K`.

mod interpolation;
mod mean_variation;
mod point;
mod projection;
mod stats;

pub use interpolation::Interpolation;
pub use mean_variation::MeanVariation;
pub use point::{Coefficients, PointGeometry, each_point, mean_curvature, surface_point};
pub use projection::project_to_vertices;
pub use stats::{SurfaceStats, sample_surface};
