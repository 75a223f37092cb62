"""How soon large reports are painted, and how large their pages are.

usage: first_paint.py PROGRAM [FOLDER]     (target/first-paint)

Two studies of `large_report.py`: 43 phases of 20 sensors; the same with 10 transients of 10,000 rows. Each is run and its report opened
in a headless Chromium of 1280 x 800, three times; of the first paint and the first paint with content the slowest is said. Less
than 1 s and less than 5 MB are wanted: what misses either ends with status 1.
"""

import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / ".ci"))
import browser  # noqa: E402

STUDIES = {"43 phases, 20 sensors": ("phases", "43", "20", "0", "0"),
           "43 phases and 10 transients of 10,000 rows, 20 sensors": ("transients", "43", "20", "10", "10000")}
PAINT = "Object.fromEntries(performance.getEntriesByType('paint').map((one) => [one.name, one.startTime]))"
MOST_S, MOST_BYTES = 1.0, 5e6
TIMES = 3


def report(program, folder, name, numbers):
    """The page of the report on such a study, and how long rendering it takes, s."""
    study = folder / "studies" / name
    if not study.is_dir():
        subprocess.run([sys.executable, ROOT / "benches/sizes/large_report.py", study, *numbers], check=True)
    out = folder / "reports"
    command = [program, "report", str(study), "--cache", str(folder / "cache"), "--out", str(out)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    begun = time.monotonic()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return out / name / "pass-1/report.html", time.monotonic() - begun


def painted(own, page):
    """First paint and first paint with content, s."""
    own.open(page.as_uri())
    until = time.monotonic() + 30
    while time.monotonic() < until:
        paints = own.evaluate(PAINT)
        if "first-contentful-paint" in paints:
            return paints["first-paint"] / 1000, paints["first-contentful-paint"] / 1000
        time.sleep(0.1)
    raise browser.Failed("no paint within 30 s")


def main(program, folder=None):
    folder = pathlib.Path(folder or ROOT / "target/first-paint").resolve()
    chromium = browser.find()
    if not chromium:
        print("SKIPPED: there is no Chromium on the PATH, so no paint was timed")
        return
    own, is_kept = browser.Browser(chromium), True
    try:
        own.size(1280, 800)
        for title, (name, *numbers) in STUDIES.items():
            page, rendered = report(program, folder, name, numbers)
            times = [painted(own, page) for _ in range(TIMES)]
            first, content = (max(of) for of in zip(*times))
            size = page.stat().st_size
            is_kept &= content < MOST_S and size < MOST_BYTES
            print(f"{title}: report.html {size / 1e6:.2f} MB, made in {rendered:.1f} s; first paint {first:.2f} s, with content {content:.2f} s")
    finally:
        own.close()
    if not is_kept:
        sys.exit(f"wanted: less than {MOST_BYTES / 1e6:.0f} MB and a first paint in less than {MOST_S:.0f} s")


main(*sys.argv[1:])
