//! The coefficient of `gradH2` in an expression, which is linear in it.

use super::error::SyntaxError;
use super::program::{Algebra, Op, Program, Variable};

/// The name of `|∇H|²`.
pub const NAME: &str = "gradH2";

/// The program without its terms with `|∇H|²`, and the coefficient of `|∇H|²`, 0 without one.
///
/// # Errors
/// At the first `gradH2` with another use, or with a coefficient that depends on a curvature or is
/// not finite.
pub fn split_gradient(text: &str, program: &Program) -> Result<(Program, f64), SyntaxError> {
    let coefficient = match program.eval(&Coefficients) {
        Gradient::None => return Ok((program.clone(), 0.0)),
        Gradient::Times(c, _) if c.is_finite() => c,
        Gradient::Times(_, place) | Gradient::Other(place) => {
            let message = format!(
                "{NAME} must be a term by itself or times a number or parameter, e.g. \
                 H^2 + 0.1*{NAME}; its coefficient cannot depend on H, K, k1, k2 or {NAME}"
            );
            return Err(SyntaxError::new(text, place, place + NAME.len(), message));
        }
    };
    let rest = program.map(|op| match op {
        Op::Variable(Variable::Gradient(_)) => Op::Constant(0.0),
        other => other,
    });
    Ok((rest, coefficient))
}

/// How a value depends on `|∇H|²`.
#[derive(Clone, Copy)]
enum Gradient {
    None,
    /// A number times `|∇H|²`, beside terms without it; a place where it stands.
    Times(f64, usize),
    /// In another way; a place where it stands.
    Other(usize),
}

impl Gradient {
    fn scaled(self, c: f64) -> Self {
        match self {
            Self::Times(own, place) => Self::Times(c * own, place),
            other => other,
        }
    }

    fn plus(self, other: Self) -> Self {
        match (self, other) {
            (Self::None, one) | (one, Self::None) => one,
            (Self::Times(a, place), Self::Times(b, _)) => Self::Times(a + b, place),
            _ => self.mixed_with(other),
        }
    }

    /// The result of an operation on both that is not linear.
    fn mixed_with(self, other: Self) -> Self {
        match (self, other) {
            (Self::None, Self::None) => Self::None,
            (Self::Other(place), _) | (Self::Times(_, place), Self::None | Self::Times(..)) => {
                Self::Other(place)
            }
            (_, Self::Other(place) | Self::Times(_, place)) => Self::Other(place),
        }
    }
}

struct Coefficients;

impl Algebra for Coefficients {
    type Value = Gradient;

    fn constant(&self, _: f64) -> Gradient {
        Gradient::None
    }

    fn variable(&self, v: Variable) -> Gradient {
        match v {
            Variable::Gradient(place) => Gradient::Times(1.0, place),
            _ => Gradient::None,
        }
    }

    fn unary(&self, op: Op, x: Gradient) -> Gradient {
        match op {
            Op::Neg => x.scaled(-1.0),
            Op::Scale(c) => x.scaled(c),
            Op::Shift(_) | Op::Integer(1) => x,
            _ => x.mixed_with(Gradient::None),
        }
    }

    /// The parser folds numbers, so neither factor of a product is one.
    fn binary(&self, op: Op, x: Gradient, y: Gradient) -> Gradient {
        match op {
            Op::Add => x.plus(y),
            Op::Sub => x.plus(y.scaled(-1.0)),
            _ => x.mixed_with(y),
        }
    }
}
