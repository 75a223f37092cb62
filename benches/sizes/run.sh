#!/usr/bin/env bash
# Times the verbs on grids of several numbers of nodes: seconds, CPU seconds and memory.
# usage: [ROWS=N] run.sh BMV NODES...   (with ROWS one transient of ten phases of N rows and 6 sensors)
set -euo pipefail
bmv="$(realpath "$1")"
here="$(cd "$(dirname "$0")" && pwd)"
shift
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
printf '%-6s %-10s %8s %8s %8s\n' nodes verb wall_s cpu_s MiB
for nodes in "$@"; do
  if [ -n "${ROWS:-}" ]; then
    python3 "$here/grid.py" "$work/$nodes" "$nodes" 6 10 "$ROWS"
  else
    python3 "$here/grid.py" "$work/$nodes" "$nodes" 20 10
  fi
  for verb in plan compare diagnose; do
    /usr/bin/time -f '%e %U %S %M' -o "$work/time" "$bmv" "$verb" "$work/$nodes/pass-1.json" --cache "$work/cache-$nodes" > "$work/out" 2>&1 || true
    awk -v n="$nodes" -v v="$verb" 'NF == 4 { printf "%-6s %-10s %8.2f %8.2f %8.0f\n", n, v, $1, $2 + $3, $4 / 1024 }' "$work/time"
  done
  grep -E '^- Missing' "$work/out" || true
done
