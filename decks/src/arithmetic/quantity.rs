//! Expressions of constants: folded to a number, to a constant times a number, or kept as an expression.

use crate::Value;

use super::piece::Piece;

/// Longest expression that is kept, in bytes: constants are written out where they are used.
const LONGEST: usize = 4096;
/// Most levels of brackets, signs and powers.
const DEEPEST: usize = 64;

/// A number that may depend on constants.
#[derive(Debug, Clone)]
pub(crate) struct Quantity {
    /// Its value with the deck's constants.
    pub(crate) nominal: f64,
    is_integer: bool,
    form: Value,
}

impl Quantity {
    /// A number.
    pub(crate) fn number(value: f64, is_integer: bool) -> Self {
        Self { nominal: value, is_integer, form: Value::Number(value) }
    }

    /// A constant by its name among the deck's parameters.
    pub(crate) fn constant(parameter: &str, nominal: f64) -> Self {
        Self { nominal, is_integer: false, form: Value::Scaled { parameter: parameter.to_owned(), factor: 1.0 } }
    }

    /// An expression in the words of a deck, with its value at the start.
    pub(crate) fn expression(text: String, nominal: f64) -> Self {
        Self { nominal, is_integer: false, form: Value::Expression(text) }
    }

    /// Whether it depends on no constant.
    pub(crate) fn is_number(&self) -> bool {
        matches!(self.form, Value::Number(_))
    }

    /// Whether it is more than a number or a constant times one.
    pub(crate) fn is_expression(&self) -> bool {
        matches!(self.form, Value::Expression(_))
    }

    /// Its value for a deck.
    pub(crate) fn into_value(self) -> Value {
        self.form
    }

    /// As a factor of an expression.
    fn written(&self) -> String {
        match &self.form {
            Value::Number(number) if *number < 0.0 => format!("({number:?})"),
            Value::Number(number) => format!("{number:?}"),
            Value::Scaled { parameter, factor } if *factor == 1.0 => parameter.clone(),
            Value::Scaled { parameter, factor } => format!("({factor:?} * {parameter})"),
            Value::Expression(text) => format!("({text})"),
        }
    }

    /// Joins two by one of `+ - * / ^`.
    pub(crate) fn join(self, sign: char, other: Self) -> Result<Self, String> {
        let (a, b) = (self.nominal, other.nominal);
        let is_integer = self.is_integer && other.is_integer;
        let nominal = match sign {
            '+' => a + b,
            '-' => a - b,
            '*' => a * b,
            '/' => a / b,
            _ => libm::pow(a, b),
        };
        if !nominal.is_finite() {
            return Err(format!("{} {sign} {} is not a finite number", self.written(), other.written()));
        }
        if is_integer && matches!(sign, '/' | '^') && nominal.fract() != 0.0 {
            return Err(format!("{a} {sign} {b} of integers would drop its fraction; write {a}.0 {sign} {b}.0"));
        }
        let form = match (&self.form, &other.form, sign) {
            (Value::Number(_), Value::Number(_), _) => Value::Number(nominal),
            (Value::Number(number), Value::Scaled { parameter, factor }, '*')
            | (Value::Scaled { parameter, factor }, Value::Number(number), '*') => {
                Value::Scaled { parameter: parameter.clone(), factor: factor * number }
            }
            (Value::Scaled { parameter, factor }, Value::Number(number), '/') => {
                Value::Scaled { parameter: parameter.clone(), factor: factor / number }
            }
            _ => expression(format!("{} {sign} {}", self.written(), other.written()))?,
        };
        Ok(Self { nominal, is_integer, form })
    }

    fn negated(self) -> Result<Self, String> {
        let is_integer = self.is_integer;
        let product = Self::number(-1.0, true).join('*', self)?;
        Ok(Self { is_integer, ..product })
    }

    fn call(name: &str, arguments: &[Self]) -> Result<Self, String> {
        let upper = name.to_ascii_uppercase();
        let (name, nominal) = match (upper.trim_start_matches('D'), arguments) {
            ("SQRT", [x]) => ("sqrt", x.nominal.sqrt()),
            ("EXP", [x]) => ("exp", libm::exp(x.nominal)),
            ("LOG" | "ALOG", [x]) => ("log", libm::log(x.nominal)),
            ("SIN", [x]) => ("sin", libm::sin(x.nominal)),
            ("COS", [x]) => ("cos", libm::cos(x.nominal)),
            ("TANH", [x]) => ("tanh", libm::tanh(x.nominal)),
            ("ABS", [x]) => ("abs", x.nominal.abs()),
            ("MIN", [x, y]) => ("min", x.nominal.min(y.nominal)),
            ("MAX", [x, y]) => ("max", x.nominal.max(y.nominal)),
            _ => {
                return Err(format!(
                    "`{name}` of {} arguments is not read; SQRT, EXP, LOG, SIN, COS, TANH, ABS, MIN and MAX are: write \
                     its value",
                    arguments.len()
                ));
            }
        };
        if !nominal.is_finite() {
            return Err(format!("{name} is not finite at {}", arguments.first().map_or(0.0, |x| x.nominal)));
        }
        let form = if arguments.iter().all(Self::is_number) {
            Value::Number(nominal)
        } else {
            let written: Vec<String> = arguments.iter().map(Self::written).collect();
            expression(format!("{name}({})", written.join(", ")))?
        };
        Ok(Self { nominal, is_integer: false, form })
    }
}

