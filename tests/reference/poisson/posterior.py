"""Holds a calibration of the Poisson benchmark by bmv against an independent sampler: logarithms of 64 conductivities.

usage: posterior.py PROGRAM FOLDER [--trajectories 5000] [--chains 4] [--draws 1000] [--warmup 500]

The equation, its readings and their noise are those of README.md beside this file. The network's study is written to FOLDER/study
and calibrated by PROGRAM (`nuts`). The sampler here knows nothing of it: bilinear elements, a factorisation of the banded matrix,
gradients by the adjoint, Hamiltonian Monte Carlo in coordinates that are normal at the most probable point (Duane et al. 1987;
Neal 2011). Both state their Monte Carlo errors by effective sample sizes (here: Geyer 1992, initial monotone sequence, as Gelman et
al. 2013 combine chains). A mean that lies farther from the other than four times their common error ends with status 1.
Needs numpy and scipy.
"""

import argparse
import json
import math
import os
import pathlib
import subprocess
import sys
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np  # noqa: E402
import scipy.linalg  # noqa: E402
import scipy.sparse  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
ELEMENTS, SQUARES, POINTS = 32, 8, 13
INNER = ELEMENTS - 1
SIGMA, PRIOR_SD, LOAD = 0.05, 2.0, 10.0
ZERO_K = 300.0
MEASURED = np.array(json.loads((HERE / "measured.json").read_text()))
FARTHEST = 4.0


def node(x, y):
    """Number of an inner corner, -1 at the rim."""
    return (y - 1) * INNER + x - 1 if 0 < x < ELEMENTS and 0 < y < ELEMENTS else -1


def square(x, y):
    """The square of conductivity in which an element lies."""
    return y // (ELEMENTS // SQUARES) * SQUARES + x // (ELEMENTS // SQUARES)


def point(number):
    """Corners about a point of a reading with their weights."""
    at = [(k + 1) / (POINTS + 1) * ELEMENTS for k in divmod(number, POINTS)]
    corners = {}
    for right in (0, 1):
        for above in (0, 1):
            weights = [(a % 1.0) if side else 1.0 - a % 1.0 for a, side in zip(at, (right, above))]
            corners[node(int(at[0]) + right, int(at[1]) + above)] = weights[0] * weights[1]
    return corners


# The stiffness of an element over its corners (0, 0), (1, 0), (0, 1), (1, 1), by a conductivity of 1: from the integrals of the
# gradients of bilinear functions over a square (any text on finite elements).
CORNERS = [(0, 0), (1, 0), (0, 1), (1, 1)]
STIFFNESS = np.array([[4, -1, -1, -2], [-1, 4, -2, -1], [-1, -2, 4, -1], [-2, -1, -1, 4]]) / 6.0


