//! The registry of diagnostics: every code with a long explanation and an example, for `bmv explain CODE`.

mod expression;
mod model;
mod pass;
mod syntax;

pub use expression::*;
pub use model::*;
pub use pass::*;
pub use syntax::*;

/// A kind of diagnostic.
#[derive(Debug, PartialEq, Eq)]
pub struct Code {
    /// Its name: `unknown-field`. Unique; it stays once released.
    pub name: &'static str,
    /// In half a sentence.
    pub title: &'static str,
    /// At length: what it means, why it is refused, what to do.
    pub explanation: &'static str,
    /// Wrong and right.
    pub example: &'static str,
}

/// Declares codes as constants, and the list of them.
macro_rules! codes {
    ($list:ident: $( $constant:ident = $name:literal, $title:literal, $explanation:literal, $example:literal; )*) => {
        $(
            #[doc = $title]
            pub static $constant: $crate::document::code::Code = $crate::document::code::Code {
                name: $name, title: $title, explanation: $explanation, example: $example,
            };
        )*
        /// The codes of this part of the registry.
        pub static $list: &[&$crate::document::code::Code] = &[$( &$constant ),*];
    };
}
pub(crate) use codes;

/// All codes, in the order of the registry.
pub fn all() -> impl Iterator<Item = &'static Code> {
    [SYNTAX_CODES, EXPRESSION_CODES, MODEL_CODES, PASS_CODES].into_iter().flatten().copied()
}

/// The code of a name.
pub fn find(name: &str) -> Option<&'static Code> {
    all().find(|code| code.name == name)
}
