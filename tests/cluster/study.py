"""A study whose jobs last as long as a test needs.

study.py FOLDER ENVIRONMENTS SAMPLES [PLATES]: a chain of plates on a wall that radiate to the sky; a block an environment.
study.py FOLDER ENVIRONMENTS SAMPLES pause SECONDS: a plate by a program that takes so long a sample, and computes nothing
meanwhile; 16 samples a block, one at a time."""

import json
import pathlib
import sys

folder, environments, samples = pathlib.Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
pause = float(sys.argv[5]) if sys.argv[4:5] == ["pause"] else None
plates = int(sys.argv[4]) if len(sys.argv) > 4 and pause is None else 8
names = [f"plate {number}" for number in range(plates)]
model = {
    "format": "bmv-network/1",
    "title": "Plates",
    "inputs": {
        "T_wall": {"unit": "K", "nominal": 290},
        "Q": {"unit": "W", "nominal": 20},
    },
    "parameters": {
        "G": {"unit": "W/K", "nominal": 0.5, "prior": {"uniform": [0.4, 0.6]}},
        "eps": {"unit": "1", "nominal": 0.8, "prior": {"uniform": [0.7, 0.9]}},
    },
    "nodes": {"wall": {"boundary": "T_wall"}, "sky": {"boundary": 4}, **{name: {} for name in names}},
    "conductors": {
        f"mount {number}": {"between": [(["wall"] + names)[number], names[number]], "conductance": "G"}
        for number in range(plates)
    },
    "radiations": {
        f"face {number}": {"between": [names[number], "sky"], "exchange_area": "0.05 * eps"}
        for number in range(plates)
    },
    "loads": {f"board {number}": {"into": names[number], "power": "Q"} for number in range(plates)},
    "quantities": {"last plate": names[-1]},
}
if pause is not None:
    for part in ["nodes", "conductors", "radiations", "loads", "quantities"]:
        del model[part]
    names = ["plate"]
    model["command"] = {
        "run": ["./plate.sh"],
        "input": {"templates": [{"file": "values.in", "as": "values"}]},
        "outputs": {"last plate": {"unit": "K", "from": {"json": {"file": "out.json", "pointer": "/plate"}}}},
        "at_once": 1,
    }
sweep = {"Q": {"from": 5, "to": 20, "steps": environments}}
passed = {
    "format": "bmv-pass/1",
    "title": "Plates",
    "parent": None,
    "model": "model.json",
    "seed": 7,
    "requirements": {
        "last plate": {"quantity": "last plate", "below": {"value": 60, "unit": "degC"}, "probability": 0.9}
    },
    "jobs": {"prior": {"propagate": {"samples": samples, "sweep": sweep}}},
}
folder.mkdir(parents=True, exist_ok=True)
(folder / "model.json").write_text(json.dumps(model, indent=1))
if pause is not None:
    (folder / "values.in").write_text("G={{G}}\neps={{eps}}\nQ={{ Q }}\nT_wall={{T_wall}}\n")
    (folder / "plate.sh").write_text(
        f"#!/bin/sh\n. ./values\nsleep {pause}\n"
        'awk -v G="$G" -v Q="$Q" -v T="$T_wall" \'BEGIN {printf "{\\"plate\\": %.17g}\\n", T + Q / G}\' > out.json\n'
    )
    (folder / "plate.sh").chmod(0o755)
(folder / "pass-1.json").write_text(json.dumps(passed, indent=1))
