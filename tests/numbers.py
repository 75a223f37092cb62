#!/usr/bin/env python3
"""Compares every value of the rendered `results.json` files with those of a revision (HEAD, or the first argument).

Keys and hashes may differ, and so may sentences; a number that differs ends with status 1. For rebuilding without changing results:
`cargo run --release -- report && tests/numbers.py`.
"""
import json
import subprocess
import sys


# Names of the forms of results that changed, old to new: a revision from before the change is compared under the new ones.
RENAMED = {"handed_on": "posterior_priors", "handed_on_fits": "posterior_prior_fits"}


def leaves(value, path=()):
    if isinstance(value, dict):
        for key in value:
            # Of one parameter it is one.
            new = "posterior_prior" if key == "handed_on" and not isinstance(value[key], list) else RENAMED.get(key, key)
            yield from leaves(value[key], path + (new,))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from leaves(item, path + (index,))
    else:
        yield path, value


def git(*arguments):
    return subprocess.run(["git", *arguments], capture_output=True, text=True, check=True).stdout


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


revision = sys.argv[1] if len(sys.argv) > 1 else "HEAD"
differ = 0
for file in git("ls-files", "reports/*/results.json").split():
    before = dict(leaves(json.loads(git("show", f"{revision}:{file}"))))
    with open(file, encoding="utf-8") as text:
        after = dict(leaves(json.load(text)))
    missing = object()
    changed = [path for path in before.keys() | after.keys() if before.get(path, missing) != after.get(path, missing)]
    numbers = [path for path in changed if is_number(before.get(path)) or is_number(after.get(path))]
    print(f"{file}: {len(after)} values, {len(numbers)} numbers and {len(changed) - len(numbers)} texts differ")
    for path in sorted(numbers, key=str)[:10]:
        print("   ", ".".join(map(str, path)), before.get(path), "->", after.get(path))
    differ += len(numbers)
sys.exit(differ > 0)
