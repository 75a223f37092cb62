"""Writes a study whose report is large: steady phases and long transients of many sensors against a network of one node a sensor.

usage: large_report.py FOLDER [PHASES SENSORS TRANSIENTS ROWS]     (43 20 10 10000)

Each node hangs on a wall by its own conductor and is heated by its share of one power. The readings are the closed form of
that with conductances of their own, and noise of 0.1 K.
"""

import json
import math
import pathlib
import random
import sys

CAPACITY_J_K = 200.0
CONDUCTANCE_W_K = 0.5
WALL_K = 290.0
PERIOD_S = 7200.0
STEP_S = 30


def main(folder, phases=43, sensors=20, transients=10, rows=10_000):
    phases, sensors, transients, rows = int(phases), int(sensors), int(transients), int(rows)
    draw = random.Random(1)
    names = [f"n{n}" for n in range(sensors)]
    shares = [(n + 1) / sensors for n in range(sensors)]
    conductances = [CONDUCTANCE_W_K * math.exp(0.05 * draw.gauss(0, 1)) for _ in names]
    study = pathlib.Path(folder)
    (study / "data").mkdir(parents=True, exist_ok=True)
    model = {
        "format": "bmv-network/1",
        "inputs": {"T_wall": {"unit": "K", "nominal": WALL_K}, "Q": {"unit": "W", "nominal": 10}},
        "parameters": {"G": {"nominal": CONDUCTANCE_W_K, "unit": "W/K", "prior": {"lognormal": {"median": CONDUCTANCE_W_K, "factor": 1.4}}}},
        "nodes": {name: {"capacity": CAPACITY_J_K} for name in names} | {"wall": {"boundary": "T_wall"}},
        "conductors": {f"c {name}": {"between": [name, "wall"], "conductance": "G"} for name in names},
        "loads": {f"q {name}": {"into": name, "power": f"{share} * Q"} for name, share in zip(names, shares)},
        "quantities": {"warmest": {"temperature": names[-1]}},
    }
    (study / "model.json").write_text(json.dumps(model, indent=1))
    head = ",".join(["T_wall [K]", "Q [W]", *[f"{name} [K]" for name in names]])
    noisy = lambda value: f"{value + draw.gauss(0, 0.1):.3f}"
    lines = ["phase," + head]
    for phase in range(phases):
        power = draw.uniform(0, 30)
        readings = [noisy(WALL_K + share * power / own) for share, own in zip(shares, conductances)]
        lines.append(",".join([f"P{phase:02}", f"{WALL_K}", f"{power:.3f}", *readings]))
    (study / "data/balance.csv").write_text("\n".join(lines) + "\n")
    measured = {name: {"measures": name, "sigma": {"value": 0.1, "unit": "K"}} for name in names}
    measurements = {"balance": {"steady": {"file": "data/balance.csv", "sensors": measured}}}
    for record in range(transients):
        lines = ["time [s]," + head]
        rises = [0.0] * sensors
        for row in range(rows):
            power = 20.0 if (row * STEP_S) % PERIOD_S < PERIOD_S / 2 else 5.0
            lines.append(",".join([f"{row * STEP_S}", f"{WALL_K}", f"{power}", *[noisy(WALL_K + rise) for rise in rises]]))
            for n, own in enumerate(conductances):
                steady = shares[n] * power / own
                rises[n] = steady + (rises[n] - steady) * math.exp(-own * STEP_S / CAPACITY_J_K)
        (study / f"data/log-{record}.csv").write_text("\n".join(lines) + "\n")
        measurements[f"log {record}"] = {"transient": {
            "file": f"data/log-{record}.csv", "sensors": measured, "hold": ["Q", "T_wall"],
            "initial": {"temperatures": {"all": {"value": WALL_K, "unit": "K"}}}}}
    study_pass = {
        "format": "bmv-pass/1", "title": f"{phases} phases and {transients} transients of {rows} rows, {sensors} sensors", "parent": None,
        "model": "model.json", "seed": 1, "measurements": measurements, "jobs": {"delivered": {"compare": {"data": list(measurements)}}},
    }
    (study / "pass-1.json").write_text(json.dumps(study_pass, indent=1))


main(*sys.argv[1:])
