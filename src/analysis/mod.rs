//! Measures of surfaces.

mod distance;

pub use distance::{Deviation, Distances, distances};
