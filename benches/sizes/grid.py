"""Writes a study of a spacecraft of panels that are grids of nodes, with synthetic readings of a hidden path.

usage: grid.py FOLDER NODES [--sensors 20] [--phases 10] [--rows 0] [--swing 0] [--scattered 0] [--noise] [--jobs KIND...]

Steady phases; with `--rows` each phase is that many rows of one transient, two minutes apart. Its inputs are constant, but with
`--swing` the sink steps in every row, by so many kelvin (one standard deviation) about the phase's. With `--scattered` each node
radiates to so many others, drawn from all, as through an open interior. Then, with `--noise` and above 5000 nodes nothing is
solved here, and the readings are noise about one temperature: enough for `plan`, `compare` and `propagate`. `--jobs` keeps those kinds alone.

Ten parameters: contacts, emittances and powers shared by many elements, so groups follow from the model. The readings are of
this network with parameters of its own and a strap between two nodes that the model lacks, and noise of 0.1 K.
"""

import argparse
import json
import math
import pathlib
import random

SIGMA = 5.670374419e-8
STRAP_W_K = 0.25
START_K = 293.15
CAPACITY_J_K = 200.0
MOST_SOLVED = 5000


def network(nodes):
    """Panels of up to 10 x 10 nodes in a chain: links (a, b, parameter, factor) and areas (node, panel, m2)."""
    side = max(2, min(10, math.isqrt(nodes // 3)))
    panels = [range(start, min(start + side * side, nodes)) for start in range(0, nodes, side * side)]
    links, views = [], []
    for index, panel in enumerate(panels):
        for place, node in enumerate(panel):
            if (place + 1) % side and node + 1 in panel:
                links.append((node, node + 1, "G_sheet", 1.0))
            if node + side in panel:
                links.append((node, node + side, "G_sheet", 1.0))
            views.append((node, ["eps_black", "eps_white", "eps_tape"][index % 3], 0.8 / nodes))
        if index:
            before = panels[index - 1]
            for place in range(min(side, len(panel), len(before))):
                links.append((before[-1 - place], panel[place], ["G_bolt", "G_hinge", "G_bracket"][index % 3], 1.0))
    return panels, links, views


def solve_banded(band, width, *sides):
    """Solutions of a symmetric system, whose rows hold the diagonal and `width` entries after it, by an LDL' factorisation."""
    size = len(band)
    for k in range(size):
        pivot = band[k][0]
        row = band[k]
        for offset in range(1, min(width, size - 1 - k) + 1):
            if row[offset] == 0.0:
                continue
            factor = row[offset] / pivot
            below = band[k + offset]
            for other in range(offset, min(width, size - 1 - k) + 1):
                below[other - offset] -= factor * row[other]
            for side in sides:
                side[k + offset] -= factor * side[k]
    for side in sides:
        for k in reversed(range(size)):
            known = sum(band[k][offset] * side[k + offset] for offset in range(1, min(width, size - 1 - k) + 1))
            side[k] = (side[k] - known) / band[k][0]
    return sides


def solve(nodes, links, strap, views, values, sink_k, powers):
    """Temperatures, K, by Newton's method; the strap (a, b, W/K) enters by Sherman and Morrison's formula."""
    width = max(abs(a - b) for a, b, *_ in links)
    temperature = [290.0] * nodes
    for _ in range(60):
        heat = [0.0] * nodes
        band = [[0.0] * (width + 1) for _ in range(nodes)]
        for node, power in powers.items():
            heat[node] += power
        for node, key, area in views:
            size = SIGMA * values[key] * area
            heat[node] -= size * (temperature[node] ** 4 - sink_k**4)
            band[node][0] += 4 * size * temperature[node] ** 3
        for a, b, key, factor in links:
            size = values[key] * factor
            flow = size * (temperature[a] - temperature[b])
            heat[a] -= flow
            heat[b] += flow
            band[a][0] += size
            band[b][0] += size
            band[min(a, b)][abs(a - b)] -= size
        a, b, size = strap
        flow = size * (temperature[a] - temperature[b])
        heat[a] -= flow
        heat[b] += flow
        unit = [0.0] * nodes
        unit[a], unit[b] = 1.0, -1.0
        step, through = solve_banded(band, width, heat, unit)
        share = size * (step[a] - step[b]) / (1 + size * (through[a] - through[b]))
        step = [max(-50.0, min(50.0, one - share * other)) for one, other in zip(step, through)]
        temperature = [before + one for before, one in zip(temperature, step)]
        if max(map(abs, step)) < 1e-9:
            return temperature
    raise ArithmeticError("no steady state")


def advance(temperature, links, strap, views, values, sink_k, powers):
    """Temperatures two minutes later, K, by Runge and Kutta's method in steps of 20 s: well within what is stable here."""

    def rates(now):
        heat = [0.0] * len(now)
        for node, power in powers.items():
            heat[node] += power
        for node, key, area in views:
            heat[node] -= SIGMA * values[key] * area * (now[node] ** 4 - sink_k**4)
        for a, b, size in [(a, b, values[key] * factor) for a, b, key, factor in links] + [strap]:
            flow = size * (now[a] - now[b])
            heat[a] -= flow
            heat[b] += flow
        return [one / CAPACITY_J_K for one in heat]

    ahead = lambda slope, step: [one + step * other for one, other in zip(temperature, slope)]
    for _ in range(6):
        first = rates(temperature)
        second = rates(ahead(first, 10.0))
        third = rates(ahead(second, 10.0))
        fourth = rates(ahead(third, 20.0))
        slopes = zip(first, second, third, fourth)
        temperature = ahead([(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in slopes], 20.0)
    return temperature


def main(folder, nodes, sensors, phases, rows_each, swing, scattered, noise, jobs):
    noise = noise or scattered > 0 or nodes > MOST_SOLVED
    draw, swings = random.Random(nodes), random.Random(-nodes)
    panels, links, views = network(nodes)
    others = random.Random(nodes + 1)
    across = [(n, (n + others.randrange(1, nodes)) % nodes) for n in range(nodes) for _ in range(scattered)]
    name = lambda node: f"n{node}"
    units = [nodes // 7, nodes // 2, (6 * nodes) // 7]
    nominal = {
        "G_sheet": 1.5, "G_bolt": 0.3, "G_hinge": 0.1, "G_bracket": 0.2, "eps_black": 0.85, "eps_white": 0.8, "eps_tape": 0.6,
        "f_0": 1.0, "f_1": 1.0, "f_2": 1.0,
    }
    parameters = {}
    for key, value in nominal.items():
        unit = {"G": "W/K"}.get(key[0], "1")
        if key[0] == "f":
            prior = {"normal": {"mean": 1.0, "sd": 0.03}}
        elif key[0] == "e":
            prior = {"normal": {"mean": value, "sd": 0.04, "lower": 0.0, "upper": 1.0}}
        else:
            prior = {"lognormal": {"median": value, "factor": 1.4}}
        parameters[key] = {"nominal": value, "unit": unit, "prior": prior}
    model = {
        "format": "bmv-network/1",
        "inputs": {"T_sink": {"unit": "K", "nominal": 150}}
        | {f"Q_{k}": {"unit": "W", "nominal": 20} for k in range(3)},
        "parameters": {key: {k: v for k, v in entry.items() if k != "prior"} | {"prior": entry["prior"]} for key, entry in parameters.items()},
        "nodes": {name(n): {"capacity": CAPACITY_J_K} for n in range(nodes)} | {"shroud": {"boundary": "T_sink"}},
        "conductors": {
            f"c{k}": {"between": [name(a), name(b)], "conductance": f"{key}" if factor == 1 else f"{factor}*{key}"}
            for k, (a, b, key, factor) in enumerate(links)
        },
        "radiations": {
            f"r{n}": {"between": [name(n), "shroud"], "exchange_area": f"{area:.6g}*{key}"} for n, key, area in views
        }
        | {
            f"x{k}": {"between": [name(a), name(b)], "exchange_area": f"{0.2 / nodes:.6g}*eps_black"}
            for k, (a, b) in enumerate(across)
        },
        "loads": {f"unit {k}": {"into": name(node), "power": f"f_{k}*Q_{k}"} for k, node in enumerate(units)},
        "quantities": {"warmest unit": {"temperature": name(units[1])}},
        "groups": {f"panel {k}": {"nodes": {name(n): 1 for n in panel}} for k, panel in enumerate(panels) if len(panel) > 1},
    }
    truth = {key: value * (1 + 0.02 * draw.gauss(0, 1)) if key[0] in "ef" else value * math.exp(0.2 * draw.gauss(0, 1)) for key, value in nominal.items()}
    measured = sorted({(k * nodes) // sensors + (nodes // sensors) // 2 for k in range(min(sensors, nodes))})
    strap = (units[0], min(nodes - 1, units[2] + 1))
    rows = []
    temperatures = [START_K] * nodes
    for phase in range(phases):
        sink = draw.uniform(90, 290)
        power = [draw.uniform(0, 60) for _ in range(3)]
        powers = {node: truth[f"f_{k}"] * power[k] for k, node in enumerate(units)}
        panel_network = (links, (*strap, STRAP_W_K), views, truth)
        for row in range(rows_each):
            now = round(sink + swing * swings.gauss(0, 1), 2)
            readings = [f"{temperatures[n] + draw.gauss(0, 0.1):.3f}" for n in measured]
            rows.append([str(120 * len(rows)), f"{now:.2f}", *[f"{p:.2f}" for p in power], *readings])
            if not noise:
                temperatures = advance(temperatures, *panel_network, now if swing else sink, powers)
        if not rows_each:
            exact = [START_K] * nodes if noise else solve(nodes, *panel_network, sink, powers)
            readings = [f"{exact[n] + draw.gauss(0, 0.1):.3f}" for n in measured]
            rows.append([f"P{phase:02}", f"{sink:.2f}", *[f"{p:.2f}" for p in power], *readings])
    first = "time [s]" if rows_each else "phase"
    head = [first, "T_sink [K]", *[f"Q_{k} [W]" for k in range(3)], *[f"{name(n)} [K]" for n in measured]]
    study = pathlib.Path(folder)
    (study / "data").mkdir(parents=True, exist_ok=True)
    (study / "model.json").write_text(json.dumps(model, indent=1))
    (study / "data" / "test.csv").write_text("\n".join(",".join(row) for row in [head, *rows]) + "\n")
    sensor = lambda n: {"measures": name(n), "sigma": {"value": 0.1, "unit": "K"}}
    test = {"file": "data/test.csv", "sensors": {name(n): sensor(n) for n in measured}}
    if rows_each:
        test |= {"initial": {"temperatures": {"all": {"value": START_K, "unit": "K"}}}, "hold": ["T_sink", "Q_0", "Q_1", "Q_2"]}
    study_pass = {
        "format": "bmv-pass/1", "title": f"Grid of {nodes} nodes", "parent": None, "model": "model.json", "seed": 1,
        "measurements": {"test": {"transient" if rows_each else "steady": test}},
        "jobs": {
            "delivered": {"compare": {"data": ["test"]}},
            "spread": {"propagate": {"quantities": ["warmest unit"], "samples": 1024}},
            "shares": {"sensitivity": {"quantities": ["warmest unit"], "methods": ["sobol"], "samples": 128}},
            "missing": {"diagnose": {"data": ["test"]}},
            "tuned": {"calibrate": {"data": ["test"]}},
        },
    }
    if jobs:
        study_pass["jobs"] = {name: job for name, job in study_pass["jobs"].items() if next(iter(job)) in jobs}
    (study / "pass-1.json").write_text(json.dumps(study_pass, indent=1))
    (study / "truth.json").write_text(json.dumps({"truth": [{"effect": "conductive-path", "where": [name(n) for n in strap]}]}))


parser = argparse.ArgumentParser()
parser.add_argument("folder")
parser.add_argument("nodes", type=int)
parser.add_argument("--sensors", type=int, default=20)
parser.add_argument("--phases", type=int, default=10)
parser.add_argument("--rows", type=int, default=0, dest="rows_each")
parser.add_argument("--swing", type=float, default=0.0)
parser.add_argument("--scattered", type=int, default=0)
parser.add_argument("--noise", action="store_true")
parser.add_argument("--jobs", nargs="*", default=[])
main(**vars(parser.parse_args()))
