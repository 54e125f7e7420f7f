//! Evaluation of expressions in κ1, κ2 by jets in `(H, K)`, exact at umbilics.
//!
//! With `t = s² = H² − K`, a value is stored as `a + s b`, where `a` and `b` are jets in `(H, K)`:
//! `κ1 = H + s`, `κ2 = H − s`. Sums, products and quotients never divide by `s`
//! (`(a + s b)(c + s d) = (ac + t bd) + s (ad + bc)`). For an expression symmetric in κ1, κ2 the
//! `s` part cancels, so the even part is `f` with its exact derivatives, including at umbilics.
//! This is the expansion in even powers of `s` of formulation.md section 2, carried to all orders
//! for rational expressions.
//!
//! A smooth function φ of `a + s b` has even part `E(a,u) = ½(φ(a+w) + φ(a−w))` and odd part
//! `b·O(a,u)`, `O = (φ(a+w) − φ(a−w))/(2w)`, with `u = t b² = w²`. Their derivatives in `u` are
//!
//! ```text
//! E_u = ½ O[φ'],              E_uu = (E[φ''] − O[φ'])/(4u),
//! O_u = (E[φ'] − O[φ])/(2u),  O_au = (E[φ''] − O[φ'])/(2u),  O_uu = (½ O[φ''] − 3 O_u)/(2u).
//! ```
//!
//! **Near umbilics.** Let ℓ be the length over which φ varies (1 for exp, sin, cos, tanh; the
//! distance |a| to the singularity for log; |a|/max(1,|c|) for powers c). These differences lose
//! `ε (ℓ/w)³` in the terms that the even part of the result needs (`E_uu`, `u·O_uu`), and
//! `ε (ℓ/w)⁵` in `O_uu` alone. Below `w = ℓ/8` ([`SWITCH`]) the Taylor series of φ at `a` replaces
//! them, with [`TERMS`] = 9 terms. The first omitted term is `64⁻⁹` times at most 21·20 of the
//! leading one, below 1e-13. At the switch the differences lose about 1e-13, and 1e-11 in `O_uu`.
//!
//! **Far from umbilics.** `a − w` cancels where the values of φ, or of a quotient, at κ1 and κ2
//! differ greatly, as in sqrt(1e-8 + k1^2) on a cylinder. Beyond a factor of 64 ([`CANCELLED`]) the
//! point is marked. The caller then evaluates by the plain chain rule through κ1 and κ2. There `s`
//! is as large as the lengths over which the expression varies, so no accuracy is lost.

use std::cell::Cell;
use std::ops::Neg;

use super::program::{Algebra, Function, Op, Program, Variable};
use super::scalar::{JetAlgebra, unary as jet_unary};
use crate::energy::jet::{Jet2, Outer2};

/// `a + s b` with `s = √(H² − K) ≥ 0`.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    a: Jet2,
    b: Jet2,
}

/// Pairs at one point `(H, K)`.
///
/// `H² < K` does not occur on a surface, but roundoff can produce it. Rational expressions are then
/// continued as the same rational function of `H` and `K`; smooth functions use the umbilic value
/// `u = 0`.
#[derive(Clone, Debug)]
pub struct PairAlgebra {
    h: f64,
    k: f64,
    /// `t = H² − K` with its derivatives.
    t: Jet2,
    /// `s`, 0 where `t < 0`.
    s: f64,
    /// Set when the values at κ1 and κ2 differed too much for `a ± s b`.
    cancelled: Cell<bool>,
}

/// Number of terms in `u` of the series, and the order in `a` that they need.
const TERMS: usize = 9;
const ORDER: usize = 2 * TERMS + 5;
/// The switch to the series: `w < SWITCH · ℓ`.
const SWITCH: f64 = 0.125;
/// Smallest `(a − w)/a` at which `a − w` is used.
const CANCELLED: f64 = 1.0 / 64.0;

impl PairAlgebra {
    fn new(h: f64, k: f64) -> Self {
        let t = Jet2::half_difference_squared(h, k);
        Self {
            h,
            k,
            t,
            s: t.f.max(0.0).sqrt(),
            cancelled: Cell::new(false),
        }
    }

    /// `f` of an expression at `(h, k)`.
    ///
    /// Set `odd_cancels` if the expression is even in `s` (symmetric, and free of abs, min and max
    /// of κ1 and κ2); the odd part is then only roundoff. Otherwise `s b` is added, whose
    /// derivatives are infinite at umbilics unless `b` vanishes there.
    pub fn jet(program: &Program, odd_cancels: bool, h: f64, k: f64) -> Jet2 {
        let algebra = Self::new(h, k);
        let x = program.eval(&algebra);
        if algebra.cancelled.get() {
            return program.eval(&JetAlgebra::principal(h, k));
        }
        if odd_cancels || x.b.is_zero() {
            return x.a;
        }
        let root = jet_unary(Op::Call(Function::Power(0.5)), algebra.t);
        x.a + root * x.b
    }

