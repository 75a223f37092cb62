//! Codes of expressions, units and quantities.

use super::codes;

codes! { EXPRESSION_CODES:
EXPRESSION_SYNTAX = "expression-syntax", "an expression that does not parse",
    "Expressions know + - * / ^ ( ), numbers, functions, pi, sigma (Stefan-Boltzmann), t (time in s), parameters and inputs by name, and inside an element its temperatures Ta, Tb, Tm or T. Multiplication is always written out: 2 * G, not 2 G.",
    "wrong: \"eps_r 0.045\"\nright: \"eps_r * 0.045\"";
UNKNOWN_NAME = "unknown-name", "an expression uses a name that does not exist",
    "A name in an expression is neither a parameter nor an input of the model, nor a temperature of the element at hand. Conductors, radiations and flows know Ta and Tb (kelvin, in the order of \"between\") and Tm = (Ta + Tb) / 2; loads and capacities know T.",
    "wrong: \"conductance\": \"Gbi\" where the parameter is G_bi\nright: \"conductance\": \"G_bi\"";
EXPRESSION_ARGUMENTS = "expression-arguments", "a function with the wrong number of arguments",
    "exp, log, sqrt, sin, cos, tanh, abs and step take one argument; smoothstep one (the ramp from 0 to 1) or three (lower edge, upper edge, x); clamp three (x, lower, upper); min and max two or more; interp a table's name and x.",
    "wrong: clamp(x, 1)\nright: clamp(x, 0, 1)";
EXPRESSION_DEPTH = "expression-depth", "an expression that is too long or too deep",
    "Expressions are limited to 20000 bytes, 1000 operations and 64 levels of brackets, so that a hostile file cannot exhaust the stack. Split it with parameters, or put a curve into a table.",
    "\"interp(louver, T)\" instead of a polynomial of a hundred terms";
UNDEFINED_VALUE = "undefined-value", "an expression without a value",
    "A part of the expression that holds no name is already undefined: a division by zero, the root or logarithm of a negative number, a real power of a negative number.",
    "wrong: sqrt(-2), 1 / 0\nright: sqrt(2)";
UNKNOWN_UNIT = "unknown-unit", "a unit that is not known",
    "Units are products of SI units with prefixes and powers: W/K, W/(m2 K), W/K^1.25, mK, kJ/(kg K), and 1, %, degC, min, h, d, bar, mbar, deg, rad, sr, g, L, ppm. Case matters: mW is a milliwatt, MW a megawatt.",
    "wrong: \"Watt/Kelvin\", \"celsius\"\nright: \"W/K\", \"degC\"";
UNIT_SYNTAX = "unit-syntax", "a unit that does not parse",
    "A unit is symbols joined by `*`, `.`, a blank or `/`, with powers as in m2, m^2 or K^1.25, and brackets. degC has an offset and stands alone; in products use K.",
    "wrong: \"W//K\", \"W/degC^2\"\nright: \"W/K\", \"W/K2\"";
WRONG_DIMENSION = "wrong-dimension", "a unit of another kind",
    "The unit given measures something else than what is asked for here, such as watts where a temperature belongs. Values are converted to SI where they are read, so a wrong unit would be a wrong number.",
    "wrong: \"sigma\": {\"value\": 0.25, \"unit\": \"W\"}\nright: \"sigma\": {\"value\": 0.25, \"unit\": \"K\"}";
COULOMB = "coulomb", "the coulomb where degrees Celsius are most likely meant",
    "C is the SI unit of charge. A thermal model hardly has charges, so that `C` is most likely meant for degrees Celsius, which are `degC`; in a product, as a standard deviation or as a difference they are `K`. A charge is written in `A s`.",
    "wrong: \"T_if\": {\"unit\": \"C\", \"nominal\": 20}\nright: \"T_if\": {\"unit\": \"degC\", \"nominal\": 20}";
NEEDS_NUMBER = "needs-number", "an expression where a number is needed",
    "Here a value must be known before the model runs: a number in SI, or {\"value\": ..., \"unit\": ...}. An expression string is allowed only where a part of the model is described.",
    "wrong: \"range\": [\"T_min\", 60]\nright: \"range\": [-40, 60]";
UNIT_CLASH = "unit-clash", "the units of an expression do not fit (warning)",
    "The dimension of the expression, worked out from the units of parameters and inputs, clashes with what is asked for, or terms of different dimension are added, or exp, log, sin and the like are taken of something with a unit. It is a warning, since numbers in an expression may carry units that only their author knows.",
    "suspicious: \"conductance\": \"area\" with area in m2\nfine: \"conductance\": \"area * 120\"";
}
