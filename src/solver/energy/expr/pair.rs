//! Evaluation of expressions in κ1, κ2 by jets in `(H, K)`, exact at umbilics.
//!
//! With `t = s² = H² − K`, a value is kept as `a + s b`, where `a` and `b` are jets in `(H, K)`:
//! `κ1 = H + s`, `κ2 = H − s`. Sums, products and quotients never divide by `s`
//! (`(a + s b)(c + s d) = (ac + t bd) + s (ad + bc)`), and for an expression symmetric in κ1, κ2
//! the `s` part cancels, so the even part is `f` with its exact derivatives, umbilics included.
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
//! **Threshold.** With ℓ the length over which φ varies (1 for exp, sin, cos, tanh; the distance
//! |a| to the singularity for log; |a|/max(1,|c|) for powers c) these differences lose
//! `ε (ℓ/w)³` in what the even part of the result needs (`E_uu`, `u·O_uu`), `ε (ℓ/w)⁵` in `O_uu`
//! itself. Below `w = ℓ/8` the Taylor series of φ at `a` is used instead, through `u^8`
//! ([`TERMS`]): its remainder is `64^-9`-ish of the leading term times at most `21·20` from two
//! differentiations, under 1e-13. At the switch the differences lose under 1e-13 in what matters
//! and 1e-11 in `O_uu`, so nothing jumps by more than that.

use super::program::{Algebra, Function, Op, Variable};
use super::scalar::unary as jet_unary;
use crate::solver::energy::jet::{Jet2, Outer2};

/// `a + s b` with `s = √(H² − K) ≥ 0`.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    a: Jet2,
    b: Jet2,
}

/// Pairs at one point `(H, K)`.
///
/// For `H² < K` (no surface has that, but roundoff does) rational expressions are continued as the
/// same rational function of `H` and `K`; smooth functions use the umbilic value `u = 0`.
#[derive(Clone, Copy, Debug)]
pub struct PairAlgebra {
    h: f64,
    k: f64,
    /// `t = H² − K` with its derivatives.
    t: Jet2,
    /// `s`, 0 where `t < 0`.
    s: f64,
}

/// Terms in `u` of the series, and the order in `a` that takes.
const TERMS: usize = 9;
const ORDER: usize = 2 * TERMS + 5;
/// The switch to the series: `w < SWITCH · ℓ`.
const SWITCH: f64 = 0.125;

impl PairAlgebra {
    /// Pairs at `(h, k)`.
    pub fn new(h: f64, k: f64) -> Self {
        let t = Jet2 {
            f: h * h - k,
            h: 2.0 * h,
            k: -1.0,
            hh: 2.0,
            hk: 0.0,
            kk: 0.0,
        };
        Self {
            h,
            k,
            t,
            s: t.f.max(0.0).sqrt(),
        }
    }

    /// `f` from the pair an expression ends in.
    ///
    /// `odd_cancels` says that the expression is even in `s` (symmetric, and free of abs, min and
    /// max of κ1, κ2), so that what is left of the odd part is roundoff. Otherwise `s b` is added,
    /// whose derivatives are infinite at umbilics unless `b` vanishes there.
    pub fn finish(&self, x: Pair, odd_cancels: bool) -> Jet2 {
        if odd_cancels || x.b.is_zero() {
            return x.a;
        }
        let root = jet_unary(Op::Call(Function::Power(0.5)), self.t);
        x.a + root * x.b
    }

    fn mul(&self, x: Pair, y: Pair) -> Pair {
        match (x.b.is_zero(), y.b.is_zero()) {
            (true, true) => even(x.a * y.a),
            (true, false) => Pair {
                a: x.a * y.a,
                b: x.a * y.b,
            },
            (false, true) => Pair {
                a: x.a * y.a,
                b: x.b * y.a,
            },
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
        let norm = (x.a * x.a - self.t * (x.b * x.b)).recip();
        Pair {
            a: x.a * norm,
            b: -(x.b * norm),
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
        let (e, o) = if u.f.sqrt() < SWITCH * function.length(a) {
            series(&function.taylor(a), u.f)
        } else {
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
        }
    }

    fn unary(&self, op: Op, x: Pair) -> Pair {
        match op {
            Op::Neg => Pair { a: -x.a, b: -x.b },
            Op::Shift(c) => Pair {
                a: x.a.shifted(c),
                b: x.b,
            },
            Op::Scale(c) => Pair {
                a: x.a.scaled(c),
                b: x.b.scaled(c),
            },
            Op::Integer(n) => self.powi(x, n),
            Op::Call(function) => self.call(function, x),
            Op::Abs if self.less(x, self.constant(0.0)) => Pair { a: -x.a, b: -x.b },
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
            Op::Min => {
                if self.less(y, x) {
                    y
                } else {
                    x
                }
            }
            Op::Max => {
                if self.less(x, y) {
                    y
                } else {
                    x
                }
            }
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
    (
        e,
        Outer2 {
            f: o0,
            a: o1,
            u: o_u,
            aa: o2,
            au: o_au,
            uu: o_uu,
        },
    )
}

/// The same from Taylor coefficients `c_m = φ^(m)(a)/m!`:
/// `E = Σ c_{2n} uⁿ`, `O = Σ c_{2n+1} uⁿ`.
fn series(c: &[f64; ORDER], u: f64) -> (Outer2, Outer2) {
    let part = |first: usize| {
        let mut p = Outer2 {
            f: 0.0,
            a: 0.0,
            u: 0.0,
            aa: 0.0,
            au: 0.0,
            uu: 0.0,
        };
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
        p
    };
    (part(0), part(1))
}

impl Function {
    /// The length over which the function varies at `x`.
    fn length(self, x: f64) -> f64 {
        match self {
            Self::Exp | Self::Sin | Self::Cos | Self::Tanh => 1.0,
            Self::Log => x.abs(),
            Self::Power(c) => x.abs() / c.abs().max(1.0),
        }
    }

    /// Taylor coefficients at `x`.
    fn taylor(self, x: f64) -> [f64; ORDER] {
        let mut c = [0.0; ORDER];
        match self {
            Self::Exp => {
                c[0] = x.exp();
                for m in 1..ORDER {
                    c[m] = c[m - 1] / m as f64;
                }
            }
            Self::Sin | Self::Cos => {
                let value = self.at(x);
                (c[0], c[1]) = (value.f, value.d);
                for m in 2..ORDER {
                    c[m] = -c[m - 2] / (m * (m - 1)) as f64;
                }
            }
            Self::Log => {
                c[0] = x.ln();
                let mut power = -1.0;
                for m in 1..ORDER {
                    power /= -x;
                    c[m] = power / m as f64;
                }
            }
            Self::Tanh => {
                // y' = 1 − y², except that 1 − y² of the value itself would cancel.
                let value = self.at(x);
                (c[0], c[1]) = (value.f, value.d);
                for m in 1..ORDER - 1 {
                    let square: f64 = (0..=m).map(|i| c[i] * c[m - i]).sum();
                    c[m + 1] = -square / (m + 1) as f64;
                }
            }
            Self::Power(p) => {
                c[0] = self.at(x).f;
                for m in 1..ORDER {
                    c[m] = c[m - 1] * (p - (m - 1) as f64) / (m as f64 * x);
                }
            }
        }
        c
    }
}
