//! Energy densities `f(H, K) + c |∇H|²` of `E(S)`, with exact first and second derivatives of `f`.
//!
//! An energy is one of the [`Preset`]s or a typed expression in `H`, `K`, `k1`, `k2`, `gradH2` and
//! named parameters ([`Energy::parse`]). Signs are those of formulation.md section 1: on a sphere of
//! radius R with outward normal `κ1 = κ2 = H = −1/R`, `K = 1/R²`. `f` is in the units of the file.
//!
//! ```
//! use meniscus::energy::Energy;
//! let willmore = Energy::parse("H^2", &Default::default())?;
//! let jet = willmore.jet(-0.5, 0.25); // a sphere of radius 2
//! assert_eq!((jet.f, jet.h, jet.hh), (0.25, -1.0, 2.0));
//! # Ok::<(), meniscus::energy::ExprError>(())
//! ```

mod expr;
mod jet;
mod preset;
mod shift;
mod wellposed;

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

pub use expr::{ExprError, SyntaxError};
pub use jet::Jet2;
pub use preset::Preset;
pub use wellposed::{WellPosed, WellPosedScan, WorstPoint, scan_well_posedness};

/// The order of the flow `∂x/∂t = −δE` that an energy density drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Order {
    /// `f` is a constant multiple of `K`: every surface is stationary.
    Stationary,
    /// `f_HH = f_HK = f_KK = 0` everywhere, as for `f = 1` or `f = H`.
    Second,
    /// All others without `|∇H|²`.
    Fourth,
    /// With `|∇H|²`.
    Sixth,
}

/// An energy density `f(H, K) + c |∇H|²`; cheap to clone, immutable.
#[derive(Clone)]
pub struct Energy {
    /// `f`.
    density: Density,
    /// `c`.
    gradient: f64,
    order: Order,
    text: Arc<str>,
    params: Arc<BTreeMap<String, f64>>,
}

#[derive(Clone)]
enum Density {
    /// A preset, with its parameter.
    Preset(Preset, f64),
    /// An expression in `H` and `K`.
    Plain(Arc<expr::Program>),
    /// An expression with κ1 or κ2. The flag states whether it is even in `κ1 − κ2`.
    Principal(Arc<expr::Program>, bool),
    /// Another energy with tension and spontaneous curvature.
    Shifted(shift::Shift),
}

impl Energy {
    /// A preset. Its parameter, if it has one, has its default value ([`Preset::parameter`]).
    pub fn preset(preset: Preset) -> Self {
        let mut params = BTreeMap::new();
        let parameter = preset.parameter();
        if let Some((name, value)) = parameter {
            params.insert(name.to_owned(), value);
        }
        Self {
            density: Density::Preset(preset, parameter.map_or(0.0, |p| p.1)),
            gradient: preset.gradient(),
            order: match preset {
                Preset::K => Order::Stationary,
                Preset::One => Order::Second,
                Preset::MeanVariation => Order::Sixth,
                _ => Order::Fourth,
            },
            text: preset.text().into(),
            params: Arc::new(params),
        }
    }

