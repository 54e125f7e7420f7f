//! The named energies, in closed form.

use super::jet::Jet2;

/// A named energy density. The closed forms are those of its part `f(H, K)`.
///
/// The first six are those of Xu 2008, Fig. 2. `κ1, κ2 = H ± √(H² − K)`, hence
/// `κ1⁴ + κ2⁴ = 16H⁴ − 16H²K + 2K²`, `κ1² + κ2² = 4H² − 2K`, `(κ1 − κ2)² = 4H² − 4K`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Preset {
    /// `f = 1`: area; its flow is mean curvature flow.
    One,
    /// `f = H²`: Willmore energy.
    H2,
    /// `f = K²`.
    K2,
    /// `f = H² + K²` (the two terms differ in units: the unit of length matters).
    H2PlusK2,
    /// `f = H²K²`.
    H2K2,
    /// `f = κ1⁴ + κ2⁴`.
    K1P4PlusK2P4,
    /// `f = K`: every surface is stationary (Gauss-Bonnet).
    K,
    /// `f = (H − H0)²`: Helfrich's energy; the parameter `H0` has the default 0.
    HMinusH0Squared,
    /// `f = κ1² + κ2²`: bending energy.
    K1SqPlusK2Sq,
    /// `f = (κ1 − κ2)²`.
    K1MinusK2Squared,
    /// `f = √(κ1² + κ2² + c²)`: the norm of the shape operator, regularized by the parameter `c`
    /// (default 1). A bend costs its angle, not the square of its angle, so the flow keeps sharp
    /// edges. `H²` rounds them off and bulges beside them.
    CurvatureNorm,
    /// `|∇H|²`: variation of the mean curvature. Its flow is of sixth order and continues curvatures
    /// across a rim; surfaces of constant mean curvature have none.
    MeanVariation,
}

impl serde::Serialize for Preset {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.text())
    }
}

impl Preset {
    /// All presets, in the order they are listed to users.
    pub const ALL: [Self; 12] = [
        Self::One,
        Self::H2,
        Self::K2,
        Self::H2PlusK2,
        Self::H2K2,
        Self::K1P4PlusK2P4,
        Self::K,
        Self::HMinusH0Squared,
        Self::K1SqPlusK2Sq,
        Self::K1MinusK2Squared,
        Self::CurvatureNorm,
        Self::MeanVariation,
    ];

