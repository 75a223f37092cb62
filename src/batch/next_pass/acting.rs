//! Where adopted effects act: everywhere, or in some of the measurements and environments, which their entries then name.

use crate::document::{Diagnostics, code, suggest};
use crate::study::Pass;
use crate::study::resolve::belongs_to;
use crate::study::resolve::scope::unknown;

use super::Asked;

/// Names that a sentence lists.
const MOST_NAMES: usize = 8;

/// Where adopted effects act.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Acting {
    /// In every measurement and every environment, those of later passes too.
    #[default]
    Everywhere,
    /// In the measurements of the pass alone.
    InTests,
    /// In the measurements and environments of these names.
    In(Vec<String>),
}

impl Acting {
    /// What stands under `applies_to`; nothing where the effects act everywhere.
    ///
    /// # Errors
    /// A name that no measurement and no environment of the pass has.
    pub(super) fn names(&self, pass: &Pass, asked: &Asked) -> Result<Option<Vec<String>>, Diagnostics> {
        match self {
            Self::Everywhere => Ok(None),
            Self::InTests => Ok(Some(measurements(pass))),
            Self::In(names) => {
                let mut diagnostics = Diagnostics::new();
                let own = measurements(pass);
                let known = own.iter().chain(pass.environments.iter().map(|one| &one.name)).map(String::as_str);
                for name in names.iter().filter(|name| !known.clone().any(|own| own == name.as_str())) {
                    let what = ("measurement or environment", name.as_str());
                    unknown(&mut diagnostics, &code::UNKNOWN_NAME, what, &asked.command(), known.clone());
                }
                if diagnostics.has_errors() { Err(diagnostics) } else { Ok(Some(names.clone())) }
            }
        }
    }
}

/// The measurements of a pass as its files name them: parts of a transient are one.
fn measurements(pass: &Pass) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for measurement in &pass.measurements {
        if !names.iter().any(|whole| belongs_to(&measurement.name, whole)) {
            names.push(measurement.name.clone());
        }
    }
    names
}

/// Where effects that are adopted act, in a sentence, and what stands under `applies_to` where they belong to the test alone:
/// nothing where they act in no environment.
pub fn acts_in(pass: &Pass, acting: &Acting, is_one: bool) -> (String, Option<String>) {
    let tests = measurements(pass);
    let has = |name: &str| match acting {
        Acting::Everywhere => true,
        Acting::InTests => tests.iter().any(|own| own == name),
        Acting::In(names) => names.iter().any(|own| own == name),
    };
    let environments = || pass.environments.iter().map(|environment| environment.name.as_str());
    let listed = |what: &str, names: Vec<&str>| match names.as_slice() {
        [] => None,
        [_] => Some(format!("{what} {}", suggest::listed(names, MOST_NAMES))),
        _ => Some(format!("{what}s {}", suggest::listed(names, MOST_NAMES))),
    };
    let of_tests = listed("measurement", tests.iter().map(String::as_str).filter(|name| has(name)).collect());
    let of_flight = listed("environment", environments().filter(|name| has(name)).collect());
    let acts = if is_one { "it acts" } else { "they act" };
    let whole = match (&of_tests, &of_flight) {
        (Some(tests), Some(flight)) => format!("{acts} in {tests} and in {flight}"),
        (Some(only), None) | (None, Some(only)) => format!("{acts} in {only}"),
        (None, None) => format!("{acts} in no measurement and no environment of this pass"),
    };
    if *acting == Acting::Everywhere {
        let quoted: Vec<String> = tests.iter().map(|name| crate::document::canonical::quoted(name)).collect();
        (format!("{whole}, and in every prediction of later passes"), Some(format!("[{}]", quoted.join(", "))))
    } else {
        let left = listed("environment", environments().filter(|name| !has(name)).collect());
        let left =
            left.map_or_else(String::new, |names| format!("; {names} and predictions of later passes are without"));
        (format!("{whole} alone{left}"), None)
    }
}
