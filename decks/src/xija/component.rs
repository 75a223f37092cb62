//! A component whose class is known.

use super::arguments::Arguments;
use super::class::Class;
use super::specification::Entry;

/// A component with its arguments.
#[derive(Debug)]
pub struct Component<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its class.
    pub class: Class,
    /// Its arguments.
    pub arguments: Arguments<'a>,
    /// Line of its name.
    pub line: Option<usize>,
}

impl<'a> Component<'a> {
    /// A component of the file.
    ///
    /// # Errors
    /// A class that is not read; arguments that do not fit it.
    pub fn of(entry: &Entry<'a>) -> Result<Self, String> {
        let class = Class::of(entry.class_name).ok_or_else(|| {
            let names = Class::names().collect::<Vec<_>>().join(", ");
            format!("this class is not read; remove the component or express it by one of {names}")
        })?;
        let arguments = Arguments::of(class, entry.value)?;
        Ok(Self { name: entry.name, class, arguments, line: entry.line })
    }
}
