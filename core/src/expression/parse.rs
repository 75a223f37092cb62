//! Text to expression: `+ - * / ^ ( )`, numbers, functions, `pi`, `sigma`, `t` and names.
//!
//! `^` binds to the right and above the unary minus: `-x^2` is `-(x^2)`, `2^3^2` is `2^9`. A sum or product is
//! read from the left.

use super::graph::{Binary, ExprId, Graph, Symbol, Unary};
use super::scope::{SIGMA, Scope};

/// Longer texts are refused, in bytes.
pub const LONGEST: usize = 20_000;

/// Brackets, signs and powers nested deeper are refused.
pub const DEEPEST: usize = 64;

/// More operators and functions than these are refused: a chain of them is as deep as it is long, and walks over
/// expressions recurse.
pub const MOST: usize = 1000;

/// What kind of error it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The text does not parse.
    Syntax,
    /// A name is not known.
    UnknownName,
    /// A function has the wrong number of arguments.
    Arguments,
    /// Too long or too deep.
    Depth,
    /// A part without names has no finite value.
    Undefined,
}

/// Why an expression could not be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct ParseError {
    /// What kind of error it is.
    pub fault: Fault,
    /// First byte of the fault in the text.
    pub start: usize,
    /// One after its last byte.
    pub end: usize,
    /// What is wrong.
    pub message: String,
    /// What was expected.
    pub expected: Option<String>,
    /// What to write instead.
    pub help: Option<String>,
    /// An unknown name, for suggestions.
    pub name: Option<String>,
}

/// Reads an expression into the graph.
///
/// # Errors
/// The first fault, with its place in the text.
pub fn parse(text: &str, graph: &mut Graph, scope: &Scope<'_>) -> Result<ExprId, ParseError> {
    if text.len() > LONGEST {
        let message = format!("the expression has {} bytes; at most {LONGEST} are read", text.len());
        return Err(fault(Fault::Depth, 0, 0, message));
    }
    let mut parser = Parser { text, at: 0, depth: 0, operations: 0, graph, scope };
    parser.blank();
    if parser.at == text.len() {
        return Err(fault(Fault::Syntax, 0, text.len(), "the expression is empty").expected(OPERAND));
    }
    let id = parser.sum()?;
    match parser.peek() {
        None => Ok(id),
        Some(c) => Err(parser.unexpected(c)),
    }
}

/// What may begin an operand.
const OPERAND: &str = "a number, a name, a function or `(`";

/// A function: how many arguments it takes.
const FUNCTIONS: &[(&str, &[usize])] = &[
    ("exp", &[1]),
    ("log", &[1]),
    ("sqrt", &[1]),
    ("sin", &[1]),
    ("cos", &[1]),
    ("tanh", &[1]),
    ("abs", &[1]),
    ("step", &[1]),
    ("smoothstep", &[1, 3]),
    ("clamp", &[3]),
    ("interp", &[2]),
    ("min", &[]),
    ("max", &[]),
];

/// Functions that people write, with what they are called here.
const HABITS: &[(&str, &str)] = &[
    ("ln", "log(x)"),
    ("log10", "log(x) / log(10)"),
    ("pow", "x ^ y"),
    ("fabs", "abs(x)"),
    ("tan", "sin(x) / cos(x)"),
    ("sinh", "(exp(x) - exp(-x)) / 2"),
    ("cosh", "(exp(x) + exp(-x)) / 2"),
    ("cbrt", "x ^ (1 / 3)"),
    ("heaviside", "step(x)"),
    ("limit", "clamp(x, lower, upper)"),
];

fn fault(fault: Fault, start: usize, end: usize, message: impl Into<String>) -> ParseError {
    ParseError { fault, start, end, message: message.into(), expected: None, help: None, name: None }
}

impl ParseError {
    fn expected(mut self, text: impl Into<String>) -> Self {
        self.expected = Some(text.into());
        self
    }

    fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }
}

type Parsed = Result<ExprId, ParseError>;

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    operations: usize,
    graph: &'a mut Graph,
    scope: &'a Scope<'a>,
}

impl<'a> Parser<'a> {
    fn peek(&self) -> Option<char> {
        self.text[self.at..].chars().next()
    }

    fn blank(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
    }

    /// Takes a character and the blanks behind it.
    fn take(&mut self, wanted: char) -> bool {
        let is_next = self.peek() == Some(wanted);
        if is_next {
            self.at += wanted.len_utf8();
            self.blank();
        }
        is_next
    }