class Poisson:
    """Readings of the equation and their gradient, by the logarithms of the conductivities."""

    def __init__(self):
        entries, self.cells = [], []
        for y in range(ELEMENTS):
            for x in range(ELEMENTS):
                own = [node(x + a, y + b) for a, b in CORNERS]
                self.cells.append((square(x, y), own))
                for i in range(4):
                    for j in range(4):
                        if own[i] >= own[j] >= 0:
                            entries.append(((own[i] - own[j]) * INNER * INNER + own[j], square(x, y), STIFFNESS[i, j]))
        self.rows = 1 + INNER + 1
        place, column, value = zip(*entries)
        shape = (self.rows * INNER * INNER, SQUARES * SQUARES)
        self.band = scipy.sparse.csr_matrix((value, (place, column)), shape)
        weights = [(number, corner, weight) for number in range(POINTS**2) for corner, weight in point(number).items()]
        row, column, value = zip(*weights)
        self.readings = scipy.sparse.csr_matrix((value, (row, column)), (POINTS**2, INNER * INNER))
        self.transposed = self.readings.T.tocsr()
        self.load = np.full(INNER * INNER, LOAD / ELEMENTS**2)
        # Corners of each element, by square; the rim is one node more, at 0.
        order = np.argsort([cell[0] for cell in self.cells], kind="stable")
        self.corners = np.array([self.cells[k][1] for k in order])
        self.corners[self.corners < 0] = INNER * INNER

    def solve(self, logarithms):
        """The factor, the solution and the conductivities."""
        conductivities = np.exp(logarithms)
        band = (self.band @ conductivities).reshape(self.rows, INNER * INNER)
        factor = scipy.linalg.cholesky_banded(band, lower=True, check_finite=False)
        return factor, self.back(factor, self.load), conductivities

    @staticmethod
    def back(factor, side):
        return scipy.linalg.cho_solve_banded((factor, True), side, check_finite=False)

    def slopes(self, adjoint, solution, conductivities):
        """Minus the adjoint times the derivative of the matrix times the solution, by logarithm."""
        ends = [np.append(vector, 0.0)[self.corners] for vector in (adjoint, solution)]
        products = np.einsum("ci,ij,cj->c", ends[0], STIFFNESS, ends[1], optimize=True)
        return -conductivities * products.reshape(SQUARES * SQUARES, -1).sum(axis=1)

    def density(self, logarithms):
        """Logarithm of the posterior density but for a constant, and its gradient."""
        factor, solution, conductivities = self.solve(logarithms)
        residuals = self.readings @ solution - MEASURED
        value = -0.5 * residuals @ residuals / SIGMA**2 - 0.5 * logarithms @ logarithms / PRIOR_SD**2
        adjoint = self.back(factor, self.transposed @ (-residuals / SIGMA**2))
        return value, self.slopes(adjoint, solution, conductivities) - logarithms / PRIOR_SD**2

    def curvature(self, logarithms):
        """The negative Hessian without second derivatives of the readings (Gauss and Newton)."""
        factor, solution, conductivities = self.solve(logarithms)
        adjoints = self.back(factor, self.transposed.toarray())
        jacobian = np.array([self.slopes(adjoint, solution, conductivities) for adjoint in adjoints.T]) / SIGMA
        return jacobian.T @ jacobian + np.eye(SQUARES**2) / PRIOR_SD**2


def most_probable(model):
    """By steps of Gauss and Newton that are shortened until the density rises."""
    at = np.zeros(SQUARES**2)
    value, gradient = model.density(at)
    for _ in range(100):
        step = np.linalg.solve(model.curvature(at), gradient)
        share = min(1.0, 3.0 / np.abs(step).max())
        while True:
            trial = model.density(at + share * step)
            if trial[0] > value or share < 1e-9:
                break
            share *= 0.5
        gained, at = trial[0] - value, at + share * step
        value, gradient = trial
        if gained < 1e-10:
            return at
    raise ArithmeticError("no most probable point")


def chain(model, centre, spread, seed, trajectories, warmup):
    """Draws of one chain: (trajectories, 64); a share of acceptance and the gradients that it took."""
    random = np.random.default_rng(seed)
    at = 1.5 * random.standard_normal(len(centre))
    value, gradient = model.density(centre + spread @ at)
    gradient = spread.T @ gradient
    step, draws, accepted, gradients = 0.2, [], 0.0, 0
    for trajectory in range(-warmup, trajectories):
        momentum = random.standard_normal(len(at))
        # Lengths that vary keep no direction from turning (Neal 2011, 3.2).
        own = step * random.uniform(0.8, 1.2)
        count = random.integers(1, 2 * max(1, round(1.2 / step)) + 1)
        trial, slope, speed = at, gradient, momentum
        change = -math.inf
        for _ in range(count):
            speed = speed + 0.5 * own * slope
            trial = trial + own * speed
            logarithms = centre + spread @ trial
            gradients += 1
            # A trajectory that leaves what numbers can hold is refused.
            if np.abs(logarithms).max() > 100.0:
                break
            try:
                ahead, slope = model.density(logarithms)
            except np.linalg.LinAlgError:
                break
            slope = spread.T @ slope
            speed = speed + 0.5 * own * slope
        else:
            change = ahead - value + 0.5 * (momentum @ momentum - speed @ speed)
        probability = math.exp(min(0.0, change)) if change == change else 0.0
        if random.uniform() < probability:
            at, value, gradient = trial, ahead, slope
        if trajectory < 0:
            step *= math.exp(0.1 * (probability - 0.8))
        else:
            accepted += probability / trajectories
            draws.append(centre + spread @ at)
    return np.array(draws), accepted, gradients


