//! A specification before its components are understood.

use serde_json::Value;

use crate::error::DeckError;

use super::method::Method;

/// A component as the file has it.
#[derive(Debug)]
pub struct Entry<'a> {
    /// Its name, unique.
    pub name: &'a str,
    /// Name of its class.
    pub class_name: &'a str,
    /// The object.
    pub value: &'a Value,
    /// Line of its name.
    pub line: Option<usize>,
}

/// A parameter as the file has it.
#[derive(Debug)]
pub struct Fitted<'a> {
    /// Component that the file writes beside it; xija looks at the place in the list alone.
    pub component: &'a str,
    /// Name within the component.
    pub name: &'a str,
    /// Value in xija's unit.
    pub value: f64,
    /// Bounds of its fit.
    pub bounds: Option<[f64; 2]>,
    /// Whether the fit leaves it alone.
    pub is_frozen: bool,
}

/// A specification.
#[derive(Debug)]
pub struct Specification<'a> {
    /// Name of the file, for errors.
    pub file: &'a str,
    /// Name of the model.
    pub title: &'a str,
    /// Step in s.
    pub step_s: f64,
    /// Solver.
    pub method: Method,
    /// Components in order.
    pub entries: Vec<Entry<'a>>,
    /// Parameters in order.
    pub fitted: Vec<Fitted<'a>>,
    /// The whole document.
    pub document: &'a Value,
}

impl<'a> Specification<'a> {
    /// Reads the frame of a specification.
    ///
    /// # Errors
    /// Fields that are missing or of another type.
    pub fn read(file: &'a str, text: &str, document: &'a Value) -> Result<Self, Vec<DeckError>> {
        let mut errors = Vec::new();
        let list = |key: &str, errors: &mut Vec<DeckError>| -> &'a [Value] {
            document.get(key).and_then(Value::as_array).map(Vec::as_slice).unwrap_or_else(|| {
                errors
                    .push(DeckError::of(file, format!("the list `{key}` is missing: no model specification of xija")));
                &[]
            })
        };
        let (components, parameters) = (list("comps", &mut errors), list("pars", &mut errors));
        let mut entries: Vec<Entry<'a>> = Vec::new();
        let mut lines = Lines::new(text);
        let mut names = std::collections::HashSet::new();
        for (at, value) in components.iter().enumerate() {
            let field = |key: &str| value.get(key).and_then(Value::as_str).filter(|text| !text.is_empty());
            let (Some(name), Some(class_name)) = (field("name"), field("class_name")) else {
                let message = format!("component {} of `comps` has no `name` or no `class_name`; give both", at + 1);
                errors.push(DeckError::of(file, message));
                continue;
            };
            let line = lines.of(name);
            if !names.insert(name) {
                let message = format!("two components are called `{name}`; xija keeps the last alone: remove one");
                errors.push(DeckError { file: file.to_owned(), line, message });
                continue;
            }
            entries.push(Entry { name, class_name, value, line });
        }
        let mut fitted = Vec::new();
        for (at, value) in parameters.iter().enumerate() {
            let text = |key: &str| value.get(key).and_then(Value::as_str);
            let number = |key: &str| value.get(key).and_then(Value::as_f64);
            let (Some(component), Some(name), Some(nominal)) = (text("comp_name"), text("name"), number("val")) else {
                let message =
                    format!("parameter {} of `pars` needs texts `comp_name`, `name` and a number `val`", at + 1);
                errors.push(DeckError::of(file, message));
                continue;
            };
            let bounds = number("min").zip(number("max")).map(|(lower, upper)| [lower, upper]);
            let is_frozen = value.get("frozen").and_then(Value::as_bool).unwrap_or(false);
            fitted.push(Fitted { component, name, value: nominal, bounds, is_frozen });
        }
        let method = Method::read(document).unwrap_or_else(|message| {
            errors.push(DeckError::of(file, message));
            Method::Ordinary
        });
        let step_s =
            document.get("dt").map_or(Some(328.0), Value::as_f64).filter(|step| *step > 0.0).unwrap_or_else(|| {
                errors.push(DeckError::of(file, "`dt` must be a number above 0, the step in s; 328 is xija's default"));
                328.0
            });
        if !errors.is_empty() {
            return Err(errors);
        }
        let title = document.get("name").and_then(Value::as_str).unwrap_or(file);
        Ok(Self { file, title, step_s, method, entries, fitted, document })
    }
}

/// Lines of the names of components, which stand in the text's order: one pass for all.
struct Lines<'t> {
    rows: Vec<(usize, &'t str)>,
    next: usize,
    misses: usize,
}

impl<'t> Lines<'t> {
    /// Longer lines are not searched: a file in one line has no places that help.
    const LONGEST: usize = 1000;
    /// After so many names that do not stand in a line of their own, no others are looked for.
    const MOST_MISSES: usize = 20;

    fn new(text: &'t str) -> Self {
        let is_name = |row: &str| row.len() <= Self::LONGEST && row.contains("\"name\"");
        let rows = text.lines().enumerate().filter(|(_, row)| is_name(row)).map(|(at, row)| (at + 1, row));
        Self { rows: rows.collect(), next: 0, misses: 0 }
    }

    fn of(&mut self, name: &str) -> Option<usize> {
        if self.misses > Self::MOST_MISSES {
            return None;
        }
        let quoted = format!("\"{name}\"");
        let rest = self.rows.get(self.next..).unwrap_or_default();
        match rest.iter().position(|row| row.1.contains(&quoted)) {
            Some(at) => {
                self.next += at;
                rest.get(at).map(|row| row.0)
            }
            None => {
                self.misses += 1;
                None
            }
        }
    }
}
