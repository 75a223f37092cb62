//! Words of other thermal tools, and what stands for them here.

/// A word of another tool, such as ESATAN's or SINDA's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OtherWord {
    /// The word; letters of either case are the same.
    pub word: &'static str,
    /// What it means.
    pub meaning: &'static str,
    /// What to write.
    pub write: &'static str,
}

/// The words.
pub static OTHER_WORDS: &[OtherWord] = &[
    OtherWord {
        word: "GL",
        meaning: "a linear conductor, W/K",
        write: "`conductors`: {\"bolts\": {\"between\": [\"a\", \"b\"], \"conductance\": 0.8}}",
    },
    OtherWord {
        word: "GR",
        meaning: "a radiative conductor, m2, without sigma",
        write: "`radiations`: {\"to space\": {\"between\": [\"a\", \"b\"], \"exchange_area\": \"eps * 0.045\"}}",
    },
    OtherWord {
        word: "GF",
        meaning: "a one-way conductor of a fluid, W/K",
        write: "`flows`: {\"coolant\": {\"between\": [\"a\", \"b\"], \"heat\": \"m_dot_c * Ta\"}}",
    },
    OtherWord {
        word: "QI",
        meaning: "internal dissipation, W",
        write: "`loads`: {\"board\": {\"into\": \"a\", \"power\": \"Q_board\"}}",
    },
    OtherWord {
        word: "QR",
        meaning: "other heat, often of heaters, W",
        write: "`loads`: {\"heater\": {\"into\": \"a\", \"power\": 5}}, or `heaters` where a controller switches it",
    },
    OtherWord {
        word: "QS",
        meaning: "absorbed sunlight, W",
        write: "`loads`: {\"sun\": {\"into\": \"a\", \"power\": \"alpha * area * S\"}}",
    },
    OtherWord {
        word: "QA",
        meaning: "absorbed albedo, W",
        write: "`loads`: {\"albedo\": {\"into\": \"a\", \"power\": \"alpha * area * q_albedo\"}}",
    },
    OtherWord {
        word: "QE",
        meaning: "absorbed infrared of a planet, W",
        write: "`loads`: {\"planet\": {\"into\": \"a\", \"power\": \"eps * area * q_planet\"}}",
    },
    OtherWord {
        word: "D",
        meaning: "a diffusion node, which stores heat",
        write: "a node with `capacity`, J/K: {\"plate\": {\"capacity\": 900}}",
    },
    OtherWord {
        word: "A",
        meaning: "an arithmetic node, which stores none",
        write: "a node with neither `capacity` nor `boundary`: {\"mli\": {}}; an area is `area`",
    },
    OtherWord {
        word: "B",
        meaning: "a boundary node of given temperature",
        write: "a node with `boundary`, K: {\"shroud\": {\"boundary\": \"T_sh\"}}",
    },
    OtherWord { word: "C", meaning: "a heat capacity, J/K", write: "`capacity` of a node" },
    OtherWord {
        word: "T",
        meaning: "a node's temperature",
        write: "`boundary` of a node where it is given; a start temperature stands under `initial` of a transient measurement",
    },
    OtherWord {
        word: "MLI",
        meaning: "multi-layer insulation",
        write: "an arithmetic node for the outer layer, a radiation with the effective emittance to what it covers, and one with \
                the outer emittance to the surroundings: docs/guide.md",
    },
    OtherWord {
        word: "EPS",
        meaning: "an emittance",
        write: "a parameter, used in `exchange_area` of a radiation: \"eps * 0.045\"",
    },
    OtherWord {
        word: "ALP",
        meaning: "a solar absorptance",
        write: "a parameter, used in `power` of a load: \"alpha * area * S\"",
    },
];

/// Longer words that mean the same.
static SAME: &[(&str, &str)] = &[
    ("diffusion", "D"),
    ("arithmetic", "A"),
    ("boundary", "B"),
    ("T0", "T"),
    ("temperature", "T"),
    ("initial_temperature", "T"),
    ("emissivity", "EPS"),
    ("emittance", "EPS"),
    ("absorptance", "ALP"),
];

/// The entry of a word. Single letters are capitals.
pub fn other_word(word: &str) -> Option<&'static OtherWord> {
    let same = SAME.iter().find(|(long, _)| long.eq_ignore_ascii_case(word)).map_or(word, |(_, short)| *short);
    let is_meant = |own: &&OtherWord| own.word == same || own.word.len() > 1 && own.word.eq_ignore_ascii_case(same);
    OTHER_WORDS.iter().find(is_meant)
}

/// What a field of another tool stands for here; of a `type` or `kind` its value.
pub fn advice(field: &str, value: Option<&str>) -> Option<String> {
    let own = match value.filter(|_| ["type", "kind"].contains(&field)) {
        Some(kind) => other_word(kind),
        None => other_word(field),
    }?;
    Some(format!("{} ({}): write {}", own.word, own.meaning, own.write))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_either_case_and_capital_letters_are_known() {
        let meant = |word| other_word(word).map(|own| own.word);
        assert_eq!(
            [meant("gl"), meant("QI"), meant("qi"), meant("D")],
            [Some("GL"), Some("QI"), Some("QI"), Some("D")]
        );
        // The small letters are ends of a pair more often than nodes.
        assert_eq!([meant("a"), meant("b"), meant("wattage")], [None; 3]);
        assert_eq!(meant("Diffusion"), Some("D"));
        assert!(advice("type", Some("B")).is_some_and(|advice| advice.contains("`boundary`")));
        assert_eq!(advice("type", Some("other")), None);
    }
}
