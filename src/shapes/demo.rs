//! The built-in sample: a small four-legged creature with many complex holes.

use std::f64::consts::FRAC_PI_2;

use super::{Hole, HoleShape, TriangleMesh, cut_holes, implicit_surface};
use crate::mesh::DVec3;

/// Sharpness of the blend between limbs, in 1/length.
const BLEND: f64 = 16.0;

/// A limb: the points within a radius, which varies linearly, of a segment.
struct Limb {
    from: DVec3,
    to: DVec3,
    radius_from: f64,
    radius_to: f64,
}

const fn limb(from: [f64; 3], to: [f64; 3], radius_from: f64, radius_to: f64) -> Limb {
    Limb {
        from: DVec3::from_array(from),
        to: DVec3::from_array(to),
        radius_from,
        radius_to,
    }
}

/// x forward, y to the left, z up; about three units long.
const LIMBS: [Limb; 16] = [
    // trunk, neck, head, snout
    limb([-0.55, 0.0, 0.02], [0.42, 0.0, 0.05], 0.35, 0.31),
    limb([0.45, 0.0, 0.15], [0.88, 0.0, 0.52], 0.20, 0.16),
    limb([0.95, 0.0, 0.60], [1.02, 0.0, 0.58], 0.25, 0.22),
    limb([1.05, 0.0, 0.53], [1.38, 0.0, 0.44], 0.14, 0.10),
    // ears
    limb([0.90, 0.13, 0.78], [0.82, 0.25, 1.10], 0.08, 0.06),
    limb([0.90, -0.13, 0.78], [0.82, -0.25, 1.10], 0.08, 0.06),
    // legs and feet
    limb([0.38, 0.20, -0.10], [0.44, 0.24, -0.75], 0.14, 0.095),
    limb([0.38, -0.20, -0.10], [0.44, -0.24, -0.75], 0.14, 0.095),
    limb([-0.58, 0.20, -0.10], [-0.60, 0.25, -0.75], 0.17, 0.10),
    limb([-0.58, -0.20, -0.10], [-0.60, -0.25, -0.75], 0.17, 0.10),
    limb([0.44, 0.24, -0.80], [0.54, 0.25, -0.82], 0.09, 0.08),
    limb([0.44, -0.24, -0.80], [0.54, -0.25, -0.82], 0.09, 0.08),
    limb([-0.60, 0.25, -0.80], [-0.50, 0.26, -0.82], 0.09, 0.08),
    limb([-0.60, -0.25, -0.80], [-0.50, -0.26, -0.82], 0.09, 0.08),
    // tail
    limb([-0.85, 0.0, 0.18], [-1.20, 0.0, 0.42], 0.09, 0.08),
    limb([-1.20, 0.0, 0.42], [-1.30, 0.0, 0.78], 0.08, 0.07),
];

/// Value and (nearly) gradient of the smooth union of the limbs.
fn body(p: DVec3) -> (f64, DVec3) {
    let (mut sum, mut slope) = (0.0, DVec3::ZERO);
    for l in &LIMBS {
        let along = l.to - l.from;
        let t = ((p - l.from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        let offset = p - (l.from + along * t);
        let distance = offset.length();
        let radius = l.radius_from + (l.radius_to - l.radius_from) * t;
        let weight = (-BLEND * (distance - radius)).exp();
        sum += weight;
        slope += offset * (weight / distance.max(f64::MIN_POSITIVE));
    }
    (-sum.ln() / BLEND, slope / sum)
}

/// The sample without its holes: a closed surface of genus 0, some 12,000 vertices.
pub fn demo_body() -> TriangleMesh {
    let (low, high) = (DVec3::new(-1.6, -0.7, -1.1), DVec3::new(1.7, 0.7, 1.4));
    implicit_surface(&body, low, high, 0.03, 3)
}

/// The sample: a small four-legged creature with sixteen holes of every kind, in the spirit of
/// Fig. 3 of the paper.
pub fn demo() -> TriangleMesh {
    cut_holes(&demo_body(), &demo_holes())
}

fn demo_holes() -> Vec<Hole> {
    use HoleShape::{Angle, Blots, Disc, Ragged, Slit, Star};
    let mut seed = 0;
    let mut hole = |centre: [f64; 3], turn: f64, shape: HoleShape| {
        seed += 1;
        Hole {
            centre: DVec3::from_array(centre),
            shape,
            turn,
            seed,
        }
    };
    let (length, width) = (0.62, 0.13);
    vec![
        hole([-0.15, 0.0, 0.45], FRAC_PI_2, Slit { length, width }),
        hole([0.15, 0.38, 0.10], 0.0, Disc { radius: 0.17 }),
        hole([-0.42, 0.40, 0.08], 0.0, Blots { radius: 0.27 }),
        hole(
            [0.02, -0.40, 0.05],
            0.4,
            Angle {
                arm: 0.36,
                width: 0.13,
            },
        ),
        hole([-0.48, -0.40, 0.12], 0.0, Ragged { radius: 0.15 }),
        hole(
            [-0.05, 0.0, -0.36],
            0.3,
            Star {
                outer: 0.26,
                inner: 0.11,
                points: 5,
            },
        ),
        // the hollow between neck and back, and the tip of the snout: strongly curved
        hole([0.58, 0.0, 0.48], 0.0, Ragged { radius: 0.13 }),
        hole([1.50, 0.0, 0.42], 0.0, Disc { radius: 0.13 }),
        hole([0.98, 0.26, 0.60], 0.0, Blots { radius: 0.15 }),
        hole([1.00, -0.27, 0.60], 0.0, Disc { radius: 0.12 }),
        hole(
            [0.84, 0.32, 0.98],
            0.0,
            Slit {
                length: 0.22,
                width: 0.08,
            },
        ),
        hole([0.45, 0.36, -0.45], 0.0, Ragged { radius: 0.10 }),
        hole(
            [-0.60, -0.38, -0.50],
            1.0,
            Angle {
                arm: 0.20,
                width: 0.08,
            },
        ),
        hole([-0.60, 0.25, -0.92], 0.0, Disc { radius: 0.10 }),
        hole([-1.31, 0.0, 0.88], 0.0, Disc { radius: 0.10 }),
        hole(
            [-1.00, 0.0, -0.02],
            0.0,
            Star {
                outer: 0.2,
                inner: 0.1,
                points: 4,
            },
        ),
    ]
}