    /// Marks the point when a difference has lost too many digits. Umbilics are not marked, because
    /// κ1 and κ2 are no more accurate there.
    fn watch(&self, difference: f64, of: f64) {
        if difference < CANCELLED * of && self.s > 0.0 {
            self.cancelled.set(true);
        }
    }

    fn mul(&self, x: Pair, y: Pair) -> Pair {
        match (x.b.is_zero(), y.b.is_zero()) {
            (true, true) => even(x.a * y.a),
            (true, false) => y.map(|jet| x.a * jet),
            (false, true) => x.map(|jet| jet * y.a),
            (false, false) => Pair {
                a: x.a * y.a + self.t * (x.b * y.b),
                b: x.a * y.b + x.b * y.a,
            },
        }
    }

    /// `1/(a + s b) = (a − s b)/(a² − t b²)`.
    fn recip(&self, x: Pair) -> Pair {
        if x.b.is_zero() {
            return even(x.a.recip());
        }
        let norm = x.a * x.a - self.t * (x.b * x.b);
        self.watch(norm.f.abs(), x.a.f * x.a.f);
        let inverse = norm.recip();
        Pair {
            a: x.a * inverse,
            b: -(x.b * inverse),
        }
    }

    fn div(&self, x: Pair, y: Pair) -> Pair {
        // Divided differences such as (k1^3 - k2^3)/(k1 - k2): s cancels, also at s = 0.
        if x.a.is_zero() && y.a.is_zero() {
            return even(x.b * y.b.recip());
        }
        self.mul(x, self.recip(y))
    }

    fn powi(&self, x: Pair, n: i32) -> Pair {
        if x.b.is_zero() {
            return even(jet_unary(Op::Integer(n), x.a));
        }
        let (mut result, mut base, mut left) = (even(Jet2::constant(1.0)), x, n.unsigned_abs());
        while left > 0 {
            if left & 1 == 1 {
                result = self.mul(result, base);
            }
            left >>= 1;
            if left > 0 {
                base = self.mul(base, base);
            }
        }
        if n < 0 { self.recip(result) } else { result }
    }

    fn call(&self, function: Function, x: Pair) -> Pair {
        if x.b.is_zero() {
            return even(jet_unary(Op::Call(function), x.a));
        }
        let mut u = self.t * (x.b * x.b);
        u.f = u.f.max(0.0);
        let a = x.a.f;
        let length = function.length(a);
        let (e, o) = if u.f.sqrt() < SWITCH * length {
            series(&function.taylor(a, length), length, u.f)
        } else {
            self.watch((a.abs() - u.f.sqrt()).abs().max(function.unit()), a.abs());
            differences(function, a, u.f)
        };
        Pair {
            a: Jet2::chain2(&e, x.a, u),
            b: x.b * Jet2::chain2(&o, x.a, u),
        }
    }

    /// Whether `x` is below `y` for `s → s + 0`.
    fn less(&self, x: Pair, y: Pair) -> bool {
        let (vx, vy) = (x.a.f + self.s * x.b.f, y.a.f + self.s * y.b.f);
        vx < vy || (vx == vy && x.b.f < y.b.f)
    }

    fn is_nan(&self, x: Pair) -> bool {
        (x.a.f + self.s * x.b.f).is_nan()
    }
}

impl Pair {
    fn map(self, f: impl Fn(Jet2) -> Jet2) -> Self {
        Self {
            a: f(self.a),
            b: f(self.b),
        }
    }
}

fn even(a: Jet2) -> Pair {
    Pair {
        a,
        b: Jet2::default(),
    }
}

impl Algebra for PairAlgebra {
    type Value = Pair;

    fn constant(&self, c: f64) -> Pair {
        even(Jet2::constant(c))
    }

    fn variable(&self, v: Variable) -> Pair {
        let kappa = |sign| Pair {
            a: Jet2::mean(self.h),
            b: Jet2::constant(sign),
        };
        match v {
            Variable::Mean => even(Jet2::mean(self.h)),
            Variable::Gauss => even(Jet2::gauss(self.k)),
            Variable::Kappa1 => kappa(1.0),
            Variable::Kappa2 => kappa(-1.0),
            Variable::Gradient(_) => even(Jet2::constant(f64::NAN)),
        }
    }

    fn unary(&self, op: Op, x: Pair) -> Pair {
        match op {
            Op::Neg => x.map(Neg::neg),
            Op::Shift(c) => Pair {
                a: x.a.shifted(c),
                b: x.b,
            },
            Op::Scale(c) => x.map(|jet| jet.scaled(c)),
            Op::Integer(n) => self.powi(x, n),
            Op::Call(function) => self.call(function, x),
            Op::Abs if self.less(x, self.constant(0.0)) => x.map(Neg::neg),
            Op::Abs => x,
            _ => self.constant(f64::NAN),
        }
    }

