"""Writes campaigns of small test benches for `tests/known_truth.py`: few sensors, noise that is not stated, wide priors, and a truth of four
cells a node with a loss that is a little nonlinear, a room that is not quite where it is logged, and one effect that the believed model lacks;
beside it so many minor ones, each a quarter to two fifths as large.

usage: prepare.py SEED COUNT FOLDER [MINOR [KIND,...]], with NumPy; without KIND all but `shift`
"""

import json
import pathlib
import sys

import numpy as np

KINDS = ["fan", "storage", "loss", "sun", "joule", "path", "dated-load", "dated-conductance", "lag", "dissipation", "sink", "nothing"]
# Offsets in time, of one thermometer or of all, are asked for by name.
SHIFT = "shift"
NAMES = [["heater block", "plate", "case", "lid"], ["chip", "board", "frame", "cover"]]
CELLS = 4
STEFAN_BOLTZMANN = 5.670374419e-8
ROOM = 21.0
# Sizes between which that of the hidden effect is sought, of each kind; of loads in shares of the heater's power.
SIZES = {"fan": (0.3, 4), "storage": (0.3, 6), "loss": (0.1, 3), "sun": (1 / 8000, 1 / 300), "path": (0.2, 10), "dated-load": (0.03, 0.8), "dated-conductance": (0.2, 3), "dissipation": (0.003, 0.02), "sink": (2, 10)}
# Kinds that minor effects may have: what needs no input of its own and changes no other effect's place.
MINOR_KINDS = ["storage", "loss", "path", "dated-load", "dated-conductance", "dissipation", "sink", "offset"]
UNITS = {"time": "s", "P": "W", "I": "A", "fan": "1", "light": "W/m2"}


def steps(random, times, levels, mean):
    """Levels held for exponentially distributed times."""
    values, row = np.zeros(len(times)), 0
    while row < len(times):
        held = max(3, int(random.exponential(mean) / (times[1] - times[0])))
        values[row : row + held] = random.choice(levels)
        row += held
    return values


def wandering(random, rows, times):
    """A first-order autoregressive course of standard deviation 1 that forgets itself so many times in the record."""
    rho, values = 1 - times / rows, np.zeros(rows)
    for row in range(1, rows):
        values[row] = rho * values[row - 1] + np.sqrt(1 - rho * rho) * random.normal()
    return values


def daylight(random, times, day):
    sun = 800 * np.clip(np.sin(2 * np.pi * (times / day - random.uniform(0.1, 0.3))), 0, None)
    return sun / (1 + np.exp(-1.5 * wandering(random, len(times), 0.03 * len(times)) - 0.5))


