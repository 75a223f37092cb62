"""Ten orbits of a panel of 200 nodes beside scipy's LSODA with one thread for its linear algebra, at the same error.

usage: python benches/peers/transient.py PANEL [REPEATS]; needs numpy and scipy. PANEL is the example `panel` of `benches`, the
network `panel200` of `tests/verification/orbit.rs`, read every minute at ten nodes. CPU seconds: of LSODA medians of the repeats, of
PANEL what ten further runs in one process add, a tenth of it, the median of the repeats. The reference is LSODA itself, begun anew at each corner of
the sun's course, with tolerances a thousand times tighter. LSODA runs at several tolerances; its time at PANEL's error is
read off the straight line through the two nearest on logarithmic axes. Its functions get a hand-written Jacobian.
"""

import os
import resource
import statistics
import subprocess
import sys
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
    read = [str(node) for node in READ]
    times = []
    for _ in range(repeats):
        (one, text), (eleven, _) = (program_s([program, str(runs), *read]) for runs in (1, 11))
        times.append((eleven - one) / 10)
    error = np.abs(np.loadtxt(text.splitlines()) - reference).max()
    own = statistics.median(times)
    print(f"panel: error {error:.2e} K, {own:.4f} s of CPU")
    points.sort()
    near = sorted(points, key=lambda one: abs(np.log(one[0] / error)))[:2]
    (e0, s0), (e1, s1) = sorted(near)
    at = np.exp(np.log(s0) + (np.log(error) - np.log(e0)) * (np.log(s1) - np.log(s0)) / (np.log(e1) - np.log(e0)))
    print(f"LSODA at that error: {at:.3f} s of CPU, {at / own:.1f} times as much")


main(*sys.argv[1:])