    /// The expression that [`Energy::parse`](super::Energy::parse) reads back as this preset.
    pub const fn text(self) -> &'static str {
        match self {
            Self::One => "1",
            Self::H2 => "H^2",
            Self::K2 => "K^2",
            Self::H2PlusK2 => "H^2+K^2",
            Self::H2K2 => "H^2*K^2",
            Self::K1P4PlusK2P4 => "k1^4+k2^4",
            Self::K => "K",
            Self::HMinusH0Squared => "(H-H0)^2",
            Self::K1SqPlusK2Sq => "k1^2+k2^2",
            Self::K1MinusK2Squared => "(k1-k2)^2",
            Self::CurvatureNorm => "sqrt(k1^2+k2^2+c^2)",
            Self::MeanVariation => "gradH2",
        }
    }

    /// The preset that is written like a text, spaces apart.
    pub fn of_text(text: &str) -> Option<Self> {
        let plain = text.replace(' ', "");
        Self::ALL.into_iter().find(|preset| preset.text() == plain)
    }

    /// Its name in words.
    pub const fn title(self) -> &'static str {
        match self {
            Self::One => "Area",
            Self::H2 => "Willmore energy",
            Self::K2 => "Squared Gaussian curvature",
            Self::H2PlusK2 => "Sum of squares",
            Self::H2K2 => "Product of squares",
            Self::K1P4PlusK2P4 => "Fourth powers",
            Self::K => "Total curvature",
            Self::HMinusH0Squared => "Helfrich energy",
            Self::K1SqPlusK2Sq => "Bending energy",
            Self::K1MinusK2Squared => "Difference of curvatures",
            Self::CurvatureNorm => "Curvature norm",
            Self::MeanVariation => "Mean curvature variation",
        }
    }

    /// The parameter of its expression, if it has one, with the default value.
    pub const fn parameter(self) -> Option<(&'static str, f64)> {
        match self {
            Self::HMinusH0Squared => Some(("H0", 0.0)),
            Self::CurvatureNorm => Some(("c", 1.0)),
            _ => None,
        }
    }

    /// The coefficient of `|∇H|²`.
    pub(super) const fn gradient(self) -> f64 {
        match self {
            Self::MeanVariation => 1.0,
            _ => 0.0,
        }
    }

    /// The degree `p` of `f(cH, c²K) = c^p f(H, K)`, where there is one for every parameter value.
    #[cfg(test)]
    pub(super) const fn degree(self) -> Option<i32> {
        match self {
            Self::One => Some(0),
            Self::H2 | Self::K | Self::K1SqPlusK2Sq | Self::K1MinusK2Squared => Some(2),
            Self::K2 | Self::K1P4PlusK2P4 => Some(4),
            Self::H2K2 => Some(6),
            Self::H2PlusK2 | Self::HMinusH0Squared | Self::CurvatureNorm | Self::MeanVariation => {
                None
            }
        }
    }

    /// The coefficient `c[i][j]` of `H^i K^j`, `i ≤ 4`, `j ≤ 2`, of a polynomial preset. For
    /// [`Preset::CurvatureNorm`] it is that of the square. `parameter` is that of the preset.
    pub(super) const fn coefficients(self, parameter: f64) -> [[f64; 3]; 5] {
        let mut c = [[0.0; 3]; 5];
        match self {
            Self::One => c[0][0] = 1.0,
            Self::H2 => c[2][0] = 1.0,
            Self::K2 => c[0][2] = 1.0,
            Self::H2PlusK2 => {
                c[2][0] = 1.0;
                c[0][2] = 1.0;
            }
            Self::H2K2 => c[2][2] = 1.0,
            Self::K1P4PlusK2P4 => {
                c[4][0] = 16.0;
                c[2][1] = -16.0;
                c[0][2] = 2.0;
            }
            Self::K => c[0][1] = 1.0,
            Self::HMinusH0Squared => {
                c[2][0] = 1.0;
                c[1][0] = -2.0 * parameter;
                c[0][0] = parameter * parameter;
            }
            Self::K1SqPlusK2Sq => {
                c[2][0] = 4.0;
                c[0][1] = -2.0;
            }
            Self::K1MinusK2Squared => {
                c[2][0] = 4.0;
                c[0][1] = -4.0;
            }
            Self::CurvatureNorm => {
                c[2][0] = 4.0;
                c[0][1] = -2.0;
                c[0][0] = parameter * parameter;
            }
            Self::MeanVariation => {}
        }
        c
    }

    /// `f` and its derivatives at `(H, K)`; `parameter` is that of the preset.
    #[inline]
    pub(super) fn jet(self, parameter: f64, h: f64, k: f64) -> Jet2 {
        let zero = Jet2::default();
        match self {
            Self::One => Jet2::constant(1.0),
            Self::H2 => Jet2 {
                f: h * h,
                h: 2.0 * h,
                hh: 2.0,
                ..zero
            },
            Self::K2 => Jet2 {
                f: k * k,
                k: 2.0 * k,
                kk: 2.0,
                ..zero
            },
            Self::H2PlusK2 => Jet2 {
                f: h * h + k * k,
                h: 2.0 * h,
                k: 2.0 * k,
                hh: 2.0,
                hk: 0.0,
                kk: 2.0,
            },
            Self::H2K2 => {
                let hk = h * k;
                Jet2 {
                    f: hk * hk,
                    h: 2.0 * hk * k,
                    k: 2.0 * hk * h,
                    hh: 2.0 * k * k,
                    hk: 4.0 * hk,
                    kk: 2.0 * h * h,
                }
            }
            Self::K1P4PlusK2P4 => {
                let h2 = h * h;
                Jet2 {
                    f: 16.0 * h2 * (h2 - k) + 2.0 * k * k,
                    h: 32.0 * h * (2.0 * h2 - k),
                    k: 4.0 * k - 16.0 * h2,
                    hh: 192.0 * h2 - 32.0 * k,
                    hk: -32.0 * h,
                    kk: 4.0,
                }
            }
            Self::K => Jet2::gauss(k),
            Self::HMinusH0Squared => {
                let d = h - parameter;
                Jet2 {
                    f: d * d,
                    h: 2.0 * d,
                    hh: 2.0,
                    ..zero
                }
            }
            Self::K1SqPlusK2Sq => Jet2 {
                f: 4.0 * h * h - 2.0 * k,
                h: 8.0 * h,
                k: -2.0,
                hh: 8.0,
                ..zero
            },
            Self::K1MinusK2Squared => Jet2 {
                f: 4.0 * (h * h - k),
                h: 8.0 * h,
                k: -4.0,
                hh: 8.0,
                ..zero
            },
            Self::CurvatureNorm => {
                let f = (4.0 * h * h - 2.0 * k + parameter * parameter).sqrt();
                let (g, third) = (f.recip(), (f * f * f).recip());
                Jet2 {
                    f,
                    h: 4.0 * h * g,
                    k: -g,
                    hh: 4.0 * g - 16.0 * h * h * third,
                    hk: 4.0 * h * third,
                    kk: -third,
                }
            }
            Self::MeanVariation => zero,
        }
    }
}

impl std::fmt::Display for Preset {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(self.text())
    }
}
