//! `bmv effects`.

use std::path::PathBuf;

use serde_json::{Map, Value, json};

use super::Context;
use super::output::{escaped, folded, print, print_json, table};
use super::status::{Failure, Status};
use crate::document::suggest;
use crate::effect::place::TEMPERATURE_RANGE_K;
use crate::effect::{Effect, Like};

/// Arguments of `bmv effects`.
#[derive(Debug, clap::Args)]
pub(super) struct Effects {
    /// Name of an effect [default: list all]
    name: Option<String>,
    /// Folder of a study, whose own effects are shown with the others
    #[arg(long, value_name = "DIR")]
    study: Option<PathBuf>,
    /// Print the files as one JSON document
    #[arg(long)]
    json: bool,
}

/// Findings printed of a study's own effects.
const MOST_DIAGNOSTICS: usize = 20;

impl Effects {
    pub(super) fn execute(self, context: &Context) -> Result<Status, Failure> {
        let catalogue = crate::study::effects(self.study.as_deref())
            .map_err(|wrong| Failure::rendered(wrong.render(context.coloured, MOST_DIAGNOSTICS)))?;
        let Some(name) = self.name else {
            if self.json {
                print_json(&json!({"effects": catalogue.effects().iter().map(as_json).collect::<Vec<_>>()}))?;
            } else {
                print(&list(catalogue.effects(), context.fold))?;
            }
            return Ok(Status::Done);
        };
        let Some(effect) = catalogue.get(&name) else {
            let near = suggest::nearest(&name, catalogue.names());
            let hint = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
            return Err(Failure::input(format!("there is no effect `{}`{hint}", escaped(&name))));
        };
        if self.json {
            print_json(&as_json(effect))?;
        } else {
            print(&at_length(effect, context.fold))?;
        }
        Ok(Status::Done)
    }
}

/// An effect's file with its name.
fn as_json(effect: &Effect) -> Value {
    let mut object = Map::new();
    object.insert("name".to_owned(), json!(effect.name));
    object.extend(effect.json.as_object().into_iter().flatten().map(|(key, value)| (key.clone(), value.clone())));
    Value::Object(object)
}

/// One line an effect, by family.
fn list(effects: &[Effect], fold: Option<usize>) -> String {
    let mut families: Vec<&str> = effects.iter().map(|effect| effect.form.family.word()).collect();
    families.dedup();
    let mut seen = Vec::new();
    let mut rows = Vec::new();
    for family in families {
        if seen.contains(&family) {
            continue;
        }
        seen.push(family);
        rows.push(vec![format!("{family}:")]);
        for effect in effects.iter().filter(|effect| effect.form.family.word() == family) {
            rows.push(vec![format!("  {}", escaped(&effect.name)), places(effect), escaped(&effect.form.title)]);
        }
    }
    table(&rows, fold)
}

/// Where an effect applies.
fn places(effect: &Effect) -> String {
    let mut words: Vec<&str> = effect.places.iter().map(|place| place.word()).collect();
    if effect.groups {
        words.push("group");
    }
    words.join(", ")
}

fn at_length(effect: &Effect, fold: Option<usize>) -> String {
    let form = &effect.form;
    let mut text = format!("{}: {}\n", escaped(&effect.name), escaped(&form.title));
    if let Some(description) = &form.description {
        text.push_str(&format!("\n{}", folded("", &escaped(description), fold)));
    }
    text.push('\n');
    let mut row = |what: &str, value: String| {
        if !value.is_empty() {
            text.push_str(&folded(&format!("{what:<15} "), &escaped(&value), fold));
        }
    };
    let optional = |value: &Option<String>| value.clone().unwrap_or_default();
    row("equation", optional(&form.equation));
    row("applies to", places(effect));
    for entry in &form.inputs {
        let units = entry.value.unit.iter().flat_map(|units| &units.0).map(|unit| unit.unit.text.as_str());
        let units: Vec<&str> = units.collect();
        let units = if units.is_empty() { "any unit".to_owned() } else { units.join(" or ") };
        let what = entry.value.description.as_deref().unwrap_or_default();
        row("input", format!("{} [{units}] {what}", entry.name));
    }
    for entry in &form.parameters {
        let parameter = &entry.value;
        let mut unit = parameter.unit.as_ref().map_or("?", |written| written.unit.text.as_str()).to_owned();
        let like = effect.like(parameter);
        match like {
            Some(Like::OwnTemperature) => "K".clone_into(&mut unit),
            Some(Like::Input(input)) => {
                let name = form.inputs.names().nth(input).unwrap_or_default();
                unit = format!("unit of {name}");
            }
            None => {}
        }
        for input in &parameter.per {
            unit.push_str(&format!(" / unit of {}", input.value));
        }
        let role = if parameter.shape { "shape" } else { "amplitude" };
        let what = parameter.description.as_deref().unwrap_or_default();
        row(role, format!("{} [{unit}] {what}", entry.name));
        let prior = effect.json.pointer(&format!("/parameters/{}/prior", entry.name));
        let without = match like {
            Some(Like::OwnTemperature) => {
                let [lower, upper] = TEMPERATURE_RANGE_K;
                format!("uniform {lower} to {upper}, of the node's own temperature")
            }
            _ => "uniform over the input's range".to_owned(),
        };
        let prior = prior.map_or(without, in_words);
        row("  prior", format!("{prior}; sign {}", parameter.sign.word()));
    }
    if effect.needs_gas() {
        row(
            "needs",
            "a gas; improbable where a very cold boundary or a low pressure among the inputs tells of vacuum"
                .to_owned(),
        );
    }
    let seen: Vec<&str> = form.seen_by.iter().map(|by| by.word()).collect();
    row("seen by", seen.join(", "));
    row("signature", optional(&form.signature));
    let confused: Vec<&str> = form.confused_with.iter().map(|other| other.value.as_str()).collect();
    row("confused with", confused.join(", "));
    row("told apart by", optional(&form.separate));
    row("source", crate::document::source_text(&form.source, form.evidence));
    text
}

/// A prior such as `{"uniform": [0, 1]}` as `uniform 0 to 1`.
fn in_words(prior: &Value) -> String {
    let Some((kind, value)) = prior.as_object().and_then(|object| object.iter().next()) else {
        return prior.to_string();
    };
    let numbers = match value {
        Value::Array(items) => items.iter().map(Value::to_string).collect::<Vec<_>>().join(" to "),
        Value::Object(fields) => {
            fields.iter().map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", ")
        }
        other => other.to_string(),
    };
    format!("{kind} {numbers}")
}
