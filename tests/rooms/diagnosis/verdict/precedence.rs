//! Tests of `diagnosis/src/diagnosis/verdict/precedence.rs`.

use bmv::diagnosis::output::Precedence;
use bmv::diagnosis::verdict::precedence::*;

use crate::reports::diagnosis::output;

#[test]
fn that_a_rival_is_more_probable_is_said_in_a_sentence_with_the_reason() {
    let mut output = output("ambiguous");
    (output.effects[0].probability, output.effects[1].probability) = (0.088, 0.762);
    let said = |output: &bmv::diagnosis::Output| in_words(output, &output.effects[0]);
    assert_eq!(
        said(&output),
        " It goes first although radiative-path:baseplate:board (76.2 %) is more probable.",
        "no rule says why"
    );
    output.effects[0].precedence = Some(Precedence::HeldOut);
    assert_eq!(
        said(&output),
        " It goes first although radiative-path:baseplate:board (76.2 %) is more probable: held-out readings speak against the other."
    );
    (output.effects[2].group, output.effects[2].probability) = (Some(1), 0.1);
    let several = said(&output);
    assert!(several.contains("(76.2 %) and 1 more of its group are more probable: held-out"), "{several}");
    output.effects[0].probability = 0.8;
    assert_eq!(said(&output), "");
}

#[test]
fn errors_of_the_model_are_why_only_where_they_turn_the_order() {
    assert!(is_by_model_error([0.6, 0.4], [0.5, 0.1]));
    assert!(!is_by_model_error([0.3, 0.4], [0.5, 0.1]) && !is_by_model_error([0.6, 0.4], [0.1, 0.1]));
}
