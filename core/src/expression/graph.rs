//! Expressions as a shared, simplified graph.
//!
//! Every distinct subexpression exists once (hash-consing), so that a term used by ten elements is
//! computed once, and a derivative shares what it can with the function.

use std::collections::HashMap;

use serde::Serialize;

use crate::math::functions;

use super::hasher::Map;

/// A subexpression of a [`Graph`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ExprId(pub(super) u32);

/// What an expression may depend on. The numbers index the model's lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Symbol {
    /// A parameter of the model, in its SI unit.
    Parameter(u32),
    /// An input (environment, dissipation, ...), in its SI unit.
    Input(u32),
    /// An output of what answers for the model in place of equations, in its SI unit.
    Output(u32),
    /// Time, s.
    Time,
    /// Temperature of a node, K.
    Node(u32),
    /// State of a switched element (0 or 1), such as a thermostat.
    Mode(u32),
    /// A value that the owner of the expression supplies, such as a quantity's term or a sensor's true reading.
    Local(u32),
}

/// What kinds of symbol an expression depends on, as flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Dependence(u8);

impl Dependence {
    /// Depends on nothing.
    pub const CONSTANT: Self = Self(0);
    /// Depends on a parameter.
    pub const PARAMETER: Self = Self(1);
    /// Depends on an input.
    pub const INPUT: Self = Self(2);
    /// Depends on time.
    pub const TIME: Self = Self(4);
    /// Depends on a node's temperature.
    pub const NODE: Self = Self(8);
    /// Depends on the state of a switched element.
    pub const MODE: Self = Self(16);
    /// Depends on a local value.
    pub const LOCAL: Self = Self(32);

    /// Both together.
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether nothing outside `allowed` is depended on.
    pub const fn within(self, allowed: Self) -> bool {
        self.0 & !allowed.0 == 0
    }

    /// Whether any of `other` is depended on.
    pub const fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

impl Symbol {
    fn dependence(self) -> Dependence {
        match self {
            Self::Parameter(_) => Dependence::PARAMETER,
            // Known before anything is solved, as an input is.
            Self::Input(_) | Self::Output(_) => Dependence::INPUT,
            Self::Time => Dependence::TIME,
            Self::Node(_) => Dependence::NODE,
            Self::Mode(_) => Dependence::MODE,
            Self::Local(_) => Dependence::LOCAL,
        }
    }
}

/// A function of one argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unary {
    /// `-x`.
    Negate,
    /// `e^x`.
    Exp,
    /// Natural logarithm.
    Log,
    /// Square root.
    Sqrt,
    /// `1 / (2 sqrt(x))`, and 0 at 0 so that a product with a vanishing factor stays finite.
    SqrtSlope,
    /// Sine.
    Sin,
    /// Cosine.
    Cos,
    /// Hyperbolic tangent.
    Tanh,
    /// Magnitude.
    Abs,
    /// 1 for `x >= 0`, else 0.
    Step,
    /// 1 for `x > 0`, -1 for `x < 0`, 0 at 0: the slope of the magnitude.
    Sign,
    /// Cubic ramp `3 c^2 - 2 c^3` of `c = clamp(x, 0, 1)`.
    Smoothstep,
    /// Slope of the cubic ramp.
    SmoothstepSlope,
}

/// A function of two arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Binary {
    /// `a + b`.
    Add,
    /// `a - b`.
    Subtract,
    /// `a * b`.
    Multiply,
    /// `a / b`.
    Divide,
    /// `a ^ b`.
    Power,
    /// `b a^(b-1)`, and 0 where `a` is 0 and `b` below 1, so that `x |x|^n` has a finite slope at 0.
    PowerSlope,
    /// `min(a, b)`.
    Minimum,
    /// `max(a, b)`.
    Maximum,
    /// 1 where `a >= b`, else 0.
    AtLeast,
}

