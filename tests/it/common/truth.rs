//! True surfaces and the distance of a point from them.

use std::path::Path;

use meniscus::mesh::{DVec3, TriangleBvh};

use super::manifest::TruthEntry;
use super::raw;

pub enum Truth {
    Sphere {
        centre: DVec3,
        radius: f64,
    },
    /// About the z axis.
    Torus {
        major: f64,
        minor: f64,
    },
    /// `r = c cosh(z / c)`.
    Catenoid {
        c: f64,
    },
    Ellipsoid {
        axes: [f64; 3],
    },
    /// `z = x² − y²`.
    Saddle,
    /// About the z axis.
    Cylinder {
        radius: f64,
    },
    Plane {
        point: DVec3,
        normal: DVec3,
    },
    Mesh(TriangleBvh),
}

impl Truth {
    /// Loads the truth a manifest entry describes; mesh files are relative to `folder`.
    pub fn load(entry: &TruthEntry, folder: &Path) -> Result<Self, String> {
        Ok(match entry {
            TruthEntry::Sphere { centre, radius } => Self::Sphere {
                centre: DVec3::from_array(*centre),
                radius: *radius,
            },
            TruthEntry::Torus { major, minor } => Self::Torus {
                major: *major,
                minor: *minor,
            },
            TruthEntry::Catenoid { c } => Self::Catenoid { c: *c },
            TruthEntry::Ellipsoid { axes } => Self::Ellipsoid { axes: *axes },
            TruthEntry::Graph { f } if f == "x*x-y*y" => Self::Saddle,
            TruthEntry::Graph { f } => return Err(format!("no distance to the graph of {f}")),
            TruthEntry::Cylinder { radius } => Self::Cylinder { radius: *radius },
            TruthEntry::Plane { point, normal } => Self::Plane {
                point: DVec3::from_array(*point),
                normal: DVec3::from_array(*normal).normalize(),
            },
            TruthEntry::Mesh { file } => {
                let mesh = raw::read(&folder.join(file))?;
                Self::Mesh(TriangleBvh::new(&mesh.positions, &mesh.triangles()))
            }
            TruthEntry::Other => return Err("a truth of another kind".into()),
        })
    }

    /// Distance of `p` from the surface.
    pub fn distance(&self, p: DVec3) -> f64 {
        let rho = p.x.hypot(p.y);
        match self {
            Self::Sphere { centre, radius } => (p.distance(*centre) - radius).abs(),
            Self::Torus { major, minor } => ((rho - major).hypot(p.z) - minor).abs(),
            Self::Catenoid { c } => catenoid(rho, p.z, *c),
            Self::Ellipsoid { axes } => ellipsoid(p, *axes),
            Self::Saddle => saddle(p),
            Self::Cylinder { radius } => (rho - radius).abs(),
            Self::Plane { point, normal } => (p - *point).dot(*normal).abs(),
            Self::Mesh(bvh) => bvh.closest_point(p).map_or(f64::INFINITY, |c| c.distance),
        }
    }
}

/// Newton's method for the nearest point of the profile curve, from the point of equal height.
fn catenoid(rho: f64, z: f64, c: f64) -> f64 {
    let mut t = z;
    for _ in 0..50 {
        let (sinh, cosh) = ((t / c).sinh(), (t / c).cosh());
        let offset = c * cosh - rho;
        let slope = sinh * offset + (t - z);
        // without the concave part far inside, where Newton's step would go uphill
        let curvature = (cosh / c * offset).max(0.0) + sinh * sinh + 1.0;
        t -= slope / curvature;
    }
    (c * (t / c).cosh() - rho).hypot(t - z)
}

/// Nearest point by bisection for the Lagrange multiplier `t` of `Σ (a_i p_i / (t + a_i²))² = 1`
/// (Eberly, "Distance from a Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid").
fn ellipsoid(p: DVec3, axes: [f64; 3]) -> f64 {
    let y = p.abs().to_array();
    let k = (0..3)
        .min_by(|&i, &j| axes[i].total_cmp(&axes[j]))
        .unwrap_or(0);
    let square = |x: f64| x * x;
    let norm = (0..3).map(|i| square(axes[i] * y[i])).sum::<f64>().sqrt();
    let mut low = -square(axes[k]) + axes[k] * y[k];
    let mut high = -square(axes[k]) + norm;
    for _ in 0..200 {
        let t = 0.5 * (low + high);
        let sum: f64 = (0..3)
            .map(|i| square(axes[i] * y[i] / (t + square(axes[i]))))
            .sum();
        if sum > 1.0 {
            low = t;
        } else {
            high = t;
        }
    }
    let t = 0.5 * (low + high);
    (0..3)
        .map(|i| square(square(axes[i]) * y[i] / (t + square(axes[i])) - y[i]))
        .sum::<f64>()
        .sqrt()
}

/// Newton's method for the nearest point, from the foot straight below.
fn saddle(p: DVec3) -> f64 {
    let (mut u, mut v) = (p.x, p.y);
    for _ in 0..50 {
        let h = u * u - v * v - p.z;
        let (a, b) = (u - p.x + 2.0 * u * h, v - p.y - 2.0 * v * h);
        let (uu, uv) = (1.0 + 4.0 * u * u + 2.0 * h, -4.0 * u * v);
        let vv = 1.0 + 4.0 * v * v - 2.0 * h;
        let det = uu * vv - uv * uv;
        u -= (vv * a - uv * b) / det;
        v -= (uu * b - uv * a) / det;
    }
    DVec3::new(u, v, u * u - v * v).distance(p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::random::SplitMix;

    /// Points offset by a known small distance along a known normal.
    fn check(truth: &Truth, point: DVec3, normal: DVec3) {
        for offset in [0.0, 0.05, -0.05, 1e-4] {
            let d = truth.distance(point + normal.normalize() * offset);
            assert!(
                (d - offset.abs()).abs() < 1e-12,
                "{point} offset {offset}: {d}"
            );
        }
    }

    #[test]
    fn distances_of_offset_points() {
        let mut rng = SplitMix::new(11);
        for _ in 0..100 {
            let n = rng.direction();
            let axes = [1.5, 1.0, 0.7];
            let a = DVec3::from_array(axes);
            check(&Truth::Ellipsoid { axes }, n * a, n / a);
            let centre = DVec3::new(1.0, 2.0, 3.0);
            check(
                &Truth::Sphere {
                    centre,
                    radius: 2.0,
                },
                centre + 2.0 * n,
                n,
            );

            let (u, v) = (rng.range(-0.7, 0.7), rng.range(-0.7, 0.7));
            let p = DVec3::new(u, v, u * u - v * v);
            check(&Truth::Saddle, p, DVec3::new(-2.0 * u, 2.0 * v, 1.0));

            let (s, c) = rng.range(0.0, 6.0).sin_cos();
            let radial = DVec3::new(c, s, 0.0);
            let z = rng.range(-1.2, 1.2);
            let p = radial * z.cosh() + DVec3::Z * z;
            check(&Truth::Catenoid { c: 1.0 }, p, radial - DVec3::Z * z.sinh());
            let tube = radial * n.x.hypot(n.y) + DVec3::Z * n.z;
            let truth = Truth::Torus {
                major: 1.5,
                minor: 1.0,
            };
            check(&truth, radial * 1.5 + tube, tube);
            check(
                &Truth::Cylinder { radius: 0.5 },
                radial * 0.5 + DVec3::Z * z,
                radial,
            );
        }
    }
}
