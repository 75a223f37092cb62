//! Clocks: what says when, for laws that depend on it.

/// What counts the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// The date, through all measurements of a pass.
    Date,
    /// The time since the start of each run.
    Elapsed,
}

impl Clock {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Date, Self::Elapsed];
}

/// The inputs of a model that are clocks. In a transient the time that has passed is added to their values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clocks {
    inputs: [Option<usize>; Clock::ALL.len()],
    /// Median time from one row of a transient to the next, s; 0 where there is no transient.
    pub rows_apart_s: f64,
}

impl Clocks {
    /// The input of a clock, where the model has it.
    pub fn get(&self, clock: Clock) -> Option<usize> {
        self.inputs[clock as usize]
    }

    /// Makes an input that of a clock.
    pub fn set(&mut self, clock: Clock, input: usize) {
        self.inputs[clock as usize] = Some(input);
    }

    /// Whether an input is a clock.
    pub fn has(&self, input: usize) -> bool {
        self.inputs.contains(&Some(input))
    }

    /// The first of these inputs.
    pub fn first(&self) -> Option<usize> {
        self.inputs.iter().flatten().min().copied()
    }
}
