//! Expressions compiled to a straight list of instructions.
//!
//! A program owns a file of registers: the symbols first, then the constants, then one register for each
//! subexpression. Instructions stand in segments, in the order in which their outputs were asked for; what an
//! earlier segment computed is not computed again. So a solver runs the segment of the parameters once, that of
//! the temperatures in every iteration, and nothing allocates.

use std::collections::HashMap;

use super::graph::{Binary, ExprId, Graph, Symbol, Table, Term, Unary, apply_binary, apply_unary};

/// A place in the file of registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Register(u32);

impl Register {
    /// Its index in the file.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

#[derive(Clone, Copy, Debug)]
enum Code {
    Unary(Unary),
    Binary(Binary),
    Interpolate,
    Slope,
}

#[derive(Clone, Copy, Debug)]
struct Instruction {
    code: Code,
    a: u32,
    b: u32,
}

/// One value, or several evaluated side by side with the same bits as one at a time.
pub trait Lanes: Copy + Send + Sync {
    /// The same value in every lane.
    fn splat(value: f64) -> Self;
    /// A function applied to every lane.
    fn map(self, function: impl Fn(f64) -> f64) -> Self;
    /// A function applied lane by lane to two.
    fn zip(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self;
}

impl Lanes for f64 {
    #[inline]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline]
    fn map(self, function: impl Fn(f64) -> f64) -> Self {
        function(self)
    }
    #[inline]
    fn zip(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        function(self, other)
    }
}

impl<const N: usize> Lanes for [f64; N] {
    #[inline]
    fn splat(value: f64) -> Self {
        [value; N]
    }
    #[inline]
    fn map(self, function: impl Fn(f64) -> f64) -> Self {
        let mut out = self;
        for value in &mut out {
            *value = function(*value);
        }
        out
    }
    #[inline]
    fn zip(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self;
        for (value, &second) in out.iter_mut().zip(&other) {
            *value = function(*value, second);
        }
        out
    }
}

/// A compiled set of expressions.
#[derive(Clone, Debug)]
pub struct Program {
    symbols: HashMap<Symbol, Register>,
    constants: Vec<f64>,
    first_constant: usize,
    first_instruction: usize,
    instructions: Vec<Instruction>,
    /// End of each segment in `instructions`.
    ends: Vec<usize>,
    tables: Vec<Table>,
    places: HashMap<ExprId, Register>,
}

impl Program {
    /// Compiles the outputs of each segment, in order. `symbols` fixes the first registers, in its order; a symbol
    /// that is used but not listed follows them.
    pub fn compile(graph: &Graph, symbols: &[Symbol], segments: &[&[ExprId]]) -> Self {
        let mut order: Vec<ExprId> = Vec::new();
        let mut ends_in_order = Vec::new();
        let mut seen = vec![false; graph.len()];
        for outputs in segments {
            for &output in *outputs {
                schedule(graph, output, &mut seen, &mut order);
            }
            ends_in_order.push(order.len());
        }
        let mut listed: Vec<Symbol> = symbols.to_vec();
        let mut constants = Vec::new();
        let mut places: HashMap<ExprId, Register> = HashMap::new();
        let mut known: HashMap<Symbol, Register> = symbols.iter().enumerate().map(|(i, &s)| (s, register(i))).collect();
        for &id in &order {
            if let Term::Symbol(symbol) = graph.term(id) {
                let place = *known.entry(symbol).or_insert_with(|| {
                    listed.push(symbol);
                    register(listed.len() - 1)
                });
                places.insert(id, place);
            }
        }
        let first_constant = listed.len();
        for &id in &order {
            if let Term::Number(bits) = graph.term(id) {
                places.insert(id, register(first_constant + constants.len()));
                constants.push(f64::from_bits(bits));
            }
        }
        let first_instruction = first_constant + constants.len();
        let mut instructions = Vec::new();
        let mut ends = Vec::new();
        let mut next_end = ends_in_order.iter().peekable();
        for (position, &id) in order.iter().enumerate() {
            while next_end.next_if(|&&end| end == position).is_some() {
                ends.push(instructions.len());
            }
            let at = |id: ExprId| places[&id].0;
            let instruction = match graph.term(id) {
                Term::Number(_) | Term::Symbol(_) => continue,
                Term::Unary(function, a) => Instruction { code: Code::Unary(function), a: at(a), b: 0 },
                Term::Binary(function, a, b) => Instruction { code: Code::Binary(function), a: at(a), b: at(b) },
                Term::Interpolate(table, a) => Instruction { code: Code::Interpolate, a: at(a), b: table },
                Term::Slope(table, a) => Instruction { code: Code::Slope, a: at(a), b: table },
            };
            places.insert(id, register(first_instruction + instructions.len()));
            instructions.push(instruction);
        }
        ends.resize(segments.len(), instructions.len());
        Self {
            symbols: known,
            constants,
            first_constant,
            first_instruction,
            instructions,
            ends,
            tables: graph.tables().to_vec(),
            places,
        }
    }

