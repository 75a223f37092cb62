//! Words by which results are judged, for `bmv explain WORD`: what each means and what follows from it.

/// A word of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResultWord {
    /// The word as screens and reports have it.
    pub word: &'static str,
    /// What it means.
    pub meaning: &'static str,
    /// What to do then.
    pub then: &'static str,
}

/// The words.
pub static RESULT_WORDS: &[ResultWord] = &[
    ResultWord {
        word: "adequate",
        meaning: "verdict of a diagnosis: tuned as far as its parameters allow, the model leaves no more than the noise of the sensors does, by tests at a family-wise level, or no effect is more probable than none.",
        then: "Nothing is to be adopted. It does not mean that nothing is missing: what the data cannot see is listed as unseen. Calibrate, and predict within what was tested.",
    },
    ResultWord {
        word: "identified",
        meaning: "verdict of a diagnosis: one set of effects explains the misfit, and no other set comes near it: what these data cannot tell from it has a probability below 0.09 together.",
        then: "`bmv adopt PASS` writes the next pass with it; with `--test-only` where it belongs to the test and not to flight.",
    },
    ResultWord {
        word: "ambiguous",
        meaning: "verdict of a diagnosis: a set of effects explains the misfit, but these data do not settle which. Sets that explain it about as well are named as rivals; an effect that all of them have is settled all the same, and called missing. So is what rivals are together, where they are laws of one thing: a loss of heat from a plate, say, whose law is open.",
        then: "Adopt what is settled by its name, `bmv adopt PASS ID`; for the rest run the phase that is named to tell the rivals apart, or choose by what you know of the hardware, by name.",
    },
    ResultWord {
        word: "unexplained",
        meaning: "verdict of a diagnosis: something is missing, and no set of effects of the catalogue explains it: `something else` has a probability above 0.5, or what the best set leaves is far from the noise.",
        then: "Look at the heat that is missing by node and phase, at the inputs it goes with, and at the readings themselves; write an effect of your own under `effects/` of the study where you suspect one. No prediction is to rest on the model as it is.",
    },
    ResultWord {
        word: "group",
        meaning: "effects that these data cannot tell apart: they predict the same in all readings, or explain the misfit about equally. Each is a rival of the others.",
        then: "Adopt one of a group, not two; the phase that the diagnosis names parts them, where one does.",
    },
    ResultWord {
        word: "rival",
        meaning: "an effect, or a set of effects, that explains the misfit about as well as the selected one.",
        then: "See `bmv explain group`.",
    },
    ResultWord {
        word: "settled",
        meaning: "an effect that every likely set has, whatever else stays open.",
        then: "It can be adopted alone, by its name.",
    },
    ResultWord {
        word: "unseen",
        meaning: "an effect that no size would show in these data, such as a heat capacity in steady phases.",
        then: "Nothing speaks for it or against it: measure what would show it, or write it under `adopt` if you know it.",
    },
    ResultWord {
        word: "untuned",
        meaning: "the model at the nominal values of its parameters: as delivered, or with adopted effects at their nominal sizes.",
        then: "Its error says how good the model was before the test; that of the tuned state how good it can be made.",
    },
    ResultWord {
        word: "tuned",
        meaning: "the model at the most probable values of its parameters, given the readings for fitting.",
        then: "Judge it by the readings held out, which it did not see.",
    },
    ResultWord {
        word: "held out",
        meaning: "readings that no fit sees, by which a fit is judged; `held_out` of a measurement.",
        then: "An error that falls on the fitted rows and rises on these is one of fitting noise.",
    },
    ResultWord {
        word: "converged",
        meaning: "the chains of a calibration agree (split R-hat below 1.01), have 400 effective draws of every unknown in the bulk and in the tails, and no trajectory diverged.",
        then: "Draws that did not converge support no claim: the result names the settings of the job that mend it.",
    },
    ResultWord {
        word: "Bayes factor",
        meaning: "how many times more probable the readings are with the effect than without it; its natural logarithm is stated, of which 3 is strong and 5 very strong.",
        then: "The probability beside it takes into account how many effects were tried.",
    },
    ResultWord {
        word: "Pareto k",
        meaning: "shape of the largest importance weights of an evidence: above 0.7 a few draws carry the estimate.",
        then: "Do not compare such an evidence; `\"sampler\": \"smc\"` gives it independently.",
    },
    ResultWord {
        word: "reduced chi-square",
        meaning: "sum of squares of the residuals in standard deviations of the noise, over readings less unknowns: near 1 the noise explains them, far above something is missing, far below the stated noise is too large.",
        then: "Correct `sigma` where it is not near what the sensors do; then ask `bmv diagnose`.",
    },
];

/// The word, whatever case and number it is written in.
pub fn result_word(word: &str) -> Option<&'static ResultWord> {
    let is_it = |own: &&ResultWord| {
        own.word.eq_ignore_ascii_case(word)
            || word.strip_suffix('s').is_some_and(|singular| own.word.eq_ignore_ascii_case(singular))
    };
    RESULT_WORDS.iter().find(is_it)
}
