//! Energies with tension and spontaneous curvature.

use std::sync::Arc;

use super::{Density, Energy, Jet2, Order};

/// An energy with two changes.
#[derive(Clone)]
pub(super) struct Shift {
    base: Arc<Energy>,
    tension: f64,
    curvature: f64,
}

impl Energy {
    /// `f(k1 − c, k2 − c) + t`, with the same term of `|∇H|²`. The tension t is the weight of the area. Curvatures are measured
    /// from the spontaneous `curvature` c; a negative c makes the surface bulge along its normals.
    /// For `H^2` the result is `(H − c)² + t`. Units are those of f and of H.
    ///
    /// Bending penalizes curvature and tension penalizes area. Between two rims, a higher tension
    /// contracts the surface.
    #[must_use]
    pub fn shifted(&self, tension: f64, curvature: f64) -> Self {
        if tension == 0.0 && curvature == 0.0 {
            return self.clone();
        }
        Self {
            density: Density::Shifted(Shift {
                base: Arc::new(self.clone()),
                tension,
                curvature,
            }),
            gradient: self.gradient,
            order: match self.order {
                Order::Stationary => Order::Second,
                order => order,
            },
            text: Arc::clone(&self.text),
            params: Arc::clone(&self.params),
        }
    }
}

impl Shift {
    /// By the chain rule: H' = H − c, K' = K − 2cH + c².
    pub(super) fn jet(&self, h: f64, k: f64) -> Jet2 {
        let c = self.curvature;
        let at = self.base.jet(h - c, k - 2.0 * c * h + c * c);
        Jet2 {
            f: at.f + self.tension,
            h: at.h - 2.0 * c * at.k,
            k: at.k,
            hh: at.hh - 4.0 * c * at.hk + 4.0 * c * c * at.kk,
            hk: at.hk - 2.0 * c * at.kk,
            kk: at.kk,
        }
    }

    pub(super) fn same(&self, other: &Self) -> bool {
        self.tension == other.tension && self.curvature == other.curvature
    }
}

#[cfg(test)]
mod tests {
    use super::super::*;

    fn parsed(text: &str) -> Energy {
        let params = BTreeMap::from([("c".to_owned(), -0.3), ("t".to_owned(), 0.7)]);
        Energy::parse(text, &params).expect(text)
    }

    #[test]
    fn is_the_energy_written_out() {
        let pairs = [
            ("H^2", "(H-c)^2 + t"),
            ("K^2", "((k1-c)*(k2-c))^2 + t"),
            ("k1^4+k2^4", "(k1-c)^4+(k2-c)^4 + t"),
            ("H^2*K^2", "(H-c)^2*(K-2*c*H+c^2)^2 + t"),
            ("K", "K-2*c*H+c^2+t"),
            ("1", "1+t"),
        ];
        for (base, whole) in pairs {
            let shifted = parsed(base).shifted(0.7, -0.3);
            let whole = parsed(whole);
            assert_eq!(shifted.order(), whole.order(), "{base}");
            for (h, k) in [(0.4, -0.5), (-1.2, 0.3), (0.0, 0.0), (0.5, 0.25)] {
                let (a, b) = (shifted.jet(h, k), whole.jet(h, k));
                let pairs = [
                    (a.f, b.f),
                    (a.h, b.h),
                    (a.k, b.k),
                    (a.hh, b.hh),
                    (a.hk, b.hk),
                    (a.kk, b.kk),
                ];
                for (x, y) in pairs {
                    assert!(
                        (x - y).abs() < 1e-12 * (1.0 + y.abs()),
                        "{base} {h} {k}: {x} {y}"
                    );
                }
            }
        }
    }

    #[test]
    fn no_shift_changes_nothing() {
        let plain = parsed("H^2");
        assert_eq!(plain.shifted(0.0, 0.0).as_preset(), Some(Preset::H2));
        assert_eq!(plain.shifted(0.0, 0.0), plain);
        assert_ne!(plain.shifted(0.0, 0.1), plain);
        assert_ne!(plain.shifted(0.0, 0.1), plain.shifted(0.1, 0.0));
    }
}
