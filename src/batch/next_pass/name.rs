//! Names of adopted effects: the place, then the effect, as in `baseplate-board conductive path`.

use crate::document::name::is_label;

/// A name for an effect at a place, with what its inputs stand for, that is not used yet; allowed by the rules for labels.
pub fn name(
    effect: &str,
    place: &[String],
    where_kind: &str,
    input: Option<&str>,
    is_used: &dyn Fn(&str) -> bool,
) -> String {
    let mut words = effect.replace('-', " ");
    if matches!(where_kind, "sensor" | "sensors") {
        // The place is a sensor's name: `TC box bias`, not `TC box sensor bias`.
        words = words.strip_prefix("sensor ").map(str::to_owned).unwrap_or(words);
    }
    let place = place.join("-");
    // `dissipation temperature dependence`, not `dissipation dissipation temperature`.
    if words.ends_with(" temperature") {
        words.push_str(" dependence");
    }
    let last = place.rsplit(' ').next().unwrap_or_default();
    let said = words.strip_prefix(last).and_then(|rest| rest.strip_prefix(' ')).unwrap_or(&words);
    let mut name = format!("{place} {said}");
    if let Some(input) = input {
        name.push_str(&format!(" ({input})"));
    }
    if !is_label(&name) {
        // Names of a place may be as long as a name can be.
        name = words;
    }
    let free = |name: &String| is_label(name) && !is_used(name);
    if free(&name) {
        return name;
    }
    // There is a free one among the natural numbers.
    (2u64..).map(|number| format!("{name} {number}")).find(free).unwrap_or(name)
}
