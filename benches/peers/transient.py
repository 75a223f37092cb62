"""Ten orbits of a panel of 200 nodes beside scipy's LSODA with one thread for its linear algebra, at the same error.

usage: python benches/peers/transient.py BMV [REPEATS]; needs numpy and scipy. CPU seconds, medians of the repeats. The network is that of
`tests/verification/orbit.rs` (`panel200`), read every minute at ten nodes. The reference is LSODA itself, begun anew at each corner of the
sun's course, with tolerances a thousand times tighter. `bmv compare` solves the same from a study whose readings are the reference, so
that the largest deviation is its error; what the same takes over the first minute is taken off. LSODA runs at several tolerances; its time at `bmv`'s error is
read off the straight line through the two nearest on logarithmic axes. Its functions get a hand-written Jacobian.
"""

import json
import os
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile
import time

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[threads] = "1"
import numpy as np  # noqa: E402
from scipy.integrate import solve_ivp  # noqa: E402

SIGMA = 5.670374419e-8
NX, NY, PERIOD_S, ORBITS = 10, 20, 5400.0, 10
END_S = ORBITS * PERIOD_S
OUTPUTS_S = np.arange(0.0, END_S + 1.0, 60.0)
READ = list(range(9, 200, 20))
BASE_K, SPACE_K, START_K = 290.0, 4.0, 290.0
HEATED = [33, 34, 53, 54, 133, 134, 153, 154]


def network():
    """Conductors and radiations as (a, b, size); 200 is the base, 201 is space."""
    at = lambda i, j: i * NY + j
    conductors, radiations, across = [], [], set()
    for i in range(NX):
        for j in range(NY):
            own = at(i, j)
            conductors += [(own, at(i + 1, j), 0.4)] if i + 1 < NX else []
            conductors += [(own, at(i, j + 1), 0.4)] if j + 1 < NY else []
            conductors += [(own, 200, 0.05)] if i == 0 else []
            radiations.append((own, 201, 0.85 * 0.01 * (1 + 0.2 * (j % 3))))
            if i % 3 == 0:
                across.add(tuple(sorted((own, at(NX - 1 - i, NY - 1 - j)))))
    radiations += [(a, b, 1e-3) for a, b in sorted(across) if a != b]
    capacities = [20.0 + 5.0 * (k % 4) for k in range(NX * NY)]
    return conductors, radiations, capacities


class Equations:
    """The balances with dense matrices, as one writes them for scipy."""

    def __init__(self):
        conductors, radiations, capacities = network()
        size = len(capacities)
        given = np.array([BASE_K, SPACE_K])
        self.capacities = np.array(capacities)
        self.heat = np.zeros(size)
        self.heat[HEATED] = 4.0
        self.matrices = []
        for paths, factor, power in ((conductors, 1.0, 1), (radiations, SIGMA, 4)):
            whole = np.zeros((size + 2, size + 2))
            for a, b, own in paths:
                whole[a, b] += own * factor
                whole[b, a] += own * factor
            self.heat += whole[:size, size:] @ given**power
            self.matrices.append(whole[:size, :size] - np.diag(whole[:size].sum(axis=1)))

    def rates(self, t, temperatures):
        sun = 0.2 * 0.01 * 1361.0 * max(0.0, np.cos(2 * np.pi * t / PERIOD_S))
        linear, radiative = self.matrices
        return (self.heat + sun + linear @ temperatures + radiative @ temperatures**4) / self.capacities

    def slopes(self, t, temperatures):
        linear, radiative = self.matrices
        return (linear + radiative * (4 * temperatures**3)) / self.capacities[:, None]

    def solve(self, tolerance, ends):
        """Temperatures of the nodes read, by output; begun anew at each of some ends."""
        state, rows, begin = np.full(len(self.capacities), START_K), [], 0.0
        for end in ends:
            wanted = OUTPUTS_S[(OUTPUTS_S >= begin) & ((OUTPUTS_S < end) | (end == END_S))]
            found = solve_ivp(
                self.rates, (begin, end), state, method="LSODA", jac=self.slopes, rtol=tolerance, atol=100 * tolerance,
                t_eval=np.union1d(wanted, [end]), max_step=600.0,
            )
            rows.append(found.y[:, np.isin(found.t, wanted)])
            state, begin = found.y[:, -1], end
        return np.hstack(rows)[READ].T


