//! Expressions compiled to a straight list of instructions.
//!
//! A program owns a file of registers: the symbols first, then the constants, then one register for each
//! subexpression. Instructions stand in segments, in the order in which their outputs were asked for; what an
//! earlier segment computed is not computed again. So a solver runs the segment of the parameters once, that of
//! the temperatures in every iteration, and nothing allocates. A segment may state on which earlier ones it
//! builds ([`Program::compile_branches`]), so that the others need not have run before it.

use std::collections::HashMap;

use super::graph::{Binary, ExprId, Graph, Symbol, Table, Term, Unary, apply_binary, apply_unary};
use super::schedule;
use crate::math::lanes::Lanes;

/// A place in the file of registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Register(u32);

impl Register {
    /// Its index in the file.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Code {
    Unary(Unary),
    Binary(Binary),
    Interpolate,
    Slope,
}

/// Registers of an instruction's arguments; of a function of one argument `b` is its table or nothing.
#[derive(Clone, Copy, Debug)]
struct Instruction {
    a: u32,
    b: u32,
}

/// Like instructions one after another.
#[derive(Clone, Copy, Debug)]
struct Run {
    code: Code,
    /// Where they end in the list.
    end: usize,
}

/// A compiled set of expressions.
#[derive(Clone, Debug)]
pub struct Program {
    symbols: HashMap<Symbol, Register>,
    constants: Vec<f64>,
    first_constant: usize,
    first_instruction: usize,
    instructions: Vec<Instruction>,
    runs: Vec<Run>,
    /// End of each segment in `instructions` and in `runs`.
    ends: Vec<[usize; 2]>,
    /// Registers of the outputs of each segment.
    outputs: Vec<Vec<Register>>,
    tables: Vec<Table>,
    /// Register of each subexpression by its id, `u32::MAX` where it was not compiled.
    places: Vec<u32>,
}

/// Outputs of a segment and the earlier segments that have run before it.
#[derive(Clone, Copy, Debug)]
pub struct Segment<'a> {
    /// Earlier segments whose results may be used.
    pub after: &'a [usize],
    /// What it computes.
    pub outputs: &'a [ExprId],
}

/// A subexpression placed by a segment.
struct Placed {
    segment: usize,
    register: u32,
    /// Next placement of the same subexpression, `u32::MAX` at the end.
    next: u32,
}

/// Placements of every subexpression while compiling.
struct Placements {
    first: Vec<u32>,
    all: Vec<Placed>,
}

impl Placements {
    /// Where a subexpression stands for a segment that may use `visible` ones.
    fn find(&self, id: ExprId, visible: &[bool]) -> Option<u32> {
        let mut at = self.first[id.0 as usize];
        while let Some(placed) = self.all.get(at as usize) {
            if visible[placed.segment] {
                return Some(placed.register);
            }
            at = placed.next;
        }
        None
    }

    fn add(&mut self, id: ExprId, segment: usize, register: u32) {
        let head = &mut self.first[id.0 as usize];
        self.all.push(Placed { segment, register, next: *head });
        *head = u32::try_from(self.all.len() - 1).unwrap_or(u32::MAX);
    }
}

impl Program {
    /// Compiles the outputs of each segment, in order; each may use what all earlier ones computed. `symbols` fixes
    /// the first registers, in its order; a symbol that is used but not listed follows them.
    pub fn compile(graph: &Graph, symbols: &[Symbol], segments: &[&[ExprId]]) -> Self {
        let before: Vec<usize> = (0..segments.len()).collect();
        let branches: Vec<Segment<'_>> = segments
            .iter()
            .enumerate()
            .map(|(number, &outputs)| Segment { after: &before[..number], outputs })
            .collect();
        Self::compile_branches(graph, symbols, &branches)
    }