    /// Parses an expression in `H`, `K`, `k1`, `k2`, numbers, `pi`, the parameters in `params`,
    /// `+ − * / ^`, parentheses and `abs sqrt exp log sin cos tanh min max`, plus terms `gradH2`
    /// (`|∇H|²`), alone or times numbers and parameters.
    ///
    /// `^` is right associative and binds more tightly than the sign: `-H^2 = -(H^2)`,
    /// `2^-1 = 0.5`. Integer powers are exact for every base, including zero (`0^0 = 1`); other
    /// powers need a positive base. The derivatives of `abs`, `min` and `max` are those of the
    /// active branch. At a tie they are those of the first argument, or of `+x` for `abs(x)`.
    /// Between expressions that differ in `κ1 − κ2` they are those of the limit from `κ1 > κ2`.
    /// Where a derivative does not exist, as for `sqrt(H)` at `H = 0` or `abs(k1-k2)` at an
    /// umbilic, [`Energy::jet`] is not finite.
    ///
    /// An expression that expands to a [`Preset`] is evaluated as that preset, however it is
    /// written. Parameters that do not occur are ignored; see [`Energy::params`] for those that do.
    ///
    /// # Errors
    /// [`ExprError`] for text outside this grammar (with the position), unknown names, parameters
    /// that are not finite or have a reserved name, expressions not symmetric in κ1 and κ2 or not
    /// linear in `|∇H|²`, and expressions without a finite value at any curvature.
    pub fn parse(text: &str, params: &BTreeMap<String, f64>) -> Result<Self, ExprError> {
        for (name, &value) in params {
            check_parameter(name, value)?;
        }
        let (program, used) = expr::parse(text, params)?;
        let (program, gradient) = expr::split_gradient(text, &program)?;
        expr::check_symmetry(text, &program)?;
        let polynomial = expr::as_polynomial(&program);
        let preset = match &polynomial {
            Some(p) if gradient == 1.0 && *p == expr::Polynomial::default() => {
                Some((Preset::MeanVariation, 0.0))
            }
            Some(polynomial) => as_preset(polynomial),
            None => program.radicand().and_then(|p| as_root(&p)),
        };
        let density = match preset {
            Some((preset, parameter)) => Density::Preset(preset, parameter),
            None if program.uses_principal() => {
                let even = program.is_smooth_in_principal();
                Density::Principal(Arc::new(program), even)
            }
            None => Density::Plain(Arc::new(program)),
        };
        let mut energy = Self {
            density,
            gradient,
            order: Order::Fourth,
            text: text.trim().into(),
            params: Arc::new(used),
        };
        energy.order = match &polynomial {
            _ if gradient != 0.0 => Order::Sixth,
            Some(p) => polynomial_order(p),
            None => energy.sampled_order(),
        };
        Ok(energy)
    }

    /// The same energy with another value of one of its parameters.
    ///
    /// # Errors
    /// [`ExprError::Parameter`] if the energy has no parameter of that name, and the errors of
    /// [`Energy::parse`] for the new value.
    pub fn with_param(&self, name: &str, value: f64) -> Result<Self, ExprError> {
        if !self.params.contains_key(name) {
            let names: Vec<&str> = self.params.keys().map(String::as_str).collect();
            let reason = if names.is_empty() {
                format!("'{}' has no parameters", self.text)
            } else {
                format!(
                    "'{}' has no such parameter, only {}",
                    self.text,
                    names.join(", ")
                )
            };
            return Err(ExprError::Parameter {
                name: name.to_owned(),
                value,
                reason,
            });
        }
        let mut params = (*self.params).clone();
        params.insert(name.to_owned(), value);
        Self::parse(&self.text, &params)
    }

    /// The parameters that occur in the expression, with their values.
    pub fn params(&self) -> &BTreeMap<String, f64> {
        &self.params
    }

    /// The expression as typed, or that of the preset.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The preset it is evaluated as, if it is one.
    pub fn as_preset(&self) -> Option<Preset> {
        match self.density {
            Density::Preset(preset, _) if preset.gradient() == self.gradient => Some(preset),
            _ => None,
        }
    }

    /// The coefficient `c` of `|∇H|²`, 0 for most energies.
    pub fn gradient(&self) -> f64 {
        self.gradient
    }

    /// The order of the flow.
    pub fn order(&self) -> Order {
        self.order
    }

