#!/usr/bin/env bash
# Times the verbs on grids of several numbers of nodes: seconds, CPU seconds and memory; and the exponents of the CPU seconds.
# usage: [GRID="--sensors M --phases P ..."] [SAMPLER=NAME] [VERBS="plan compare ..."] run.sh BMV NODES...
# GRID is what `grid.py` takes. Where VERBS does not say: `plan`, `compare` and `propagate` of all, the rest of what is affordable.
# SAMPLER calibrates another way than by default. `diagnose` is asked on 60 sensors and 12 phases unless GRID says otherwise.
set -euo pipefail
bmv="$(realpath "$1")"
here="$(cd "$(dirname "$0")" && pwd)"
shift
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
printf '%-6s %-12s %8s %8s %8s\n' nodes verb wall_s cpu_s MiB
for nodes in "$@"; do
  verbs="plan compare propagate"
  if [ "$nodes" -le 1000 ]; then verbs="$verbs sensitivity calibrate"; fi
  if [ "$nodes" -le 5000 ]; then verbs="$verbs diagnose"; fi
  for verb in ${VERBS:-$verbs}; do
    grid="${GRID:-}"
    if [ -z "$grid" ] && [ "$verb" = diagnose ]; then grid="--sensors 60 --phases 12"; fi
    study="$work/$nodes$grid"
    if [ ! -d "$study" ]; then
      # shellcheck disable=SC2086
      python3 "$here/grid.py" "$study" "$nodes" $grid
      if [ -n "${SAMPLER:-}" ]; then
        sed -i "s/\"calibrate\": {/&\"sampler\": \"$SAMPLER\", /" "$study/pass-1.json"
      fi
    fi
    case "$verb" in
      propagate | sensitivity | calibrate) command="run --job $verb" ;;
      report) command="report --out $work/report" ;;
      *) command="$verb" ;;
    esac
    # shellcheck disable=SC2086
    /usr/bin/time -f '%e %U %S %M' -o "$work/time" "$bmv" $command "$study/pass-1.json" --cache "$work/cache-$nodes" > "$work/out" 2>&1 || true
    awk -v n="$nodes" -v v="$verb" 'NF == 4 { printf "%-6s %-12s %8.2f %8.2f %8.0f\n", n, v, $1, $2 + $3, $4 / 1024 }' "$work/time" | tee -a "$work/all"
    # What went wrong, and what a diagnosis found.
    grep -E '^error[:[]|^- Missing' "$work/out" || true
  done
done
# Slopes of the logarithm of the CPU seconds over that of the number of nodes, by least squares.
awk '
  $4 > 0 { x = log($1); y = log($4); n[$2]++; sx[$2] += x; sy[$2] += y; sxx[$2] += x * x; sxy[$2] += x * y }
  END {
    for (v in n) {
      spread = n[v] * sxx[v] - sx[v] * sx[v]
      if (spread > 1e-9) printf "%-12s CPU seconds grow as nodes to the power of %.2f\n", v, (n[v] * sxy[v] - sx[v] * sy[v]) / spread
    }
  }' "$work/all" | sort
