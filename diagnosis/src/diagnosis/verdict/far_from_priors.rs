//! Parameters of the model that a fit leads far from their priors or to an end of one: the prior is wrong, or the parameter stands for
//! what is missing.

use crate::diagnosis::fits::other_noise::scale;
use crate::diagnosis::verdict::numbers::{joined, short, stated};
use crate::diagnosis::{Problem, Refit};
use crate::effect::Site;
use crate::expression::Unit;
use crate::math::sort::sort_by;
use crate::thermal::Parameter;

/// Standard deviations of a prior from which a fitted value is far from it: one in 30,000 lies there.
const FAR: f64 = 4.0;
/// Most parameters that are named, the farthest first.
const MOST: usize = 3;

/// The parameters of the model that a fit leads far from their priors; nothing where there are none.
pub fn in_words(problem: &Problem, refit: &Refit) -> Option<String> {
    let known = refit.by_name();
    let own = |&index: &usize| {
        let parameter = problem.model.parameters.get(index)?;
        let (value, prior) = (*known.get(&parameter.name)?, problem.priors.get(index)?);
        let (away, sd) = scale(prior, value);
        (away.abs() >= FAR && sd > 0.0).then(|| (away, parameter, value, prior.quantile(0.5)))
    };
    let is_asked = |index: &&usize| {
        let priors = refit.effects.iter().map(|&effect| &problem.candidates[effect].site);
        !priors.into_iter().any(|site| matches!(site, Site::Parameter(own) if own == *index))
    };
    let mut far: Vec<_> = problem.parameters.iter().filter(is_asked).filter_map(own).collect();
    sort_by(&mut far, |a, b| b.0.abs().total_cmp(&a.0.abs()).then(a.1.name.cmp(&b.1.name)));
    let one = |(away, parameter, value, median): &(f64, &Parameter, f64, f64)| {
        let (number, unit) = shown(parameter, *median);
        format!(
            "`{}` to {}{unit}, {} standard deviations from {}",
            parameter.name,
            number(*value),
            short(away.abs(), 2),
            number(*median)
        )
    };
    let named: Vec<String> = far.iter().take(MOST).map(one).collect();
    let or = match named.len() {
        0 => return None,
        1 => "the median of its prior: that prior is wrong, or the parameter stands",
        _ => "the medians of their priors: these priors are wrong, or the parameters stand",
    };
    let fit =
        if refit.effects.is_empty() { "The fit of the baseline model" } else { "Beside what is selected the fit" };
    Some(format!("{fit} leads {}, {or} for something that is missing.", joined(&named)))
}

/// How values of a parameter are written that are about as large as this one, SI, and their unit.
fn shown(parameter: &Parameter, size: f64) -> (impl Fn(f64) -> String, String) {
    let unit = Unit::parse(&parameter.unit).ok();
    let own = move |si: f64| unit.as_ref().map_or(si, |unit| unit.from_si(si));
    let (times, unit) = stated(&parameter.unit, own(size).abs());
    (move |si: f64| short(own(si) * times, 3), unit)
}

/// Which end of its prior a fit presses a parameter of this name against, as in `the upper end of its prior, 2 W/K`.
pub fn end_of_prior(problem: &Problem, refit: &Refit, name: &str) -> String {
    let known = || {
        let index = problem.model.parameters.iter().position(|parameter| parameter.name == name)?;
        let (value, prior) = (*refit.by_name().get(name)?, problem.priors.get(index)?);
        let (low, high) = prior.support();
        let (end, which) = if (high - value).abs() < (value - low).abs() { (high, "upper") } else { (low, "lower") };
        let (number, unit) = shown(problem.model.parameters.get(index)?, end);
        end.is_finite().then(|| format!("the {which} end of its prior, {}{unit}", number(end)))
    };
    known().unwrap_or_else(|| "an end of its prior".to_owned())
}
