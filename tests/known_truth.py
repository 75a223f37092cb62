"""Diagnoses campaigns whose truth is written beside them and counts what is right.

usage: known_truth.py BMV CAMPAIGN...

Each CAMPAIGN is a folder with `pass-1.json` and `truth.json`: `truth` and `alternatives` list effects with their places, `rmse_after.held_out`
is the error that an ordinary fit with the truth reaches, K; `widen` lists parameters whose priors are too narrow. Right: an effect of either list is selected first, or in the first step's group. `decoys` lists effects that must not be selected.
"""

import json
import pathlib
import subprocess
import sys
import tempfile


def fits(listed, effect):
    """Whether an effect of the answer is a listed one: the same law, where a place or an input is given with the same."""
    if isinstance(listed, str):
        return listed == effect["effect"]
    place = set(listed.get("where") or [])
    same_input = listed.get("input") in (None, effect.get("input"))
    return listed["effect"] == effect["effect"] and place <= set(effect["where"]) and same_input


def shown(value):
    return "-" if value is None else f"{value:.2f}"


def main(bmv, campaigns):
    right, wrong, asked, misled = 0, 0, 0, 0
    print(f"{'campaign':30} {'verdict':12} {'first':6} {'above 0.9':10} {'decoys':7} {'held out [K]':16} selected")
    for folder in map(pathlib.Path, campaigns):
        if not (folder / "truth.json").is_file():
            continue
        truth = json.loads((folder / "truth.json").read_text())
        listed = (truth.get("truth") or []) + (truth.get("alternatives") or [])
        if truth.get("event_phase"):
            # A change for good, described before there were effects that set in at a date.
            listed += [{**one, "effect": "dated-conductance"} for one in listed if one["effect"] == "conductance-step"]
        listed += [{"effect": "prior-of", "where": [name]} for name in truth.get("widen") or []]
        with tempfile.TemporaryDirectory() as cache:
            command = [str(pathlib.Path(bmv).resolve()), "diagnose", "pass-1.json", "--json", "--cache", cache]
            run = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        if run.returncode not in (0, 1) or not run.stdout.startswith("{"):
            print(f"{folder.name:30} failed: {run.stderr.strip()[-200:]}")
            asked += 1
            continue
        answer = json.loads(run.stdout)
        effects = {effect["id"]: effect for effect in answer["effects"]}
        is_right = lambda name: any(fits(one, effects[name]) for one in listed)
        selected = [name for name in answer["selected"] if name in effects]
        groups = {effects[name].get("group") for name in selected} - {None}
        near = [name for name in effects if effects[name].get("group") in groups]
        steps = answer.get("steps") or []
        first = near if not steps else [steps[0]["effect"], *steps[0]["alternatives"]]
        found = any(is_right(name) for name in first if name in effects) if listed else not selected
        sure = [name for name in effects if effects[name]["probability"] > 0.9 and not is_right(name)]
        error = next((m["rmse_k"]["held_out"] for m in answer["models"] if sorted(m["effects"]) == sorted(selected)), None)
        mark = (truth.get("rmse_after") or {}).get("held_out")
        decoys = [name for name in selected if not is_right(name) and any(fits(one, effects[name]) for one in truth.get("decoys") or [])]
        asked, right, wrong, misled = asked + 1, right + found, wrong + bool(sure), misled + bool(decoys)
        errors = shown(error) + (f" of {shown(mark)}" if mark else "")
        print(f"{folder.name:30} {answer['verdict']:12} {'right' if found else 'no':6} {len(sure):<10} {len(decoys):<7} {errors:16} {' + '.join(selected)}")
    print(f"{right} of {asked} right in the first step; {wrong} with a wrong name above 0.9; {misled} with a decoy selected")


if len(sys.argv) < 3:
    sys.exit(__doc__)
main(sys.argv[1], sys.argv[2:])