    /// `f` and its derivatives at mean curvature `h` and Gauss curvature `k`.
    ///
    /// Members are not finite where `f` is undefined or not twice differentiable. `h² < k` does not
    /// occur on a surface, but roundoff can produce it. Rational expressions are then continued
    /// unchanged; other functions of κ1 and κ2 take their umbilic value.
    #[inline]
    pub fn jet(&self, h: f64, k: f64) -> Jet2 {
        match &self.density {
            Density::Preset(preset, parameter) => preset.jet(*parameter, h, k),
            Density::Plain(program) => program.eval(&expr::JetAlgebra::plain(h, k)),
            Density::Principal(program, even) => expr::PairAlgebra::jet(program, *even, h, k),
            Density::Shifted(shift) => shift.jet(h, k),
        }
    }

    /// The order of an expression that is not a polynomial of low degree. It is second if no sample
    /// has a second derivative, for example abs(H).
    fn sampled_order(&self) -> Order {
        let mut jets = expr::sample_curvatures()
            .map(|[h, k]| self.jet(h, k))
            .filter(Jet2::is_finite)
            .peekable();
        let known = jets.peek().is_some();
        if known && jets.all(|jet| [jet.hh, jet.hk, jet.kk] == [0.0; 3]) {
            Order::Second
        } else {
            Order::Fourth
        }
    }
}

/// Whether two energies have the same text, parameters and shifts.
impl PartialEq for Energy {
    fn eq(&self, other: &Self) -> bool {
        let shifts = match (&self.density, &other.density) {
            (Density::Shifted(a), Density::Shifted(b)) => a.same(b),
            (Density::Shifted(_), _) | (_, Density::Shifted(_)) => false,
            _ => true,
        };
        shifts && self.text == other.text && self.params == other.params
    }
}

impl fmt::Debug for Energy {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Energy")
            .field("text", &self.text)
            .field("params", &self.params)
            .field("preset", &self.as_preset())
            .field("order", &self.order)
            .finish_non_exhaustive()
    }
}

/// The expression, followed by its parameters: `(H-H0)^2, H0 = 0.3`.
impl fmt::Display for Energy {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.text)?;
        self.params
            .iter()
            .try_for_each(|(name, value)| write!(out, ", {name} = {value}"))
    }
}

fn check_parameter(name: &str, value: f64) -> Result<(), ExprError> {
    let reason = if expr::is_reserved(name) {
        "the name is reserved by the grammar; rename the parameter"
    } else if !expr::is_name(name) {
        "a name starts with a letter and continues with letters, digits and _"
    } else if !value.is_finite() {
        "the value must be a finite number"
    } else {
        return Ok(());
    };
    Err(ExprError::Parameter {
        name: name.to_owned(),
        value,
        reason: reason.to_owned(),
    })
}

/// The preset with exactly these coefficients, and its `H0`.
fn as_preset(p: &expr::Polynomial) -> Option<(Preset, f64)> {
    let h0 = -0.5 * p[1][0];
    Preset::ALL
        .into_iter()
        .filter(|preset| !matches!(preset, Preset::CurvatureNorm | Preset::MeanVariation))
        .find(|preset| preset.coefficients(h0) == *p)
        .map(|x| (x, h0))
}

/// The preset whose square `radicand` is, with its parameter.
fn as_root(radicand: &expr::Program) -> Option<(Preset, f64)> {
    let p = expr::as_polynomial(radicand)?;
    let c = p[0][0].max(0.0).sqrt();
    let mut square = Preset::CurvatureNorm.coefficients(c);
    // c² may differ from the number under the root by rounding
    square[0][0] = p[0][0];
    (c > 0.0 && square == p).then_some((Preset::CurvatureNorm, c))
}

fn polynomial_order(p: &expr::Polynomial) -> Order {
    let mut higher = *p;
    let [constant, linear] = [p[0][0], p[1][0]];
    (higher[0][0], higher[1][0], higher[0][1]) = (0.0, 0.0, 0.0);
    if higher != expr::Polynomial::default() {
        Order::Fourth
    } else if constant != 0.0 || linear != 0.0 {
        Order::Second
    } else {
        Order::Stationary
    }
}

#[cfg(test)]
mod tests;
