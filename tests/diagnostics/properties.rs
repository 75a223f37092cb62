//! What holds for any input: no panic, and exact places.

use bmv::document::canonical::{canonical, float};
use bmv::document::{Diagnostics, Source, json};
use bmv::expression::{Graph, Names, Scope, Symbol, Unit, parse};
use bmv::study::model;
use proptest::prelude::*;

/// A model with one of everything that the format has.
const WHOLE: &str = include_str!("whole.json");

#[test]
fn one_of_everything_loads() {
    let mut diagnostics = Diagnostics::new();
    let model = model::load("whole.json", WHOLE.as_bytes(), &mut diagnostics);
    assert!(diagnostics.is_empty(), "{}", diagnostics.render(false, 20));
    let model = model.expect("no error");
    assert_eq!(model.model.nodes.len(), 7);
    assert_eq!(model.model.elements.len(), 3 + 2 + 2 + 1 + 1 + 1 + 2);
    assert_eq!(model.model.quantities.len(), 11);
    assert_eq!(model.groups.len(), 5, "those of the file and those that it implies");
}

#[test]
#[ignore = "thorough"]
fn a_model_cut_off_anywhere_is_an_error() {
    let whole = WHOLE.trim_end();
    for length in 0..whole.len() {
        let mut diagnostics = Diagnostics::new();
        let model = model::load("cut.json", &whole.as_bytes()[..length], &mut diagnostics);
        assert!(model.is_none() && diagnostics.has_errors(), "cut at {length}");
        assert!(!diagnostics.plain().is_empty());
    }
}

/// One byte of the whole model replaced.
#[test]
fn a_changed_byte_never_panics() {
    let mut failed = 0;
    for (step, place) in (0..WHOLE.len()).step_by(3).enumerate() {
        let mut bytes = WHOLE.as_bytes().to_vec();
        bytes[place] = b"{}[]\",:\\\x00\xff-9eE(T"[step % 16];
        let mut diagnostics = Diagnostics::new();
        let model = model::load("changed.json", &bytes, &mut diagnostics);
        assert_eq!(model.is_none(), diagnostics.has_errors(), "byte {place}");
        failed += usize::from(model.is_none());
    }
    assert!(failed > WHOLE.len() / 6, "most changes are errors: {failed}");
}

/// Expression trees, to be printed with brackets and evaluated beside the parser.
#[derive(Clone, Debug)]
enum Tree {
    Number(f64),
    X,
    Negate(Box<Tree>),
    Abs(Box<Tree>),
    Pair(char, Box<Tree>, Box<Tree>),
}

impl Tree {
    /// The text with as few brackets as the grammar allows; `above` is the binding strength outside.
    fn print(&self, above: u8) -> String {
        let (text, own) = match self {
            Self::Number(n) => (format!("{n}"), 5),
            Self::X => ("x".to_owned(), 5),
            Self::Abs(a) => (format!("abs({})", a.print(0)), 5),
            Self::Negate(a) => (format!("-{}", a.print(3)), 3),
            Self::Pair(c @ ('+' | '-'), a, b) => (format!("{} {c} {}", a.print(1), b.print(2)), 1),
            Self::Pair(c, a, b) => (format!("{}{c}{}", a.print(2), b.print(3)), 2),
        };
        if own < above { format!("({text})") } else { text }
    }

    fn value(&self, x: f64) -> f64 {
        match self {
            Self::Number(n) => *n,
            Self::X => x,
            Self::Negate(a) => -a.value(x),
            Self::Abs(a) => a.value(x).abs(),
            Self::Pair('+', a, b) => a.value(x) + b.value(x),
            Self::Pair('-', a, b) => a.value(x) - b.value(x),
            Self::Pair(_, a, b) => a.value(x) * b.value(x),
        }
    }
}

fn trees() -> impl Strategy<Value = Tree> {
    let leaf = prop_oneof![(0.0..1e3f64).prop_map(Tree::Number), Just(Tree::X)];
    leaf.prop_recursive(6, 40, 2, |inner| {
        prop_oneof![
            inner.clone().prop_map(|a| Tree::Negate(Box::new(a))),
            inner.clone().prop_map(|a| Tree::Abs(Box::new(a))),
            (prop_oneof![Just('+'), Just('-'), Just('*')], inner.clone(), inner).prop_map(|(c, a, b)| Tree::Pair(
                c,
                Box::new(a),
                Box::new(b)
            )),
        ]
    })
}

fn values() -> impl Strategy<Value = serde_json::Value> {
    let leaf = prop_oneof![
        Just(serde_json::Value::Null),
        any::<bool>().prop_map(Into::into),
        any::<u64>().prop_map(Into::into),
        any::<i64>().prop_map(Into::into),
        any::<f64>().prop_filter("finite", |f| f.is_finite()).prop_map(Into::into),
        any::<String>().prop_map(Into::into),
    ];
    leaf.prop_recursive(4, 30, 5, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..5).prop_map(serde_json::Value::Array),
            prop::collection::hash_map(any::<String>(), inner, 0..5)
                .prop_map(|map| serde_json::Value::Object(map.into_iter().collect())),
        ]
    })
}

