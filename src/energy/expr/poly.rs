//! Expansion of expressions that are polynomials of low degree. It recognises presets and
//! second-order energies independently of their notation.

use super::program::{Algebra, Op, Variable};

/// `H^i K^j`, `i ≤ 4`, `j ≤ 2`: coefficient `c[i][j]`. All presets fit.
pub type Polynomial = [[f64; 3]; 5];

/// `even + s·odd` with `s² = H² − K`; `None` once it is not such a polynomial.
pub type Extended = Option<(Polynomial, Polynomial)>;

/// Expands a program; `None` unless it is a polynomial of at most degree 4 in `H` and 2 in `K`
/// whose odd part in `κ1 − κ2` cancels exactly.
pub fn as_polynomial(program: &super::Program) -> Option<Polynomial> {
    let (even, odd) = program.eval(&Polynomials)?;
    let coefficients = even.as_flattened().iter().chain(odd.as_flattened());
    (odd == ZERO && coefficients.into_iter().all(|c| c.is_finite())).then_some(even)
}

const ZERO: Polynomial = [[0.0; 3]; 5];

struct Polynomials;

impl Algebra for Polynomials {
    type Value = Extended;

    fn constant(&self, c: f64) -> Extended {
        Some((monomial(0, 0, c), ZERO))
    }

    fn variable(&self, v: Variable) -> Extended {
        let h = monomial(1, 0, 1.0);
        match v {
            Variable::Mean => Some((h, ZERO)),
            Variable::Gauss => Some((monomial(0, 1, 1.0), ZERO)),
            Variable::Kappa1 => Some((h, monomial(0, 0, 1.0))),
            Variable::Kappa2 => Some((h, monomial(0, 0, -1.0))),
            Variable::Gradient(_) => None,
        }
    }

    fn unary(&self, op: Op, x: Extended) -> Extended {
        let (even, odd) = x?;
        let scaled = |c: f64| Some((scale(&even, c), scale(&odd, c)));
        match op {
            Op::Neg => scaled(-1.0),
            Op::Scale(c) => scaled(c),
            Op::Shift(c) => Some((add(&even, &monomial(0, 0, c)), odd)),
            Op::Integer(n @ 0..=4) => (0..n).try_fold((monomial(0, 0, 1.0), ZERO), |p, _| {
                product(&p, &(even, odd))
            }),
            _ => None,
        }
    }

    fn binary(&self, op: Op, x: Extended, y: Extended) -> Extended {
        let (x, y) = (x?, y?);
        match op {
            Op::Add => Some((add(&x.0, &y.0), add(&x.1, &y.1))),
            Op::Sub => Some((add(&x.0, &scale(&y.0, -1.0)), add(&x.1, &scale(&y.1, -1.0)))),
            Op::Mul => product(&x, &y),
            _ => None,
        }
    }
}

fn monomial(i: usize, j: usize, c: f64) -> Polynomial {
    let mut p = ZERO;
    p[i][j] = c;
    p
}

fn add(x: &Polynomial, y: &Polynomial) -> Polynomial {
    std::array::from_fn(|i| std::array::from_fn(|j| x[i][j] + y[i][j]))
}

fn scale(x: &Polynomial, c: f64) -> Polynomial {
    std::array::from_fn(|i| std::array::from_fn(|j| c * x[i][j]))
}

/// `None` when the degree grows too large.
fn multiply(x: &Polynomial, y: &Polynomial) -> Option<Polynomial> {
    let mut p = ZERO;
    for (i, j) in (0..5).flat_map(|i| (0..3).map(move |j| (i, j))) {
        for (m, n) in (0..5).flat_map(|m| (0..3).map(move |n| (m, n))) {
            if x[i][j] != 0.0 && y[m][n] != 0.0 {
                *p.get_mut(i + m)?.get_mut(j + n)? += x[i][j] * y[m][n];
            }
        }
    }
    Some(p)
}

fn product(
    x: &(Polynomial, Polynomial),
    y: &(Polynomial, Polynomial),
) -> Option<(Polynomial, Polynomial)> {
    let mut squared_s = monomial(2, 0, 1.0);
    squared_s[0][1] = -1.0;
    let even = multiply(&x.0, &y.0)?;
    let from_odd = multiply(&squared_s, &multiply(&x.1, &y.1)?)?;
    Some((
        add(&even, &from_odd),
        add(&multiply(&x.0, &y.1)?, &multiply(&x.1, &y.0)?),
    ))
}
