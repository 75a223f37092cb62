"""Nested Monte Carlo beside vectorised numpy, in one run: the example of Huan & Marzouk (2013, section 5.1), 11 values of d.

usage: python benches/peers/expected_information.py BMV [REPEATS]; needs numpy. Whole processes, one thread each, empty cache; the least CPU
time of the repeats. numpy reuses its outer samples as inner ones (N = M = 4000), all 11 x 4000^2 pairs at once in blocks of 1000 rows.
"""
import json, os, subprocess, sys, tempfile, time

NUMPY = r"""
import numpy as np
SG, N = 1e-2, 4000
g = lambda th, d: th ** 3 * d ** 2 + th * np.exp(-np.abs(.2 - d))
for d in np.linspace(0, 1, 11):
    r = np.random.default_rng(1); th = r.uniform(size=N); e = r.standard_normal(N); y = g(th, d) + SG * e
    terms = []
    for a in range(0, N, 1000):
        q = -.5 * ((y[a:a + 1000, None] - g(th, d)[None]) / SG) ** 2
        mx = q.max(1, keepdims=True)
        terms.append(-.5 * e[a:a + 1000] ** 2 - mx[:, 0] - np.log(np.exp(q - mx).mean(1)))
    t = np.concatenate(terms)
    print(t.mean(), t.std(ddof=1) / N ** .5)
"""
EXACT = [3.008295006, 3.116823719, 3.241977400, 3.195570218, 3.172521617, 3.171135048, 3.188370417, 3.220719179, 3.264830112,
         3.317815831, 3.377332214]
MODEL = {"format": "bmv-network/1", "title": "y = theta^3 d^2 + theta exp(-|0.2 - d|)",
         "inputs": {"d": {"unit": "1", "nominal": 0, "range": [0, 1]}},
         "parameters": {"theta": {"unit": "1", "nominal": 0.5, "prior": {"uniform": [0, 1]}}},
         "quantities": {"y": {"expression": {"of": "theta^3 * d^2 + theta * exp(-abs(0.2 - d))", "unit": "1"}}}}
ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")


def timed(command, cwd):
    before, t = os.times(), time.perf_counter()
    out = subprocess.run(command, cwd=cwd, env=ENVIRONMENT, capture_output=True, text=True, check=True).stdout
    after = os.times()
    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    return cpu, time.perf_counter() - t, out


def program(bmv, folder, outer, inner):
    job = {"design": {"conditions": {"d": {"from": 0, "to": 1, "steps": 11}}, "outer": outer, "inner": inner,
                      "sensors": {"y": {"measures": "y", "sigma": 0.01}}}}
    study = {"format": "bmv-pass/1", "title": "t", "model": "model.json", "seed": 7, "jobs": {"j": job}}
    json.dump(MODEL, open(f"{folder}/model.json", "w")); json.dump(study, open(f"{folder}/pass-1.json", "w"))
    cache = tempfile.mkdtemp(dir=folder)
    cpu, wall, _ = timed([bmv, "run", "pass-1.json", "--threads", "1", "--cache", cache], folder)
    shown = timed([bmv, "show", "pass-1.json", "--json", "--cache", cache], folder)[2]
    return cpu, wall, [(c["information_nats"], c["se"], c["bias_bound"]) for c in candidates(json.loads(shown))]


def candidates(value):
    if isinstance(value, dict):
        if "candidates" in value:
            return value["candidates"]
        value = list(value.values())
    for own in value if isinstance(value, list) else []:
        found = candidates(own)
        if found:
            return found


def main():
    bmv, repeats = os.path.abspath(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 5
    with tempfile.TemporaryDirectory() as folder:
        best = {}
        for _ in range(repeats):
            cpu, wall, out = timed([sys.executable, "-c", NUMPY], folder)
            rows = [tuple(map(float, line.split())) for line in out.splitlines()]
            runs = [("numpy, N = M = 4000", cpu, wall, [(v, s, None) for v, s in rows])]
            for outer, inner in ((256, 128), (512, 256), (1024, 512), (2048, 1024)):
                runs.append((f"bmv, {outer} outer, {inner} inner", *program(bmv, folder, outer, inner)))
            for name, cpu, wall, rows in runs:
                if name not in best or cpu < best[name][0]:
                    best[name] = (cpu, wall, rows)
        print("load", os.getloadavg())
        for name, (cpu, wall, rows) in best.items():
            errors = [abs(v - x) for (v, _, _), x in zip(rows, EXACT)]
            ses, biases = [s for _, s, _ in rows], [b or 0 for _, _, b in rows]
            print(f"{name}: CPU {cpu:.3f} s, wall {wall:.3f} s, standard error {min(ses):.5f} to {max(ses):.5f}, bias bound at most "
                  f"{max(biases):.5f}, largest error {max(errors):.5f}, CPU of numpy / own {best['numpy, N = M = 4000'][0] / cpu:.1f}")


main()
