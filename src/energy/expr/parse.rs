//! Recursive descent parser that emits postfix directly.
//!
//! ```text
//! sum     = product (("+" | "-") product)*
//! product = signed (("*" | "/") signed)*
//! signed  = ("-" | "+")* power
//! power   = atom ["^" signed]            right associative: -H^2 = -(H^2), 2^3^2 = 2^(3^2)
//! atom    = number | name | name "(" sum ("," sum)* ")" | "(" sum ")"
//! ```
//!
//! Parameters become numbers and constant parts are folded during parsing. An exponent with an
//! integer value is therefore recognised as an integer. Recursion only follows parentheses and
//! exponents and is bounded by [`MAX_DEPTH`].

use std::collections::BTreeMap;

use super::build::Builder;
use super::error::SyntaxError;
use super::gradient;
use super::lex::{Kind, Token, tokens};
use super::program::{Function, MAX_STACK, Op, Program, Variable};

/// Maximum length of the text, bytes.
pub const MAX_LENGTH: usize = 4096;
/// Maximum nesting of parentheses, function calls and exponents.
pub const MAX_DEPTH: usize = 30;

const FUNCTIONS: [&str; 9] = [
    "abs", "sqrt", "exp", "log", "sin", "cos", "tanh", "min", "max",
];
const NAMES: [&str; 6] = ["H", "K", "k1", "k2", "pi", gradient::NAME];

/// Whether `name` is a variable, constant or function and so cannot be a parameter.
pub fn is_reserved(name: &str) -> bool {
    FUNCTIONS.contains(&name) || NAMES.contains(&name)
}

/// Whether `name` is parsed as one name.
pub fn is_name(name: &str) -> bool {
    let is = |token: &Token<'_>| token.kind == Kind::Name(name);
    tokens(name).is_ok_and(|all| all.first().is_some_and(is))
}

/// The program for `text`, and the parameters of `params` that occur in it.
pub fn parse(
    text: &str,
    params: &BTreeMap<String, f64>,
) -> Result<(Program, BTreeMap<String, f64>), SyntaxError> {
    if text.len() > MAX_LENGTH {
        let message = format!(
            "the expression has {} bytes, at most {MAX_LENGTH} are accepted",
            text.len()
        );
        return Err(SyntaxError::new(text, 0, 0, message));
    }
    let mut parser = Parser {
        text,
        tokens: tokens(text)?,
        at: 0,
        depth: 0,
        code: Builder::default(),
        params,
        used: BTreeMap::new(),
    };
    parser.sum()?;
    parser.expect_end()?;
    let Some(program) = Program::new(parser.code.finish()) else {
        return Err(SyntaxError::new(
            text,
            0,
            text.len(),
            "the expression is too complex",
        ));
    };
    Ok((program, parser.used))
}

struct Parser<'a> {
    text: &'a str,
    tokens: Vec<Token<'a>>,
    at: usize,
    /// Depth of open parentheses, calls and exponents.
    depth: usize,
    code: Builder,
    params: &'a BTreeMap<String, f64>,
    used: BTreeMap<String, f64>,
}

type Parsed = Result<(), SyntaxError>;

