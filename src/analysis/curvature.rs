//! Ranges and histograms of the curvatures of a limit surface.

use serde::Serialize;

use crate::analysis::shape::all_elements;
use crate::mesh::{DVec3, Topology};
use crate::subdivision::Rule;
use crate::surface::{each_point, project_to_vertices, surface_point};

/// Bins of a histogram.
const BINS: usize = 32;
/// Fraction of the area left out at each end of a histogram's range. Otherwise a few spikes would
/// push everything else into one bin. Values outside count for the outermost bins.
const TRIM: f64 = 0.01;

/// The curvatures of a surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CurvatureReport {
    /// Mean curvature, negative on a sphere with outward normals.
    pub mean: Range,
    /// Gaussian curvature.
    pub gauss: Range,
    /// The greater principal curvature `H + √(H² − K)`.
    pub k1: Range,
    /// The smaller one.
    pub k2: Range,
}

impl CurvatureReport {
    /// All four with their names.
    pub fn named(&self) -> [(&'static str, &Range); 4] {
        [
            ("H", &self.mean),
            ("K", &self.gauss),
            ("k1", &self.k1),
            ("k2", &self.k2),
        ]
    }
}

/// Distribution of a quantity over a surface, at the points of the 12-point rule.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Range {
    /// Minimum.
    pub min: f64,
    /// Place of the minimum.
    pub min_at: [f64; 3],
    /// Maximum.
    pub max: f64,
    /// Place of the maximum.
    pub max_at: [f64; 3],
    /// Area average.
    pub average: f64,
    /// Root of the area average of the squared difference to it.
    pub deviation: f64,
    /// Area by value.
    pub histogram: Histogram,
}

/// Area by value, in bins of equal width.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Histogram {
    /// Lower end of the first bin; values below count for it.
    pub from: f64,
    /// Upper end of the last bin; values above count for it.
    pub to: f64,
    /// Part of the whole area in each bin.
    pub share: Vec<f64>,
}

/// A sample of the surface: its area, place, and `H, K, k1, k2`.
struct Sample {
    area: f64,
    at: DVec3,
    values: [f64; 4],
}

pub(super) fn curvature(topology: &Topology, control: &[DVec3]) -> CurvatureReport {
    let samples = samples(topology, control);
    let [mean, gauss, k1, k2] = [0, 1, 2, 3].map(|i| range(&samples, i));
    CurvatureReport {
        mean,
        gauss,
        k1,
        k2,
    }
}

fn samples(topology: &Topology, control: &[DVec3]) -> Vec<Sample> {
    let elements = all_elements(topology, Rule::Twelve);
    let mut samples = Vec::with_capacity(12 * elements.len());
    for e in 0..elements.len() {
        each_point(&elements, e, control, |at, p| {
            let root = (p.mean * p.mean - p.gauss).max(0.0).sqrt();
            let area = Rule::Twelve.weight() * 0.5 * p.sqrt_g;
            if area > 0.0 && root.is_finite() {
                samples.push(Sample {
                    area,
                    at,
                    values: [p.mean, p.gauss, p.mean + root, p.mean - root],
                });
            }
        });
    }
    samples
}

fn range(samples: &[Sample], i: usize) -> Range {
    let area: f64 = samples.iter().map(|s| s.area).sum();
    let mut least = (f64::INFINITY, DVec3::ZERO);
    let mut most = (f64::NEG_INFINITY, DVec3::ZERO);
    let (mut sum, mut squares) = (0.0, 0.0);
    for s in samples {
        let x = s.values[i];
        if x < least.0 {
            least = (x, s.at);
        }
        if x > most.0 {
            most = (x, s.at);
        }
        sum += s.area * x;
    }
    let average = if area > 0.0 { sum / area } else { 0.0 };
    for s in samples {
        squares += s.area * (s.values[i] - average).powi(2);
    }
    if samples.is_empty() {
        (least.0, most.0) = (0.0, 0.0);
    }
    Range {
        min: least.0,
        min_at: least.1.to_array(),
        max: most.0,
        max_at: most.1.to_array(),
        average,
        deviation: if area > 0.0 {
            (squares / area).sqrt()
        } else {
            0.0
        },
        histogram: histogram(samples, i, area),
    }
}

fn histogram(samples: &[Sample], i: usize, area: f64) -> Histogram {
    let mut sorted: Vec<(f64, f64)> = samples.iter().map(|s| (s.values[i], s.area)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let quantile = |part: f64| {
        let mut below = 0.0;
        for &(x, a) in &sorted {
            below += a;
            if below >= part * area {
                return x;
            }
        }
        sorted.last().map_or(0.0, |s| s.0)
    };
    let (from, to) = (quantile(TRIM), quantile(1.0 - TRIM));
    let mut share = vec![0.0; BINS];
    for &(x, a) in &sorted {
        let place = if to > from {
            (x - from) / (to - from)
        } else {
            0.0
        };
        let last = BINS as f64 - 1.0;
        #[expect(clippy::cast_sign_loss, reason = "clamped")]
        let bin = (place * BINS as f64).clamp(0.0, last) as usize;
        share[bin] += a / area;
    }
    Histogram { from, to, share }
}

/// Mean and Gaussian curvature at the vertices: averages over the quadrature points around each
/// (the L2 projection to piecewise linear functions with lumped mass); at an irregular vertex the
/// limit surface itself has none. NaN for vertices without triangles.
pub fn vertex_curvatures(topology: &Topology, control: &[DVec3]) -> Vec<[f64; 2]> {
    let elements = all_elements(topology, Rule::Twelve);
    let sample = |e, q| {
        let (_, p) = surface_point(&elements, e, q, control);
        (p.sqrt_g > 0.0 && p.mean.is_finite()).then_some((p.sqrt_g, [p.mean, p.gauss]))
    };
    let mut sums = vec![[0.0; 3]; control.len()];
    project_to_vertices(
        &elements,
        Rule::Twelve,
        sample,
        |v, weight, [mean, gauss]| {
            let sum = &mut sums[v as usize];
            sum[0] += weight * mean;
            sum[1] += weight * gauss;
            sum[2] += weight;
        },
    );
    sums.iter().map(|s| [s[0] / s[2], s[1] / s[2]]).collect()
}