    /// Compiles segments each of which uses only the results of the segments that it names. A subexpression that two
    /// unrelated segments need is computed by both.
    pub fn compile_branches(graph: &Graph, symbols: &[Symbol], segments: &[Segment<'_>]) -> Self {
        let mut listed: Vec<Symbol> = symbols.to_vec();
        let mut registers: HashMap<Symbol, Register> =
            symbols.iter().enumerate().map(|(i, &s)| (s, register(i))).collect();
        let mut constants = Vec::new();
        let roots: Vec<ExprId> = segments.iter().flat_map(|s| s.outputs.iter().copied()).collect();
        let (mut symbol_ids, mut number_ids) = (Vec::new(), Vec::new());
        for id in graph.below(&roots) {
            match graph.term(id) {
                Term::Symbol(symbol) => {
                    let place = *registers.entry(symbol).or_insert_with(|| {
                        listed.push(symbol);
                        register(listed.len() - 1)
                    });
                    symbol_ids.push((id, place.0));
                }
                Term::Number(bits) => {
                    number_ids.push((id, constants.len()));
                    constants.push(f64::from_bits(bits));
                }
                _ => {}
            }
        }
        let first_constant = listed.len();
        let first_instruction = first_constant + constants.len();
        // Symbols and constants belong to segment 0 of the placements, segment `s` to `s + 1`.
        let mut placements = Placements { first: vec![u32::MAX; graph.len()], all: Vec::new() };
        for (id, place) in symbol_ids {
            placements.add(id, 0, place);
        }
        for (id, position) in number_ids {
            placements.add(id, 0, register(first_constant + position).0);
        }
        let mut instructions: Vec<(Code, Instruction)> = Vec::new();
        let mut ends: Vec<usize> = Vec::new();
        let mut outputs = Vec::new();
        let mut stack = Vec::new();
        for (number, segment) in segments.iter().enumerate() {
            let mut visible = vec![false; segments.len() + 1];
            visible[0] = true;
            visible[number + 1] = true;
            for &before in segment.after {
                visible[before + 1] = true;
            }
            for &root in segment.outputs {
                stack.push(root);
                // Arguments before functions, without recursion (a long sum is a deep graph).
                while let Some(&id) = stack.last() {
                    if placements.find(id, &visible).is_some() {
                        stack.pop();
                        continue;
                    }
                    let (code, first, second) = match graph.term(id) {
                        // Placed above, all of them.
                        Term::Number(_) | Term::Symbol(_) => {
                            stack.pop();
                            continue;
                        }
                        Term::Unary(function, a) => (Code::Unary(function), a, None),
                        Term::Binary(function, a, b) => (Code::Binary(function), a, Some(b)),
                        Term::Interpolate(_, a) => (Code::Interpolate, a, None),
                        Term::Slope(_, a) => (Code::Slope, a, None),
                    };
                    let a = placements.find(first, &visible);
                    let b = second.map(|b| placements.find(b, &visible));
                    match (a, b) {
                        (Some(a), None) => {
                            let b = match graph.term(id) {
                                Term::Interpolate(table, _) | Term::Slope(table, _) => table,
                                _ => 0,
                            };
                            instructions.push((code, Instruction { a, b }));
                        }
                        (Some(a), Some(Some(b))) => instructions.push((code, Instruction { a, b })),
                        _ => {
                            if let (Some(None), Some(second)) = (b, second) {
                                stack.push(second);
                            }
                            if a.is_none() {
                                stack.push(first);
                            }
                            continue;
                        }
                    }
                    placements.add(id, number + 1, register(first_instruction + instructions.len() - 1).0);
                    stack.pop();
                }
            }
            ends.push(instructions.len());
            let placed = segment.outputs.iter().filter_map(|&id| placements.find(id, &visible).map(Register)).collect();
            outputs.push(placed);
        }
        let everything = vec![true; segments.len() + 1];
        let places = (0..graph.len())
            .map(|index| placements.find(ExprId(register(index).0), &everything).unwrap_or(u32::MAX))
            .collect();
        let mut program = Self {
            symbols: registers,
            constants,
            first_constant,
            first_instruction,
            instructions: Vec::new(),
            runs: Vec::new(),
            ends: Vec::new(),
            outputs,
            tables: graph.tables().to_vec(),
            places,
        };
        program.arrange(&instructions, &ends);
        program
    }

    /// Takes the instructions, segment by segment, in an order in which like ones stand together.
    fn arrange(&mut self, instructions: &[(Code, Instruction)], ends: &[usize]) {
        let mut kinds: Vec<Code> = Vec::new();
        let kind_of = |kinds: &mut Vec<Code>, code: Code| match kinds.iter().position(|kind| *kind == code) {
            Some(kind) => kind,
            None => {
                kinds.push(code);
                kinds.len() - 1
            }
        };
        let of_each: Vec<usize> = instructions.iter().map(|(code, _)| kind_of(&mut kinds, *code)).collect();
        let first = self.first_instruction;
        // Of each instruction as it was listed its register.
        let mut registers = vec![0_u32; instructions.len()];
        let mut from = 0;
        for &end in ends {
            let arguments = |place: usize| {
                let (code, own) = instructions[from + place];
                let within = |argument: u32| (argument as usize).checked_sub(first + from);
                [within(own.a), if let Code::Binary(_) = code { within(own.b) } else { None }]
            };
            let order = schedule::order(end - from, |place| of_each[from + place], arguments);
            for (place, &old) in order.iter().enumerate() {
                registers[from + old] = register(first + from + place).0;
            }
            let moved = |argument: u32| match (argument as usize).checked_sub(first) {
                Some(place) => registers[place],
                None => argument,
            };
            for &old in &order {
                let (code, own) = instructions[from + old];
                let b = if let Code::Binary(_) = code { moved(own.b) } else { own.b };
                self.instructions.push(Instruction { a: moved(own.a), b });
                let (end, is_first) = (self.instructions.len(), self.instructions.len() == from + 1);
                match self.runs.last_mut() {
                    Some(run) if run.code == code && !is_first => run.end = end,
                    _ => self.runs.push(Run { code, end }),
                }
            }
            self.ends.push([self.instructions.len(), self.runs.len()]);
            from = end;
        }
        let moved = |argument: &mut u32| {
            if *argument != u32::MAX
                && let Some(place) = (*argument as usize).checked_sub(first)
            {
                *argument = registers[place];
            }
        };
        self.places.iter_mut().for_each(moved);
        self.outputs.iter_mut().flatten().for_each(|output| moved(&mut output.0));
    }

    /// Registers of a segment's outputs, in their order.
    pub fn outputs(&self, segment: usize) -> &[Register] {
        &self.outputs[segment]
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
        self.places.get(id.0 as usize).filter(|&&place| place != u32::MAX).map(|&place| Register(place))
    }

    /// Where a symbol's value is to be written; `None` if nothing depends on it and it was not listed.
    pub fn symbol(&self, symbol: Symbol) -> Option<Register> {
        self.symbols.get(&symbol).copied()
    }

    /// Number of instructions of a segment.
    pub fn cost(&self, segment: usize) -> usize {
        self.ends[segment][0] - self.start(segment)[0]
    }

    fn start(&self, segment: usize) -> [usize; 2] {
        if segment == 0 { [0; 2] } else { self.ends[segment - 1] }
    }

    /// Runs one segment on a file made by [`Program::registers`] of this program. Earlier segments must have run
    /// for the present symbols.
    pub fn run<V: Lanes>(&self, segment: usize, file: &mut [V]) {
        let [mut from, first_run] = self.start(segment);
        for run in &self.runs[first_run..self.ends[segment][1]] {
            let like = Like { first: self.first_instruction + from, instructions: &self.instructions[from..run.end] };
            // The common ones apart, so that the compiler sees a loop over the lanes without a branch.
            match run.code {
                Code::Binary(Binary::Add) => like.pairs(file, |x, y| x + y),
                Code::Binary(Binary::Subtract) => like.pairs(file, |x, y| x - y),
                Code::Binary(Binary::Multiply) => like.pairs(file, |x, y| x * y),
                Code::Binary(Binary::Divide) => like.pairs(file, |x, y| x / y),
                Code::Binary(other) => like.pairs(file, |x, y| apply_binary(other, x, y)),
                Code::Unary(Unary::Negate) => like.each(file, |_, x| -x),
                Code::Unary(Unary::Abs) => like.each(file, |_, x| x.abs()),
                Code::Unary(function) => like.each(file, |_, x| apply_unary(function, x)),
                Code::Interpolate => like.each(file, |table, x| self.tables[table as usize].value(x)),
                Code::Slope => like.each(file, |table, x| self.tables[table as usize].slope(x)),
            }
            from = run.end;
        }
    }
}

/// Like instructions and the register of the first.
struct Like<'a> {
    first: usize,
    instructions: &'a [Instruction],
}

impl Like<'_> {
    /// Runs a function of two arguments.
    #[inline]
    fn pairs<V: Lanes>(&self, file: &mut [V], function: impl Fn(f64, f64) -> f64) {
        for (position, instruction) in self.instructions.iter().enumerate() {
            // An instruction's arguments stand before it: symbols, constants, earlier instructions.
            let (before, rest) = file.split_at_mut(self.first + position);
            rest[0].become_zip(&before[instruction.a as usize], &before[instruction.b as usize], &function);
        }
    }

    /// Runs a function of one argument, given the instruction's table.
    #[inline]
    fn each<V: Lanes>(&self, file: &mut [V], function: impl Fn(u32, f64) -> f64) {
        for (position, instruction) in self.instructions.iter().enumerate() {
            let (before, rest) = file.split_at_mut(self.first + position);
            rest[0].become_map(&before[instruction.a as usize], |x| function(instruction.b, x));
        }
    }
}

fn register(index: usize) -> Register {
    Register(u32::try_from(index).unwrap_or(u32::MAX))
}
