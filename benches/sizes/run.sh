#!/usr/bin/env bash
# Times the verbs on grids of several numbers of nodes: seconds, CPU seconds and memory.
# usage: [ROWS=N [SWING=K] [SENSORS=M]] run.sh BMV NODES...
# With ROWS one transient of ten phases of N rows and M sensors (6), whose sink steps by K in every row.
set -euo pipefail
bmv="$(realpath "$1")"
here="$(cd "$(dirname "$0")" && pwd)"
shift
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
printf '%-6s %-12s %8s %8s %8s\n' nodes verb wall_s cpu_s MiB
for nodes in "$@"; do
  if [ -n "${ROWS:-}" ]; then
    python3 "$here/grid.py" "$work/$nodes" "$nodes" "${SENSORS:-6}" 10 "$ROWS" "${SWING:-0}"
  else
    python3 "$here/grid.py" "$work/$nodes" "$nodes" 20 10
  fi
  for verb in plan "run --job propagate" "run --job sensitivity" compare diagnose; do
    /usr/bin/time -f '%e %U %S %M' -o "$work/time" "$bmv" $verb "$work/$nodes/pass-1.json" --cache "$work/cache-$nodes" > "$work/out" 2>&1 || true
    awk -v n="$nodes" -v v="${verb##* }" 'NF == 4 { printf "%-6s %-12s %8.2f %8.2f %8.0f\n", n, v, $1, $2 + $3, $4 / 1024 }' "$work/time"
  done
  grep -E '^- Missing' "$work/out" || true
done
