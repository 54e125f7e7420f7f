//! Patches raised to domes.

use super::data::Patch;
use crate::mesh::{DVec3, vector_area};

/// The patch raised along the vector area of its rim, for a negative height against it: by a function of the
/// distance from the rim along edges that begins with `slope` and tends to `height`. A rim in a plane
/// then has a patch on one side of that plane.
pub(crate) fn domed(patch: &Patch, slope: f64, height: f64) -> Patch {
    let up = vector_area(&patch.points[..patch.rim]).normalize_or_zero();
    let mut distance = vec![f64::INFINITY; patch.points.len()];
    distance[..patch.rim].fill(0.0);
    let mut is_changed = true;
    while std::mem::take(&mut is_changed) {
        for t in &patch.triangles {
            for k in 0..3 {
                let [v, w] = [t[k], t[(k + 1) % 3]].map(|v| v as usize);
                let length = patch.points[v].distance(patch.points[w]);
                for [v, w] in [[v, w], [w, v]] {
                    if distance[v] + length < distance[w] {
                        distance[w] = distance[v] + length;
                        is_changed = true;
                    }
                }
            }
        }
    }
    let raise = |d: f64| height * (1.0 - (-slope * d / height.abs()).exp());
    let points = patch.points.iter().zip(&distance);
    let raised: Vec<DVec3> = points.map(|(&p, &d)| p + raise(d) * up).collect();
    Patch {
        points: [&patch.points[..patch.rim], &raised[patch.rim..]].concat(),
        ..patch.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patch::{PatchOptions, Rim, fill};

    #[test]
    fn a_dome_lies_on_one_side_of_its_rim() {
        let points: Vec<DVec3> = (0..40)
            .map(|i| f64::from(i) * std::f64::consts::TAU / 40.0)
            .map(|angle| DVec3::new(angle.cos(), angle.sin(), 0.0))
            .collect();
        let opposite = points.iter().map(|p| 1.2 * *p).collect();
        let forbidden = Vec::new();
        let rim = Rim {
            points,
            opposite,
            forbidden,
        };
        let flat = fill(&rim, PatchOptions::default()).expect("a patch");
        for height in [0.5, -0.5] {
            let dome = domed(&flat, 2.0, height);
            assert_eq!(dome.points[..40], flat.points[..40]);
            let heights = dome.new_points().iter().map(|p| p.z / height);
            let (low, high) = heights.fold((1.0f64, 0.0f64), |(l, h), z| (l.min(z), h.max(z)));
            // an edge length of 0.16 from the rim, and in the middle
            assert!(low > 0.3 && high > 0.95 && high < 1.0, "{low} {high}");
        }
    }
}
