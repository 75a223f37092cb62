"""Serves a model of five lines with the reference package of UM-Bridge in Python and asks it from a study: propagation,
sensitivity, the choice of an experiment, calibration, and the last again through a surrogate; then the same model with
derivatives (Gradient, ApplyJacobian or both), which must be those of the differences, and by which trajectories run.

usage: umbridge_server.py BMV

Skipped, and said so, where the package `umbridge` is not installed.
"""

import json
import math
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time

SERVER = """
import sys, umbridge
class Plate(umbridge.Model):
    def __init__(self): super().__init__("plate")
    def get_input_sizes(self, config): return [1, 1]
    def get_output_sizes(self, config): return [1]
    def __call__(self, given, config): return [[20.0 + given[1][0] / given[0][0]]]
    def supports_evaluate(self): return True
class Sloped(Plate):
    def __init__(self, name, *offers): umbridge.Model.__init__(self, name); self.offers = offers
    def slope(self, given, vector): return [-given[1][0] / given[0][0] ** 2, 1 / given[0][0]][vector]
    def supports_gradient(self): return "Gradient" in self.offers
    def supports_apply_jacobian(self): return "ApplyJacobian" in self.offers
    def gradient(self, out, vector, given, sens, config): return [sens[0] * self.slope(given, vector)]
    def apply_jacobian(self, out, vector, given, vec, config): return [vec[0] * self.slope(given, vector)]
umbridge.serve_models([Plate(), Sloped("gradient", "Gradient"), Sloped("direction", "ApplyJacobian"),
                       Sloped("both", "Gradient", "ApplyJacobian")], int(sys.argv[1]))
"""


def numbers(document):
    """All numbers of a document, in order."""
    if isinstance(document, (dict, list)):
        parts = document.values() if isinstance(document, dict) else document
        return [number for part in parts for number in numbers(part)]
    return [document] if isinstance(document, float) else []