fn expression(text: String) -> Result<Value, String> {
    if text.len() > LONGEST {
        return Err(format!("written out, it is longer than {LONGEST} characters; write some of it as a number"));
    }
    Ok(Value::Expression(text))
}

/// Reads expressions off the pieces of a statement.
pub(crate) struct Reader<'a> {
    pieces: &'a [Piece],
    position: usize,
    depth: usize,
    /// What a name stands for.
    constant: &'a dyn Fn(&str) -> Result<Quantity, String>,
}

impl<'a> Reader<'a> {
    /// A reader of pieces with the meaning of names.
    pub(crate) fn new(pieces: &'a [Piece], constant: &'a dyn Fn(&str) -> Result<Quantity, String>) -> Self {
        Self { pieces, position: 0, depth: 0, constant }
    }

    /// The next piece.
    pub(crate) fn peek(&self) -> Option<&'a Piece> {
        self.pieces.get(self.position)
    }

    /// The next piece, passed.
    pub(crate) fn next(&mut self) -> Option<&'a Piece> {
        let piece = self.pieces.get(self.position);
        self.position += 1;
        piece
    }

    /// Passes a sign if it comes next.
    pub(crate) fn accept(&mut self, sign: char) -> bool {
        let comes = self.peek() == Some(&Piece::Sign(sign));
        self.position += usize::from(comes);
        comes
    }

    /// Passes a sign that has to come next.
    pub(crate) fn expect(&mut self, sign: char) -> Result<(), String> {
        if self.accept(sign) { Ok(()) } else { Err(format!("expected `{sign}` instead of {}", self.coming())) }
    }

    /// What comes next, for a message.
    pub(crate) fn coming(&self) -> String {
        self.peek().map_or("the end of the statement".to_owned(), Piece::described)
    }

    /// Refuses anything that is left; `expected` is what should come instead, such as "`;`".
    pub(crate) fn end(&self, expected: &str) -> Result<(), String> {
        if self.peek().is_none() { Ok(()) } else { Err(format!("expected {expected} instead of {}", self.coming())) }
    }

    /// An expression: sums of products of powers.
    pub(crate) fn quantity(&mut self) -> Result<Quantity, String> {
        let mut sum = self.product()?;
        loop {
            if self.accept('+') {
                sum = sum.join('+', self.product()?)?;
            } else if self.accept('-') {
                sum = sum.join('-', self.product()?)?;
            } else {
                return Ok(sum);
            }
        }
    }

    fn product(&mut self) -> Result<Quantity, String> {
        let mut product = self.signed()?;
        loop {
            if self.accept('*') {
                product = product.join('*', self.signed()?)?;
            } else if self.accept('/') {
                product = product.join('/', self.signed()?)?;
            } else {
                return Ok(product);
            }
        }
    }

    /// As in Fortran, a sign is weaker than a power, and powers are taken from the right.
    fn signed(&mut self) -> Result<Quantity, String> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(format!("it is nested deeper than {DEEPEST} levels"));
        }
        let quantity = if self.accept('-') {
            self.signed()?.negated()?
        } else if self.accept('+') {
            self.signed()?
        } else {
            let base = self.factor()?;
            if self.peek() == Some(&Piece::Power) {
                self.position += 1;
                base.join('^', self.signed()?)?
            } else {
                base
            }
        };
        self.depth -= 1;
        Ok(quantity)
    }

    fn factor(&mut self) -> Result<Quantity, String> {
        let coming = self.coming();
        match self.next() {
            Some(Piece::Number(value, is_integer)) => Ok(Quantity::number(*value, *is_integer)),
            Some(Piece::Sign('(')) => {
                let inner = self.quantity()?;
                self.expect(')')?;
                Ok(inner)
            }
            Some(Piece::Word(name)) if self.accept('(') => {
                let mut arguments = vec![self.quantity()?];
                while self.accept(',') {
                    arguments.push(self.quantity()?);
                }
                self.expect(')')?;
                Quantity::call(name, &arguments)
            }
            Some(Piece::Word(name)) if self.peek() == Some(&Piece::Sign(':')) => Err(format!(
                "`{name}:` refers to a node or another model, which is not read here; write a constant or a number"
            )),
            Some(Piece::Word(name)) => (self.constant)(name),
            _ => Err(format!("expected a number or the name of a constant instead of {coming}")),
        }
    }
}
