"""Makes the tables of the campaigns beside it from the files that their origins publish.

usage: prepare.py BUILDING_CSV SATELLITE_CSV INTO

BUILDING_CSV: github.com/czagoni/darkgreybox at 280a7cd5849ad1c109c7aca8b68c52f09f1ca3f3, docs/tutorials/data/demo_data.csv (MIT).
SATELLITE_CSV: github.com/DelfiSpace/ThermalModel at 1e38661300b8f87de8d586a868beb405f09ea8b7, qb50p1_busepswod_all.csv (GPL-3.0).
INTO gets a folder a campaign with its study and data; the measurements themselves are not part of this repository.
"""

import csv
import datetime
import hashlib
import pathlib
import shutil
import sys

HASHES = {
    "building": "d462f1cfde5841a7f17fc2a37e1ad26eb1dccd528761303d088d6d7ec7e1363c",
    "qb50-p1": "e8b87e6d474af498c4ff683dfcb571276552e1bccc37ffe964fa7f2094dcade1",
}
PANELS = {"X+": "xp", "X-": "xm", "Y+": "yp", "Y-": "ym", "Z-": "zm"}
DAYS = {"May": ("2015-05-04 08:26:00", "2015-05-04 10:26:00"), "January": ("2015-01-20 07:47:00", "2015-01-20 09:32:00")}


def table(path, header, rows):
    path.parent.mkdir(exist_ok=True)
    with path.open("w", newline="") as out:
        csv.writer(out).writerows([header, *rows])


def building(raw, folder):
    """Four weeks and five days, hourly; the heating is a mean over the hour from the instant on."""
    rows = list(csv.reader(raw.open()))[1:]
    header = ["time [s]", "P_heat [kW]", "T_amb [degC]", "indoor [degC]"]
    table(folder / "data/building.csv", header, [[3600 * k, row[1], row[3], row[2]] for k, row in enumerate(rows)])


def satellite(raw, folder):
    """Two orbits whose rows lie without a long gap; every third row at most, 20 s apart or more."""
    lines = csv.reader(raw.open())
    names = next(lines)
    column = {name: names.index(name) for name in names}
    lines = sorted(lines)
    for day, (start, end) in DAYS.items():
        rows, last, first = [], None, None
        for line in lines:
            if not start <= line[0] < end:
                continue
            instant = datetime.datetime.fromisoformat(line[0])
            first = first or instant
            if last and (instant - last).total_seconds() < 20:
                continue
            last = instant
            amperes = [float(line[column[f"wodeps_{name}"]]) / 1000 for name in ("cursun", "cursys", "vbatt")]
            panels = [line[column[f"wodbus_panels_temp_{name}"]] for name in PANELS.values()]
            rows.append([int((instant - first).total_seconds()), *amperes, *panels, line[column["wodbus_obcsup_temp"]]])
        header = ["time [s]", "I_sun [A]", "I_sys [A]", "V_bat [V]", *[f"{panel} [degC]" for panel in PANELS], "computer [degC]"]
        table(folder / f"data/{day.lower()}.csv", header, rows)


def main(sources, into):
    for (name, raw), make in zip(sources.items(), (building, satellite)):
        if hashlib.sha256(raw.read_bytes()).hexdigest() != HASHES[name]:
            sys.exit(f"{raw} is not the file that the campaign was written for")
        folder = into / name
        shutil.copytree(pathlib.Path(__file__).parent / name, folder, dirs_exist_ok=True)
        make(raw, folder)


if len(sys.argv) != 4:
    sys.exit(__doc__)
main({"building": pathlib.Path(sys.argv[1]), "qb50-p1": pathlib.Path(sys.argv[2])}, pathlib.Path(sys.argv[3]))