    fn binary(&self, op: Op, x: Pair, y: Pair) -> Pair {
        match op {
            Op::Add => Pair {
                a: x.a + y.a,
                b: x.b + y.b,
            },
            Op::Sub => Pair {
                a: x.a - y.a,
                b: x.b - y.b,
            },
            Op::Mul => self.mul(x, y),
            Op::Div => self.div(x, y),
            Op::Min | Op::Max if self.is_nan(x) || self.is_nan(y) => self.constant(f64::NAN),
            Op::Min if self.less(y, x) => y,
            Op::Max if self.less(x, y) => y,
            Op::Min | Op::Max => x,
            Op::Power => self.call(Function::Exp, self.mul(y, self.call(Function::Log, x))),
            _ => self.constant(f64::NAN),
        }
    }
}

/// `E`, `O` and their derivatives from values at `a ± √u`.
fn differences(function: Function, a: f64, u: f64) -> (Outer2, Outer2) {
    let w = u.sqrt();
    let (p, m) = (function.at(a + w), function.at(a - w));
    let mean = |x: f64, y: f64| 0.5 * (x + y);
    let slope = |x: f64, y: f64| (x - y) / (2.0 * w);
    let (e0, e1, e2) = (mean(p.f, m.f), mean(p.d, m.d), mean(p.dd, m.dd));
    let (o0, o1, o2) = (slope(p.f, m.f), slope(p.d, m.d), slope(p.dd, m.dd));
    let o_u = (e1 - o0) / (2.0 * u);
    let o_au = (e2 - o1) / (2.0 * u);
    let e = Outer2 {
        f: e0,
        a: e1,
        u: 0.5 * o1,
        aa: e2,
        au: 0.5 * o2,
        uu: 0.5 * o_au,
    };
    let o_uu = (0.5 * o2 - 3.0 * o_u) / (2.0 * u);
    let o = Outer2 {
        f: o0,
        a: o1,
        u: o_u,
        aa: o2,
        au: o_au,
        uu: o_uu,
    };
    (e, o)
}

/// The same from Taylor coefficients `c_m = ℓ^m φ^(m)(a)/m!`, `ℓ = length`:
/// `E = Σ c_{2n} (u/ℓ²)ⁿ`, `ℓ O = Σ c_{2n+1} (u/ℓ²)ⁿ`. (In units of ℓ, or powers overflow.)
fn series(c: &[f64; ORDER], length: f64, u: f64) -> (Outer2, Outer2) {
    let r = length.recip();
    let u = u * r * r;
    let part = |first: usize, unit: f64| {
        let mut p = Outer2::default();
        for n in (0..TERMS).rev() {
            let m = 2 * n + first;
            let (x, y) = (m as f64, n as f64);
            // Coefficient of uⁿ in the function and its derivatives: d/da raises the index,
            // d/du is taken term by term.
            let (d1, d2) = ((x + 1.0) * c[m + 1], (x + 1.0) * (x + 2.0) * c[m + 2]);
            p.f = p.f * u + c[m];
            p.a = p.a * u + d1;
            p.aa = p.aa * u + d2;
            p.u = p.u * u + (y + 1.0) * c[m + 2];
            p.au = p.au * u + (y + 1.0) * (x + 3.0) * c[m + 3];
            p.uu = p.uu * u + (y + 1.0) * (y + 2.0) * c[m + 4];
        }
        let (first, second) = (unit * r, unit * r * r);
        Outer2 {
            f: p.f * unit,
            a: p.a * first,
            u: p.u * second,
            aa: p.aa * second,
            au: p.au * first * r * r,
            uu: p.uu * second * r * r,
        }
    };
    (part(0, 1.0), part(1, r))
}

impl Function {
    /// A change of the argument that is significant at every argument; 0 for functions of ratios.
    fn unit(self) -> f64 {
        match self {
            Self::Exp | Self::Sin | Self::Cos | Self::Tanh => 1.0,
            Self::Log | Self::Power(_) => 0.0,
        }
    }

    /// The length over which the function varies at `x`.
    fn length(self, x: f64) -> f64 {
        match self {
            Self::Exp | Self::Sin | Self::Cos | Self::Tanh => self.unit(),
            Self::Log => x.abs(),
            Self::Power(c) => x.abs() / c.abs().max(1.0),
        }
    }

    /// Taylor coefficients at `x` in units of `length`.
    fn taylor(self, x: f64, length: f64) -> [f64; ORDER] {
        let mut c = [0.0; ORDER];
        let value = self.at(x);
        (c[0], c[1]) = (value.f, value.d * length);
        for m in 2..ORDER {
            let n = m as f64;
            c[m] = match self {
                Self::Exp => c[m - 1] * length / n,
                Self::Sin | Self::Cos => -c[m - 2] * length * length / (n * (n - 1.0)),
                // From xφ'' = −φ' and xφ' = cφ.
                Self::Log => -c[m - 1] * (length / x) * ((n - 1.0) / n),
                Self::Power(p) => c[m - 1] * (length / x) * ((p - n + 1.0) / n),
                // From φ'' = −2φφ' = −(φ²)'.
                Self::Tanh => {
                    let square: f64 = (0..m).map(|i| c[i] * c[m - 1 - i]).sum();
                    -square * length / n
                }
            };
        }
        c
    }
}