    /// Counts an operation over `start..`, whose arguments were all constants or not, and checks its value.
    fn checked(&mut self, id: ExprId, arguments: &[ExprId], start: usize) -> Parsed {
        let end = self.text[..self.at].trim_end().len().max(start);
        self.operations += 1;
        if self.operations > MOST {
            let message = format!("the expression has more than {MOST} operations");
            return Err(fault(Fault::Depth, start, end, message));
        }
        let constant = arguments.iter().all(|&a| self.graph.constant(a).is_some());
        if constant && self.graph.constant(id).is_none_or(|v| !v.is_finite()) {
            let message = format!("`{}` has no finite value", &self.text[start..end]);
            return Err(fault(Fault::Undefined, start, end, message));
        }
        Ok(id)
    }

    fn binary(&mut self, function: Binary, a: ExprId, b: ExprId, start: usize) -> Parsed {
        let id = self.graph.binary(function, a, b);
        self.checked(id, &[a, b], start)
    }

    fn unary(&mut self, function: Unary, a: ExprId, start: usize) -> Parsed {
        let id = self.graph.unary(function, a);
        self.checked(id, &[a], start)
    }

    fn sum(&mut self) -> Parsed {
        let start = self.at;
        let mut left = self.product()?;
        loop {
            let function = if self.take('+') {
                Binary::Add
            } else if self.take('-') {
                Binary::Subtract
            } else {
                return Ok(left);
            };
            let right = self.product()?;
            left = self.binary(function, left, right, start)?;
        }
    }

    fn product(&mut self) -> Parsed {
        let start = self.at;
        let mut left = self.signed()?;
        loop {
            let star = self.at;
            let function = if self.take('*') {
                if self.peek() == Some('*') {
                    let error = fault(Fault::Syntax, star, self.at + 1, "`**` is no operator");
                    return Err(error.help("a power is written with `^`"));
                }
                Binary::Multiply
            } else if self.take('/') {
                Binary::Divide
            } else {
                return Ok(left);
            };
            let right = self.signed()?;
            if function == Binary::Divide && self.graph.constant(right) == Some(0.0) {
                let end = self.text[..self.at].trim_end().len();
                let message = format!("`{}` divides by 0", &self.text[start..end]);
                return Err(fault(Fault::Undefined, start, end, message));
            }
            left = self.binary(function, left, right, start)?;
        }
    }

    fn signed(&mut self) -> Parsed {
        let start = self.at;
        self.depth += 1;
        if self.depth > DEEPEST {
            let message = format!("the expression is nested deeper than {DEEPEST} levels");
            return Err(fault(Fault::Depth, start, start + self.peek().map_or(0, char::len_utf8), message));
        }
        let result = if self.take('-') {
            let inner = self.signed()?;
            self.unary(Unary::Negate, inner, start)
        } else if self.take('+') {
            self.signed()
        } else {
            self.power()
        };
        self.depth -= 1;
        result
    }

    fn power(&mut self) -> Parsed {
        let start = self.at;
        let base = self.operand()?;
        if !self.take('^') {
            return Ok(base);
        }
        let exponent = self.signed()?;
        self.binary(Binary::Power, base, exponent, start)
    }