/// One node of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Term {
    /// A constant, by its bits.
    Number(u64),
    /// A symbol.
    Symbol(Symbol),
    /// A function of one argument.
    Unary(Unary, ExprId),
    /// A function of two arguments.
    Binary(Binary, ExprId, ExprId),
    /// Piecewise linear interpolation in a table, held constant outside.
    Interpolate(u32, ExprId),
    /// Slope of the interpolation (right-hand side at a corner, 0 outside).
    Slope(u32, ExprId),
}

/// A table of a piecewise linear function.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Abscissae, strictly increasing.
    pub x: Vec<f64>,
    /// Ordinates, as many.
    pub y: Vec<f64>,
}

impl Table {
    /// The segment that holds `x`: `None` outside the table.
    fn segment(&self, x: f64) -> Option<usize> {
        let last = self.x.len().checked_sub(1)?;
        if !(x >= self.x[0] && x < self.x[last]) {
            return None;
        }
        Some(self.x.partition_point(|&v| v <= x) - 1)
    }

    /// Interpolated value; the end values hold outside.
    pub fn value(&self, x: f64) -> f64 {
        if x.is_nan() || self.x.is_empty() {
            return f64::NAN;
        }
        match self.segment(x) {
            Some(i) => self.y[i] + (self.y[i + 1] - self.y[i]) * ((x - self.x[i]) / (self.x[i + 1] - self.x[i])),
            None if x < self.x[0] => self.y[0],
            None => self.y[self.y.len() - 1],
        }
    }

    /// Slope at `x`.
    pub fn slope(&self, x: f64) -> f64 {
        if x.is_nan() {
            return f64::NAN;
        }
        self.segment(x).map_or(0.0, |i| (self.y[i + 1] - self.y[i]) / (self.x[i + 1] - self.x[i]))
    }
}

/// Evaluates a function of one argument.
#[inline]
pub(super) fn apply_unary(function: Unary, x: f64) -> f64 {
    match function {
        Unary::Negate => -x,
        Unary::Exp => functions::exp(x),
        Unary::Log => functions::ln(x),
        Unary::Sqrt => functions::sqrt(x),
        Unary::SqrtSlope => {
            if x == 0.0 {
                0.0
            } else {
                0.5 / functions::sqrt(x)
            }
        }
        Unary::Sin => functions::sin(x),
        Unary::Cos => functions::cos(x),
        Unary::Tanh => functions::tanh(x),
        Unary::Abs => x.abs(),
        Unary::Step => f64::from(u8::from(x >= 0.0)),
        Unary::Sign => f64::from(i8::from(x > 0.0) - i8::from(x < 0.0)),
        Unary::Smoothstep => {
            let c = x.clamp(0.0, 1.0);
            c * c * (3.0 - 2.0 * c)
        }
        Unary::SmoothstepSlope => {
            let c = x.clamp(0.0, 1.0);
            6.0 * c * (1.0 - c)
        }
    }
}

/// Evaluates a function of two arguments.
#[inline]
pub(super) fn apply_binary(function: Binary, a: f64, b: f64) -> f64 {
    match function {
        Binary::Add => a + b,
        Binary::Subtract => a - b,
        Binary::Multiply => a * b,
        Binary::Divide => a / b,
        Binary::Power => functions::pow(a, b),
        Binary::PowerSlope => {
            if a == 0.0 && b < 1.0 {
                0.0
            } else {
                b * functions::pow(a, b - 1.0)
            }
        }
        Binary::Minimum => {
            if a.is_nan() || a <= b {
                a
            } else {
                b
            }
        }
        Binary::Maximum => {
            if a.is_nan() || a >= b {
                a
            } else {
                b
            }
        }
        Binary::AtLeast => f64::from(u8::from(a >= b)),
    }
}

/// A store of shared subexpressions with their tables.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    terms: Vec<Term>,
    dependences: Vec<Dependence>,
    index: Map<Term, ExprId>,
    slopes: Map<(ExprId, Symbol), ExprId>,
    tables: Vec<Table>,
}