def effective(chains):
    """Effective number of draws of each parameter: chains, draws, parameters."""
    count, length, width = chains.shape
    centred = chains - chains.mean(axis=1, keepdims=True)
    padded = np.fft.rfft(centred, 2 * length, axis=1)
    within = np.fft.irfft(padded * padded.conj(), axis=1)[:, :length].mean(axis=0) / length
    variance = within[0] * length / (length - 1)
    total = within[0] + (chains.mean(axis=1).var(axis=0, ddof=1) if count > 1 else 0.0)
    sizes = []
    for k in range(width):
        correlation = 1.0 - (variance[k] - within[:, k]) / total[k]
        pairs = correlation[0 : length - 1 : 2] + correlation[1:length:2]
        positive = np.argmax(pairs < 0) if (pairs < 0).any() else len(pairs)
        sizes.append(count * length / (2 * np.minimum.accumulate(pairs[:positive]).sum() - 1))
    return np.array(sizes)


def study(folder, chains, draws, warmup):
    """Writes the network with its readings as a study."""
    conductors = {}
    for y in range(ELEMENTS):
        for x in range(ELEMENTS):
            own = [node(x + a, y + b) for a, b in CORNERS]
            for i in range(4):
                for j in range(i):
                    if own[i] != own[j]:
                        share = (square(x, y), -float(STIFFNESS[i, j]))
                        conductors.setdefault((min(own[i], own[j]), max(own[i], own[j])), []).append(share)
    name = lambda number: "rim" if number < 0 else f"n{number}"
    text = lambda shares: " + ".join(f"exp(b{own}) * {share!r}" for own, share in shares)
    model = {
        "format": "bmv-network/1", "title": "Poisson equation of Aristoff and Bangerth",
        "parameters": {
            f"b{k}": {"nominal": 0, "unit": "1", "prior": {"normal": {"mean": 0, "sd": PRIOR_SD}}} for k in range(SQUARES**2)
        },
        "nodes": {"rim": {"boundary": ZERO_K}} | {name(k): {} for k in range(INNER**2)},
        "conductors": {
            f"{name(a)}-{name(b)}": {"between": [name(a), name(b)], "conductance": text(shares)}
            for (a, b), shares in conductors.items()
        },
        "loads": {f"q{k}": {"into": name(k), "power": LOAD / ELEMENTS**2} for k in range(INNER**2)},
        "quantities": {
            f"z{k}": {"mean": {name(corner): weight for corner, weight in point(k).items()}} for k in range(POINTS**2)
        },
    }
    sensor = lambda k: {"measures": f"z{k}", "sigma": {"value": SIGMA, "unit": "K"}}
    sampler = {"data": ["readings"], "sampler": "nuts", "chains": chains, "warmup": warmup, "draws": draws}
    a_pass = {
        "format": "bmv-pass/1", "title": "Readings of the benchmark", "parent": None, "model": "model.json", "seed": 1,
        "measurements": {"readings": {"steady": {"file": "data/readings.csv", "sensors": {f"z{k}": sensor(k) for k in range(POINTS**2)}}}},
        "jobs": {"tuned": {"calibrate": sampler}},
    }
    (folder / "data").mkdir(parents=True, exist_ok=True)
    (folder / "model.json").write_text(json.dumps(model, indent=1))
    (folder / "pass-1.json").write_text(json.dumps(a_pass, indent=1))
    head = ",".join(["phase", *(f"z{k} [K]" for k in range(POINTS**2))])
    row = ",".join(["P1", *(f"{ZERO_K + value:.13f}" for value in MEASURED)])
    (folder / "data" / "readings.csv").write_text(f"{head}\n{row}\n")


