//! A typed expression as a flat postfix program, run over any [`Algebra`].

/// A variable of the energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    /// Mean curvature `H`.
    Mean,
    /// Gauss curvature `K`.
    Gauss,
    /// `κ1 = H + √(H² − K)`.
    Kappa1,
    /// `κ2 = H − √(H² − K)`.
    Kappa2,
    /// `|∇H|²`; the byte of the text where it stands. Only [`split_gradient`] evaluates it.
    ///
    /// [`split_gradient`]: super::split_gradient
    Gradient(usize),
}

/// A smooth function of one argument. (`sqrt` is `Power(0.5)`.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Function {
    /// `eˣ`.
    Exp,
    /// Natural logarithm.
    Log,
    /// Sine of an angle in radians.
    Sin,
    /// Cosine of an angle in radians.
    Cos,
    /// Hyperbolic tangent.
    Tanh,
    /// `x^c` with a constant that is not an integer; not finite for negative `x`.
    Power(f64),
}

/// One instruction; operands are taken from the top of the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Op {
    /// Pushes a number.
    Constant(f64),
    /// Pushes a variable.
    Variable(Variable),
    /// `x + y`.
    Add,
    /// `x − y`.
    Sub,
    /// `x y`.
    Mul,
    /// `x / y`.
    Div,
    /// `−x`.
    Neg,
    /// `x + c`.
    Shift(f64),
    /// `c x`.
    Scale(f64),
    /// `x^n`, exact for every sign of `x` and at zero.
    Integer(i32),
    /// A smooth function of `x`.
    Call(Function),
    /// `|x|`; the derivative is that of the active branch, `+x` at zero.
    Abs,
    /// The smaller of two; the derivative is that of the active branch.
    Min,
    /// The larger of two; the derivative is that of the active branch.
    Max,
    /// `x^y = exp(y log x)`.
    Power,
}

impl Op {
    /// The number of operands that it takes from the stack; it always leaves one value.
    pub const fn arity(self) -> usize {
        match self {
            Self::Constant(_) | Self::Variable(_) => 0,
            Self::Neg
            | Self::Shift(_)
            | Self::Scale(_)
            | Self::Integer(_)
            | Self::Call(_)
            | Self::Abs => 1,
            Self::Add | Self::Sub | Self::Mul | Self::Div | Self::Min | Self::Max | Self::Power => {
                2
            }
        }
    }
}

/// The domain of an evaluation: numbers, jets, pairs of jets, polynomials.
pub trait Algebra {
    /// An element.
    type Value: Copy;
    /// The number `c`.
    fn constant(&self, c: f64) -> Self::Value;
    /// A variable.
    fn variable(&self, v: Variable) -> Self::Value;
    /// An instruction of one operand.
    fn unary(&self, op: Op, x: Self::Value) -> Self::Value;
    /// An instruction of two operands.
    fn binary(&self, op: Op, x: Self::Value, y: Self::Value) -> Self::Value;
}

/// Maximum number of stack slots of an expression.
pub const MAX_STACK: usize = 32;

/// A checked postfix program: it never underflows, leaves exactly one value, and fits
/// [`MAX_STACK`].
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    ops: Vec<Op>,
    slots: usize,
}

impl Program {
    /// Checks `ops`; `None` when they do not leave exactly one value or need too many slots.
    pub fn new(ops: Vec<Op>) -> Option<Self> {
        let (mut depth, mut slots) = (0_usize, 0);
        for op in &ops {
            depth = depth.checked_sub(op.arity())? + 1;
            slots = slots.max(depth);
        }
        (depth == 1 && slots <= MAX_STACK).then_some(Self { ops, slots })
    }

    /// The same with `change(op)` in place of each instruction `op`, which must take as many operands.
    pub(super) fn map(&self, change: impl Fn(Op) -> Op) -> Self {
        Self {
            ops: self.ops.iter().copied().map(change).collect(),
            slots: self.slots,
        }
    }

    /// The radicand of an expression that is a square root.
    pub fn radicand(&self) -> Option<Self> {
        let (last, rest) = self.ops.split_last()?;
        (*last == Op::Call(Function::Power(0.5)))
            .then(|| Self::new(rest.to_vec()))
            .flatten()
    }

    /// Number of instructions.
    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.ops.len()
    }

    /// Whether κ1 or κ2 occurs.
    pub fn uses_principal(&self) -> bool {
        let principal = [Variable::Kappa1, Variable::Kappa2].map(Op::Variable);
        self.ops.iter().any(|op| principal.contains(op))
    }

    /// Whether abs, min and max are applied only to operands without κ1 and κ2.
    ///
    /// The expression is then analytic in `κ1 − κ2` wherever it is finite. Because it is symmetric,
    /// it is even in `κ1 − κ2`.
    pub fn is_smooth_in_principal(&self) -> bool {
        // Marks of the operands: does κ1 or κ2 occur in it?
        let mut marks = Vec::with_capacity(self.slots);
        for &op in &self.ops {
            let operands = marks.split_off(marks.len().saturating_sub(op.arity()));
            let principal = operands.contains(&true);
            if principal && matches!(op, Op::Abs | Op::Min | Op::Max) {
                return false;
            }
            marks
                .push(principal || matches!(op, Op::Variable(Variable::Kappa1 | Variable::Kappa2)));
        }
        true
    }

    /// The value over `algebra`. No allocation: the stack is an array of the next larger size.
    pub fn eval<A: Algebra>(&self, algebra: &A) -> A::Value {
        match self.slots {
            0..=2 => self.run::<A, 2>(algebra),
            3..=4 => self.run::<A, 4>(algebra),
            5..=8 => self.run::<A, 8>(algebra),
            _ => self.run::<A, MAX_STACK>(algebra),
        }
    }

    fn run<A: Algebra, const N: usize>(&self, algebra: &A) -> A::Value {
        let mut stack = [algebra.constant(0.0); N];
        let mut top = 0;
        for &op in &self.ops {
            match op.arity() {
                0 => {
                    stack[top] = match op {
                        Op::Variable(v) => algebra.variable(v),
                        Op::Constant(c) => algebra.constant(c),
                        _ => unreachable!("only constants and variables take no operand"),
                    };
                    top += 1;
                }
                1 => stack[top - 1] = algebra.unary(op, stack[top - 1]),
                _ => {
                    top -= 1;
                    stack[top - 1] = algebra.binary(op, stack[top - 1], stack[top]);
                }
            }
        }
        stack[0]
    }
}
