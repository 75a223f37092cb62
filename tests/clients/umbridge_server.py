"""Serves a model of five lines with the reference package of UM-Bridge in Python and asks it from a study.

usage: umbridge_server.py BMV

Skipped, and said so, where the package `umbridge` is not installed.
"""

import json
import pathlib
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
umbridge.serve_models([Plate()], int(sys.argv[1]))
"""


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
            "inputs": {"Q": {"unit": "W", "nominal": 10}},
            "parameters": {"G": {"unit": "W/K", "nominal": 0.5, "prior": {"uniform": [0.4, 0.6]}}},
            "umbridge": {"url": f"http://127.0.0.1:{port}", "name": "plate", "version": "1",
                         "outputs": {"plate": {"unit": "degC"}}},
        }
        (study / "model.json").write_text(json.dumps(model))
        jobs = {"prior": {"propagate": {"samples": 1024}}}
        (study / "pass-1.json").write_text(json.dumps(
            {"format": "bmv-pass/1", "title": "Plate", "parent": None, "model": "model.json", "seed": 1, "jobs": jobs}))
        server = subprocess.Popen([sys.executable, root / "serve.py", str(port)], stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL)
        try:
            for _ in range(100):
                with socket.socket() as probe:
                    if probe.connect_ex(("127.0.0.1", port)) == 0:
                        break
                time.sleep(0.1)
            begun = time.monotonic()
            shown = subprocess.run([bmv, "show", study / "pass-1.json", "prior", "--json", "--run"], capture_output=True,
                                   text=True)
            seconds = time.monotonic() - begun
        finally:
            server.kill()
            server.wait()
        assert shown.returncode == 0, shown.stderr
        plate = json.loads(shown.stdout)["quantities"]["plate"]
        assert json.loads(shown.stdout)["failed"] == 0
        # Mean of 10 W / G with G uniform from 0.4 to 0.6, above 20 degC; a scrambled Sobol set of 1024 is within 1e-3.
        import math
        expected = 293.15 + 10 * math.log(0.6 / 0.4) / 0.2
        assert abs(plate["mean"] - expected) < 1e-2, (plate, expected)
        print(f"a model of five lines answered 1024 samples in {seconds:.1f} s ({1e3 * seconds / 1024:.2f} ms a sample)")


if __name__ == "__main__":
    main(sys.argv[1])