impl Graph {
    /// An empty graph.
    pub fn new() -> Self {
        Self::default()
    }

    /// The node behind an id.
    pub fn term(&self, id: ExprId) -> Term {
        self.terms[id.0 as usize]
    }

    /// Number of distinct subexpressions.
    pub fn len(&self) -> usize {
        self.terms.len()
    }

    /// Whether the graph holds nothing.
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    /// What kinds of symbol an expression depends on.
    pub fn dependence(&self, id: ExprId) -> Dependence {
        self.dependences[id.0 as usize]
    }

    /// The tables, in the order of [`Graph::table`].
    pub fn tables(&self) -> &[Table] {
        &self.tables
    }

    /// Adds a table and returns its number for [`Graph::interpolate`].
    pub fn table(&mut self, table: Table) -> u32 {
        self.tables.push(table);
        u32::try_from(self.tables.len() - 1).unwrap_or(u32::MAX)
    }

    /// The value, if the expression is a constant.
    pub fn constant(&self, id: ExprId) -> Option<f64> {
        match self.term(id) {
            Term::Number(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    fn intern(&mut self, term: Term) -> ExprId {
        if let Some(&id) = self.index.get(&term) {
            return id;
        }
        let dependence = match term {
            Term::Number(_) => Dependence::CONSTANT,
            Term::Symbol(symbol) => symbol.dependence(),
            Term::Unary(_, a) | Term::Interpolate(_, a) | Term::Slope(_, a) => self.dependence(a),
            Term::Binary(_, a, b) => self.dependence(a).union(self.dependence(b)),
        };
        // A graph of four thousand million terms does not fit in memory before the number does.
        let id = ExprId(u32::try_from(self.terms.len()).unwrap_or(u32::MAX));
        self.terms.push(term);
        self.dependences.push(dependence);
        self.index.insert(term, id);
        id
    }

    /// A constant.
    pub fn number(&mut self, value: f64) -> ExprId {
        let value = if value == 0.0 { 0.0 } else { value };
        self.intern(Term::Number(value.to_bits()))
    }

    /// A symbol.
    pub fn symbol(&mut self, symbol: Symbol) -> ExprId {
        self.intern(Term::Symbol(symbol))
    }

    /// A function of one argument, simplified.
    pub fn unary(&mut self, function: Unary, a: ExprId) -> ExprId {
        if let Some(x) = self.constant(a) {
            let value = apply_unary(function, x);
            if value.is_finite() {
                return self.number(value);
            }
        }
        match (function, self.term(a)) {
            (Unary::Negate, Term::Unary(Unary::Negate, inner)) => inner,
            (Unary::Negate, Term::Binary(Binary::Subtract, x, y)) => self.subtract(y, x),
            _ => self.intern(Term::Unary(function, a)),
        }
    }

    /// A function of two arguments, simplified.
    pub fn binary(&mut self, function: Binary, a: ExprId, b: ExprId) -> ExprId {
        let (left, right) = (self.constant(a), self.constant(b));
        if let (Some(x), Some(y)) = (left, right) {
            let value = apply_binary(function, x, y);
            if value.is_finite() {
                return self.number(value);
            }
        }
        match (function, left, right) {
            (Binary::Add, Some(0.0), _) | (Binary::Multiply, Some(1.0), _) => return b,
            (Binary::Add | Binary::Subtract, _, Some(0.0))
            | (Binary::Multiply | Binary::Divide | Binary::Power, _, Some(1.0)) => return a,
            (Binary::Subtract, Some(0.0), _) => return self.negate(b),
            (Binary::Multiply, Some(0.0), _) | (Binary::Multiply, _, Some(0.0)) | (Binary::Divide, Some(0.0), _) => {
                return self.number(0.0);
            }
            (Binary::Multiply, Some(-1.0), _) => return self.negate(b),
            (Binary::Multiply, _, Some(-1.0)) => return self.negate(a),
            (Binary::Power, _, Some(0.0)) => return self.number(1.0),
            (Binary::Power, _, Some(0.5)) => return self.unary(Unary::Sqrt, a),
            (Binary::Power, _, Some(n)) if n.fract() == 0.0 && n.abs() <= 16.0 => {
                return self.integer_power(a, n);
            }
            (Binary::Subtract, ..) if a == b => return self.number(0.0),
            _ => {}
        }
        match (function, self.term(b)) {
            (Binary::Add, Term::Unary(Unary::Negate, inner)) => return self.subtract(a, inner),
            (Binary::Subtract, Term::Unary(Unary::Negate, inner)) => return self.add(a, inner),
            _ => {}
        }
        // One order for the commutative functions, so that `a + b` and `b + a` are one term.
        let (a, b) = match function {
            Binary::Add | Binary::Multiply if b < a => (b, a),
            _ => (a, b),
        };
        self.intern(Term::Binary(function, a, b))
    }

    /// `a^n` by repeated multiplication: fourth powers are products, whose bits are the same everywhere.
    fn integer_power(&mut self, a: ExprId, n: f64) -> ExprId {
        let mut result: Option<ExprId> = None;
        let mut square = a;
        let mut rest = n.abs() as u32;
        while rest > 0 {
            if rest & 1 == 1 {
                result = Some(match result {
                    Some(r) => self.multiply(r, square),
                    None => square,
                });
            }
            rest >>= 1;
            if rest > 0 {
                square = self.multiply(square, square);
            }
        }
        let one = self.number(1.0);
        let positive = result.unwrap_or(one);
        if n < 0.0 { self.divide(one, positive) } else { positive }
    }

    /// Interpolation in a table.
    pub fn interpolate(&mut self, table: u32, x: ExprId) -> ExprId {
        match (self.constant(x), self.tables.get(table as usize)) {
            (Some(value), Some(t)) => {
                let y = t.value(value);
                self.number(y)
            }
            _ => self.intern(Term::Interpolate(table, x)),
        }
    }

    /// `a + b`.
    pub fn add(&mut self, a: ExprId, b: ExprId) -> ExprId {
        self.binary(Binary::Add, a, b)
    }

    /// `a - b`.
    pub fn subtract(&mut self, a: ExprId, b: ExprId) -> ExprId {
        self.binary(Binary::Subtract, a, b)
    }

    /// `a * b`.
    pub fn multiply(&mut self, a: ExprId, b: ExprId) -> ExprId {
        self.binary(Binary::Multiply, a, b)
    }

    /// `a / b`.
    pub fn divide(&mut self, a: ExprId, b: ExprId) -> ExprId {
        self.binary(Binary::Divide, a, b)
    }

    /// `-a`.
    pub fn negate(&mut self, a: ExprId) -> ExprId {
        self.unary(Unary::Negate, a)
    }

    /// Sum of terms, in order; 0 when there are none.
    pub fn sum(&mut self, terms: &[ExprId]) -> ExprId {
        let mut total = self.number(0.0);
        for &term in terms {
            total = self.add(total, term);
        }
        total
    }

    /// The symbols that an expression depends on, sorted.
    pub fn symbols(&self, root: ExprId) -> Vec<Symbol> {
        let mut symbols = Vec::new();
        let mut seen = std::collections::HashSet::new();
        let mut stack = vec![root];
        while let Some(id) = stack.pop() {
            if !seen.insert(id) {
                continue;
            }
            match self.term(id) {
                Term::Number(_) => {}
                Term::Symbol(symbol) => symbols.push(symbol),
                Term::Unary(_, a) | Term::Interpolate(_, a) | Term::Slope(_, a) => stack.push(a),
                Term::Binary(_, a, b) => stack.extend([a, b]),
            }
        }
        symbols.sort_unstable();
        symbols
    }

    /// The largest subexpressions below `roots` whose dependence is within `allowed`, constants left out, in order
    /// of their ids. What can be computed once outside a loop over the rest.
    pub fn frontier(&self, roots: &[ExprId], allowed: Dependence) -> Vec<ExprId> {
        let mut seen = vec![false; self.terms.len()];
        let mut frontier = Vec::new();
        let mut stack: Vec<ExprId> = roots.to_vec();
        while let Some(id) = stack.pop() {
            if std::mem::replace(&mut seen[id.0 as usize], true) {
                continue;
            }
            let term = self.term(id);
            if self.dependence(id).within(allowed) {
                if !matches!(term, Term::Number(_)) {
                    frontier.push(id);
                }
                continue;
            }
            match term {
                Term::Number(_) | Term::Symbol(_) => {}
                Term::Unary(_, a) | Term::Interpolate(_, a) | Term::Slope(_, a) => stack.push(a),
                Term::Binary(_, a, b) => stack.extend([a, b]),
            }
        }
        frontier.sort_unstable();
        frontier
    }

    /// Every subexpression of the roots, arguments before functions, in order of their ids.
    pub fn below(&self, roots: &[ExprId]) -> Vec<ExprId> {
        let mut needed = vec![false; self.terms.len()];
        let mut stack: Vec<ExprId> = roots.to_vec();
        while let Some(id) = stack.pop() {
            if std::mem::replace(&mut needed[id.0 as usize], true) {
                continue;
            }
            match self.term(id) {
                Term::Number(_) | Term::Symbol(_) => {}
                Term::Unary(_, a) | Term::Interpolate(_, a) | Term::Slope(_, a) => stack.push(a),
                Term::Binary(_, a, b) => stack.extend([a, b]),
            }
        }
        // An argument is interned before its function, so ids are in order of need.
        (0u32..).zip(&needed).filter(|(_, used)| **used).map(|(index, _)| ExprId(index)).collect()
    }

    /// Whether any key of `wanted` occurs in the roots; takes time in proportion to these, not to the graph.
    fn occurs(&self, roots: &[ExprId], wanted: &HashMap<ExprId, ExprId>) -> bool {
        let mut seen = std::collections::HashSet::new();
        let mut stack: Vec<ExprId> = roots.to_vec();
        while let Some(id) = stack.pop() {
            if wanted.contains_key(&id) {
                return true;
            }
            match self.term(id) {
                Term::Number(_) | Term::Symbol(_) => {}
                _ if !seen.insert(id) => {}
                Term::Unary(_, a) | Term::Interpolate(_, a) | Term::Slope(_, a) => stack.push(a),
                Term::Binary(_, a, b) => stack.extend([a, b]),
            }
        }
        false
    }

    /// The roots with each key of `replacements` replaced by its value, wherever it occurs. What is put in is not
    /// looked at again.
    pub fn substitute(&mut self, roots: &[ExprId], replacements: &HashMap<ExprId, ExprId>) -> Vec<ExprId> {
        if !self.occurs(roots, replacements) {
            return roots.to_vec();
        }
        let order = self.below(roots);
        let mut renewed: Vec<ExprId> = (0..u32::try_from(self.terms.len()).unwrap_or(u32::MAX)).map(ExprId).collect();
        for id in order {
            let at = |argument: ExprId| renewed[argument.0 as usize];
            let new = match (replacements.get(&id), self.term(id)) {
                (Some(&replacement), _) => replacement,
                (None, Term::Number(_) | Term::Symbol(_)) => id,
                (None, Term::Unary(function, a)) if at(a) != a => {
                    let a = at(a);
                    self.unary(function, a)
                }
                (None, Term::Binary(function, a, b)) if at(a) != a || at(b) != b => {
                    let (a, b) = (at(a), at(b));
                    self.binary(function, a, b)
                }
                (None, Term::Interpolate(table, a)) if at(a) != a => {
                    let a = at(a);
                    self.interpolate(table, a)
                }
                (None, Term::Slope(table, a)) if at(a) != a => {
                    let a = at(a);
                    self.intern(Term::Slope(table, a))
                }
                _ => id,
            };
            renewed[id.0 as usize] = new;
        }
        roots.iter().map(|root| renewed[root.0 as usize]).collect()
    }

    /// Functions within `allowed` at whose sign changes a root has a corner or a jump: the arguments of magnitudes and
    /// steps, the differences of what minima, maxima and comparisons compare. In order of their ids, each once;
    /// ramps and tables are left out.
    pub fn discontinuities(&mut self, roots: &[ExprId], allowed: Dependence) -> Vec<ExprId> {
        let mut switches = Vec::new();
        for id in self.below(roots) {
            let switching = match self.term(id) {
                Term::Unary(Unary::Abs | Unary::Step | Unary::Sign, a) => a,
                Term::Binary(Binary::Minimum | Binary::Maximum | Binary::AtLeast, a, b) => self.subtract(a, b),
                _ => continue,
            };
            if self.dependence(switching).within(allowed)
                && self.dependence(switching).intersects(Dependence::TIME.union(Dependence::INPUT))
            {
                switches.push(switching);
            }
        }
        switches.sort_unstable();
        switches.dedup();
        switches
    }

    /// Tables read at a function of inputs and time, with that function: at each of its points a table has a corner.
    /// `allowed` as for [`Graph::discontinuities`].
    pub fn table_discontinuities(&self, roots: &[ExprId], allowed: Dependence) -> Vec<(u32, ExprId)> {
        let mut switches = Vec::new();
        for id in self.below(roots) {
            if let Term::Interpolate(table, at) = self.term(id)
                && self.dependence(at).within(allowed)
                && self.dependence(at).intersects(Dependence::TIME.union(Dependence::INPUT))
            {
                switches.push((table, at));
            }
        }
        switches.sort_unstable();
        switches.dedup();
        switches
    }

    /// Value of an expression; `lookup` supplies the symbols. For single evaluations: repeated ones go
    /// through [`super::Program`], which gives the same bits.
    pub fn evaluate(&self, root: ExprId, lookup: &dyn Fn(Symbol) -> f64) -> f64 {
        fn go(graph: &Graph, id: ExprId, lookup: &dyn Fn(Symbol) -> f64, memo: &mut HashMap<ExprId, f64>) -> f64 {
            if let Some(&value) = memo.get(&id) {
                return value;
            }
            let value = match graph.term(id) {
                Term::Number(bits) => f64::from_bits(bits),
                Term::Symbol(symbol) => lookup(symbol),
                Term::Unary(function, a) => apply_unary(function, go(graph, a, lookup, memo)),
                Term::Binary(function, a, b) => {
                    let x = go(graph, a, lookup, memo);
                    apply_binary(function, x, go(graph, b, lookup, memo))
                }
                Term::Interpolate(table, a) => graph.tables[table as usize].value(go(graph, a, lookup, memo)),
                Term::Slope(table, a) => graph.tables[table as usize].slope(go(graph, a, lookup, memo)),
            };
            memo.insert(id, value);
            value
        }
        go(self, root, lookup, &mut HashMap::new())
    }

    /// Derivative of an expression with respect to a symbol, itself an expression of this graph.
    ///
    /// At a corner (`abs`, `min`, `max`, `clamp`, a table's point) it is one of the one-sided slopes.
    pub fn derivative(&mut self, id: ExprId, symbol: Symbol) -> ExprId {
        if !self.dependence(id).intersects(symbol.dependence()) {
            return self.number(0.0);
        }
        if let Some(&slope) = self.slopes.get(&(id, symbol)) {
            return slope;
        }
        let result = match self.term(id) {
            Term::Number(_) | Term::Slope(..) => self.number(0.0),
            Term::Symbol(leaf) => self.number(if leaf == symbol { 1.0 } else { 0.0 }),
            Term::Unary(function, a) => {
                let inner = self.derivative(a, symbol);
                let outer = self.unary_slope(function, a, id);
                self.multiply(outer, inner)
            }
            Term::Interpolate(table, a) => {
                let inner = self.derivative(a, symbol);
                let outer = self.intern(Term::Slope(table, a));
                self.multiply(outer, inner)
            }
            Term::Binary(function, a, b) => self.binary_derivative(function, (a, b), id, symbol),
        };
        self.slopes.insert((id, symbol), result);
        result
    }

    /// Slope of a function of one argument at `a`; `id` is the function's value.
    fn unary_slope(&mut self, function: Unary, a: ExprId, id: ExprId) -> ExprId {
        match function {
            Unary::Negate => self.number(-1.0),
            Unary::Exp => id,
            Unary::Log => {
                let one = self.number(1.0);
                self.divide(one, a)
            }
            Unary::Sqrt => self.unary(Unary::SqrtSlope, a),
            Unary::Sin => self.unary(Unary::Cos, a),
            Unary::Cos => {
                let sine = self.unary(Unary::Sin, a);
                self.negate(sine)
            }
            Unary::Tanh => {
                let one = self.number(1.0);
                let square = self.multiply(id, id);
                self.subtract(one, square)
            }
            Unary::Abs => self.unary(Unary::Sign, a),
            Unary::Smoothstep => self.unary(Unary::SmoothstepSlope, a),
            // Second derivatives of these are not needed beyond their one-sided values.
            Unary::Step | Unary::Sign => self.number(0.0),
            Unary::SqrtSlope => {
                let half = self.number(-0.5);
                let scaled = self.multiply(half, id);
                self.divide(scaled, a)
            }
            Unary::SmoothstepSlope => {
                let (zero, one, two, six) = (self.number(0.0), self.number(1.0), self.number(2.0), self.number(6.0));
                let above = self.binary(Binary::AtLeast, a, zero);
                let below = self.binary(Binary::AtLeast, one, a);
                let inside = self.multiply(above, below);
                let double = self.multiply(two, a);
                let linear = self.subtract(one, double);
                let slope = self.multiply(six, linear);
                self.multiply(inside, slope)
            }
        }
    }

    fn binary_derivative(&mut self, function: Binary, (a, b): (ExprId, ExprId), id: ExprId, symbol: Symbol) -> ExprId {
        let da = self.derivative(a, symbol);
        let db = self.derivative(b, symbol);
        match function {
            Binary::Add => self.add(da, db),
            Binary::Subtract => self.subtract(da, db),
            Binary::Multiply => {
                let left = self.multiply(da, b);
                let right = self.multiply(a, db);
                self.add(left, right)
            }
            Binary::Divide => {
                let carried = self.multiply(id, db);
                let top = self.subtract(da, carried);
                self.divide(top, b)
            }
            Binary::Power | Binary::PowerSlope if function == Binary::Power => {
                let slope = self.binary(Binary::PowerSlope, a, b);
                let base = self.multiply(slope, da);
                if self.constant(db) == Some(0.0) {
                    return base;
                }
                let log = self.unary(Unary::Log, a);
                let growth = self.multiply(id, log);
                let exponent = self.multiply(growth, db);
                self.add(base, exponent)
            }
            Binary::Minimum | Binary::Maximum => {
                let (low, high) = if function == Binary::Minimum { (b, a) } else { (a, b) };
                // 1 where `a` is the one taken.
                let chosen = self.binary(Binary::AtLeast, low, high);
                let one = self.number(1.0);
                let other = self.subtract(one, chosen);
                let left = self.multiply(chosen, da);
                let right = self.multiply(other, db);
                self.add(left, right)
            }
            Binary::AtLeast => self.number(0.0),
            // d/da of b a^(b-1) = b (b-1) a^(b-2), for a constant exponent.
            _ => {
                let one = self.number(1.0);
                let lower = self.subtract(b, one);
                let slope = self.binary(Binary::PowerSlope, a, lower);
                let scaled = self.multiply(b, slope);
                self.multiply(scaled, da)
            }
        }
    }
}