    fn operand(&mut self) -> Parsed {
        let start = self.at;
        match self.peek() {
            Some('(') => {
                self.take('(');
                let inner = self.sum()?;
                self.close(start)?;
                Ok(inner)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => self.word(),
            Some(c) => {
                let mut error = fault(Fault::Syntax, start, start + c.len_utf8(), format!("unexpected `{c}`"));
                error = error.expected(OPERAND);
                Err(error)
            }
            None => Err(fault(Fault::Syntax, start, start, "the expression ends too early").expected(OPERAND)),
        }
    }

    /// The closing bracket of the one opened at `open`.
    fn close(&mut self, open: usize) -> Result<(), ParseError> {
        if self.take(')') {
            return Ok(());
        }
        match self.peek() {
            None => Err(fault(Fault::Syntax, open, open + 1, "this bracket is not closed").expected("a `)` for it")),
            Some(c) => Err(self.unexpected(c)),
        }
    }

    /// Something that cannot follow an operand.
    fn unexpected(&self, c: char) -> ParseError {
        let rest = &self.text[self.at..];
        let word = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
        let end = self.at + word.max(c.len_utf8());
        let shown = &self.text[self.at..end];
        let error = fault(Fault::Syntax, self.at, end, format!("unexpected `{shown}`"));
        match c {
            ')' => error.expected("an opening `(` before it"),
            ',' => error
                .expected("an operator: commas separate arguments of functions")
                .help("a decimal is written with a point"),
            '=' | '<' | '>' => {
                error.expected("an operator + - * / ^").help("compare with step(x): 1 for x >= 0, else 0")
            }
            '(' => error.expected("an operator + - * / ^").help("a product is written with `*`"),
            c if c.is_alphanumeric() || c == '_' || c == '.' => {
                error.expected("an operator + - * / ^").help(format!("a product is written `* {shown}`"))
            }
            _ => error.expected("an operator + - * / ^"),
        }
    }

    fn number(&mut self) -> Parsed {
        let start = self.at;
        let rest = &self.text.as_bytes()[start..];
        let digits = |from: usize| rest[from.min(rest.len())..].iter().take_while(|b| b.is_ascii_digit()).count();
        let mut length = digits(0);
        if rest.get(length) == Some(&b'.') {
            length += 1 + digits(length + 1);
        }
        if let Some(b'e' | b'E') = rest.get(length) {
            let sign = usize::from(matches!(rest.get(length + 1), Some(b'+' | b'-')));
            let count = digits(length + 1 + sign);
            if count > 0 {
                length += 1 + sign + count;
            }
        }
        let end = start + length;
        let text = &self.text[start..end];
        let Ok(value) = text.parse::<f64>() else {
            return Err(fault(Fault::Syntax, start, end, format!("`{text}` is no number")).expected(OPERAND));
        };
        if !value.is_finite() {
            let message = format!("the number `{text}` is too large");
            return Err(fault(Fault::Undefined, start, end, message).expected("a number below 1.8e308"));
        }
        self.at = end;
        self.blank();
        Ok(self.graph.number(value))
    }

    /// A name, dots included, or a function.
    fn word(&mut self) -> Parsed {
        let start = self.at;
        let rest = &self.text[start..];
        let plain = |c: char| c.is_alphanumeric() || c == '_';
        let mut length = rest.find(|c: char| !plain(c)).unwrap_or(rest.len());
        while let Some(behind) = rest[length..].strip_prefix('.') {
            let more = behind.find(|c: char| !plain(c)).unwrap_or(behind.len());
            if more == 0 {
                break;
            }
            length += 1 + more;
        }
        let name = &rest[..length];
        let end = start + length;
        self.at = end;
        self.blank();
        if self.peek() == Some('(') {
            return self.call(name, start, end);
        }
        match name {
            "pi" => return Ok(self.graph.number(std::f64::consts::PI)),
            "sigma" => return Ok(self.graph.number(SIGMA)),
            "t" => return Ok(self.graph.symbol(Symbol::Time)),
            _ => {}
        }
        self.scope.find(name).ok_or_else(|| {
            let mut error = fault(Fault::UnknownName, start, end, format!("unknown name `{name}`"));
            if FUNCTIONS.iter().any(|f| f.0 == name) {
                error.message = format!("the function `{name}` needs arguments");
                error.fault = Fault::Arguments;
                return error.expected(format!("`{name}(...)`"));
            }
            error.name = Some(name.to_owned());
            match name {
                "Ta" | "Tb" | "Tm" => error.help("Ta, Tb and Tm are known inside conductors, radiations and flows"),
                "T" => error.help("T is known in a load's power and a node's capacity"),
                "e" => error.help("Euler's number is exp(1)"),
                _ => error,
            }
        })
    }

    fn call(&mut self, name: &str, start: usize, end: usize) -> Parsed {
        let Some((name, counts)) = FUNCTIONS.iter().find(|f| f.0 == name) else {
            let mut error = fault(Fault::UnknownName, start, end, format!("unknown function `{name}`"));
            if self.scope.find(name).is_some() || matches!(name, "pi" | "sigma" | "t") {
                error.message = format!("`{name}` is no function");
                return Err(error.help(format!("a product is written `{name} * (...)`")));
            }
            if let Some((_, right)) = HABITS.iter().find(|h| h.0 == name) {
                return Err(error.help(format!("write `{right}`")));
            }
            error.name = Some(name.to_owned());
            return Err(error);
        };
        let open = self.at;
        self.take('(');
        let table = if *name == "interp" { Some(self.table(open)?) } else { None };
        let mut arguments = Vec::new();
        if table.is_none() || self.peek() != Some(')') {
            if self.peek() != Some(')') {
                arguments.push(self.sum()?);
            }
            while self.take(',') {
                arguments.push(self.sum()?);
            }
        }
        self.close(open)?;
        let count = arguments.len() + usize::from(table.is_some());
        let fits = if counts.is_empty() { count >= 2 } else { counts.contains(&count) };
        if !fits {
            let end = self.text[..self.at].trim_end().len();
            let message = format!("`{name}` is given {count} argument{}", if count == 1 { "" } else { "s" });
            return Err(fault(Fault::Arguments, start, end, message).expected(usage(name)));
        }
        self.apply(name, table, &arguments, start)
    }

    fn apply(&mut self, name: &str, table: Option<u32>, arguments: &[ExprId], start: usize) -> Parsed {
        let unary = match name {
            "exp" => Unary::Exp,
            "log" => Unary::Log,
            "sqrt" => Unary::Sqrt,
            "sin" => Unary::Sin,
            "cos" => Unary::Cos,
            "tanh" => Unary::Tanh,
            "abs" => Unary::Abs,
            "step" => Unary::Step,
            _ => {
                return match (name, arguments, table) {
                    ("interp", [x], Some(table)) => {
                        let id = self.graph.interpolate(table, *x);
                        self.checked(id, &[*x], start)
                    }
                    ("clamp", [x, lower, upper], _) => {
                        if let (Some(lower), Some(upper)) = (self.graph.constant(*lower), self.graph.constant(*upper))
                            && lower > upper
                        {
                            let message = format!("clamp's lower bound {lower} is above its upper bound {upper}");
                            return Err(fault(Fault::Undefined, start, self.text[..self.at].trim_end().len(), message));
                        }
                        let raised = self.binary(Binary::Maximum, *x, *lower, start)?;
                        self.binary(Binary::Minimum, raised, *upper, start)
                    }
                    ("smoothstep", [x], _) => self.unary(Unary::Smoothstep, *x, start),
                    ("smoothstep", [lower, upper, x], _) => {
                        let above = self.binary(Binary::Subtract, *x, *lower, start)?;
                        let width = self.binary(Binary::Subtract, *upper, *lower, start)?;
                        let zero_width = self.graph.constant(width) == Some(0.0);
                        if zero_width {
                            let message = "smoothstep's edges are equal".to_owned();
                            let end = self.text[..self.at].trim_end().len();
                            return Err(fault(Fault::Undefined, start, end, message).help("use step(x - edge)"));
                        }
                        let share = self.binary(Binary::Divide, above, width, start)?;
                        self.unary(Unary::Smoothstep, share, start)
                    }
                    // min and max of several: from the left.
                    (_, [first, rest @ ..], _) => {
                        let function = if name == "min" { Binary::Minimum } else { Binary::Maximum };
                        let mut result = *first;
                        for &next in rest {
                            result = self.binary(function, result, next, start)?;
                        }
                        Ok(result)
                    }
                    _ => Err(fault(Fault::Arguments, start, self.at, usage(name))),
                };
            }
        };
        match arguments {
            [x] => self.unary(unary, *x, start),
            _ => Err(fault(Fault::Arguments, start, self.at, usage(name))),
        }
    }

    /// The table's name, quoted or not, and the comma behind it.
    fn table(&mut self, open: usize) -> Result<u32, ParseError> {
        let start = self.at;
        let rest = &self.text[start..];
        let (name, length) = match self.peek() {
            Some(quote @ ('\'' | '"')) => match rest[1..].find(quote) {
                Some(length) => (&rest[1..=length], length + 2),
                None => return Err(fault(Fault::Syntax, start, start + 1, "this quote is not closed")),
            },
            _ => {
                let length = rest.find([',', ')', '(']).unwrap_or(rest.len());
                (rest[..length].trim_end(), rest[..length].trim_end().len())
            }
        };
        self.at += length;
        let end = self.at;
        self.blank();
        if name.is_empty() {
            return Err(
                fault(Fault::Arguments, open, open + 1, "the table's name is missing").expected(usage("interp"))
            );
        }
        let Some(&table) = self.scope.names.tables.get(name) else {
            let mut error = fault(Fault::UnknownName, start, end, format!("unknown table `{name}`"));
            error = match self.scope.names.tables.is_empty() {
                true => error.help("the model has no \"tables\""),
                false => {
                    let tables: Vec<&str> = self.scope.names.tables.keys().map(String::as_str).collect();
                    error.help(format!("the tables are {}", tables.join(", ")))
                }
            };
            return Err(error.expected(usage("interp")));
        };
        self.take(',');
        Ok(table)
    }
}

/// How a function is called.
fn usage(name: &str) -> String {
    match name {
        "smoothstep" => "`smoothstep(x)` or `smoothstep(lower_edge, upper_edge, x)`".to_owned(),
        "clamp" => "`clamp(x, lower, upper)`".to_owned(),
        "interp" => "`interp(table, x)`".to_owned(),
        "min" | "max" => format!("`{name}(a, b, ...)` with two or more arguments"),
        _ => format!("`{name}(x)`"),
    }
}
