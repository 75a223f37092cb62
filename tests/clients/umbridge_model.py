"""Asks a served network with the reference client of UM-Bridge in Python and holds its derivatives against differences.

usage: umbridge_model.py BMV [PASS]

Skipped, and said so, where the package `umbridge` is not installed.
"""

import subprocess
import sys
import time


def main(bmv, path="studies/radiator/pass-1.json"):
    try:
        import requests
        import umbridge
    except ImportError as missing:
        print(f"SKIPPED: {missing}; the served model was not asked by the reference client (pip install umbridge)")
        return
    server = subprocess.Popen([bmv, "serve-model", path, "--port", "0"], stdout=subprocess.PIPE, text=True)
    try:
        url = server.stdout.readline().split(" at ")[1].strip()
        model = umbridge.HTTPModel(url, "forward")
        about = requests.post(f"{url}/ModelInfo", json={"name": "forward"}).json()
        at = [[float(entry["nominal"]) for entry in vector] for vector in about["inputs"]]
        assert model.get_input_sizes() == [len(vector) for vector in at]
        outputs = model.get_output_sizes()[0]
        assert model.supports_evaluate() and model.supports_gradient() and model.supports_apply_jacobian()
        values = model(at)[0]
        assert len(values) == outputs
        worst, compared = 0.0, 0
        for vector, entries in enumerate(at):
            for place, nominal in enumerate(entries):
                step = 1e-4 * (abs(nominal) or 1.0)

                def moved(by):
                    there = [list(values) for values in at]
                    there[vector][place] += by
                    return model(there)[0]

                # Fourth order: the error of the difference is that of the solution over the step.
                near, far = [[(b - a) for a, b in zip(moved(-h), moved(h))] for h in (step, 2 * step)]
                difference = [(8 * a - b) / (12 * step) for a, b in zip(near, far)]
                direction = [float(place == other) for other in range(len(entries))]
                exact = model.apply_jacobian(0, vector, at, direction)
                for output in range(outputs):
                    sens = [float(output == other) for other in range(outputs)]
                    adjoint = model.gradient(0, vector, at, sens)[place]
                    scale = max(abs(exact[output]), 1e-6 * abs(values[output]) / step, 1e-12)
                    assert abs(adjoint - exact[output]) < 1e-9 * scale, (adjoint, exact[output])
                    worst = max(worst, abs(difference[output] - exact[output]) / scale)
                    compared += 1
        assert worst < 1e-5, worst
        try:
            model([[0.0] * (len(at[0]) + 1)] + at[1:])
            raise AssertionError("a wrong length was taken")
        except Exception as refused:
            assert "InvalidInput" in str(refused), refused
        times = []
        with requests.Session() as session:
            body = {"name": "forward", "input": at}
            for _ in range(300):
                begun = time.perf_counter()
                assert session.post(f"{url}/Evaluate", json=body).json()["output"][0] == values
                times.append(1e3 * (time.perf_counter() - begun))
        times.sort()
        print(f"{path}: {compared} derivatives within {worst:.1e} of differences; a call on a kept connection takes {times[0]:.2f} ms at best, {times[150]:.2f} ms in the median")
    finally:
        server.kill()
        server.wait()


if __name__ == "__main__":
    main(*sys.argv[1:])
