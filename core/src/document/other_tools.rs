//! Words of other thermal tools and of other samplers, and what stands for them here.

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

/// Fields that different jobs, or different tools, call by different names, and who has them where the object that is read
/// has none of them.
static SAME_FIELD: &[(&[&str], &str)] = &[
    (
        &[
            "draws",
            "samples",
            "outer",
            "iterations",
            "n",
            "n_samples",
            "num_samples",
            "sample",
            "n_draws",
            "nsamples",
            "sample_size",
            "points",
            "particles",
        ],
        "`calibrate` has `draws`; `propagate`, `predict`, `goal`, `sensitivity` and `test-plan` have `samples`; `design` has `outer`",
    ),
    (
        &["warmup", "warm_up", "burn_in", "burnin", "burn", "tune", "adapt", "discard", "n_warmup", "num_warmup"],
        "`calibrate` has `warmup`",
    ),
    (&["chains", "n_chains", "num_chains", "walkers", "nwalkers", "islands"], "`calibrate` has `chains`"),
    (&["acceptance", "target_accept", "adapt_delta", "target_acceptance"], "`calibrate` has `acceptance`"),
    (
        &["sampler", "sampling", "methods", "estimator", "method", "algorithm", "scheme"],
        "`calibrate` has `sampler`, `propagate` and `predict` have `sampling`, `sensitivity` has `methods`, `design` has \
         `estimator`",
    ),
    (&["scrambles", "replicates", "bootstrap", "resamples", "repeats"], "`sensitivity` has `scrambles`"),
    (
        &["data", "measurements", "tests", "datasets"],
        "`compare`, `calibrate`, `diagnose` and `discrepancy` have `data`",
    ),
    (
        &["parameters", "learn", "unknowns", "variables", "free", "fit"],
        "`calibrate`, `diagnose` and `goal` have `parameters`; `design` has `learn`",
    ),
    (&["quantities", "outputs", "responses", "qoi"], "`propagate`, `predict` and `sensitivity` have `quantities`"),
    (
        &["environments", "environment", "cases", "scenarios"],
        "`propagate`, `predict`, `sensitivity`, `goal` and `conventional` have `environments`; `design` has `environment`",
    ),
    (&["from", "posterior", "calibration"], "`predict` and `compare` have `from`, the name of a `calibrate` job"),
    (&["effects", "candidates", "include"], "`diagnose` has `effects`"),
    (&["without", "exclude", "except", "skip"], "`diagnose` has `without`"),
    (&["false_alarm", "alpha", "significance", "p_value"], "`diagnose` has `false_alarm`"),
    (&["sigma", "std", "sd", "stdev", "uncertainty", "noise", "standard_deviation"], "a sensor has `sigma`"),
    (&["seed", "random_seed", "random_state"], "a pass has one `seed`, beside `jobs`"),
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
    let is_meant = |candidate: &&OtherWord| {
        candidate.word == same || candidate.word.len() > 1 && candidate.word.eq_ignore_ascii_case(same)
    };
    OTHER_WORDS.iter().find(is_meant)
}

/// What a field of another tool stands for here; of a `type` or `kind` its value.
pub fn advice(field: &str, value: Option<&str>) -> Option<String> {
    let entry = match value.filter(|_| ["type", "kind"].contains(&field)) {
        Some(kind) => other_word(kind),
        None => other_word(field),
    }?;
    Some(format!("{} ({}): write {}", entry.word, entry.meaning, entry.write))
}

/// A field's other names, and who has such a field.
fn same_fields(field: &str) -> Option<(&'static [&'static str], &'static str)> {
    SAME_FIELD.iter().find(|(words, _)| words.iter().any(|word| word.eq_ignore_ascii_case(field))).copied()
}

/// What an unknown field is called among the known ones of an object.
pub fn same_field(field: &str, field_names: &[&str]) -> Option<&'static str> {
    let (words, _) = same_fields(field)?;
    words.iter().copied().find(|word| field_names.contains(word))
}

/// Which jobs have a field like this one, and what it is called there.
pub fn who_has(field: &str) -> Option<&'static str> {
    same_fields(field).map(|(_, who)| who)
}
