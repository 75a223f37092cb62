#!/usr/bin/env bash
# Times the verbs on grids of several numbers of nodes: seconds, CPU seconds and memory; and the exponents of the CPU seconds.
# usage: [SENSORS=M] [PHASES=P] [ROWS=N [SWING=K]] [SAMPLER=NAME] [VERBS="plan compare ..."] run.sh BMV NODES...
# Ten steady phases of 20 sensors. With ROWS one transient of so many phases of N rows (6 sensors), whose sink steps by K in every
# row; SAMPLER calibrates another way than by default. Above 5000 nodes only `plan` and `compare` are asked.
set -euo pipefail
bmv="$(realpath "$1")"
here="$(cd "$(dirname "$0")" && pwd)"
shift
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
printf '%-6s %-12s %8s %8s %8s\n' nodes verb wall_s cpu_s MiB
for nodes in "$@"; do
  if [ -n "${ROWS:-}" ]; then
    python3 "$here/grid.py" "$work/$nodes" "$nodes" "${SENSORS:-6}" "${PHASES:-10}" "$ROWS" "${SWING:-0}"
  else
    python3 "$here/grid.py" "$work/$nodes" "$nodes" "${SENSORS:-20}" "${PHASES:-10}"
  fi
  if [ -n "${SAMPLER:-}" ]; then
    sed -i "s/\"calibrate\": {/&\"sampler\": \"$SAMPLER\", /" "$work/$nodes/pass-1.json"
  fi
  verbs="${VERBS:-plan compare propagate sensitivity calibrate diagnose}"
  if [ "$nodes" -gt 5000 ]; then verbs="plan compare"; fi
  for verb in $verbs; do
    case "$verb" in
      propagate | sensitivity | calibrate) command="run --job $verb" ;;
      *) command="$verb" ;;
    esac
    /usr/bin/time -f '%e %U %S %M' -o "$work/time" "$bmv" $command "$work/$nodes/pass-1.json" --cache "$work/cache-$nodes" > "$work/out" 2>&1 || true
    awk -v n="$nodes" -v v="$verb" 'NF == 4 { printf "%-6s %-12s %8.2f %8.2f %8.0f\n", n, v, $1, $2 + $3, $4 / 1024 }' "$work/time" | tee -a "$work/all"
  done
  grep -E '^- Missing' "$work/out" || true
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
