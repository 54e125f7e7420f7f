//! Evaluation over numbers (κ1 and κ2 as given, to test symmetry) and over jets in `(H, K)`.

use super::program::{Algebra, Function, Op, Variable};
use crate::energy::jet::{Jet2, Outer1};

/// Numbers at a pair `(κ1, κ2)` in that order.
#[derive(Clone, Copy, Debug)]
pub struct ScalarAlgebra {
    /// κ1.
    pub k1: f64,
    /// κ2.
    pub k2: f64,
}

impl ScalarAlgebra {
    /// `op(x)` for numbers.
    pub(super) fn fold1(op: Op, x: f64) -> f64 {
        match op {
            Op::Neg => -x,
            Op::Shift(c) => x + c,
            Op::Scale(c) => c * x,
            Op::Integer(n) => x.powi(n),
            Op::Abs => x.abs(),
            Op::Call(function) => function.at(x).f,
            _ => f64::NAN,
        }
    }

    /// `x op y` for numbers.
    pub(super) fn fold2(op: Op, x: f64, y: f64) -> f64 {
        match op {
            Op::Add => x + y,
            Op::Sub => x - y,
            Op::Mul => x * y,
            Op::Div => x / y,
            Op::Min | Op::Max if x.is_nan() || y.is_nan() => f64::NAN,
            Op::Min => x.min(y),
            Op::Max => x.max(y),
            Op::Power => x.powf(y),
            _ => f64::NAN,
        }
    }
}

/// A number, and the magnitude to which its roundoff is relative. This is the largest operand of
/// sums, propagated through products and functions to first order.
#[derive(Clone, Copy, Debug)]
pub struct Tracked {
    /// The value.
    pub value: f64,
    /// The magnitude.
    pub magnitude: f64,
}

impl Algebra for ScalarAlgebra {
    type Value = Tracked;

    fn constant(&self, c: f64) -> Tracked {
        Tracked {
            value: c,
            magnitude: c.abs(),
        }
    }

    fn variable(&self, v: Variable) -> Tracked {
        self.constant(match v {
            Variable::Mean => 0.5 * (self.k1 + self.k2),
            Variable::Gauss => self.k1 * self.k2,
            Variable::Kappa1 => self.k1,
            Variable::Kappa2 => self.k2,
            Variable::Gradient(_) => f64::NAN,
        })
    }

    fn unary(&self, op: Op, x: Tracked) -> Tracked {
        let value = Self::fold1(op, x.value);
        let kept = match op {
            Op::Scale(c) => x.magnitude * c.abs(),
            Op::Integer(n) if n > 0 => x.magnitude.powi(n),
            Op::Integer(n) => (f64::from(n) * value / x.value).abs() * x.magnitude,
            Op::Call(function) => function.at(x.value).d.abs() * x.magnitude,
            _ => x.magnitude,
        };
        Tracked {
            value,
            magnitude: value.abs().max(kept),
        }
    }

    fn binary(&self, op: Op, x: Tracked, y: Tracked) -> Tracked {
        let value = Self::fold2(op, x.value, y.value);
        let kept = match op {
            Op::Add | Op::Sub | Op::Min | Op::Max => x.magnitude.max(y.magnitude),
            Op::Mul => x.magnitude * y.magnitude,
            Op::Div => (x.magnitude + value.abs() * y.magnitude) / y.value.abs(),
            _ => {
                (value / x.value * y.value).abs() * x.magnitude
                    + (value * x.value.ln()).abs() * y.magnitude
            }
        };
        Tracked {
            value,
            magnitude: value.abs().max(kept),
        }
    }
}

