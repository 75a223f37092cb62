//! Laws that an unknown function may turn out to follow: each an effect file like those of a study.

use serde_json::{Value, json};

use super::checked::Effect;
use super::checked::KNOT;

/// An effect file that says a law.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LawFile {
    /// Name of the effect, and of its file without the ending.
    pub name: String,
    /// The law in a word or two.
    pub law: &'static str,
    /// The file's text.
    pub text: String,
    /// Whether it has the shape [`SCALE`].
    pub has_scale: bool,
}

/// A law of one variable.
pub struct Law {
    name: &'static str,
    words: &'static str,
    /// With `x` for the input, and `x_lower` and `x_upper` for its range.
    heat: &'static str,
    /// Amplitudes: name, power of the input by which its unit is divided, what it is.
    amplitudes: &'static [(&'static str, usize, &'static str)],
    /// What shapes it, besides a `threshold`: name, what it is.
    shapes: &'static [(&'static str, &'static str)],
    has_threshold: bool,
    of_angle: bool,
}

/// Name of the shape that stretches a law along its input.
pub const SCALE: &str = "scale";

const CONSTANT: (&str, usize, &str) = ("constant", 0, "the part that does not vary");

/// In the order in which they are tried.
pub const LAWS: &[Law] = &[
    Law {
        name: "linear",
        words: "straight line",
        heat: "constant + slope * (x - x_lower)",
        amplitudes: &[CONSTANT, ("slope", 1, "change of the heat with the input")],
        shapes: &[],
        has_threshold: false,
        of_angle: false,
    },
    Law {
        name: "square",
        words: "square",
        heat: "constant + coefficient * x^2",
        amplitudes: &[CONSTANT, ("coefficient", 2, "of the square")],
        shapes: &[],
        has_threshold: false,
        of_angle: false,
    },
    Law {
        name: "fourth-power",
        words: "fourth power",
        heat: "constant + coefficient * x^4",
        amplitudes: &[CONSTANT, ("coefficient", 4, "of the fourth power")],
        shapes: &[],
        has_threshold: false,
        of_angle: false,
    },
    Law {
        name: "exponential",
        words: "exponential",
        heat: "constant + size * exp((x - x_upper) / (scale * (x_upper - x_lower)))",
        amplitudes: &[CONSTANT, ("size", 0, "the growing part at the input's upper end")],
        shapes: &[(SCALE, "change of the input by which it grows to e times, as a share of the input's range")],
        has_threshold: false,
        of_angle: false,
    },
    Law {
        name: "saturating",
        words: "saturation",
        heat: "constant + size * (1 - exp((x_lower - x) / (scale * (x_upper - x_lower))))",
        amplitudes: &[CONSTANT, ("size", 0, "the rise from the input's lower end until it saturates")],
        shapes: &[(SCALE, "change of the input by which 63 % of the rise is there, as a share of the input's range")],
        has_threshold: false,
        of_angle: false,
    },
    Law {
        name: "step",
        words: "step",
        heat: "constant + size * smoothstep(threshold - 0.01 * (x_upper - x_lower), threshold + 0.01 * (x_upper - x_lower), x)",
        amplitudes: &[CONSTANT, ("size", 0, "the rise at the threshold")],
        shapes: &[],
        has_threshold: true,
        of_angle: false,
    },
    Law {
        name: "harmonic",
        words: "first harmonic of an angle",
        heat: "constant + cosine * cos(x) + sine * sin(x)",
        amplitudes: &[
            CONSTANT,
            ("cosine", 0, "the part that is largest at 0 deg"),
            ("sine", 0, "the part that is largest at 90 deg"),
        ],
        shapes: &[],
        has_threshold: false,
        of_angle: true,
    },
];

/// The heat with the effect's own name of its input in the place of `x`.
pub fn with_input(heat: &str, input: &str) -> String {
    let mut text = String::new();
    let mut word = String::new();
    let put = |word: &mut String, text: &mut String| {
        let renamed = match word.as_str() {
            "x" => input.to_owned(),
            "x_lower" | "x_upper" => format!("{input}{}", &word[1..]),
            _ => word.clone(),
        };
        text.push_str(&renamed);
        word.clear();
    };
    for letter in heat.chars() {
        if letter.is_ascii_alphanumeric() || letter == '_' {
            word.push(letter);
        } else {
            put(&mut word, &mut text);
            text.push(letter);
        }
    }
    put(&mut word, &mut text);
    text
}

/// The laws that an unknown function may follow, `of_angle` where its input is an angle; none for an effect that is no
/// unknown function. `of` names the curve for people.
pub fn laws(effect: &Effect, of_angle: bool, of: &str) -> Vec<LawFile> {
    let Some(curve) = &effect.form.adds.value.curve else { return Vec::new() };
    let Some(knot) = effect.json.pointer(&format!("/parameters/{KNOT}")).and_then(Value::as_object) else {
        return Vec::new();
    };
    let fitting = LAWS.iter().filter(|law| !law.of_angle || of_angle);
    let file = |law: &Law| {
        let input = &curve.of.value;
        let heat = with_input(law.heat, input);
        let load = curve.times.as_ref().map_or_else(|| heat.clone(), |times| format!("{} * ({heat})", times.value));
        let name = match &curve.times {
            None => format!("{}-load", law.name),
            Some(_) => format!("{}-product-load", law.name),
        };
        let mut parameters = serde_json::Map::new();
        for (amplitude, power, description) in law.amplitudes {
            let mut parameter = knot.clone();
            let before = knot.get("per").and_then(Value::as_array).cloned().unwrap_or_default();
            let per: Vec<Value> = before.into_iter().chain((0..*power).map(|_| json!(input))).collect();
            if !per.is_empty() {
                parameter.insert("per".to_owned(), Value::Array(per));
            }
            parameter.insert("description".to_owned(), json!(description));
            parameters.insert((*amplitude).to_owned(), Value::Object(parameter));
        }
        for (shape, description) in law.shapes {
            let form =
                json!({"unit": "1", "prior": {"loguniform": [0.05, 5]}, "shape": true, "description": description});
            parameters.insert((*shape).to_owned(), form);
        }
        if law.has_threshold {
            let form = json!({"unit_of": input, "shape": true, "description": "where it steps"});
            parameters.insert("threshold".to_owned(), form);
        }
        let fields = [
            ("format", json!(super::form::FORMAT)),
            ("title", json!(format!("{}: {}", effect.form.title, law.words))),
            ("family", json!("loads")),
            ("applies", effect.json.get("applies").cloned().unwrap_or_default()),
            ("inputs", effect.json.get("inputs").cloned().unwrap_or_default()),
            ("parameters", Value::Object(parameters)),
            ("adds", json!({ "load": load })),
            ("equation", json!(format!("Q = {load}"))),
            ("signature", effect.json.get("signature").cloned().unwrap_or_default()),
            ("confused_with", json!([effect.name])),
            ("separate", effect.json.get("separate").cloned().unwrap_or_default()),
            ("source", json!(format!("The curve that a diagnosis fitted to {of}"))),
            ("evidence", json!("definition")),
        ];
        let lines: Vec<String> = fields.iter().map(|(field, value)| format!("  \"{field}\": {value}")).collect();
        let has_scale = law.shapes.iter().any(|(shape, _)| *shape == SCALE);
        LawFile { name, law: law.words, text: format!("{{\n{}\n}}\n", lines.join(",\n")), has_scale }
    };
    fitting.map(file).collect()
}
