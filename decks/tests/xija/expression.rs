//! Expressions of a deck, evaluated.

use std::collections::HashMap;

use bmv_decks::Table;

/// An expression ready to be evaluated; names are places in a list of values.
#[derive(Debug)]
pub enum Expression {
    Number(f64),
    Name(usize),
    Call(&'static str, Vec<Expression>),
    Interpolate(usize, Box<Expression>),
}

const FUNCTIONS: [&str; 14] =
    ["exp", "log", "sqrt", "sin", "cos", "tanh", "min", "max", "abs", "step", "smoothstep", "clamp", "interp", "pi"];

/// Reads expressions: what the names in them mean.
pub struct Reader<'n> {
    pub names: &'n HashMap<String, usize>,
    pub tables: &'n [Table],
}

impl Reader<'_> {
    /// Reads a whole text.
    ///
    /// # Errors
    /// What does not parse, with the rest of the text.
    pub fn read(&self, text: &str) -> Result<Expression, String> {
        let mut rest = text.trim_start();
        let expression = self.sum(&mut rest)?;
        if rest.is_empty() { Ok(expression) } else { Err(format!("unexpected `{rest}`")) }
    }

    fn sum(&self, rest: &mut &str) -> Result<Expression, String> {
        let mut left = self.product(rest)?;
        loop {
            let function = match rest.chars().next() {
                Some('+') => "+",
                Some('-') => "-",
                _ => return Ok(left),
            };
            skip(rest, 1);
            left = Expression::Call(function, vec![left, self.product(rest)?]);
        }
    }

    fn product(&self, rest: &mut &str) -> Result<Expression, String> {
        let mut left = self.signed(rest)?;
        loop {
            let function = match rest.chars().next() {
                Some('*') => "*",
                Some('/') => "/",
                _ => return Ok(left),
            };
            skip(rest, 1);
            left = Expression::Call(function, vec![left, self.signed(rest)?]);
        }
    }

    fn signed(&self, rest: &mut &str) -> Result<Expression, String> {
        if rest.starts_with('-') {
            skip(rest, 1);
            return Ok(Expression::Call("-", vec![Expression::Number(0.0), self.signed(rest)?]));
        }
        let base = self.operand(rest)?;
        if rest.starts_with('^') {
            skip(rest, 1);
            return Ok(Expression::Call("^", vec![base, self.signed(rest)?]));
        }
        Ok(base)
    }

    fn operand(&self, rest: &mut &str) -> Result<Expression, String> {
        if rest.starts_with('(') {
            skip(rest, 1);
            let inner = self.sum(rest)?;
            return close(rest).map(|()| inner);
        }
        let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
        let length = rest.find(|c| !is_part(c)).unwrap_or(rest.len());
        let word = &rest[..length];
        skip(rest, length);
        if let Ok(number) = word.parse() {
            return Ok(Expression::Number(number));
        }
        match FUNCTIONS.iter().find(|function| **function == word) {
            None => self.names.get(word).copied().map(Expression::Name).ok_or(format!("unknown name `{word}`")),
            Some(&"pi") => Ok(Expression::Number(std::f64::consts::PI)),
            Some(&"interp") => {
                skip(rest, 1);
                let comma = rest.find(',').ok_or("no comma after the table")?;
                let at =
                    self.tables.iter().position(|table| table.name == rest[..comma].trim()).ok_or("no such table")?;
                skip(rest, comma + 1);
                let x = self.sum(rest)?;
                close(rest).map(|()| Expression::Interpolate(at, Box::new(x)))
            }
            Some(function) => {
                skip(rest, 1);
                let mut arguments = vec![self.sum(rest)?];
                while rest.starts_with(',') {
                    skip(rest, 1);
                    arguments.push(self.sum(rest)?);
                }
                close(rest).map(|()| Expression::Call(function, arguments))
            }
        }
    }
}

fn skip(rest: &mut &str, bytes: usize) {
    *rest = rest[bytes..].trim_start();
}

fn close(rest: &mut &str) -> Result<(), String> {
    if !rest.starts_with(')') {
        return Err(format!("`)` expected at `{rest}`"));
    }
    skip(rest, 1);
    Ok(())
}

impl Expression {
    /// Its value, with a value for each name.
    pub fn value(&self, values: &[f64], tables: &[Table]) -> f64 {
        match self {
            Self::Number(number) => *number,
            Self::Name(at) => values[*at],
            Self::Interpolate(at, x) => interpolate(&tables[*at], x.value(values, tables)),
            Self::Call(function, arguments) => {
                let v: Vec<f64> = arguments.iter().map(|argument| argument.value(values, tables)).collect();
                match *function {
                    "+" => v[0] + v[1],
                    "-" => v[0] - v[1],
                    "*" => v[0] * v[1],
                    "/" => v[0] / v[1],
                    "^" => libm::pow(v[0], v[1]),
                    "exp" => libm::exp(v[0]),
                    "log" => libm::log(v[0]),
                    "sqrt" => v[0].sqrt(),
                    "sin" => libm::sin(v[0]),
                    "cos" => libm::cos(v[0]),
                    "tanh" => libm::tanh(v[0]),
                    "min" => v.iter().copied().fold(f64::INFINITY, f64::min),
                    "max" => v.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                    "abs" => v[0].abs(),
                    "step" => f64::from(u8::from(v[0] >= 0.0)),
                    "clamp" => v[0].max(v[1]).min(v[2]),
                    _ => f64::NAN,
                }
            }
        }
    }
}

fn interpolate(table: &Table, x: f64) -> f64 {
    let above = table.x.partition_point(|node| *node <= x);
    if above == 0 {
        return table.y[0];
    }
    if above == table.x.len() {
        return table.y[above - 1];
    }
    let share = (x - table.x[above - 1]) / (table.x[above] - table.x[above - 1]);
    table.y[above - 1] + share * (table.y[above] - table.y[above - 1])
}
