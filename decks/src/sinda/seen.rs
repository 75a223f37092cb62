//! What a reader meets in lines and says of the deck as a whole.

use std::collections::BTreeSet;

use crate::Note;

/// Counts of what is changed or left out.
#[derive(Debug, Default)]
pub(super) struct Seen {
    /// Submodels to whose arrays something refers.
    pub(super) arrays: BTreeSet<String>,
    /// Conductors with the same node at both ends.
    pub(super) joined_to_themselves: usize,
    /// Conductors of 0.
    pub(super) zeros: usize,
    /// Temperatures that are absolute zero, rounded to below it.
    pub(super) rounded_zeros: usize,
    /// The place of the first conductor below 0, and how many there are.
    pub(super) negative: Option<(String, usize)>,
    /// Whether a value is given as a product of four.
    pub(super) has_products: bool,
}

impl Seen {
    /// What there is to say.
    pub(super) fn notes(&self) -> Vec<Note> {
        let mut notes = Vec::new();
        let mut note = |message: String| notes.push(Note::new(message));
        if self.joined_to_themselves > 0 {
            note(format!("{} conductors join a node to itself and are left out.", self.joined_to_themselves));
        }
        if self.zeros > 0 {
            note(format!("{} conductors of 0 carry no heat and are left out.", self.zeros));
        }
        if self.rounded_zeros > 0 {
            note(format!("{} temperatures just below absolute zero are read as 0 K.", self.rounded_zeros));
        }
        if let Some((first, count)) = &self.negative {
            note(format!(
                "{count} conductors have values below 0, as those of finite elements may; the first stands at {first}."
            ));
        }
        if self.has_products {
            note(
                "Four numbers X, Y, Z, W are the capacity X Y Z W of a node, and X Y Z / W of a conductor.".to_owned(),
            );
        }
        notes
    }
}
