//! Names of adopted effects: the place, then the effect, as in `baseplate-board conductive path`.

use crate::document::name::is_label;
use crate::job::findings::Finding;

/// A name for an effect that none of `taken` has; allowed by the rules for labels.
pub fn name(effect: &Finding, taken: &dyn Fn(&str) -> bool) -> String {
    let mut words = effect.effect.replace('-', " ");
    if matches!(effect.where_kind.as_str(), "sensor" | "sensors") {
        // The place is a sensor's name: `TC box bias`, not `TC box sensor bias`.
        words = words.strip_prefix("sensor ").map(str::to_owned).unwrap_or(words);
    }
    let mut name = format!("{} {words}", effect.place.join("-"));
    if let Some(input) = &effect.input {
        name.push_str(&format!(" ({input})"));
    }
    if !is_label(&name) {
        // Names of a place may be as long as a name can be.
        name = words;
    }
    let free = |name: &String| is_label(name) && !taken(name);
    if free(&name) {
        return name;
    }
    // There is a free one among the natural numbers.
    (2u64..).map(|number| format!("{name} {number}")).find(free).unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(effect: &str, place: &[&str], where_kind: &str, input: Option<&str>) -> Finding {
        Finding {
            effect: effect.into(),
            place: place.iter().map(|&name| name.into()).collect(),
            where_kind: where_kind.into(),
            input: input.map(str::to_owned),
            ..Finding::default()
        }
    }

    #[test]
    fn names_say_where_and_what_and_are_free() {
        let none = |_: &str| false;
        let path = finding("conductive-path", &["baseplate", "board"], "nodes", None);
        assert_eq!(name(&path, &none), "baseplate-board conductive path");
        assert_eq!(name(&finding("sensor-bias", &["TC box"], "sensor", None), &none), "TC box bias");
        assert_eq!(name(&finding("joule-heating", &["box"], "node", Some("i")), &none), "box joule heating (i)");
        let taken =
            |name: &str| ["baseplate-board conductive path", "baseplate-board conductive path 2"].contains(&name);
        assert_eq!(name(&path, &taken), "baseplate-board conductive path 3");
        let long = "n".repeat(100);
        assert_eq!(name(&finding("heat-load", &[&long], "node", None), &none), "heat load");
    }
}
