//! SUBROUTINE blocks: what Thermal Desktop always writes, and has no physics in it, is passed over; others are refused.

use std::collections::BTreeSet;

use super::block::Block;
use crate::DeckError;

/// Routines around the solution; they do nothing unless a heater or the user has put something into them.
const EMPTY: [&str; 8] = ["TDHTR", "TDREL", "TDHTOT", "TDHTRST", "TDPREBL", "TDPOSTBL", "TDPOSTSL", "BASEPLOT"];
/// The routine that interpolates heating rates, whose data are read from their arrays.
const LOADQ: &str = "LOADQ_";

/// Beginnings of statements, without spaces, that print what heaters did.
const PRINTING: [&str; 9] =
    ["WRITE(", "CALLOUTLOG", "CALLHNQCAL", "CALLCOMMON", "CHARACTER*", "IF(ISBUILT(", "IF(T__TD.", "T__TD=", "O__TD="];
/// Counters of heaters, which may be set back.
const COUNTERS: [&str; 4] = ["CH", "HT", "OT", "TP"];

/// Whether a statement only prints or resets what heaters counted.
fn is_of_heaters(text: &str, handles: &BTreeSet<String>) -> bool {
    let plain: String = text.split_whitespace().collect();
    let resets = |handle: &String| COUNTERS.iter().any(|name| plain.starts_with(&format!("{name}{handle}=0")));
    !handles.is_empty()
        && (PRINTING.iter().any(|start| plain.starts_with(start))
            || plain.starts_with('+')
            || plain == "ENDIF"
            || handles.iter().any(resets))
}

/// Refuses every routine with something in it that would act on the network. `handles` are those of the heaters that were
/// read: what prints and counts of them is passed over.
pub(super) fn check(block: &Block<'_>, handles: &BTreeSet<String>, errors: &mut Vec<DeckError>) {
    let mut routine = String::new();
    for card in &block.cards {
        let text = card.text.to_ascii_uppercase();
        let mut words = text.split_whitespace().filter(|word| *word != "RECURSIVE");
        if words.next() == Some("SUBROUTINE") {
            routine = words.next().unwrap_or_default().split('(').next().unwrap_or_default().to_owned();
            if !EMPTY.contains(&routine.as_str()) && !routine.starts_with(LOADQ) {
                let message = format!("subroutine {routine}: Fortran is not read; write what it does as data");
                errors.push(DeckError::at(card.file, card.line, message));
            }
            continue;
        }
        let is_empty = matches!(text.as_str(), "RETURN" | "END" | "CALL COMMON") || is_of_heaters(&text, handles);
        if EMPTY.contains(&routine.as_str()) && !is_empty {
            let message = format!(
                "`{}` in {routine}: heaters and other logic are Fortran, which is not read; write a load instead and \
                 add the heater to the imported model",
                card.text
            );
            errors.push(DeckError::at(card.file, card.line, message));
            // One error is enough for a routine.
            routine.clear();
        }
    }
}
