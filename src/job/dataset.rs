//! Labelled arrays in groups: what is handed to other programs, whatever the file is that it is written to.

use std::collections::BTreeSet;

/// A value that says something of a dataset, a group or a variable.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// A text.
    Text(String),
    /// A whole number.
    Whole(u64),
    /// Numbers.
    Numbers(Vec<f64>),
}

/// What the places along a dimension are called.
#[derive(Clone, Debug, PartialEq)]
pub enum Labels {
    /// Whole numbers.
    Places(Vec<u64>),
    /// Names.
    Names(Vec<String>),
}

impl Labels {
    /// Number of places.
    pub fn len(&self) -> usize {
        match self {
            Self::Places(places) => places.len(),
            Self::Names(names) => names.len(),
        }
    }

    /// Whether there is no place.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A place as text; empty beyond the end.
    pub fn text(&self, place: usize) -> String {
        match self {
            Self::Places(places) => places.get(place).map_or_else(String::new, u64::to_string),
            Self::Names(names) => names.get(place).cloned().unwrap_or_default(),
        }
    }
}

/// A dimension with its labels.
#[derive(Clone, Debug, PartialEq)]
pub struct Dimension {
    /// Name.
    pub name: &'static str,
    /// Labels.
    pub labels: Labels,
}

impl Dimension {
    /// A dimension of names.
    pub fn of_names(name: &'static str, names: Vec<String>) -> Self {
        Self { name, labels: Labels::Names(names) }
    }

    /// A dimension of every `step`th place of so many.
    pub fn of_places(name: &'static str, count: usize, step: usize) -> Self {
        Self { name, labels: Labels::Places((0..count as u64).step_by(step.max(1)).collect()) }
    }
}

/// The values of a variable, in row-major order.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numbers; NaN is missing.
    Numbers(Vec<f64>),
    /// Texts.
    Texts(Vec<String>),
}

/// An array over the rows of its group.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Name, unique in its group.
    pub name: String,
    /// What it is, for people.
    pub about: String,
    /// SI unit of numbers that have one.
    pub unit: Option<String>,
    /// The dimension after those of the rows, where there is one.
    pub across: Option<Dimension>,
    /// Values.
    pub values: Values,
}

/// Arrays that share their first dimensions.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Name.
    pub name: &'static str,
    /// Attributes.
    pub attributes: Vec<(&'static str, Attribute)>,
    /// The first dimensions of all variables.
    pub rows: Vec<Dimension>,
    /// Variables.
    pub variables: Vec<Variable>,
}

impl Group {
    /// A group without variables.
    pub fn new(name: &'static str, rows: Vec<Dimension>) -> Self {
        Self { name, attributes: Vec::new(), rows, variables: Vec::new() }
    }

    /// Adds an array of numbers.
    pub fn numbers(&mut self, name: &str, about: &str, unit: Option<String>, values: Vec<f64>) {
        self.add(name, about, unit, None, Values::Numbers(values));
    }

    /// Adds an array of texts.
    pub fn texts(&mut self, name: &str, about: &str, values: Vec<String>) {
        self.add(name, about, None, None, Values::Texts(values));
    }

    /// Adds an array of numbers with a further dimension.
    pub fn across(&mut self, name: &str, about: &str, across: Dimension, values: Vec<f64>) {
        self.add(name, about, None, Some(across), Values::Numbers(values));
    }

    /// Adds a variable. A name that a file cannot hold, or that is taken, is changed a little.
    fn add(&mut self, name: &str, about: &str, unit: Option<String>, across: Option<Dimension>, values: Values) {
        let plain: String = name.chars().map(|c| if c == '/' || c.is_control() { '_' } else { c }).collect();
        let plain = if plain.trim().is_empty() { "unnamed".to_owned() } else { plain.trim().to_owned() };
        let own = across.as_ref().map(|dimension| dimension.name);
        let dimensions = self.rows.iter().map(|dimension| dimension.name).chain(own);
        let taken: BTreeSet<&str> =
            self.variables.iter().map(|variable| variable.name.as_str()).chain(dimensions).collect();
        let mut free = plain.clone();
        while taken.contains(free.as_str()) {
            free.push('_');
        }
        self.variables.push(Variable { name: free, about: about.to_owned(), unit, across, values });
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.iter().map(|dimension| dimension.labels.len()).product()
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Groups of labelled arrays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dataset {
    /// What holds of all groups.
    pub attributes: Vec<(&'static str, Attribute)>,
    /// Groups; those without rows are left out.
    pub groups: Vec<Group>,
}

impl Dataset {
    /// Adds a group that has rows.
    pub fn add(&mut self, group: Group) {
        if !group.is_empty() {
            self.groups.push(group);
        }
    }
}