impl Function {
    /// Value and two derivatives at a number.
    pub(super) fn at(self, x: f64) -> Outer1 {
        match self {
            Self::Exp => {
                let e = x.exp();
                Outer1::new(e, e, e)
            }
            Self::Log => {
                let r = 1.0 / x;
                Outer1::new(x.ln(), r, -r * r)
            }
            Self::Sin => {
                let (s, c) = x.sin_cos();
                Outer1::new(s, c, -s)
            }
            Self::Cos => {
                let (s, c) = x.sin_cos();
                Outer1::new(c, -s, -c)
            }
            Self::Tanh => {
                // 1 − tanh² cancels for large x.
                let (t, c) = (x.tanh(), x.cosh().recip());
                Outer1::new(t, c * c, -2.0 * t * c * c)
            }
            Self::Power(c) => {
                let f = if c == 0.5 { x.sqrt() } else { x.powf(c) };
                if x > 0.0 {
                    Outer1::new(f, c * f / x, c * (c - 1.0) * f / (x * x))
                } else {
                    let second = c * (c - 1.0) * x.powf(c - 2.0);
                    Outer1::new(f, c * x.powf(c - 1.0), second)
                }
            }
        }
    }
}

/// Jets in `(H, K)` by the plain chain rule.
#[derive(Clone, Copy, Debug)]
pub struct JetAlgebra {
    h: f64,
    k: f64,
    principal: Option<[Jet2; 2]>,
}

impl JetAlgebra {
    /// For expressions without κ1 and κ2 (which are NaN).
    pub fn plain(h: f64, k: f64) -> Self {
        Self {
            h,
            k,
            principal: None,
        }
    }

    /// With `κ1,2 = H ± √(H² − K)`. Accurate where `κ1 − κ2` is not small compared with the lengths
    /// over which the expression varies.
    pub fn principal(h: f64, k: f64) -> Self {
        let t = Jet2::half_difference_squared(h, k);
        let s = t.chain(Function::Power(0.5).at(t.f));
        let (mut k1, mut k2) = (Jet2::mean(h) + s, Jet2::mean(h) - s);
        // The smaller one cancels.
        if h > 0.0 {
            k2.f = k / k1.f;
        } else if h < 0.0 {
            k1.f = k / k2.f;
        }
        Self {
            h,
            k,
            principal: Some([k1, k2]),
        }
    }
}

impl Algebra for JetAlgebra {
    type Value = Jet2;

    fn constant(&self, c: f64) -> Jet2 {
        Jet2::constant(c)
    }

    fn variable(&self, v: Variable) -> Jet2 {
        match v {
            Variable::Mean => Jet2::mean(self.h),
            Variable::Gauss => Jet2::gauss(self.k),
            Variable::Kappa1 => self.principal.map_or(Jet2::constant(f64::NAN), |k| k[0]),
            Variable::Kappa2 => self.principal.map_or(Jet2::constant(f64::NAN), |k| k[1]),
            Variable::Gradient(_) => Jet2::constant(f64::NAN),
        }
    }

    fn unary(&self, op: Op, x: Jet2) -> Jet2 {
        unary(op, x)
    }

    fn binary(&self, op: Op, x: Jet2, y: Jet2) -> Jet2 {
        match op {
            Op::Add => x + y,
            Op::Sub => x - y,
            Op::Mul => x * y,
            Op::Div => x * y.recip(),
            Op::Min | Op::Max if x.f.is_nan() || y.f.is_nan() => Jet2::constant(f64::NAN),
            Op::Min if x.f <= y.f => x,
            Op::Max if x.f >= y.f => x,
            Op::Min | Op::Max => y,
            Op::Power => unary(
                Op::Call(Function::Exp),
                y * unary(Op::Call(Function::Log), x),
            ),
            _ => Jet2::constant(f64::NAN),
        }
    }
}

/// An instruction of one operand on a jet.
pub(super) fn unary(op: Op, x: Jet2) -> Jet2 {
    match op {
        Op::Neg => -x,
        Op::Shift(c) => x.shifted(c),
        Op::Scale(c) => x.scaled(c),
        Op::Integer(-1) => x.recip(),
        Op::Integer(n) => x.powi(n),
        Op::Call(function) => x.chain(function.at(x.f)),
        Op::Abs if x.f < 0.0 => -x,
        Op::Abs => x,
        _ => Jet2::constant(f64::NAN),
    }
}
