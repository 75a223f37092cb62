//! The arguments of a component by their names.

use serde_json::Value;

use super::class::Class;

/// Arguments by name, from the list `init_args` and the object `init_kwargs`; `null` counts as absent.
#[derive(Debug)]
pub struct Arguments<'a>(Vec<(&'static str, &'a Value)>);

impl<'a> Arguments<'a> {
    /// Sorts the arguments of a class.
    ///
    /// # Errors
    /// Fields of another type; more arguments than the class has; a name that it does not have; one given twice.
    pub fn of(class: Class, component: &'a Value) -> Result<Self, String> {
        let empty = Value::Null;
        let field = |key: &str| component.get(key).filter(|value| **value != empty);
        let mut named: Vec<(&'static str, &'a Value)> = Vec::new();
        let mut names = class.arguments();
        if let Some(list) = field("init_args") {
            for value in list.as_array().ok_or("`init_args` is no list")? {
                named.push((names.next().ok_or("`init_args` has more entries than the class has arguments")?, value));
            }
        }
        if let Some(object) = field("init_kwargs") {
            for (key, value) in object.as_object().ok_or("`init_kwargs` is no object")? {
                let name = class.arguments().find(|name| name == key).ok_or_else(|| {
                    let all = class.arguments().collect::<Vec<_>>().join(", ");
                    format!("the class has no argument `{key}`; it has: {all}")
                })?;
                if named.iter().any(|row| row.0 == name) {
                    return Err(format!("the argument `{name}` is given twice"));
                }
                named.push((name, value));
            }
        }
        named.retain(|row| !row.1.is_null());
        Ok(Self(named))
    }

    fn value(&self, name: &str) -> Option<&'a Value> {
        self.0.iter().find(|row| row.0 == name).map(|row| row.1)
    }

    /// Whether it is given.
    pub fn has(&self, name: &str) -> bool {
        self.value(name).is_some()
    }

    /// A text.
    ///
    /// # Errors
    /// A value of another type.
    pub fn text(&self, name: &str) -> Result<Option<&'a str>, String> {
        self.value(name)
            .map(|value| value.as_str().ok_or_else(|| format!("the argument `{name}` is {value}; a text is expected")))
            .transpose()
    }

    /// A text that must be there.
    ///
    /// # Errors
    /// No such argument; a value of another type.
    pub fn required_text(&self, name: &str) -> Result<&'a str, String> {
        self.text(name)?.ok_or_else(|| format!("the argument `{name}` is missing"))
    }

    /// A number.
    ///
    /// # Errors
    /// A value of another type.
    pub fn number(&self, name: &str) -> Result<Option<f64>, String> {
        let wrong = |value: &Value| format!("the argument `{name}` is {}; a number is expected", brief(value));
        self.value(name).map(|value| value.as_f64().ok_or_else(|| wrong(value))).transpose()
    }

    /// A list of numbers.
    ///
    /// # Errors
    /// A value of another type.
    pub fn numbers(&self, name: &str) -> Result<Option<Vec<f64>>, String> {
        self.value(name).map(|value| list_of_numbers(name, value)).transpose()
    }

    /// How many numbers stand in each row of a list of lists.
    ///
    /// # Errors
    /// A value of another type.
    pub fn row_lengths(&self, name: &str) -> Result<Option<Vec<usize>>, String> {
        let rows = |value: &Value| -> Result<Vec<usize>, String> {
            let rows = value.as_array().ok_or_else(|| format!("the argument `{name}` is {}, no list", brief(value)))?;
            rows.iter().map(|row| list_of_numbers(name, row).map(|numbers| numbers.len())).collect()
        };
        self.value(name).map(rows).transpose()
    }

    /// A list of texts.
    ///
    /// # Errors
    /// A value of another type.
    pub fn texts(&self, name: &str) -> Result<Option<Vec<&'a str>>, String> {
        let wrong = |value: &Value| format!("the argument `{name}` is {}; a list of texts is expected", brief(value));
        let list = |value: &'a Value| -> Result<Vec<&'a str>, String> {
            let entries = value.as_array().ok_or_else(|| wrong(value))?;
            entries.iter().map(|entry| entry.as_str().ok_or_else(|| wrong(value))).collect()
        };
        self.value(name).map(list).transpose()
    }

    /// Whether a flag is set, and not to `false`.
    pub fn is_false(&self, name: &str) -> bool {
        self.value(name) == Some(&Value::Bool(false))
    }
}

fn list_of_numbers(name: &str, value: &Value) -> Result<Vec<f64>, String> {
    let wrong = || format!("the argument `{name}` is {}; a list of numbers is expected", brief(value));
    value.as_array().ok_or_else(wrong)?.iter().map(|entry| entry.as_f64().ok_or_else(wrong)).collect()
}

/// The start of a value's text.
fn brief(value: &Value) -> String {
    let text = value.to_string();
    if text.chars().count() <= 40 { text } else { format!("{}..", text.chars().take(40).collect::<String>()) }
}