def study(folder, reference, count):
    conductors, radiations, capacities = network()
    name = lambda node: {200: "base", 201: "space"}.get(node, f"n{node}")
    model = {
        "format": "bmv-network/1", "title": "Panel",
        "nodes": {"base": {"boundary": BASE_K}, "space": {"boundary": SPACE_K}}
        | {name(k): {"capacity": capacity} for k, capacity in enumerate(capacities)},
        "conductors": {f"c{k}": {"between": [name(a), name(b)], "conductance": size} for k, (a, b, size) in enumerate(conductors)},
        "radiations": {f"r{k}": {"between": [name(a), name(b)], "exchange_area": size} for k, (a, b, size) in enumerate(radiations)},
        "loads": {f"s{k}": {"into": name(k), "power": f"2.722 * max(0, cos(2 * pi * t / {PERIOD_S}))"} for k in range(200)}
        | {f"h{k}": {"into": name(k), "power": 4} for k in HEATED},
    }
    sensors = {name(k): {"measures": name(k), "sigma": {"value": 1, "unit": "K"}} for k in READ}
    record = {"file": "orbits.csv", "sensors": sensors, "initial": {"temperatures": {"all": {"value": START_K, "unit": "K"}}}}
    a_pass = {
        "format": "bmv-pass/1", "title": "Orbits", "parent": None, "model": "model.json", "measurements": {"orbits": {"transient": record}},
        "jobs": {"delivered": {"compare": {"data": ["orbits"]}}},
    }
    rows = [",".join(["time [s]", *(f"{name(k)} [K]" for k in READ)])]
    rows += [",".join([f"{t:.0f}", *(f"{value:.9f}" for value in row)]) for t, row in zip(OUTPUTS_S[:count], reference)]
    folder.mkdir()
    (folder / "model.json").write_text(json.dumps(model))
    (folder / "pass-1.json").write_text(json.dumps(a_pass))
    (folder / "orbits.csv").write_text("\n".join(rows) + "\n")


def program_s(command):
    """CPU seconds of a program and what it prints."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        sys.exit(f"{command}: {done.stdout}{done.stderr}")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stdout


def main(program, repeats="5"):
    repeats, equations = int(repeats), Equations()
    corners = sorted({PERIOD_S * (k + share) for k in range(ORBITS) for share in (0.25, 0.75)} | {END_S})
    print("load", os.getloadavg())
    reference = equations.solve(1e-9, corners)
    points = []
    for tolerance in (1e-4, 1e-5, 1e-6, 1e-7):
        times = []
        for _ in range(repeats):
            clock = time.process_time()
            found = equations.solve(tolerance, [END_S])
            times.append(time.process_time() - clock)
        points.append((np.abs(found - reference).max(), statistics.median(times)))
        print(f"LSODA, rtol {tolerance:g}: error {points[-1][0]:.2e} K, {points[-1][1]:.3f} s of CPU")
    with tempfile.TemporaryDirectory() as folder:
        medians = []
        for count in (2, len(OUTPUTS_S)):
            own = pathlib.Path(folder) / f"{count}-rows"
            study(own, reference, count)
            command = [program, "compare", str(own / "pass-1.json"), "--json", "--threads", "1", "--cache"]
            runs = [program_s([*command, str(own / f"cache-{k}")]) for k in range(repeats)]
            medians.append(statistics.median(seconds for seconds, _ in runs))
            text = runs[0][1]
    error = max(abs(sensor["delivered"]["max"]) for sensor in json.loads(text)["sensors"].values())
    own = medians[1] - medians[0]
    print(f"bmv: error {error:.2e} K, {own:.3f} s of CPU ({medians[1]:.3f} s, of which {medians[0]:.3f} s for the first minute)")
    points.sort()
    near = sorted(points, key=lambda one: abs(np.log(one[0] / error)))[:2]
    (e0, s0), (e1, s1) = sorted(near)
    at = np.exp(np.log(s0) + (np.log(error) - np.log(e0)) * (np.log(s1) - np.log(s0)) / (np.log(e1) - np.log(e0)))
    print(f"LSODA at that error: {at:.3f} s of CPU, {at / own:.1f} times as much")


main(*sys.argv[1:])
