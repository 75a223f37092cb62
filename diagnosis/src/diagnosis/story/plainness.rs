//! Which laws are plainer than others, so that they go before them where they explain nearly as much.

use crate::diagnosis::Problem;
use crate::diagnosis::odds::logged_heat::are_of_unused_heat;
use crate::diagnosis::odds::prior_odds::follows_what_warms;
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
    /// It is heat that was logged, the other a change of paths or loads that follows what warms, such as an irradiance.
    Added,
    /// The other takes several inputs.
    FewerInputs,
}

impl Plainness {
    /// Whether the plainer law explains so much of what the other does that it goes before it: errors without both, with it and with the
    /// other, on the fitted and on the unseen rows.
    pub(super) fn goes_before(self, fitted: [Option<f64>; 3], unseen: [Option<f64>; 3]) -> bool {
        match self {
            Self::FreeOfControl | Self::Logged | Self::Added => explains_nearly_as_much(fitted, unseen),
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
    /// Whether it changes paths or loads and follows nothing but what warms.
    change_by_heat: Vec<bool>,
}

impl Drivers {
    /// Of a problem, before any control is found.
    pub(super) fn of(problem: &Problem) -> Self {
        let is_one = |own: &Candidate| problem.catalogue.get(&own.effect).is_some_and(is_heat_by_clock);
        Self {
            control: vec![false; problem.candidates.len()],
            unused_heat: are_of_unused_heat(problem),
            clock: problem.candidates.iter().map(is_one).collect(),
            change_by_heat: (0..problem.candidates.len()).map(|effect| follows_what_warms(problem, effect)).collect(),
        }
    }

    fn is(of: &[bool], effect: usize) -> bool {
        of.get(effect) == Some(&true)
    }

    /// Why an effect that is heat that was logged is plainer than another.
    fn as_logged_heat(&self, own: usize, other: usize) -> Option<Plainness> {
        let reasons = [(&self.clock, Plainness::Logged), (&self.change_by_heat, Plainness::Added)];
        let own_is_logged = Self::is(&self.unused_heat, own);
        reasons.into_iter().find(|(of, _)| own_is_logged && Self::is(of, other)).map(|(_, why)| why)
    }

    /// Whether an effect follows no heat that a control makes, and another one does.
    pub(super) fn only_other_follows_control(&self, own: usize, other: usize) -> bool {
        !Self::is(&self.control, own) && Self::is(&self.control, other)
    }

    /// Whether a law is plainer than another one, and why. A single place is not plainer than the whole surface of which it is a part.
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
        self.as_logged_heat(own, other).or(has_fewer_inputs.then_some(Plainness::FewerInputs))
    }
}

/// Whether an effect adds heat that depends on when readings were taken.
fn is_heat_by_clock(effect: &Effect) -> bool {
    effect.form.adds.value.load.is_some() && effect.depends_on_time()
}