    /// A fresh file of registers with the constants in place and the symbols at zero.
    pub fn registers<V: Lanes>(&self) -> Vec<V> {
        let mut file = vec![V::splat(0.0); self.first_instruction + self.instructions.len()];
        for (slot, &value) in file[self.first_constant..].iter_mut().zip(&self.constants) {
            *slot = V::splat(value);
        }
        file
    }

    /// Where an output (or any subexpression of one) is found; `None` if it was not compiled.
    pub fn place(&self, id: ExprId) -> Option<Register> {
        self.places.get(&id).copied()
    }

    /// Where a symbol's value is to be written; `None` if nothing depends on it and it was not listed.
    pub fn symbol(&self, symbol: Symbol) -> Option<Register> {
        self.symbols.get(&symbol).copied()
    }

    /// Number of instructions of a segment.
    pub fn cost(&self, segment: usize) -> usize {
        self.ends[segment] - self.start(segment)
    }

    fn start(&self, segment: usize) -> usize {
        if segment == 0 { 0 } else { self.ends[segment - 1] }
    }

    /// Runs one segment on a file made by [`Program::registers`] of this program. Earlier segments must have run
    /// for the present symbols.
    pub fn run<V: Lanes>(&self, segment: usize, file: &mut [V]) {
        let (from, to) = (self.start(segment), self.ends[segment]);
        let offset = self.first_instruction;
        for (position, instruction) in self.instructions[from..to].iter().enumerate() {
            let a = file[instruction.a as usize];
            let value = match instruction.code {
                Code::Binary(function) => {
                    let b = file[instruction.b as usize];
                    // The common ones apart, so that the compiler sees a loop over the lanes without a branch.
                    match function {
                        Binary::Add => a.zip(b, |x, y| x + y),
                        Binary::Subtract => a.zip(b, |x, y| x - y),
                        Binary::Multiply => a.zip(b, |x, y| x * y),
                        Binary::Divide => a.zip(b, |x, y| x / y),
                        other => a.zip(b, |x, y| apply_binary(other, x, y)),
                    }
                }
                Code::Unary(function) => a.map(|x| apply_unary(function, x)),
                Code::Interpolate => a.map(|x| self.tables[instruction.b as usize].value(x)),
                Code::Slope => a.map(|x| self.tables[instruction.b as usize].slope(x)),
            };
            file[offset + from + position] = value;
        }
    }
}

fn register(index: usize) -> Register {
    Register(u32::try_from(index).unwrap_or(u32::MAX))
}

/// Appends what `root` needs, arguments before functions, without recursion (a long sum is a deep graph).
fn schedule(graph: &Graph, root: ExprId, seen: &mut [bool], order: &mut Vec<ExprId>) {
    let mut stack = vec![(root, false)];
    while let Some((id, ready)) = stack.pop() {
        if ready {
            order.push(id);
            continue;
        }
        if std::mem::replace(&mut seen[id.0 as usize], true) {
            continue;
        }
        stack.push((id, true));
        match graph.term(id) {
            Term::Number(_) | Term::Symbol(_) => {}
            Term::Unary(_, a) | Term::Interpolate(_, a) | Term::Slope(_, a) => stack.push((a, false)),
            Term::Binary(_, a, b) => stack.extend([(b, false), (a, false)]),
        }
    }
}
