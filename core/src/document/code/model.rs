//! Codes of models.

use super::codes;

codes! { MODEL_CODES:
RESERVED_NAME = "reserved-name", "a parameter or input with a reserved name",
    "The names Ta, Tb, Tm, T, t, sigma, pi and those of functions have a fixed meaning in expressions, so no parameter or input may carry them.",
    "wrong: \"inputs\": {\"T\": ...}\nright: \"inputs\": {\"T_if\": ...}";
DUPLICATE_NAME = "duplicate-name", "a name that means two things",
    "Two things that are looked up by one name carry the same: a parameter and an input, a quantity and a node, a conductor and a radiation asked for by {\"heat\": NAME}. Rename one of them.",
    "wrong: \"parameters\": {\"Q\": ...}, \"inputs\": {\"Q\": ...}\nright: \"parameters\": {\"Q_leak\": ...}, \"inputs\": {\"Q\": ...}";
UNKNOWN_REFERENCE = "unknown-reference", "a name that nothing carries",
    "A node, element, quantity, sensor, parameter or job is named that does not exist. The message names the nearest that does. Names are compared exactly: case and blanks count.",
    "wrong: \"between\": [\"base plate\", \"interface\"] where the node is \"baseplate\"\nright: \"between\": [\"baseplate\", \"interface\"]";
SELF_LOOP = "self-loop", "an element with both ends at one node",
    "A conductor, radiation, flow or cooler joins two different nodes. With both ends at one node it would carry no heat, so one of the names is a slip.",
    "wrong: \"between\": [\"plate\", \"plate\"]\nright: \"between\": [\"plate\", \"lid\"]";
INVALID_PRIOR = "invalid-prior", "a prior that is no distribution",
    "The lower bound must lie below the upper, standard deviations above 0, the bounds of a loguniform and the median of a lognormal above 0, a lognormal's factor (exp of the logarithm's standard deviation) above 1, and a triangular prior in the order lower, most probable, upper.",
    "wrong: {\"uniform\": [1.2, 0.4]}\nright: {\"uniform\": [0.4, 1.2]}";
NOMINAL_OUTSIDE = "nominal-outside", "a nominal value outside its prior or range (warning)",
    "The value of the model as delivered is impossible under its own prior, or lies outside the stated range of the input. Often a unit is wrong: bare numbers of nominal, prior and range are all in the entry's own unit.",
    "suspicious: \"nominal\": 800, \"prior\": {\"uniform\": [0.4, 1.2]}\nfine: \"nominal\": 0.8, \"prior\": {\"uniform\": [0.4, 1.2]}";
FORBIDDEN_DEPENDENCE = "forbidden-dependence", "an expression that may not depend on temperatures",
    "Boundary temperatures, set points and numbers of couples must be known before the network is solved: they may depend on parameters, inputs and the time t, not on temperatures of nodes. A heat capacity may depend on its own node's T, but not on time.",
    "wrong: \"boundary\": \"T + 5\"\nright: \"boundary\": \"T_if + 5\"";
INVALID_TABLE = "invalid-table", "a table that is no function",
    "A table has as many x as y, at least one point, and strictly increasing x. Between the points it is linear, outside it keeps its end values.",
    "wrong: {\"x\": [300, 280], \"y\": [1, 2]}\nright: {\"x\": [280, 300], \"y\": [2, 1]}";
NESTED_OVER_TIME = "nested-over-time", "a quantity over time inside another",
    "A maximum, minimum or mean over a transient is one number for the whole run, so it cannot stand in an expression or difference that is evaluated at every instant. Put over_time outermost.",
    "wrong: {\"difference\": [{\"over_time\": {\"maximum\": \"sdd\"}}, \"sink\"]}\nright: {\"over_time\": {\"maximum\": {\"difference\": [\"sdd\", \"sink\"]}}}";
UNCONNECTED = "unconnected-node", "a node that nothing leads to",
    "No element touches the node, neither in the model nor by an effect that the pass adopts: nothing determines its temperature, in a steady state or otherwise. Often a name in `between` is another than was meant. A node with a given temperature needs no connection.",
    "wrong: \"nodes\": {\"plate\": {\"capacity\": 900}} without an element\nright: \"conductors\": {\"bolts\": {\"between\": [\"plate\", \"interface\"], \"conductance\": 0.5}}";
POSSIBLY_NEGATIVE = "possibly-negative", "a value that may have an impossible sign (warning)",
    "A conductance, exchange area or heat capacity is 0 or more. At the nominal values this one is, but where one parameter or input takes a value that its prior or range allows (of a prior without an end the outer 0.1 %), or at a temperature of a boundary, it is not. The model then moves heat uphill, or has no solution. Bound the prior or the range, or the expression by max(0, ...).",
    "suspicious: \"prior\": {\"normal\": {\"mean\": 0.1, \"sd\": 0.1}} of a conductance\nfine: \"prior\": {\"normal\": {\"mean\": 0.1, \"sd\": 0.1, \"lower\": 0}}";
EXTERNAL_MODEL = "external-model", "a model outside the program that cannot be used so",
    "A model under `command` or `umbridge` gives the outputs that it declares, for given parameters and inputs, in a steady state. So it has no nodes and elements beside it, takes no adopted effects and knows no transients. A `surrogate` stands beside one of them alone. A command's program and files lie in the study; a program of the machine is named alone (found on PATH) or by its absolute path, and then `version` stands for its bytes.",
    "wrong: \"run\": [\"../sim/run.sh\"]\nright: \"run\": [\"sim/run.sh\"] in the study, or \"run\": [\"python3\", \"sim.py\"], \"files\": [\"sim.py\"], \"version\": \"Python 3.12\"";
EMPTY_MODEL = "empty-model", "a model with nothing in it",
    "A model has nodes, or (without nodes) quantities as expressions of its parameters and inputs. This one has neither, so there is nothing to compute.",
    "right: \"quantities\": {\"y\": {\"expression\": {\"of\": \"a * x\", \"unit\": \"1\"}}}";
}
