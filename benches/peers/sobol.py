"""Main and total effects with intervals beside SALib and OpenTURNS, in one run: Ishigami and Sobol's g, 2^16 base points.

usage: python benches/peers/sobol.py BMV [REPEATS]; needs numpy, SALib, openturns. Whole processes, the empty cache of `bmv` counted; medians of the
repeats. SALib and OpenTURNS: one scramble or shift, 100 bootstrap resamples; `bmv`: 8 scrambles of 2^13 base points, two threads.
"""
import json, os, statistics, sys, tempfile, time

PEER = r"""
import sys, numpy as np
peer, fun, N = sys.argv[1], sys.argv[2], 2 ** 16
if fun == "ishigami":
    d, lo, hi = 3, -np.pi, np.pi
    f = lambda x: np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + .1 * x[:, 2] ** 4 * np.sin(x[:, 0])
else:
    a = np.array([0, 1, 4.5, 9, 99, 99, 99, 99.]); d, lo, hi = 8, 0.0, 1.0
    f = lambda x: np.prod((np.abs(4 * x - 2) + a) / (1 + a), axis=1)
if peer == "SALib":
    from SALib.sample import sobol as ss
    from SALib.analyze import sobol as sa
    prob = dict(num_vars=d, names=[f"x{i}" for i in range(d)], bounds=[[lo, hi]] * d)
    Y = f(ss.sample(prob, N, calc_second_order=False, scramble=True, seed=1))
    r = sa.analyze(prob, Y, calc_second_order=False, num_resamples=100, seed=1)
    print(r["S1"], r["ST"], r["S1_conf"], r["ST_conf"])
else:
    import openturns as ot
    ot.RandomGenerator.SetSeed(1)
    dist = ot.JointDistribution([ot.Uniform(lo, hi)] * d)
    ot.ResourceMap.SetAsString("SobolIndicesExperiment-SamplingMethod", "QMC")
    X = ot.SobolIndicesExperiment(dist, N, False).generate()
    al = ot.SaltelliSensitivityAlgorithm(X, ot.Sample(f(np.asarray(X)).reshape(-1, 1)), N)
    al.setBootstrapSize(100); al.setUseAsymptoticDistribution(False)
    print(al.getFirstOrderIndices(), al.getTotalOrderIndices(), al.getFirstOrderIndicesInterval(), al.getTotalOrderIndicesInterval())
"""


def timed(command, cwd):
    """Wall time, CPU time and peak memory of a process."""
    t = time.perf_counter()
    null = os.open(os.devnull, os.O_WRONLY)
    here = os.getcwd(); os.chdir(cwd)
    pid = os.posix_spawnp(command[0], command, os.environ, file_actions=[(os.POSIX_SPAWN_DUP2, null, 1), (os.POSIX_SPAWN_DUP2, null, 2)])
    os.chdir(here); os.close(null)
    _, status, usage = os.wait4(pid, 0)
    assert status == 0, command
    return time.perf_counter() - t, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def main():
    bmv, repeats = os.path.abspath(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 5
    tests = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../tests/verification")
    print("load", os.getloadavg())
    for function in ("ishigami", "sobol-g"):
        runs = {"bmv": [], "SALib": [], "OpenTURNS": []}
        with tempfile.TemporaryDirectory() as folder:
            open(f"{folder}/model.json", "w").write(open(f"{tests}/{function}/model.json").read())
            job = {"effects": {"sensitivity": {"methods": ["sobol"], "samples": 8192, "scrambles": 8}}}
            json.dump({"format": "bmv-pass/1", "title": "t", "model": "model.json", "jobs": job}, open(f"{folder}/pass-1.json", "w"))
            for _ in range(repeats):
                runs["bmv"].append(timed([bmv, "run", "pass-1.json", "--threads", "2", "--cache", tempfile.mkdtemp(dir=folder)], folder))
                for peer in ("SALib", "OpenTURNS"):
                    runs[peer].append(timed([sys.executable, "-c", PEER, peer, function], folder))
        own = [statistics.median(run[k] for run in runs["bmv"]) for k in range(3)]
        for name, all_runs in runs.items():
            wall, cpu, peak = (statistics.median(run[k] for run in all_runs) for k in range(3))
            print(f"{function}, {name}: wall {wall:.3f} s, CPU {cpu:.3f} s, peak {peak:.0f} MiB; by bmv: wall {wall / own[0]:.1f}, CPU {cpu / own[1]:.1f}")


main()