impl<'a> Parser<'a> {
    fn peek(&self) -> Token<'a> {
        // The last token is the end, and the end is never consumed.
        self.tokens[self.at.min(self.tokens.len() - 1)]
    }

    fn next(&mut self) -> Token<'a> {
        let token = self.peek();
        self.at += 1;
        token
    }

    /// Consumes the next token if it is one of `symbols`.
    fn accept(&mut self, symbols: &[char]) -> Option<char> {
        match self.peek().kind {
            Kind::Symbol(c) if symbols.contains(&c) => {
                self.at += 1;
                Some(c)
            }
            _ => None,
        }
    }

    fn error(&self, at: Token<'_>, message: impl Into<String>) -> SyntaxError {
        SyntaxError::new(self.text, at.start, at.end, message)
    }

    fn deeper(&mut self, at: Token<'_>) -> Parsed {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(self.error(
                at,
                format!("nested more than {MAX_DEPTH} deep here; simplify"),
            ));
        }
        Ok(())
    }

    fn sum(&mut self) -> Parsed {
        let left = self.code.mark();
        self.product()?;
        while let Some(c) = self.accept(&['+', '-']) {
            let right = self.code.mark();
            self.product()?;
            self.code
                .emit2(if c == '+' { Op::Add } else { Op::Sub }, left, right);
        }
        Ok(())
    }

    fn product(&mut self) -> Parsed {
        let left = self.code.mark();
        self.signed()?;
        while let Some(c) = self.accept(&['*', '/']) {
            let right = self.code.mark();
            self.signed()?;
            self.code
                .emit2(if c == '*' { Op::Mul } else { Op::Div }, left, right);
        }
        Ok(())
    }

    fn signed(&mut self) -> Parsed {
        let mut negative = false;
        while let Some(c) = self.accept(&['-', '+']) {
            negative ^= c == '-';
        }
        let start = self.code.mark();
        self.power()?;
        if negative {
            self.code.emit1(Op::Neg, start);
        }
        Ok(())
    }

    fn power(&mut self) -> Parsed {
        let left = self.code.mark();
        self.atom()?;
        let caret = self.peek();
        if self.accept(&['^']).is_some() {
            self.deeper(caret)?;
            let right = self.code.mark();
            self.signed()?;
            self.depth -= 1;
            self.code.emit2(Op::Power, left, right);
        }
        Ok(())
    }

    fn atom(&mut self) -> Parsed {
        let token = self.next();
        match token.kind {
            Kind::Number(x) => self.leaf(Op::Constant(x), token),
            Kind::Name(name) if FUNCTIONS.contains(&name) => self.call(name, token),
            Kind::Name(name) => {
                let op = self.name(name, token)?;
                self.leaf(op, token)
            }
            Kind::Symbol('(') => {
                self.deeper(token)?;
                self.sum()?;
                self.close(token, "an operator or ')'")?;
                self.depth -= 1;
                Ok(())
            }
            _ => Err(self.error(token, self.missing_operand(token))),
        }
    }

    fn missing_operand(&self, token: Token<'_>) -> String {
        const EXPECTED: &str = "expected a number, H, K, k1, k2, a parameter, a function or '('";
        if self.tokens.len() == 1 {
            return "the expression is empty; expected e.g. H^2".to_owned();
        }
        format!("{EXPECTED}, found {}", token.describe())
    }

    /// A variable, constant or parameter.
    fn name(&mut self, name: &str, token: Token<'_>) -> Result<Op, SyntaxError> {
        let op = match name {
            "H" => Op::Variable(Variable::Mean),
            "K" => Op::Variable(Variable::Gauss),
            "k1" => Op::Variable(Variable::Kappa1),
            "k2" => Op::Variable(Variable::Kappa2),
            "pi" => Op::Constant(std::f64::consts::PI),
            gradient::NAME => Op::Variable(Variable::Gradient(token.start)),
            _ => {
                let Some(&value) = self.params.get(name) else {
                    let mut error = self.error(token, self.unknown(name));
                    let called = self.peek().kind == Kind::Symbol('(');
                    error.unknown = (!called).then(|| name.to_owned());
                    return Err(error);
                };
                self.used.insert(name.to_owned(), value);
                Op::Constant(value)
            }
        };
        if self.peek().kind == Kind::Symbol('(') {
            let message =
                format!("'{name}' is not a function; expected an operator, e.g. {name}*(...)");
            return Err(self.error(self.peek(), message));
        }
        Ok(op)
    }

    fn unknown(&self, name: &str) -> String {
        let functions = FUNCTIONS.join(", ");
        if self.peek().kind == Kind::Symbol('(') {
            return format!("unknown function '{name}'; the functions are {functions}");
        }
        let meant = match name {
            "h" => "; did you mean H?",
            "k" => "; did you mean K?",
            "K1" | "κ1" | "kappa1" | "k_1" => "; did you mean k1?",
            "K2" | "κ2" | "kappa2" | "k_2" => "; did you mean k2?",
            "Pi" | "PI" | "π" => "; did you mean pi?",
            "gradH" | "gradh2" | "GradH2" | "grad_H2" => "; did you mean gradH2?",
            _ => "",
        };
        let given = if self.params.is_empty() {
            "none".to_owned()
        } else {
            let names: Vec<&str> = self.params.keys().map(String::as_str).collect();
            names.join(", ")
        };
        format!(
            "unknown name '{name}'{meant} Known are H, K, k1, k2, gradH2, pi, the functions \
             {functions}, and the parameters that have a value ({given})",
            meant = if meant.is_empty() { "." } else { meant },
        )
    }

    fn call(&mut self, name: &str, token: Token<'_>) -> Parsed {
        let open = self.peek();
        if self.accept(&['(']).is_none() {
            let message = format!(
                "expected '(' after {name}, e.g. {name}(H), found {}",
                open.describe()
            );
            return Err(self.error(open, message));
        }
        self.deeper(token)?;
        let left = self.code.mark();
        self.sum()?;
        if matches!(name, "min" | "max") {
            let comma = self.peek();
            if self.accept(&[',']).is_none() {
                let message = format!(
                    "{name} takes two arguments: expected ',', found {}",
                    comma.describe()
                );
                return Err(self.error(comma, message));
            }
            let right = self.code.mark();
            self.sum()?;
            self.close(open, "an operator or ')'")?;
            self.code
                .emit2(if name == "min" { Op::Min } else { Op::Max }, left, right);
        } else {
            if self.peek().kind == Kind::Symbol(',') {
                return Err(self.error(
                    self.peek(),
                    format!("{name} takes one argument; expected ')'"),
                ));
            }
            self.close(open, "an operator or ')'")?;
            self.code.emit1(
                match name {
                    "abs" => Op::Abs,
                    "sqrt" => Op::Call(Function::Power(0.5)),
                    "exp" => Op::Call(Function::Exp),
                    "log" => Op::Call(Function::Log),
                    "sin" => Op::Call(Function::Sin),
                    "cos" => Op::Call(Function::Cos),
                    _ => Op::Call(Function::Tanh),
                },
                left,
            );
        }
        self.depth -= 1;
        Ok(())
    }

    /// Expects the parenthesis that closes `open`.
    fn close(&mut self, open: Token<'_>, expected: &str) -> Parsed {
        if self.accept(&[')']).is_some() {
            return Ok(());
        }
        let token = self.peek();
        if let Some(message) = self.juxtaposed(token) {
            return Err(self.error(token, message));
        }
        let place = self.text[..open.start].chars().count() + 1;
        let message = format!(
            "expected {expected} (the '(' at character {place} is open), found {}",
            token.describe()
        );
        Err(self.error(token, message))
    }

    fn expect_end(&mut self) -> Parsed {
        let token = self.peek();
        let message = match token.kind {
            Kind::End => return Ok(()),
            Kind::Symbol(')') => "unmatched ')'; expected an operator or the end".to_owned(),
            Kind::Symbol(',') => {
                "expected an operator or the end, found ','; decimals are written with a point"
                    .to_owned()
            }
            _ => self
                .juxtaposed(token)
                .unwrap_or_else(|| "expected an operator".to_owned()),
        };
        Err(self.error(token, message))
    }

    /// The message for two operands side by side.
    fn juxtaposed(&self, token: Token<'_>) -> Option<String> {
        let shown = match token.kind {
            Kind::Number(_) | Kind::Name(_) => &self.text[token.start..token.end],
            Kind::Symbol('(') => "(...)",
            _ => return None,
        };
        let before = match self.tokens[self.at.saturating_sub(1)] {
            Token {
                kind: Kind::Symbol(_),
                ..
            } => "(...)",
            Token { start, end, .. } => &self.text[start..end],
        };
        Some(format!("expected an operator, e.g. {before}*{shown}"))
    }

    fn leaf(&mut self, op: Op, token: Token<'_>) -> Parsed {
        if !self.code.leaf(op) {
            let message = format!("more than {MAX_STACK} operands wait here; simplify");
            return Err(self.error(token, message));
        }
        Ok(())
    }
}
