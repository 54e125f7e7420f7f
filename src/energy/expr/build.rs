//! Assembly of postfix instructions, with constant folding.

use super::program::{Function, MAX_STACK, Op};
use super::scalar::ScalarAlgebra;

/// Largest exponent evaluated by multiplication. Larger ones are evaluated as real exponents.
const MAX_INTEGER_POWER: f64 = 1000.0;

/// Instructions so far.
#[derive(Debug, Default)]
pub struct Builder {
    ops: Vec<Op>,
    /// Number of values on the stack after they have run.
    pending: usize,
}

impl Builder {
    /// Where the next operand will start.
    pub fn mark(&self) -> usize {
        self.ops.len()
    }

    /// The instructions.
    pub fn finish(self) -> Vec<Op> {
        self.ops
    }

    /// Appends a number or variable; false when the stack would overflow.
    #[must_use]
    pub fn leaf(&mut self, op: Op) -> bool {
        self.pending += 1;
        self.ops.push(op);
        self.pending <= MAX_STACK
    }

    /// The operand `ops[start..end]`, if it is a single number.
    fn number(&self, start: usize, end: usize) -> Option<f64> {
        match self.ops[start..end] {
            [Op::Constant(c)] => Some(c),
            _ => None,
        }
    }

    /// Applies `op` to the operand `ops[start..]`.
    pub fn emit1(&mut self, op: Op, start: usize) {
        match self.number(start, self.ops.len()) {
            Some(c) => self.ops[start] = Op::Constant(ScalarAlgebra::fold1(op, c)),
            None => self.ops.push(op),
        }
    }

    /// Joins the operands `ops[left..right]` and `ops[right..]`, folding numbers.
    pub fn emit2(&mut self, op: Op, left: usize, right: usize) {
        self.pending -= 1;
        match (self.number(left, right), self.number(right, self.ops.len())) {
            (Some(x), Some(y)) => {
                self.ops.truncate(left);
                self.ops.push(Op::Constant(ScalarAlgebra::fold2(op, x, y)));
            }
            (None, Some(c)) => {
                if let Some(joined) = with_right_number(op, c) {
                    self.ops[right] = joined;
                } else {
                    self.ops.push(op);
                }
            }
            (Some(c), None) => match op {
                Op::Add => self.replace_left(left, &[Op::Shift(c)]),
                Op::Sub => self.replace_left(left, &[Op::Neg, Op::Shift(c)]),
                Op::Mul => self.replace_left(left, &[Op::Scale(c)]),
                Op::Div => self.replace_left(left, &[Op::Integer(-1), Op::Scale(c)]),
                Op::Power if c > 0.0 => {
                    self.replace_left(left, &[Op::Scale(c.ln()), Op::Call(Function::Exp)]);
                }
                _ => self.ops.push(op),
            },
            (None, None) => self.ops.push(op),
        }
    }

    /// Drops the number at `left`; its right operand remains and takes `ops`.
    fn replace_left(&mut self, left: usize, ops: &[Op]) {
        self.ops.remove(left);
        self.ops.extend_from_slice(ops);
    }
}

/// `x op c` as an instruction of one operand.
fn with_right_number(op: Op, c: f64) -> Option<Op> {
    match op {
        Op::Add => Some(Op::Shift(c)),
        Op::Sub => Some(Op::Shift(-c)),
        Op::Mul => Some(Op::Scale(c)),
        Op::Div => Some(Op::Scale(1.0 / c)),
        Op::Power if c.fract() == 0.0 && c.abs() <= MAX_INTEGER_POWER => {
            Some(Op::Integer(c as i32))
        }
        Op::Power => Some(Op::Call(Function::Power(c))),
        _ => None,
    }
}