/// Equal as a study means it: numbers by value, so that 1 and 1.0 are one, and -0 is 0.
fn same(a: &serde_json::Value, b: &serde_json::Value) -> bool {
    use serde_json::Value::{Array, Number, Object};
    match (a, b) {
        (Number(x), Number(y)) => match (x.as_i128(), y.as_i128()) {
            (Some(x), Some(y)) => x == y,
            _ => x.as_f64() == y.as_f64(),
        },
        (Array(x), Array(y)) => x.len() == y.len() && x.iter().zip(y).all(|(x, y)| same(x, y)),
        (Object(x), Object(y)) => x.len() == y.len() && x.iter().all(|(key, x)| y.get(key).is_some_and(|y| same(x, y))),
        _ => a == b,
    }
}

proptest! {
    #[test]
    fn json_of_any_bytes_never_panics(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let mut diagnostics = Diagnostics::new();
        let node = json::parse_bytes("any", &bytes, &mut diagnostics);
        prop_assert!(node.is_some() || diagnostics.has_errors());
        diagnostics.render(false, 3);
    }

    #[test]
    fn json_of_likely_characters_never_panics(text in "[{}\\[\\]\",:'/*# \n\\\\a-eu0-9.+-]{0,60}") {
        let source = Source::new("any", text.as_str());
        let mut diagnostics = Diagnostics::new();
        let node = json::parse(&source, &mut diagnostics);
        // The independent judge of what is JSON.
        let valid = serde_json::from_str::<serde_json::Value>(&text);
        match (&valid, diagnostics.has_errors()) {
            (Ok(value), false) => prop_assert!(same(value, &node.expect("no error").to_json())),
            (Err(_), has) => prop_assert!(has, "{text:?} is no JSON"),
            // Valid JSON is refused for duplicate keys and for numbers beyond floats only.
            (Ok(_), true) => prop_assert!(diagnostics.plain().iter().all(|d| ["duplicate-key", "json-number-range"].contains(&d.code.as_str())), "{text:?}"),
        }
        diagnostics.render(true, 3);
    }

    #[test]
    fn json_reads_what_others_write(value in values()) {
        let source = Source::new("any", value.to_string());
        let mut diagnostics = Diagnostics::new();
        let node = json::parse(&source, &mut diagnostics).expect("valid");
        prop_assert!(diagnostics.is_empty());
        prop_assert!(same(&node.to_json(), &value));
    }

    #[test]
    fn the_canonical_text_reads_back_and_is_its_own(value in values()) {
        let text = canonical(&value).expect("finite");
        let back: serde_json::Value = serde_json::from_str(&text).expect("valid");
        prop_assert!(same(&value, &back), "{text}");
        prop_assert_eq!(canonical(&back).expect("finite"), text);
    }

    #[test]
    fn canonical_floats_keep_their_bits(value in any::<f64>()) {
        match float(value) {
            Ok(text) => prop_assert_eq!(text.parse::<f64>().expect("a number") + 0.0, value + 0.0),
            Err(_) => prop_assert!(!value.is_finite()),
        }
    }

    #[test]
    fn expressions_mean_what_they_say(tree in trees(), x in -1e3..1e3f64) {
        let text = tree.print(0);
        let mut graph = Graph::new();
        let mut names = Names::default();
        let symbol = graph.symbol(Symbol::Parameter(0));
        names.values.insert("x".to_owned(), symbol);
        let id = parse(&text, &mut graph, &Scope::new(&names)).map_err(|e| TestCaseError::fail(format!("{text}: {e}")))?;
        let (found, expected) = (graph.evaluate(id, &|_| x), tree.value(x));
        // The graph may write a - (-b) as a + b, which rounds alike: the values are equal, not merely near.
        prop_assert!(found == expected || (found - expected).abs() <= 1e-12 * expected.abs(), "{text}: {found} {expected}");
    }

    #[test]
    fn expressions_of_any_text_never_panic(text in "[-+*/^()., a-eT0-9'\"_=µ]{0,40}|\\PC{0,30}") {
        let mut graph = Graph::new();
        let names = Names::default();
        if let Err(error) = parse(&text, &mut graph, &Scope::new(&names)) {
            prop_assert!(error.start <= error.end && error.end <= text.len(), "{error:?}");
            prop_assert!(text.is_char_boundary(error.start) && text.is_char_boundary(error.end), "{error:?}");
        }
    }

    #[test]
    fn units_of_any_text_never_panic(text in "[-+*/^(). mkWKJsd0-9²°µC%]{0,24}|\\PC{0,20}") {
        match Unit::parse(&text) {
            Ok(unit) => prop_assert!(unit.factor.is_normal()),
            Err(error) => {
                prop_assert!(error.start <= error.end && error.end <= text.len(), "{error:?}");
                prop_assert!(text.is_char_boundary(error.start) && text.is_char_boundary(error.end), "{error:?}");
            }
        }
    }
}