def calibrated(program, folder):
    """What the program says of the parameters, and the CPU seconds that it took."""
    before = os.times()
    command = [program, "run", str(folder / "pass-1.json"), "--cache", str(folder / "cache"), "--force"]
    done = subprocess.run(command, stdout=subprocess.DEVNULL)
    after = os.times()
    if done.returncode not in (0, 4):
        sys.exit(f"{program} ended with status {done.returncode}")
    show = [program, "show", str(folder / "pass-1.json"), "tuned", "--json", "--cache", str(folder / "cache")]
    result = json.loads(subprocess.run(show, capture_output=True, check=True).stdout)
    return result, after.children_user + after.children_system - before.children_user - before.children_system


def main(program, folder, trajectories, chains, draws, warmup):
    model, folder = Poisson(), pathlib.Path(folder)
    cases = json.loads((HERE / "cases.json").read_text())
    worst = max(
        np.abs(model.readings @ model.solve(np.log(case["conductivities"]))[1] - case["readings"]).max() for case in cases
    )
    print(f"published solutions: {worst:.1e} at most")
    study(folder / "study", chains, draws, warmup)
    result, cpu_s = calibrated(program, folder / "study")
    own = result["parameters"]
    clock = time.process_time()
    centre = most_probable(model)
    # The inverse root of the curvature.
    spread = np.linalg.inv(np.linalg.cholesky(model.curvature(centre))).T
    runs = [chain(model, centre, spread, seed, trajectories, trajectories // 10) for seed in range(4)]
    clock = time.process_time() - clock
    sampled = np.array([run[0] for run in runs])
    sizes = effective(sampled)
    flat = sampled.reshape(-1, SQUARES**2)
    mean, sd = flat.mean(axis=0), flat.std(axis=0, ddof=1)
    gradients, acceptance = sum(run[2] for run in runs), np.mean([run[1] for run in runs])
    print(f"sampler: {gradients} gradients, {clock:.0f} s of CPU, acceptance {acceptance:.2f}, effective draws {sizes.min():.0f} to {sizes.max():.0f}")
    ess = [own[f"b{k}"]["ess_bulk"] for k in range(SQUARES**2)]
    rhat = [own[f"b{k}"]["rhat"] for k in range(SQUARES**2)]
    print(f"bmv: {cpu_s:.0f} s of CPU, effective draws {min(ess):.0f} to {max(ess):.0f}, R-hat {max(rhat):.4f} at most")
    print("square  mean: bmv, sampler  error     z   sd: bmv, sampler")
    scores, ratios = [], []
    for k in range(SQUARES**2):
        one = own[f"b{k}"]
        error = math.hypot(one["mcse_mean"], sd[k] / math.sqrt(sizes[k]))
        scores.append((one["mean"] - mean[k]) / error)
        ratios.append(one["sd"] / sd[k])
        print(f"{k:6} {one['mean']:9.4f} {mean[k]:9.4f} {error:7.4f} {scores[-1]:6.2f} {one['sd']:9.4f} {sd[k]:9.4f}")
    scores = np.array(scores)
    print(f"means: largest |z| {np.abs(scores).max():.2f}, root mean square {math.sqrt((scores**2).mean()):.2f}")
    print(f"standard deviations: ratios {min(ratios):.3f} to {max(ratios):.3f}")
    np.savez_compressed(folder / "sampled.npz", mean=mean, sd=sd, sizes=sizes)
    sys.exit(int(np.abs(scores).max() > FARTHEST))


parser = argparse.ArgumentParser()
parser.add_argument("program")
parser.add_argument("folder")
for option, default in [("trajectories", 5000), ("chains", 4), ("draws", 1000), ("warmup", 500)]:
    parser.add_argument(f"--{option}", type=int, default=default)
main(**vars(parser.parse_args()))