def main(bmv):
    try:
        import umbridge  # noqa: F401
    except ImportError as missing:
        print(f"SKIPPED: {missing}; no study asked the reference server (pip install umbridge)")
        return
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "serve.py").write_text(SERVER)
        study = root / "plate"
        study.mkdir()
        model = {
            "format": "bmv-network/1",
            "inputs": {"Q": {"unit": "W", "nominal": 10, "range": [5, 10]}},
            "parameters": {"G": {"unit": "W/K", "nominal": 0.5, "prior": {"uniform": [0.4, 0.6]}}},
            "umbridge": {"url": f"http://127.0.0.1:{port}", "name": "plate", "version": "1",
                         "outputs": {"plate": {"unit": "degC"}}, "steps": {"G": 1e-4}},
        }
        (study / "model.json").write_text(json.dumps(model))
        (study / "balance.csv").write_text("phase,Q [W],plate [degC]\nP1,10,40.0\nP2,5,30.0\n")
        sensor = {"measures": "plate", "sigma": {"value": 0.2, "unit": "K"}}
        jobs = {
            "prior": {"propagate": {"samples": 1024}},
            "effects": {"sensitivity": {"methods": ["local"]}},
            "phases": {"design": {"conditions": {"Q": [5, 10]}, "estimator": "nested", "outer": 1024, "inner": 512}},
            "fit": {"calibrate": {"sampler": "smc", "chains": 4, "draws": 64}},
        }
        (study / "pass-1.json").write_text(json.dumps(
            {"format": "bmv-pass/1", "title": "Plate", "parent": None, "model": "model.json", "seed": 1,
             "measurements": {"balance": {"steady": {"file": "balance.csv", "sensors": {"plate": sensor}}}}, "jobs": jobs}))
        sloped = {"effects": {"sensitivity": {"methods": ["local"]}},
                  "linear": {"design": {"conditions": {"Q": [5, 10]}, "estimator": "linear"}},
                  "fit": {"calibrate": {"sampler": "nuts", "chains": 4, "warmup": 100, "draws": 100}}}
        served = {name: root / name for name in ["gradient", "direction", "both"]}
        for name, folder in served.items():
            shutil.copytree(study, folder)
            named = {key: value for key, value in model["umbridge"].items() if key != "steps"}
            (folder / "model.json").write_text(json.dumps(
                {**model, "umbridge": {**named, "name": name, "derivatives": "served"}}))
            passed = json.loads((folder / "pass-1.json").read_text())
            (folder / "pass-1.json").write_text(json.dumps({**passed, "jobs": sloped}))
        quick = root / "quick"
        shutil.copytree(study, quick)
        (quick / "model.json").write_text(json.dumps({**model, "surrogate": {"runs": 16}}))

        def result(folder, job):
            shown = subprocess.run([bmv, "show", folder / "pass-1.json", job, "--json", "--run"], capture_output=True,
                                   text=True)
            # Short chains need not have converged.
            assert shown.returncode in (0, 4), shown.stderr
            return json.loads(shown.stdout)

        server = subprocess.Popen([sys.executable, root / "serve.py", str(port)], stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL)
        try:
            for _ in range(100):
                with socket.socket() as probe:
                    if probe.connect_ex(("127.0.0.1", port)) == 0:
                        break
                time.sleep(0.1)
            begun = time.monotonic()
            prior = result(study, "prior")
            seconds = time.monotonic() - begun
            effects, phases = result(study, "effects"), result(study, "phases")
            fits = [result(study, "fit"), result(quick, "fit")]
            surrogate = result(quick, "surrogate")
            slopes = {name: [result(folder, job) for job in sloped] for name, folder in served.items()}
        finally:
            server.kill()
            server.wait()
        plate = prior["quantities"]["plate"]
        assert prior["failed"] == 0
        # Mean of 10 W / G with G uniform from 0.4 to 0.6, above 20 degC; a scrambled Sobol set of 1024 is within 1e-3.
        expected = 293.15 + 10 * math.log(0.6 / 0.4) / 0.2
        assert abs(plate["mean"] - expected) < 1e-2, (plate, expected)
        assert "local" in effects, effects
        # Where the prior is wide against the noise, the phases' information differs by the logarithm of their slopes' ratio, ln 2.
        low, high = [candidate["information_nats"] for candidate in phases["candidates"]]
        assert abs(high - low - math.log(2)) < 0.1, (low, high)
        # The slopes -Q / G^2 are -40 and -20 K per W/K: a standard deviation of 0.2 / sqrt(40^2 + 20^2).
        sd = 0.2 / math.hypot(40, 20)
        for fit in fits:
            found = fit["parameters"]["G"]
            assert abs(found["mean"] - 0.5) < 0.3 * sd and abs(found["sd"] / sd - 1) < 0.3, found
        [error] = [output["error"] for output in surrogate["outputs"]]
        assert error < 0.02, surrogate
        for name, (local, linear, fit) in slopes.items():
            exact, difference = numbers(local["local"]), numbers(effects["local"])
            # Central differences of a step of 1e-4 in 0.5 err by its square.
            assert exact and len(exact) == len(difference), (exact, difference)
            assert all(abs(a - b) < 1e-6 * abs(b) + 1e-12 for a, b in zip(exact, difference)), (name, exact, difference)
            low, high = [candidate["information_nats"] for candidate in linear["candidates"]]
            assert abs(high - low - math.log(2)) < 0.1, (name, low, high)
            found = fit["parameters"]["G"]
            assert abs(found["mean"] - 0.5) < 0.3 * sd and abs(found["sd"] / sd - 1) < 0.3, (name, found)
        print(f"derivatives of {', '.join(slopes)} are used: local effects, linear design, NUTS")
        print(f"{surrogate['runs']} runs give a surrogate with an error of {error:.1e} K, and the posterior of the model")
        print(f"a model of five lines answered 1024 samples in {seconds:.1f} s ({1e3 * seconds / 1024:.2f} ms a sample)")


if __name__ == "__main__":
    main(sys.argv[1])
