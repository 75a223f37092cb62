//! Codes of pass files, effects and measured data.

use super::codes;

codes! { PASS_CODES:
    PATH_REFUSED = "path-refused", "a path that leaves the study's folder",
        "What a study names lies inside its own folder, so that a study can be copied, hashed and run anywhere. Absolute paths, `..` and links that lead out are refused.",
        "wrong: \"file\": \"../test.csv\"\nright: \"file\": \"data/test.csv\"";
    FILE_MISSING = "file-missing", "a file that is not there or cannot be read",
        "A study names a model, a parent pass, a rule or a measurement whose file is not in its folder, or that the system does not let us read. A measurement that may not lie in the repository can be pinned by its hash.",
        "wrong: \"file\": \"data/tets.csv\"\nright: \"file\": \"data/test.csv\"";
    PARENT_CYCLE = "parent-cycle", "passes that are one another's parents",
        "A pass inherits from its parent, which inherits from its own, until one has `\"parent\": null`. A pass that is reached twice on this way has no beginning.",
        "wrong: pass-1.json with \"parent\": \"pass-2.json\" and pass-2.json with \"parent\": \"pass-1.json\"\nright: pass-1.json with \"parent\": null";
    BECAUSE_MISSING = "because-missing", "a change without a reason",
        "A changed parameter or prior, an adopted effect, a disabled sensor or phase needs a reason that a reviewer can read: `because` with at least a word in it. The report prints it.",
        "wrong: \"parameters\": {\"G\": {\"prior\": {\"uniform\": [0, 1]}}}\nright: \"parameters\": {\"G\": {\"prior\": {\"uniform\": [0, 1]}, \"because\": \"torque not recorded\"}}";
    UNKNOWN_EFFECT = "unknown-effect", "an effect that neither the catalogue nor the study has",
        "An adopted effect is named by its file: in the program's catalogue, which `bmv effects` lists, or in the study's own folder `effects`. The message names the nearest.",
        "wrong: \"effect\": {\"conduction-path\": {...}}\nright: \"effect\": {\"conductive-path\": {...}}";
    EFFECT_FILE = "effect-file", "an effect's file whose parts do not fit together",
        "An effect adds something that fits the kinds of place that it applies to: a `flow` two nodes, a `factor` a conductor, radiation, load, capacity or heater, a `reading` a sensor. Its amplitudes have a unit and a prior on the side of 0 that `sign` allows.",
        "wrong: \"applies\": {\"sensor\": {}}, \"adds\": {\"flow\": \"...\"}\nright: \"applies\": {\"pair\": {}}, \"adds\": {\"flow\": \"...\"}";
    EFFECT_PLACE = "effect-place", "a place that an adopted effect cannot act on",
        "`where` names what the effect acts on: two nodes for a pair, one node, boundary, conductor, radiation, load, heater, cooler or sensor, or {\"group\": NAME}. `bmv effects NAME` says which.",
        "wrong: {\"conductive-path\": {\"where\": \"board\"}}\nright: {\"conductive-path\": {\"where\": [\"board\", \"baseplate\"]}}";
    EFFECT_INPUT = "effect-input", "an input of an adopted effect that is not bound, or not rightly",
        "What an effect needs of the model beside its place, such as a pressure, is bound under `inputs` to one of the model's inputs, or to a node where a temperature is allowed. The units must fit.",
        "wrong: {\"gas-conduction\": {\"where\": [\"a\", \"b\"]}}\nright: {\"gas-conduction\": {\"where\": [\"a\", \"b\"], \"inputs\": {\"pressure\": \"P_ch\"}}}";
    EFFECT_PARAMETER = "effect-parameter", "a parameter of an adopted effect that does not fit",
        "An adopted effect has the parameters of its file. Their units must be of the same kind, and priors must lie on the side of 0 that the effect's `sign` allows: a conductance is never negative.",
        "wrong: {\"conductance\": {\"unit\": \"W/K\", \"prior\": {\"normal\": {\"mean\": 0, \"sd\": 1}}}}\nright: {\"conductance\": {\"unit\": \"W/K\", \"prior\": {\"halfnormal\": 0.1}}}";
    TABLE_CELL = "table-cell", "a cell that cannot be read",
        "A cell of measured data is a finite number with a decimal point, or empty for a missing reading. NaN, inf, texts and decimal commas are refused where a column is used; only readings of sensors may be missing.",
        "wrong: P01,NaN,20.5\nright: P01,,20.5";
    TABLE_SHAPE = "table-shape", "a table that is not rectangular",
        "Measured data are CSV: a line of headers, then a line a row with as many cells as headers. Another separator than the comma is declared with \"separator\" in the measurement.",
        "wrong: phase,a,b and then P01,1\nright: phase,a,b and then P01,1,2";
    TABLE_COLUMN = "table-column", "a column that is missing, ambiguous or has a wrong unit",
        "Headers are `NAME [unit]`, where NAME is an input's or a sensor's; steady data begin with `phase`, transient data with `time [s]`. Columns with other headers are declared under \"columns\".",
        "wrong: Temperature 1 (degC)\nright: T1 [degC], or \"columns\": {\"T1\": {\"header\": \"Temperature 1 (degC)\", \"unit\": \"degC\"}}";
    TABLE_EMPTY = "table-empty", "a measurement without rows or readings",
        "The file of a measurement, or the window of it that is asked for, holds no row, or no reading of any sensor. There is nothing to compare a model with.",
        "wrong: a file with headers only\nright: a row for each phase or instant";
    MEASUREMENT_FORM = "measurement-form", "a measurement whose parts do not fit together",
        "A steady measurement has either `file` or `windows` and holds out `phases`; a transient has `file`, `initial`, and holds out `intervals`. What names a phase, a sensor, a node or an input must name one that exists.",
        "wrong: \"transient\": {\"held_out\": {\"phases\": [\"P01\"]}}\nright: \"transient\": {\"held_out\": {\"intervals\": [{\"from\": {\"value\": 300, \"unit\": \"s\"}}]}}";
    INTERVAL = "interval", "an interval that is empty or holds no data",
        "An interval of time has an end after its beginning, and holds at least one row of the data; otherwise it does not do what its author believes.",
        "wrong: {\"from\": 600, \"to\": 300}\nright: {\"from\": 300, \"to\": 600}";
    INITIAL = "initial-temperatures", "start temperatures that are incomplete",
        "A transient starts from temperatures of all nodes that store heat (`\"all\"`, or node by node), from the steady state of the first row, or from the periodic state.",
        "wrong: \"initial\": {\"temperatures\": {\"board\": 290}}\nright: \"initial\": {\"temperatures\": {\"all\": 290, \"board\": 295}}";
    PINNED = "pinned-data", "measured data that are pinned by hash",
        "The file of this measurement does not lie in the repository: its SHA-256 does. `bmv data get STUDY` brings it from a folder (`--from`, or the one in BMV_DATA) or from its origin, and checks it. A file with another hash is not used.",
        "right: \"pinned\": {\"sha256\": \"10278cae...\", \"bytes\": 104948, \"origin\": \"https://...\", \"licence\": \"Apache-2.0\"}";
    REQUIREMENT = "requirement", "a requirement that cannot be judged",
        "A requirement has a quantity, at least one of `below` and `above` in that quantity's unit (above smaller than below), and a probability between 0 and 1.",
        "right: {\"quantity\": \"sdd\", \"below\": {\"value\": -30, \"unit\": \"degC\"}, \"probability\": 0.99}";
    JOB_SETTING = "job-setting", "a job's setting outside its range",
        "Every setting of a job has a default and a range. The message says which values are accepted; `{}` takes all defaults.",
        "wrong: {\"propagate\": {\"samples\": 0}}\nright: {\"propagate\": {\"samples\": 4096}}";
    JOB_REFERENCE = "job-reference", "a job that asks for what the pass does not have",
        "A job names measurements, quantities, environments, requirements, rules, criteria or other jobs. All must exist in this pass, inherited entries included; jobs themselves are not inherited.",
        "wrong: {\"compare\": {\"data\": [\"balence test\"]}}\nright: {\"compare\": {\"data\": [\"balance test\"]}}";
    SWEEP = "sweep", "a design variable without usable values",
        "A design variable is one parameter or input with a list of at least one value, or `from`, `to` and `steps`. Bare numbers are in the unit of the parameter or input.",
        "wrong: {\"A\": {\"from\": 0.3, \"to\": 0.3, \"steps\": 9}}\nright: {\"A\": {\"from\": 0.28, \"to\": 0.36, \"steps\": 9}}";
    DESIGN_CONDITIONS = "design-conditions", "conditions of an experiment that cannot be set",
        "A design of experiments varies inputs that a test can set, within their stated ranges: a grid with `from`, `to` and `steps` or a list of values for each, or a list of phases. Every candidate stands once.",
        "wrong: \"conditions\": {\"W\": {\"from\": 5, \"to\": 250, \"steps\": 5}} for a heater of 0 to 25 W\nright: \"conditions\": {\"W\": {\"from\": 5, \"to\": 25, \"steps\": 5}}";
    DESIGN_SENSOR = "design-sensor", "a sensor of an experiment that cannot be used",
        "What an experiment tells depends on the noise of its sensors: each has a `sigma`, from the pass's measurements or in the job, and stands once. Two sensors at one place have two names.",
        "wrong: \"sensors\": [\"housing\", \"housing\"]\nright: \"sensors\": {\"housing\": {\"measures\": \"housing\", \"sigma\": {\"value\": 0.25, \"unit\": \"K\"}}}";
    ROUNDED_SAMPLES = "samples-rounded", "a number of Sobol points that is no power of two",
        "Scrambled Sobol points are balanced only in blocks whose size is a power of two. The number of samples is rounded up to the next one.",
        "rounded: \"samples\": 5000 becomes 8192\nright: \"samples\": 8192";
    BARE_NUMBER = "bare-number", "a bare number where the unit matters",
        "A number without a unit is in SI here. Where the input or parameter itself is written in another unit, such as degC, this is easily mistaken.",
        "doubtful: \"T_if\": 30 (30 K)\nright: \"T_if\": {\"value\": 30, \"unit\": \"degC\"}";
    NAME_UNUSABLE = "name-unusable", "a name that stands for two things",
        "A sensor's column feeds a sensor and an input's column feeds an input; one name in the headers cannot mean both. A requirement may not be called `all`.",
        "wrong: a sensor `T_if` beside an input `T_if`\nright: a sensor `plate` that measures the interface";
    RULE_FILE = "rule-file", "a margin rule or criteria profile that is not complete",
        "A margin rule has one margin, `temperature` or `heat_load`, from 0; a profile of criteria has at least one limit above 0. Both name their source.",
        "right: {\"format\": \"bmv-rule/1\", \"title\": \"5 K\", \"margin\": {\"temperature\": {\"value\": 5, \"unit\": \"K\"}}, \"source\": \"...\"}";
    NOTHING_TO_REMOVE = "nothing-to-remove", "a removal of what no parent has",
        "In a pass, `null` in place of a named entry removes the entry that a parent pass has under this name. Where no parent has it, the name is probably misspelt, and the entry that was meant would stay.",
        "wrong: \"requirements\": {\"detektor\": null}\nright: \"requirements\": {\"detector\": null}";
    PRIOR_NOT_READ = "prior-not-read", "a prior from draws, which this version cannot use",
        "The prior is a posterior of an earlier pass or a file of draws. This version knows the form but cannot yet propagate or fit with it; running with anything else in its place would give the results of another study.",
        "wrong, with this version: {\"posterior\": {\"pass\": \"pass-1.json\", \"job\": \"tuned\"}}\nright: {\"normal\": {\"mean\": 0.4, \"sd\": 0.02}}";
}
