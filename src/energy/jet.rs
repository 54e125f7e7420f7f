//! Values with first and second derivatives in the two variables `(H, K)`.
//!
//! Second-order forward differentiation: every operation carries the six numbers of a quadratic
//! Taylor polynomial, so derivatives are exact up to roundoff.

use std::ops::{Add, Mul, Neg, Sub};

/// `f` and its derivatives up to second order at a point `(H, K)`.
///
/// With F the unit of `f` and L that of length: `h` is in F·L, `k` and `hh` in F·L², `hk` in
/// F·L³, `kk` in F·L⁴. Non-finite members mean that `f` is not twice differentiable there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jet2 {
    /// `f`.
    pub f: f64,
    /// `∂f/∂H` at constant `K`.
    pub h: f64,
    /// `∂f/∂K` at constant `H`.
    pub k: f64,
    /// `∂²f/∂H²`.
    pub hh: f64,
    /// `∂²f/∂H∂K`.
    pub hk: f64,
    /// `∂²f/∂K²`.
    pub kk: f64,
}

/// A function of one variable at a point: value, first and second derivative.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outer1 {
    pub f: f64,
    pub d: f64,
    pub dd: f64,
}

/// A function `Φ(a, u)` of two variables at a point, with its derivatives.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Outer2 {
    pub f: f64,
    pub a: f64,
    pub u: f64,
    pub aa: f64,
    pub au: f64,
    pub uu: f64,
}

impl Outer1 {
    pub const fn new(f: f64, d: f64, dd: f64) -> Self {
        Self { f, d, dd }
    }
}

impl Jet2 {
    const ZERO: Self = Self {
        f: 0.0,
        h: 0.0,
        k: 0.0,
        hh: 0.0,
        hk: 0.0,
        kk: 0.0,
    };

    /// Each number of one with that of the other.
    #[inline]
    fn zip(self, o: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            f: f(self.f, o.f),
            h: f(self.h, o.h),
            k: f(self.k, o.k),
            hh: f(self.hh, o.hh),
            hk: f(self.hk, o.hk),
            kk: f(self.kk, o.kk),
        }
    }

    /// `H² − K`, the square of half the difference of the principal curvatures.
    pub(super) const fn half_difference_squared(h: f64, k: f64) -> Self {
        Self {
            f: h * h - k,
            h: 2.0 * h,
            k: -1.0,
            hh: 2.0,
            ..Self::ZERO
        }
    }

    /// The constant `c`.
    pub const fn constant(c: f64) -> Self {
        Self { f: c, ..Self::ZERO }
    }

    /// The variable `H`.
    pub const fn mean(h: f64) -> Self {
        Self {
            f: h,
            h: 1.0,
            ..Self::ZERO
        }
    }

    /// The variable `K`.
    pub const fn gauss(k: f64) -> Self {
        Self {
            f: k,
            k: 1.0,
            ..Self::ZERO
        }
    }

    /// Whether all six numbers are finite.
    pub fn is_finite(&self) -> bool {
        // A sum of finite numbers can overflow, so the members are tested individually.
        [self.f, self.h, self.k, self.hh, self.hk, self.kk]
            .iter()
            .all(|x| x.is_finite())
    }

    /// Whether all six numbers are exactly zero.
    pub fn is_zero(&self) -> bool {
        *self == Self::default()
    }

    pub(super) fn scaled(self, c: f64) -> Self {
        self.zip(self, |x, _| c * x)
    }

    pub(super) fn shifted(self, c: f64) -> Self {
        Self {
            f: self.f + c,
            ..self
        }
    }

    /// Chain rule for `φ(self)`.
    ///
    /// A zero first derivative of the argument is excluded from the products. An infinite `φ''`
    /// therefore does not affect directions in which the argument does not change.
    pub(super) fn chain(self, p: Outer1) -> Self {
        let second = |x: f64, y: f64, xy: f64| times(p.dd, x * y) + times(p.d, xy);
        Self {
            f: p.f,
            h: times(p.d, self.h),
            k: times(p.d, self.k),
            hh: second(self.h, self.h, self.hh),
            hk: second(self.h, self.k, self.hk),
            kk: second(self.k, self.k, self.kk),
        }
    }

    /// Chain rule for `Φ(a, u)`.
    pub(super) fn chain2(p: &Outer2, a: Self, u: Self) -> Self {
        let second = |ax: f64, ay: f64, axy: f64, ux: f64, uy: f64, uxy: f64| {
            p.aa * ax * ay + p.au * (ax * uy + ay * ux) + p.uu * ux * uy + p.a * axy + p.u * uxy
        };
        Self {
            f: p.f,
            h: p.a * a.h + p.u * u.h,
            k: p.a * a.k + p.u * u.k,
            hh: second(a.h, a.h, a.hh, u.h, u.h, u.hh),
            hk: second(a.h, a.k, a.hk, u.h, u.k, u.hk),
            kk: second(a.k, a.k, a.kk, u.k, u.k, u.kk),
        }
    }

    /// `1 / self`.
    pub(super) fn recip(self) -> Self {
        let r = 1.0 / self.f;
        self.chain(Outer1::new(r, -r * r, 2.0 * r * r * r))
    }

    /// `self^n` with exact derivatives also at zero (`0^0 = 1`).
    pub(super) fn powi(self, n: i32) -> Self {
        let m = f64::from(n);
        let power = |c: f64, e: i32| if c == 0.0 { 0.0 } else { c * self.f.powi(e) };
        match n {
            0 => Self::constant(1.0),
            1 => self,
            2 => self * self,
            _ => self.chain(Outer1::new(
                self.f.powi(n),
                power(m, n - 1),
                power(m * (m - 1.0), n - 2),
            )),
        }
    }
}

/// `c · x`, zero where `x` is exactly zero, whatever `c`.
fn times(c: f64, x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { c * x }
}

impl Add for Jet2 {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        self.zip(o, |x, y| x + y)
    }
}

impl Sub for Jet2 {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self.zip(o, |x, y| x - y)
    }
}

impl Neg for Jet2 {
    type Output = Self;
    fn neg(self) -> Self {
        self.scaled(-1.0)
    }
}

impl Mul for Jet2 {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self {
            f: self.f * o.f,
            h: self.h * o.f + self.f * o.h,
            k: self.k * o.f + self.f * o.k,
            hh: self.hh * o.f + 2.0 * self.h * o.h + self.f * o.hh,
            hk: self.hk * o.f + self.h * o.k + self.k * o.h + self.f * o.hk,
            kk: self.kk * o.f + 2.0 * self.k * o.k + self.f * o.kk,
        }
    }
}