class Bench:
    """A chain of nodes from the heater outwards, as it is and as it is believed to be."""

    def __init__(self, random, kind, minor):
        self.random, self.kind = random, kind
        least = {"path": 3, "loss": 2}.get(kind, 1)
        self.count = max(least, int(random.choice([1, 2, 3, 4], p=[0.2, 0.35, 0.3, 0.15])))
        self.names = NAMES[int(random.integers(2))][: self.count]
        self.capacities = np.exp(random.uniform(np.log(60), np.log(1500), self.count))
        self.time_constant = np.exp(random.uniform(np.log(400), np.log(4000)))
        self.to_room = self.capacities.sum() / self.time_constant
        self.joints = self.to_room * np.exp(random.uniform(np.log(1.5), np.log(8), self.count - 1))
        self.losses = np.zeros(self.count)
        self.losses[-1] = self.to_room
        for node in range(self.count - 1):
            if random.random() < 0.3:
                self.losses[node] = self.to_room * random.uniform(0.1, 0.5)
        self.at = int(random.integers(self.count - 1 if kind == "loss" else self.count))
        if kind == "loss":
            self.losses[self.at] = 0
        self.within = self.to_room * np.exp(random.uniform(np.log(10), np.log(40), self.count))
        self.shares = np.concatenate([random.dirichlet(4 * np.ones(CELLS)) for _ in range(self.count)])
        self.rise = random.uniform(20, 60)
        self.power, self.efficiency = self.rise * self.to_room, random.uniform(0.95, 1.05)
        self.behind = self.to_room * random.uniform(0.5, 3)
        self.by_current = kind == "joule" or (kind != "dissipation" and random.random() < 0.2)
        self.most_current = self.power * 1.2 / 12
        self.resistance = 12 / (0.75 * self.most_current)
        self.runs = 2 if random.random() < 0.4 and not kind.startswith("dated") else 1
        self.rows = int(random.integers(150, 700))
        self.span = self.time_constant * random.uniform(4, 12)
        self.date = self.span * random.uniform(0.25, 0.6)
        self.warm = self.rise * random.uniform(0.1, 0.5) if random.random() < 0.3 else 0.0
        others = [name for name, own in (("fan", "fan"), ("light", "sun")) if kind == own or random.random() < 0.25]
        self.records = [self.record(others) for _ in range(self.runs)]
        possible = [one for one in MINOR_KINDS if one != kind and not (one == "path" and self.count < 3) and not (one.startswith("dated") and self.runs == 2)]
        self.minor = [(str(one), int(random.integers(self.count))) for one in random.choice(possible, minor, replace=False)] if minor else []

    def record(self, others):
        random, rows = self.random, self.rows
        times = np.arange(rows) * self.span / rows
        drive = steps(random, times, [0, 0.4, 0.7, 1.0], self.span / 8)
        drive[: max(3, rows // 12)] = random.choice([0.5, 0.8, 1.0])
        inputs = {"T_room": ROOM + random.uniform(-3, 3) + 1.2 * wandering(random, rows, 4)}
        inputs |= {"I": drive * self.most_current} if self.by_current else {"P": drive * self.power}
        for name in others:
            day = self.span / random.uniform(1.5, 4)
            inputs[name] = steps(random, times, [0, 1], self.span / 6) if name == "fan" else daylight(random, times, day)
        return times, inputs, inputs["T_room"] + 0.35 * wandering(random, rows, 6)

    def simulate(self, record, hidden):
        """Temperatures of all cells, implicit Euler with the loss of the step before, degC; of each hidden effect the size and the node."""
        times, inputs, room = record
        size = lambda kind: hidden.get(kind, (0.0, 0))[0]
        here = lambda kind: slice(CELLS * hidden[kind][1], CELLS * (hidden[kind][1] + 1))
        cells = self.count * CELLS + ("storage" in hidden)
        capacities = np.repeat(self.capacities / CELLS, CELLS)
        joints = [(CELLS * n + c, CELLS * n + c + 1, self.within[n]) for n in range(self.count) for c in range(CELLS - 1)]
        joints += [(CELLS * n + CELLS - 1, CELLS * (n + 1), self.joints[n]) for n in range(self.count - 1)]
        losses = np.repeat(self.losses, CELLS) * self.shares
        if "storage" in hidden:
            host = hidden["storage"][1]
            capacities = np.append(capacities, size("storage") * self.capacities[host])
            joints.append((CELLS * host + 1, cells - 1, self.behind))
            losses = np.append(losses, 0)
        if "path" in hidden:
            joints.append((1, CELLS * (self.count - 1) + 2, size("path") * self.to_room))
        if "loss" in hidden:
            losses[here("loss")] += size("loss") * self.to_room * self.shares[here("loss")]
        network = np.zeros((cells, cells))
        for a, b, conductance in joints:
            network[[a, b], [a, b]] -= conductance
            network[[a, b], [b, a]] += conductance
        state = np.full(cells, inputs["T_room"][0] + self.warm)
        course = [state]
        pieces = min(4, max(1, int(np.ceil((times[1] - times[0]) / (self.time_constant / 60)))))
        length = (times[1] - times[0]) / pieces
        for row in range(len(times) - 1):
            sink = room[row] + size("sink")
            factor = 1 + (size("fan") * inputs["fan"][row] if "fan" in hidden else 0)
            factor += size("dated-conductance") if times[row] >= self.date else 0
            power = inputs["P"][row] if "P" in inputs else 12 * inputs["I"][row]
            if "joule" in hidden:
                power = self.resistance * inputs["I"][row] ** 2
            for _ in range(pieces):
                above = np.abs(state - sink)
                natural = (above / 15 + 0.02) ** 0.25
                radiative = 4 * STEFAN_BOLTZMANN * ((state + sink) / 2 + 273.15) ** 3 / 6
                loss = losses * factor * (0.75 + 0.125 * natural + 0.125 * radiative)
                heat = np.zeros(cells)
                heat[0] = self.efficiency * power * (1 + size("dissipation") * (state[0] - 20))
                if "sun" in hidden:
                    heat[here("sun")] += size("sun") * self.power * inputs["light"][row] / CELLS
                if "dated-load" in hidden and times[row] >= self.date:
                    heat[CELLS * hidden["dated-load"][1]] += size("dated-load") * self.power
                implicit = np.eye(cells) - length / capacities[:, None] * (network - np.diag(loss))
                state = np.linalg.solve(implicit, state + length / capacities * (heat + loss * sink))
            course.append(state)
        return np.array(course)

    def size(self, kind, at, target):
        """The size of a hidden effect that moves the temperatures by a target, as far as one does."""
        if kind == "lag":
            return self.time_constant * self.random.uniform(0.06, 0.2)
        if kind == SHIFT:
            self.of_all = self.random.random() < 0.5
            return self.time_constant * self.random.choice([-1, 1]) * np.exp(self.random.uniform(np.log(0.07), np.log(0.5)))
        if kind == "offset":
            return target
        if kind not in SIZES:
            return 1.0
        cells = self.count * CELLS
        without = np.concatenate([self.simulate(record, {}) for record in self.records])

        def apart(size):
            course = np.concatenate([self.simulate(record, {kind: (size, at)})[:, :cells] for record in self.records])
            return abs(np.log(np.sqrt(np.mean((course - without) ** 2)) / target))

        least, most = SIZES[kind]
        return min(np.geomspace(least if kind == self.kind else least / 8, most, 7 if kind == self.kind else 12), key=apart)

    def model(self):
        random, names, rough = self.random, self.names, lambda value, sd: float(f"{value * random.lognormal(0, sd):.2g}")
        lossy = [n for n in range(self.count) if self.losses[n] > 0]
        values = {f"C_{n}": ("J/K", rough(self.capacities[n], 0.25), names[n]) for n in range(self.count)}
        values |= {f"G_{n}": ("W/K", rough(self.joints[n], 0.4), f"{names[n]} to {names[n + 1]}") for n in range(self.count - 1)}
        values |= {f"H_{n}": ("W/K", rough(self.losses[n], 0.4), f"{names[n]} to room") for n in lossy}
        parameters = {name: {"unit": unit, "nominal": value, "prior": {"lognormal": {"median": value, "factor": 2.5}}, "description": what} for name, (unit, value, what) in values.items()}
        parameters["eta"] = {"unit": "1", "nominal": 1, "prior": {"lognormal": {"median": 1, "factor": 1.05}}, "description": "share of the power that heats"}
        ranges = {"T_room": ("degC", 21, [10, 35]), "P": ("W", 0, [0, 1.2 * self.power]), "I": ("A", 0, [0, 1.2 * self.most_current]), "fan": ("1", 0, [0, 1]), "light": ("W/m2", 0, [0, 1000])}
        inputs = {name: dict(zip(("unit", "nominal", "range"), ranges[name])) for name in self.records[0][1]}
        if self.by_current:
            parameters["volts"] = {"unit": "V", "nominal": 12, "description": "supply"}
        conductors = {f"{names[n]} to {names[n + 1]}": {"between": [names[n], names[n + 1]], "conductance": f"G_{n}"} for n in range(self.count - 1)}
        conductors |= {f"{names[n]} to room": {"between": [names[n], "room"], "conductance": f"H_{n}"} for n in lossy}
        nodes = {name: {"capacity": f"C_{n}"} for n, name in enumerate(names)} | {"room": {"boundary": "T_room"}}
        power = "eta * volts * I" if self.by_current else "eta * P"
        return {"format": "bmv-network/1", "title": f"Bench of {self.count} nodes", "inputs": inputs, "parameters": parameters, "nodes": nodes, "conductors": conductors, "loads": {"heater": {"into": names[0], "power": power}}}

    def truth(self, hidden):
        """The hidden effects and what a lumped network calls by other names: which of them explains most depends on what the parameters take up."""
        listed = [one for kind, (_, node) in hidden.items() for one in self.listed(kind, node)]
        note = ", ".join(f"{kind} at {self.names[node]}, size {size:.3g}" for kind, (size, node) in hidden.items())
        return {"truth": listed[:1], "alternatives": listed[1:], "note": note}

    def listed(self, kind, node):
        names, at = self.names, self.names[node]
        near = [f"{a} to {b}" for a, b in zip(names, [*names[1:], "room"]) if at in (a, b)] + [f"{at} to room"]
        of = lambda effects, where, **more: [{"effect": effect, "where": where} | more for effect in effects]
        surroundings = ["path-to-ambient", "free-convection", "radiation-to-ambient", "path-to-logged-temperature", "conductive-path", "radiative-path", "convection"]
        return {
            "fan": of(["input-dependent-conductance", "conductance-step"], [], input="fan"),
            "storage": of(["hidden-node", "thermal-mass"], [at]) + [one for joint in near for one in of(["path-capacity"], [joint])],
            "loss": of(surroundings, [at]),
            "sun": of(["input-proportional-load", "input-function-load"], [at], input="light"),
            "joule": of(["joule-heating"], [names[0]]) + of(["input-function-load"], [names[0]], input="I") + of(["input-dependent-load"], ["heater"], input="I"),
            "path": of(surroundings[4:], [names[0], names[-1]]),
            "dated-load": of(["dated-load"], [at]),
            "dated-conductance": of(["dated-conductance"], []),
            "lag": of(["sensor-lag"], [at]),
            SHIFT: of(["sensor-clock", "sensor-lag"], ["all thermometers" if self.of_all else at]),
            "dissipation": of(["dissipation-temperature"], ["heater"]),
            "sink": of(["sink-offset"], ["room"]),
            "offset": of(["sensor-bias"], [at]),
            "nothing": [],
        }[kind]

    def write(self, folder):
        random = self.random
        target = self.rise * random.uniform(0.08, 0.25) if self.kind in SIZES or self.minor else 0.0
        hidden = {self.kind: (self.size(self.kind, self.at, target), self.at)}
        hidden |= {kind: (self.size(kind, at, target * random.uniform(0.25, 0.4)), at) for kind, at in self.minor}
        seen = [n for n in range(self.count) if random.random() < 0.8] or [self.count - 1]
        if self.kind in ("lag", SHIFT) and self.at not in seen:
            self.at = seen[0]
            hidden[self.kind] = (hidden[self.kind][0], self.at)
        self.of_all = self.kind == SHIFT and self.of_all and len(seen) > 1
        size, offset = hidden[self.kind][0], hidden.get("offset", (0.0, None))
        noise, resolution = random.uniform(0.02, 0.15), random.choice([0, 0.0625, 0.1, 0.25])
        spots = random.integers(CELLS, size=self.count)
        (folder / "data").mkdir(parents=True, exist_ok=True)
        measurements = {}
        for number, record in enumerate(self.records, 1):
            times, inputs, _ = record
            course = self.simulate(record, hidden)
            # What happens after the last row is not known.
            rows = len(times) - (int(np.ceil(max(0, size) / times[1])) if self.kind == SHIFT else 0)
            columns = {"time": times} | inputs
            for node in seen:
                reading = course[:, CELLS * node + spots[node]].copy()
                if self.kind == "lag" and node == self.at:
                    for row in range(1, len(times)):
                        reading[row] = reading[row - 1] + (1 - np.exp(-(times[1] - times[0]) / size)) * (reading[row] - reading[row - 1])
                if self.kind == SHIFT and (self.of_all or node == self.at):
                    reading = np.interp(times + size, times, reading)
                reading += offset[0] if node == offset[1] else 0
                reading += noise * random.normal(size=len(times))
                columns[self.names[node]] = np.round(reading / resolution) * resolution if resolution else reading
            lines = [",".join(f"{name} [{UNITS.get(name, 'degC')}]" for name in columns)]
            lines += [",".join(f"{column[row]:.6g}" for column in columns.values()) for row in range(rows)]
            (folder / "data" / f"run {number}.csv").write_text("\n".join(lines) + "\n")
            unknown = lambda median, unit: {"prior": {"lognormal": {"median": float(f"{median:.2g}"), "factor": 3}}, "unit": unit}
            sensors = {self.names[n]: {"measures": self.names[n], "sigma": unknown(0.5, "K"), "correlation_time": unknown(10 * times[1], "s")} for n in seen}
            first = {self.names[n]: {"prior": {"normal": {"mean": round(float(columns[self.names[n]][0] if n in seen else course[0, 0]), 3), "sd": 0.3 if n in seen else 0.5}}, "unit": "degC"} for n in range(self.count)}
            late = {"intervals": [{"from": {"value": float(times[int(0.75 * self.rows)]), "unit": "s"}}]}
            held_out = {} if self.runs == 2 and number == 1 else {"held_out": {"all": {}} if self.runs == 2 else late}
            measurements[f"run {number}"] = {"transient": {"file": f"data/run {number}.csv", "hold": [name for name in inputs if name in ("P", "I", "fan")], "initial": {"temperatures": first}, "sensors": sensors} | held_out}
        jobs = {"missing": {"diagnose": {"data": list(measurements)}}}
        a_pass = {"format": "bmv-pass/1", "title": "Bench", "parent": None, "model": "model.json", "seed": 7, "measurements": measurements, "jobs": jobs}
        for name, content in (("model", self.model()), ("pass-1", a_pass), ("truth", self.truth(hidden))):
            (folder / f"{name}.json").write_text(json.dumps(content, indent=1))


if len(sys.argv) not in (4, 5, 6):
    sys.exit(__doc__)
minor = int(sys.argv[4]) if len(sys.argv) > 4 else 0
kinds = sys.argv[5].split(",") if len(sys.argv) > 5 else KINDS[: len(KINDS) - (minor > 0)]
for case in range(int(sys.argv[2])):
    kind = kinds[case % len(kinds)]
    Bench(np.random.default_rng([int(sys.argv[1]), case]), kind, minor).write(pathlib.Path(sys.argv[3]) / f"{case:03d}-{kind}")
