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
    INPUT_MISSING = "input-missing", "a measurement that does not say what an input was",
        "A measurement gives the value of each input of the model: a column of its file, or a constant under \"inputs\" beside \"file\" or \"windows\". Where it says nothing the nominal value stands in, with a warning, because a shroud that was elsewhere makes errors of many kelvin in every phase. With \"test_sets\": true an input of the model must be said.",
        "silent: \"file\": \"data/balance.csv\" without a column T_sh\nright: \"file\": \"data/balance.csv\", \"inputs\": {\"T_sh\": {\"value\": 20, \"unit\": \"degC\"}}";
    INPUT_RANGE = "input-range", "a measured value of an input outside its stated range",
        "An input of the model states the range that it is used in. A value of a measurement outside of it is a warning; one that lies more than a full width of the range beyond an end is an error, since it is most often a wrong unit: 6000 where a heater of 0 to 12 W was logged in mW. An input without a stated range takes that of the data, and nothing is checked.",
        "wrong: a column `Q [W]` with 6000 where the range is [0, 12]\nright: the header `Q [mW]`, or a wider \"range\" in the model";
    START_APART = "start-apart", "a start apart from the first readings (warning)",
        "A transient starts at temperatures that its own first readings contradict: a node begins more than five standard deviations of its sensor from the sensor's first reading, and more than 2 % of the range of its readings (10 % where no sigma is stated). All that follows then shows the wrong start, and a calibration bends parameters to make up for it.",
        "suspicious: \"initial\": {\"temperatures\": {\"all\": {\"value\": 20, \"unit\": \"degC\"}}} where the first readings are 32 degC\nright: \"initial\": {\"measured\": {}}, or a start with a prior";
    START_ASSUMED = "start-assumed", "starts that are assumed and not fitted (warning)",
        "A transient that starts at its first readings has many nodes that store heat and have no reading. Up to 40 such starts are fitted, each about the temperature in balance with the readings; more would make every transient slow. They begin in balance then, and where they did not, the first hours show it. A spread that is stated fits them whatever their number.",
        "\"initial\": {\"measured\": {\"others_sd\": {\"value\": 5, \"unit\": \"K\"}}}";
    NOT_STABILISED = "not-stabilised", "a phase that drifts (warning)",
        "A phase cut from a log as a window is compared with a steady state, but a sensor's readings rise or fall in it: faster than the stabilisation of the criteria, and more surely than their scatter explains (Student's t about a parabola, with the correlation of neighbouring readings, at a level of 1 % a phase). The heat stored meanwhile is missing in the balance. Choose a later window, ignore the phase with a reason, or compare the log as a transient.",
        "\"windows\": {\"P03\": {\"file\": \"data/log.csv\", \"from\": {\"value\": 9, \"unit\": \"h\"}, \"to\": {\"value\": 10, \"unit\": \"h\"}}} instead of the first hour after a step";
    GAP = "gap", "a transient with a stretch without rows (warning)",
        "Between two rows a transient's inputs go straight from one value to the next, or stay where they are held. Over a stretch that is far longer than the usual distance of the rows nothing is known of them, and the model after it starts from a state that nobody measured.",
        "suspicious: rows every minute until 02:00 and again from 09:00\nright: two measurements, each with \"initial\": {\"measured\": {}}";
    OUTLYING = "outlying", "readings that stand out and are left out (warning)",
        "A diagnosis leaves out readings that are faults of the data: in a transient those that jump away from the rows about them and back, or show one value meanwhile; in steady phases a few that no effect explains while a set of effects explains all others. It says which.",
        "suspicious: a reading of 0 degC between 31.2 and 31.3\nright: an empty cell, or a phase that is ignored with a reason";
    TOGETHER = "together", "readings of several sensors that jump together and are kept (warning)",
        "Two sensors or more of a transient jump away from the rows about them in one direction at one time, and back. That is no fault of a sensor: the article did something, or something was done to it, and a diagnosis keeps these readings. Jumps of all channels by one offset, several channels that show one code, and long stretches of one value are faults of the logger, and are left out.",
        "suspicious: three layers of the ground 0.4, 0.3 and 0.1 K warmer in one row\nright: an input that says when meltwater came, or empty cells if it was the logger";
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
    DOCUMENT_FILE = "document-file", "a title block that is not complete",
        "A study's document.json has a title, a number, an issue and the day of issue, written year, month, day. Passes under `not_archived` are files of the study.",
        "wrong: \"date\": \"30.06.2026\"\nright: \"date\": \"2026-06-30\"";
    FIGURE = "figure", "a figure that cannot be drawn",
        "Figures of a study's own draw what is there: `readings` a sensor of a measurement of steady phases, against an input or another sensor; `contours` a quantity of a `propagate` or `predict` job over the design variable that it sweeps, inputs in which its environments differ, or other quantities of the job. An estimate of others names its source.",
        "wrong: {\"readings\": {\"data\": \"balance\", \"of\": \"plate\", \"against\": \"colour\"}}\nright: {\"readings\": {\"data\": \"balance\", \"of\": \"plate\", \"against\": \"T_sink\"}}";
    NOTHING_TO_REMOVE = "nothing-to-remove", "a removal of what no parent has",
        "In a pass, `null` in place of a named entry removes the entry that a parent pass has under this name. Where no parent has it, the name is probably misspelt, and the entry that was meant would stay.",
        "wrong: \"requirements\": {\"detektor\": null}\nright: \"requirements\": {\"detector\": null}";
    ADOPT_UNKNOWN = "adopt-unknown", "an effect that a diagnosis does not have, or that is not unique",
        "`bmv adopt` names effects as `effects` of `bmv diagnose --json` does, effect and place joined by colons. The name of the effect alone, or the beginning of an id, is enough where it stands for one: first among those that the diagnosis selected, then among those that it supports.",
        "wrong: bmv adopt pass-1.json conduction:board\nright: bmv adopt pass-1.json conductive-path:baseplate:board";
    ADOPT_REFUSED = "adopt-refused", "an effect that the diagnosis does not support",
        "An effect is adopted where the diagnosis selected it, or where these data cannot tell it from one that is selected; of an ambiguous diagnosis it must be named, since the data leave the choice open; rivals of one group are not adopted together. What else explains noise: the fit improves and the prediction does not. An engineer who knows better says so with --force, and the reason in the new pass says that it was against the diagnosis.",
        "refused: bmv adopt pass-1.json heat-load:housing, verdict `adequate`\nagainst the diagnosis: bmv adopt pass-1.json heat-load:housing --force";
    ADOPT_AMBIGUOUS = "adopt-ambiguous", "an effect that the data do not settle (warning)",
        "Several sets of effects explain the misfit, and the diagnosis says how probable each is. What is adopted is then a choice of yours, which the data leave open: it is taken where it is named, or with --force, and the warning names its probability, its rivals and the phase that would part them, where there is one.",
        "refused: bmv adopt pass-1.json, verdict `ambiguous`\nwith a warning: bmv adopt pass-1.json heat-load:housing";
    ADOPT_FILE = "adopt-file", "a file into which no next pass can be written",
        "A next pass names its parent by its file, so it lies in the same folder, and its name ends with `.json`. A file that is there is replaced only if `--out` names it and `--force` is given; a pass is never written over itself, its parents or its model.",
        "wrong: --out elsewhere/pass-2.json\nright: --out studies/bench/pass-2.json";
    PRIOR_NOT_READ = "prior-not-read", "draws where they cannot be a prior",
        "A posterior of an earlier calibration, or a file of draws, can be the prior of a parameter. What is inferred of the data beside the parameters (a sensor's noise, bias or lag, a start temperature, an input's bias) belongs to one measurement, and takes a distribution.",
        "wrong: \"sigma\": {\"prior\": {\"posterior\": {\"pass\": \"pass-1.json\", \"job\": \"tuned\"}}}\nright: \"sigma\": {\"prior\": {\"lognormal\": {\"median\": 0.2, \"factor\": 1.5}}, \"unit\": \"K\"}";
    TOO_LONG_CHAIN = "chain-length", "a chain of passes that is too long",
        "A pass has at most 100 parents, one behind the other, and at most 50 passes hand their posteriors on, one to the next. A longer chain is hardly meant, and reading each pass with all that stands behind it would take ever longer.",
        "wrong: \"parent\": \"pass-101.json\" in pass-102.json, and so on down to pass-1.json\nright: \"parent\": null, with the entries that are still needed";
    POSTERIOR = "posterior-prior", "a posterior that cannot be taken from where it is asked for",
        "A posterior is handed on by the file of a pass and the name of a `calibrate` job in it that inferred the parameter. A pass takes no posterior of its own, nor one that is built upon its own: such priors would contain the data that they are confronted with.",
        "wrong: {\"posterior\": {\"pass\": \"pass-1.json\", \"job\": \"delivered\"}}, a comparison\nright: {\"posterior\": {\"pass\": \"pass-1.json\", \"job\": \"tuned\"}}, a calibration";
    DRAWS_FILE = "draws-file", "a file of draws that cannot be used",
        "A file of draws is a CSV with a column for each parameter that takes its prior from it, headed by the parameter's name and perhaps its unit, `G_h [W/K]`, and a line a draw. The draws of a line belong together; at least two lines are needed.",
        "right: Gh [W/K],Gb [W/K] and then 0.383,0.359 and so on";
    DATA_USED_TWICE = "data-used-twice", "data that already stand behind the prior",
        "A posterior that is used as a prior contains what its calibration learned from its readings. Fitting the same readings again counts them twice: the result looks more certain than the data allow. Rows that were held out then may be used now; to use the same rows, go back to the original priors and calibrate on all data at once.",
        "wrong: a prior from `tuned` of `pass-1.json`, and `calibrate` on the phases that `tuned` had\nright: \"held_out\" for those phases, or the parameter's original prior";
    JOB_REFUSED = "job-refused", "a job that cannot be made from its definition",
        "Each setting of the job is right by itself, and yet nothing can be computed: a network without a path to a boundary, nothing to infer, no reading that is fitted, a prior that the job cannot take, a job that it builds on and that cannot be made. The other jobs of the pass run; at the end the exit status is 2, and the report says which job has no result.",
        "wrong: {\"sensitivity\": {}} where a parameter has a posterior as its prior\nright: the parameter's original prior, or {\"propagate\": {}}";
    NO_SIGMA = "no-sigma", "a sensor without noise in a calibration",
        "How closely a model must follow a reading is decided by the noise of its sensor. A comparison works without it, a calibration does not: it needs the standard deviation as a value, or a prior under which it is inferred.",
        "wrong: \"panel\": {\"measures\": \"panel\"}\nright: \"panel\": {\"measures\": \"panel\", \"sigma\": {\"value\": 0.25, \"unit\": \"K\"}}";
    NO_ABSOLUTE_ERROR = "no-absolute-error", "a logged sensor whose only error is noise (warning)",
        "`sigma` is the noise of a reading, independent from row to row: over many rows it averages out. A thermometer also has an error that stays: that of its calibration or its type, of where it sits and of the gradient under it. That is `bias`, a value or a prior about 0. Without one, a calibration on a long log knows each temperature to hundredths of a kelvin, which no thermocouple does, and what is fitted and predicted is far too certain. In steady phases `sigma` stands for all of it.",
        "wrong: \"panel\": {\"measures\": \"panel\", \"sigma\": {\"value\": 0.1, \"unit\": \"K\"}}\nright: \"panel\": {\"measures\": \"panel\", \"sigma\": {\"value\": 0.1, \"unit\": \"K\"}, \"bias\": {\"prior\": {\"normal\": {\"mean\": 0, \"sd\": 0.75}}, \"unit\": \"K\"}}";
    DISCREPANCY = "discrepancy", "a discrepancy that its data do not allow",
        "A `discrepancy` job takes what a calibration leaves unexplained in steady phases, sensor by sensor, as a function of inputs. A sensor needs five readings in phases that are fitted, a Gaussian process five phases with different inputs; phases with the same inputs count as repetitions. The residuals are those after a `calibrate` job, of this pass or another, which `from` names.",
        "wrong: {\"discrepancy\": {\"mode\": \"joint\"}}\nright: {\"discrepancy\": {\"from\": \"tuned\", \"inputs\": [\"V\", \"T_if\"]}}";
    PREDICTION = "prediction", "a prediction that has nothing to predict with",
        "A `predict` job carries the posterior of a `calibrate` job, of this pass or of another, to environments. `from` names it: a job of this pass, or {\"pass\": ..., \"job\": ...}. Where the pass has one calibration, that is taken.",
        "right: {\"predict\": {\"from\": {\"pass\": \"pass-3.json\", \"job\": \"relaxed\"}}}";
}
