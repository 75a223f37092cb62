"""Reads exported calibrations with ArviZ and holds its numbers against the program's own.

usage: arviz_export.py BMV [PASS...]

Without PASS all passes of the studies that calibrate. Of each calibration: `az.summary`, `az.loo` and `az.plot_ppc` run on the file as it is,
R-hat and effective sample sizes are the program's to 1e-10, the log likelihoods of the readings add up to that of the draw, and a second
export has the same bytes. `az.compare` runs over the two passes of `hidden-effect`. Skipped, and said so, where ArviZ is not installed.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import warnings

CLOSE = 1e-10


def run(*command):
    return subprocess.run([str(part) for part in command], capture_output=True, text=True)


def check(folder, bmv, number, path, job, az, np, plt):
    """Exports one calibration and checks it; gives the data, or nothing where it does not run."""
    out = folder / f"{number}.nc"
    cache = ["--cache", folder / "cache"]
    made = run(bmv, "export", path, "--job", job, "--out", out, *cache)
    if made.returncode not in (0, 4):
        print(f"SKIPPED {path} {job}: {(made.stderr.strip().splitlines() or ['no reason'])[-1]}")
        return None
    again = folder / f"{number}-again.nc"
    run(bmv, "export", path, "--job", job, "--out", again, "--threads", 1, *cache)
    assert out.read_bytes() == again.read_bytes(), f"{path} {job}: other bytes"
    again.unlink()
    own = json.loads(run(bmv, "show", path, job, "--json", *cache).stdout)
    data = az.from_netcdf(out)
    assert {"posterior", "sample_stats", "log_likelihood", "posterior_predictive", "prior", "observed_data", "constant_data"} <= set(data.groups())
    summary = az.summary(data)
    worst = 0.0
    mine = {data.posterior[name].attrs["long_name"]: name for name in data.posterior.data_vars}
    found = {"rhat": az.rhat(data), "ess_bulk": az.ess(data, method="bulk"), "ess_tail": az.ess(data, method="tail")}
    for name, expected in own["parameters"].items():
        for what, values in found.items():
            if expected[what] is not None:
                worst = max(worst, abs(float(values[mine[name]]) / expected[what] - 1))
    assert worst < CLOSE, f"{path} {job}: R-hat or effective sample size differ by {worst}"
    assert len(summary) == len(own["order"])
    total = data.log_likelihood["readings"].sum("reading").values
    apart = np.abs(total / data.sample_stats["log_likelihood"].values - 1).max()
    assert apart < 1e-6, f"{path} {job}: the log likelihoods add up to another one, by {apart}"
    with warnings.catch_warnings():
        # That some Pareto k are high is a finding about the model, which the program states too.
        warnings.simplefilter("ignore")
        loo = az.loo(data)
    ours = own["leave_one_out"]
    if ours is not None and ours["unreliable"] == 0:
        # The program takes 400 of the draws.
        tolerance = 0.5 + 0.2 * ours["standard_error"]
        assert abs(loo.elpd_loo - ours["expected_log_density"]) < tolerance, f"{path} {job}: {loo.elpd_loo} {ours}"
    az.plot_ppc(data, num_pp_samples=20)
    plt.close("all")
    print(f"{path} {job}: {len(summary)} unknowns, {total.shape} draws, {data.observed_data.sizes['reading']} readings, within {worst:.1e}, elpd_loo {loo.elpd_loo:.2f}")
    return data


def main(bmv, paths):
    try:
        import arviz as az
        import matplotlib
        import numpy as np
    except ImportError as missing:
        print(f"SKIPPED: {missing}; exports were not read with ArviZ (pip install 'arviz<1' h5netcdf)")
        return
    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    bmv = pathlib.Path(bmv).resolve()
    kept = {}
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for path in paths or sorted(str(path) for path in pathlib.Path("studies").glob("*/pass-*.json")):
            jobs = json.loads(pathlib.Path(path).read_text()).get("jobs", {})
            for job in [name for name, form in jobs.items() if form and "calibrate" in form]:
                data = check(folder, bmv, len(list(folder.iterdir())), path, job, az, np, plt)
                if data is not None and "hidden-effect" in path:
                    kept[path] = data
        assert kept or paths, "no calibration was read"
        if len(kept) > 1:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                print(az.compare(kept)[["rank", "elpd_loo", "elpd_diff", "dse"]])


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
