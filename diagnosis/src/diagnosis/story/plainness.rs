//! Which laws are plainer than others, so that they go before them where they explain nearly as much.

use crate::diagnosis::Problem;
use crate::diagnosis::odds::logged_heat::{are_changes_by_inputs, are_of_unused_heat};
use crate::diagnosis::story::rules::{explains_as_much, explains_nearly_as_much};
use crate::effect::{Candidate, Effect};

/// Why a law is plainer than another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plainness {
    /// The other follows a heat that a control makes, which follows whatever is missing.
    FreeOfControl,
    /// It is heat that was logged, the other heat that goes by a clock, whose fitted time can follow any cause that changes then or
    /// comes again every day.
    Logged,
    /// It is heat that was logged, the other a change of a path or a load that follows the same power or irradiance: that this warms is
    /// likelier than that it changes anything.
    ChangeByHeat,
    /// The other takes several inputs.
    FewerInputs,
}

impl Plainness {
    /// Whether the plainer law is heat that was logged.
    pub(super) fn is_of_logged_heat(self) -> bool {
        matches!(self, Self::Logged | Self::ChangeByHeat)
    }

    /// Whether the plainer law explains so much of what the other does that it goes before it: errors without both, with it and with the
    /// other, on the fitted and on the unseen rows.
    pub(super) fn goes_before(self, fitted: [Option<f64>; 3], unseen: [Option<f64>; 3]) -> bool {
        match self {
            Self::FreeOfControl | Self::Logged | Self::ChangeByHeat => explains_nearly_as_much(fitted, unseen),
            Self::FewerInputs => explains_as_much(fitted, unseen),
        }
    }
}

/// What drives each candidate, where that makes it more or less plain than others.
#[derive(Clone, Debug, Default)]
pub(crate) struct Drivers {
    /// Whether it follows a heat that a control makes.
    pub control: Vec<bool>,
    /// Whether it is heat in proportion to a logged power or irradiance that the baseline model does not use, at whatever place.
    unused_heat: Vec<bool>,
    /// Whether it is heat that goes by a clock.
    clock: Vec<bool>,
    /// Whether it lets paths, or loads that no input drives, follow inputs.
    change_by_inputs: Vec<bool>,
}

impl Drivers {
    /// Of a problem, before any control is found.
    pub(super) fn of(problem: &Problem) -> Self {
        let is_one = |own: &Candidate| problem.catalogue.get(&own.effect).is_some_and(is_heat_by_clock);
        Self {
            control: vec![false; problem.candidates.len()],
            unused_heat: are_of_unused_heat(problem),
            clock: problem.candidates.iter().map(is_one).collect(),
            change_by_inputs: are_changes_by_inputs(problem),
        }
    }

    fn is(of: &[bool], effect: usize) -> bool {
        of.get(effect) == Some(&true)
    }

    /// Why an effect is plainer than another as heat that was logged.
    fn why_logged_heat_is_plainer(&self, problem: &Problem, own: usize, other: usize) -> Option<Plainness> {
        if !Self::is(&self.unused_heat, own) {
            return None;
        }
        let [own_inputs, inputs] = [own, other].map(|effect| &problem.candidates[effect].bound);
        let follows_it = || inputs.iter().all(|input| own_inputs.contains(input));
        let is_change = Self::is(&self.change_by_inputs, other) && follows_it();
        let by_clock = Self::is(&self.clock, other).then_some(Plainness::Logged);
        by_clock.or(is_change.then_some(Plainness::ChangeByHeat))
    }

    /// Whether an effect follows no heat that a control makes, and another one does.
    pub(super) fn only_other_follows_control(&self, own: usize, other: usize) -> bool {
        !Self::is(&self.control, own) && Self::is(&self.control, other)
    }

    /// Whether a law is plainer than another one, and why. A single place is not plainer than the whole surface of which it is a part, nor
    /// is heat at a single node plainer than a change of a whole group.
    pub(super) fn plainness(&self, problem: &Problem, own: usize, other: usize) -> Option<Plainness> {
        let [candidate, of_other] = [own, other].map(|effect| &problem.candidates[effect]);
        let is_part = of_other.is_group() && !candidate.is_group() && !of_other.is_elsewhere_than(candidate);
        if is_part || [own, other].into_iter().any(|effect| problem.is_unknown_function(effect)) {
            return None;
        }
        if self.only_other_follows_control(own, other) {
            return Some(Plainness::FreeOfControl);
        }
        if self.only_other_follows_control(other, own) {
            return None;
        }
        let has_fewer_inputs = candidate.bound.len() < 2 && of_other.bound.len() > 1;
        self.why_logged_heat_is_plainer(problem, own, other).or(has_fewer_inputs.then_some(Plainness::FewerInputs))
    }
}

/// Whether an effect adds heat that depends on when readings were taken.
fn is_heat_by_clock(effect: &Effect) -> bool {
    effect.form.adds.value.load.is_some() && effect.depends_on_time()
}
