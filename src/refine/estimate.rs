//! Memory and time that a refinement will take.

use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use crate::refine::{Method, RefineControls};

/// Bytes for each face of the last level in a flow. Measured as peak memory of refinements of 7,000 faces
/// by two levels.
const FLOW_BYTES: f64 = 3500.0;
/// The same for the schemes without a flow.
const SCHEME_BYTES: f64 = 220.0;
/// Processor time in seconds for each face of all levels in a flow. Measured with refinements of 11,000
/// faces by one and two levels: 1.0e-4 in fast mode, 1.2e-4 in flow mode.
const FLOW_SECONDS: f64 = 1.2e-4;
/// The same for the schemes without a flow.
const SCHEME_SECONDS: f64 = 1.2e-6;
/// Faces that give a rate. The time of smaller levels is mostly that of the set-up.
const ENOUGH: f64 = 5000.0;

/// What a refinement will take.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RefineEstimate {
    /// Memory in bytes of the last level, which is the largest.
    pub bytes: f64,
    /// Seconds of all levels: at the rate of the refinements of this process so far if there were any,
    /// otherwise processor time, of which the wall clock shows less if there are several processors.
    pub seconds: f64,
    /// Whether the seconds follow from refinements of this process.
    pub is_measured: bool,
}

impl RefineControls {
    /// Estimates the refinement of some of `all` faces.
    pub fn estimate(&self, refined: usize, all: usize) -> RefineEstimate {
        self.estimate_at(rate(self.method), refined, all)
    }

    /// The same for a rate in seconds for each face.
    fn estimate_at(&self, measured: Option<f64>, refined: usize, all: usize) -> RefineEstimate {
        let (bytes, seconds) = match self.method {
            Method::Pde => (FLOW_BYTES, FLOW_SECONDS),
            Method::Butterfly | Method::Loop => (SCHEME_BYTES, SCHEME_SECONDS),
        };
        let last = refined as f64 * 4f64.powf(self.levels as f64);
        RefineEstimate {
            bytes: bytes * last + SCHEME_BYTES * all as f64,
            // a level has a quarter of the faces of the next
            seconds: measured.unwrap_or(seconds) * last * 4.0 / 3.0,
            is_measured: measured.is_some(),
        }
    }
}

/// Finished levels of this process.
#[derive(Clone, Copy, Debug, Default)]
struct Done {
    seconds: f64,
    faces: f64,
}

impl Done {
    const NONE: Self = Self {
        seconds: 0.0,
        faces: 0.0,
    };

    fn add(&mut self, faces: usize, time: Duration) {
        self.seconds += time.as_secs_f64();
        self.faces += faces as f64;
    }

    /// Seconds for each face.
    fn rate(&self) -> Option<f64> {
        (self.faces >= ENOUGH).then(|| self.seconds / self.faces)
    }
}

/// Those of flows, and those of schemes without one.
static DONE: Mutex<[Done; 2]> = Mutex::new([Done::NONE; 2]);

fn place(method: Method) -> usize {
    usize::from(method != Method::Pde)
}

/// Counts a finished level, for later estimates.
pub(super) fn count_level(method: Method, faces: usize, time: Duration) {
    let mut done = DONE.lock().unwrap_or_else(PoisonError::into_inner);
    done[place(method)].add(faces, time);
}

/// Seconds for each face of a level so far in this process.
fn rate(method: Method) -> Option<f64> {
    DONE.lock().unwrap_or_else(PoisonError::into_inner)[place(method)].rate()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measured_rates_replace_the_fixed_ones() {
        let mut done = Done::NONE;
        done.add(4000, Duration::from_secs(1));
        assert_eq!(done.rate(), None);
        done.add(4000, Duration::from_secs(3));
        assert_eq!(done.rate(), Some(5e-4));
        let controls = RefineControls {
            levels: 2,
            ..RefineControls::default()
        };
        let fixed = controls.estimate_at(None, 3000, 3000);
        let measured = controls.estimate_at(done.rate(), 3000, 3000);
        assert!((fixed.seconds - 1.2e-4 * 64_000.0).abs() < 1e-9 && !fixed.is_measured);
        assert!((measured.seconds - 5e-4 * 64_000.0).abs() < 1e-9 && measured.is_measured);
        assert_eq!(measured.bytes, fixed.bytes);
        // 0.12 ms for each face of the last of nine levels, and a third more before it
        let large = RefineControls {
            levels: 9,
            ..controls
        };
        let seconds = large.estimate_at(None, 20, 20).seconds;
        assert!((830.0..850.0).contains(&seconds), "{seconds}");
    }

    #[test]
    fn finished_levels_are_counted() {
        let mesh = crate::shapes::sphere(700, 1);
        let mesh = crate::mesh::Mesh::from_triangles(mesh.0, &mesh.1).expect("manifold");
        let options = RefineControls {
            method: Method::Butterfly,
            levels: 1,
            ..RefineControls::default()
        };
        let recording = crate::runner::Recording::default();
        let mesh = std::sync::Arc::new(mesh);
        crate::refine::refine(mesh, options.clone().into(), &recording, &mut |_| true)
            .expect("refined");
        assert!(options.estimate(100, 100).is_measured);
    }
}
