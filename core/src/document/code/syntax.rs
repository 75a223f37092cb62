//! Codes of JSON itself and of the shape of files: fields, types, kinds.

use super::codes;

codes! { SYNTAX_CODES:
SYNTAX = "json-syntax", "the text is not JSON",
    "The file does not follow the grammar of JSON (RFC 8259) at the marked place: a comma, colon, quote or value is missing or stands where none belongs. Reading goes on behind the place where it can, so that one run shows all errors of a file.",
    "wrong: {title: 'bench'}\nright: {\"title\": \"bench\"}";
BROKEN_OFF = "json-end", "the file ends too early",
    "The text ends inside an object, array or string: a closing brace, bracket or quote is missing, or the file was cut off while it was written or copied.",
    "wrong: {\"nodes\": {\"plate\": {}\nright: {\"nodes\": {\"plate\": {}}}";
TRAILING_COMMA = "json-trailing-comma", "a comma before a closing bracket",
    "JSON allows a comma only between two entries, not behind the last one. Other programs that read these files would refuse it, so bmv does as well.",
    "wrong: [0.4, 1.2,]\nright: [0.4, 1.2]";
COMMENT = "json-comment", "a comment in JSON",
    "JSON has no comments. What is worth saying about a value has fields of its own: \"description\", \"source\" and \"because\" are printed in the report, where a comment would be lost.",
    "wrong: \"nominal\": 0.8 // bolted joint\nright: \"nominal\": 0.8, \"description\": \"bolted joint\"";
DUPLICATE_KEY = "duplicate-key", "a key stands twice in an object",
    "What has a name is an object keyed by that name, so a second entry of the same name would silently replace the first. Rename one of them, or remove it.",
    "wrong: {\"plate\": {\"capacity\": 900}, \"plate\": {\"capacity\": 700}}\nright: {\"plate\": {\"capacity\": 900}, \"lid\": {\"capacity\": 700}}";
INVALID_ESCAPE = "json-escape", "an invalid escape in a string",
    "A backslash in a JSON string begins one of the escapes \\\" \\\\ \\/ \\b \\f \\n \\r \\t or \\uXXXX. Characters above U+FFFF are two \\u escapes, a high and a low surrogate; one of them alone is no character. A backslash itself is written \\\\.",
    "wrong: \"C:\\data\"\nright: \"C:\\\\data\"";
CONTROL_CHARACTER = "json-control-character", "a control character or line break in a string",
    "Line breaks, tabs and other control characters must be escaped inside JSON strings. Often a closing quote is missing, so that the string runs into the next line.",
    "wrong: \"title\": \"bench\n\nright: \"title\": \"bench\"";
NOT_A_NUMBER = "json-nan", "NaN or infinity",
    "JSON has no NaN and no infinity, and a study needs neither: a missing reading is an empty cell of the CSV file, an absent bound is left out.",
    "wrong: \"upper\": Infinity\nright: leave \"upper\" out";
INVALID_NUMBER = "json-number", "a number in a form that JSON does not have",
    "JSON numbers have a digit before the point, a digit behind it, no leading zeros, no plus sign, no thousands separators and no unit. A value with a unit is an object: {\"value\": 20, \"unit\": \"degC\"}.",
    "wrong: .5, 01, +3, 1.\nright: 0.5, 1, 3, 1.0";
NUMBER_RANGE = "json-number-range", "a number that a float cannot hold",
    "Numbers are kept as 64-bit floats (integers up to 2^64 - 1 exactly). This one is beyond about 1.8e308, or so small that it would silently become 0.",
    "wrong: 1e400\nright: 1e300";
BYTE_ORDER_MARK = "json-bom", "a byte order mark at the beginning",
    "The file begins with the bytes EF BB BF, which some editors write in front of UTF-8. JSON forbids it, and it would change the file's hash without changing its meaning. Save the file as UTF-8 without BOM.",
    "in an editor: encoding \"UTF-8\", not \"UTF-8 with BOM\"";
NOT_UTF8 = "not-utf8", "the file is not UTF-8",
    "Text files of a study are UTF-8. The marked byte does not belong to it: the file was probably saved in Latin-1, Windows-1252 or UTF-16. Save it again as UTF-8.",
    "iconv -f WINDOWS-1252 -t UTF-8 old.json > new.json";
TOO_DEEP = "json-depth", "nested too deeply",
    "Objects and arrays are nested deeper than 128 levels. The formats of bmv need about ten; such a file is broken or hostile, and reading it without a limit could exhaust the stack.",
    "wrong: [[[[...]]]]";
TOO_LARGE = "file-size", "the file is too large",
    "Files of a study are read into memory as a whole. A JSON file is limited to 64 MiB and a million values (numbers, strings, arrays, objects), a CSV file to 256 MiB and ten million cells that are read. Measured data belong into CSV files; a long record is thinned out or split into several measurements.",
    "move the readings to data/NAME.csv and name that file in the measurement";
UNKNOWN_FIELD = "unknown-field", "a field that the format does not know",
    "The object has a field that means nothing here. It is refused rather than ignored, because a misspelt optional field (\"capcity\") would otherwise silently leave its default in place. bmv schema prints all fields.",
    "wrong: {\"capcity\": 900}\nright: {\"capacity\": 900}";
MISSING_FIELD = "missing-field", "a required field is missing",
    "The object lacks a field without which it has no meaning and for which no default would be honest. The message names it and says what belongs there.",
    "wrong: {\"between\": [\"a\", \"b\"]}\nright: {\"between\": [\"a\", \"b\"], \"conductance\": 0.5}";
WRONG_TYPE = "wrong-type", "a value of the wrong type",
    "The value is a string where a number belongs, an array where an object belongs, or the like. The message says what was found and what is expected.",
    "wrong: \"capacity\": [900]\nright: \"capacity\": 900";
WRONG_LENGTH = "wrong-length", "an array of the wrong length",
    "A pair has two members: a prior's bounds, a path's two nodes. The message says how many were found and how many are expected.",
    "wrong: \"uniform\": [0.4]\nright: \"uniform\": [0.4, 1.2]";
OUT_OF_RANGE = "out-of-range", "a value outside its range",
    "The value has the right type but no meaning at its size or sign: a negative heat capacity, a probability above 1, a count of zero. The message states the accepted range.",
    "wrong: \"probability\": 99\nright: \"probability\": 0.99";
ONE_KIND = "one-kind", "a choice that is not exactly one key",
    "A choice between kinds is an object with exactly one key, which is the kind: {\"uniform\": [0.4, 1.2]}. Here there is none, or more than one, or a \"kind\" field beside others.",
    "wrong: {\"kind\": \"uniform\", \"lower\": 0.4, \"upper\": 1.2}\nright: {\"uniform\": [0.4, 1.2]}";
UNKNOWN_KIND = "unknown-kind", "a kind that does not exist",
    "The one key of a choice, or the word given, is none of the kinds known here. The message lists them and names the nearest.",
    "wrong: {\"unifrom\": [0.4, 1.2]}\nright: {\"uniform\": [0.4, 1.2]}";
FORMAT_VERSION = "format-version", "a format that this version does not read",
    "Every file states its format and version in \"format\". This one is of another kind, or newer than this program. A model is \"bmv-network/1\", a pass \"bmv-pass/1\", an effect \"bmv-effect/1\".",
    "wrong: \"format\": \"bmv-network/9\"\nright: \"format\": \"bmv-network/1\"";
INVALID_NAME = "invalid-name", "a name that is not allowed",
    "Parameters and inputs are named in expressions, so their names are letters, digits and underscores and begin with a letter. Other names may be any text without control characters, `:` or `/`, not empty and not blank at the ends, because names are joined to identifiers such as conductive-path:baseplate:board.",
    "wrong: \"G-bi\" (a parameter), \"plate/2\" (a node)\nright: \"G_bi\", \"plate 2\"";
}
