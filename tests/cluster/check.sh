#!/usr/bin/env bash
# Runs on a real three-node Slurm of this machine give the bytes of one thread, whatever happens meanwhile.
#
#   check.sh BMV short        shards in several numbers, and a node that crashes
#   check.sh BMV              also: a network that parts with two writers of one block, a driver that is killed, a run that
#                             is cancelled and resumed, a controller that is away for 10 s
#
# SAMPLES and PLATES set how long a block takes: 40 blocks. Status 0 also where Slurm cannot be had, which is said.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
bmv=$(realpath "$1")
which=${2:-all}
CLUSTER=$(mktemp -d "${TMPDIR:-/tmp}/bmv-check-XXXXXX")/cluster
# munged runs as another user.
chmod 755 "$(dirname "$CLUSTER")"
export CLUSTER
slurm="$here/slurm.sh"
trap '"$slurm" stop; rm -rf "$(dirname "$CLUSTER")"' EXIT
status=0
"$slurm" start || status=$?
[ $status != 77 ] || { echo "SKIPPED: runs on a real Slurm were not tested"; exit 0; }
[ $status = 0 ] || exit $status
. "$CLUSTER/env"
work=$CLUSTER/shared
cd "$work"
python3 "$here/study.py" study 40 "${SAMPLES:-8192}" "${PLATES:-60}"

step() { printf '== %s (after %s s)\n' "$*" "$SECONDS"; }
results=()
fail() { echo "FAILED: $*" >&2; tail -n 20 "$work"/*.err >&2 || true; exit 1; }
hash() { "$bmv" show study/pass-1.json --json --cache "$1" 2> /dev/null | sha256sum | cut -c1-64; }
# cluster NAME OPTION...: a run into the cache NAME
cluster() { local name=$1; shift; "$bmv" run study --engine slurm --cache "$name" --poll 2 --retry-delay 2 "$@" > "$name.out" 2>> "$name.err"; }
same() { [ "$(hash "$1")" = "$expected" ] || fail "$1: other bytes"; [ ! -e "$1/conflict" ] || fail "$1: a block was computed twice with other bytes"; }
blocks() { find "$1/objects" -type f ! -name '.tmp-*' 2> /dev/null | wc -l; }
# until_blocks NAME COUNT
until_blocks() { local tries=600; until [ "$(blocks "$1")" -ge "$2" ]; do tries=$((tries - 1)); [ $tries -gt 0 ] || fail "$1: no $2 blocks"; sleep 0.1; done; }
arrays() { grep -c ' shards\?; run ' "$1.err" || true; }

step "one thread and seven threads of this machine"
"$bmv" run study --threads 1 --cache one > /dev/null 2>&1
expected=$(hash one)
"$bmv" run study --threads 7 --cache seven > /dev/null 2>&1
same seven

step "7 shards on three nodes"
cluster shards-7 --shards 7
same shards-7

step "40 shards; n2 crashes meanwhile"
cluster crash --shards 40 & driver=$!
until_blocks crash 6
"$slurm" crash n2
wait $driver || fail "crash: the run ended with status $?"
same crash
echo "$(blocks crash) objects, $(arrays crash) array"
"$slurm" node n2
[ "$which" != short ] || { echo "the same bytes each time: $expected"; exit 0; }

step "n2 loses its network and goes on: two writers of one block"
# A program that waits: shards must outlast the time until a node counts as lost. It may run on the nodes as it may here.
python3 "$here/study.py" waits 41 16 pause 0.6
cut="run waits --allow-commands --cache cut --engine slurm --shards 6 --poll 2"
"$bmv" $cut > cut.out 2> cut.err & driver=$!
until_blocks cut 3
"$slurm" cut n2
wait $driver || fail "cut: the run ended with status $?"
"$slurm" node n2
# The second writers may still be at work.
tries=90; while squeue -h | grep -q .; do tries=$((tries - 1)); [ $tries -gt 0 ] || break; sleep 1; done
twice=$(cat cut/runs/*/*/records/*.json | grep -o '"index":[0-9]*' | sort | uniq -d | wc -l)
[ "$twice" -gt 0 ] || fail "cut: no shard ran twice"
[ ! -e cut/conflict ] || fail "cut: a block was computed twice with other bytes"
python3 "$here/study.py" waits 41 16 pause 0
"$bmv" run waits --allow-commands --cache waits-here > /dev/null 2>&1
for cache in cut waits-here; do
  # The program is another one, so its results have other keys; the numbers are the same.
  results+=("$(cat $cache/objects/*/* | grep -a 'bmv-object/1 result' -B 1 | head -n 1 | sha256sum)")
done
[ "${results[0]}" = "${results[1]}" ] || fail "cut: other numbers"
echo "$twice shards ran twice, $(blocks cut) objects"

step "the driver is killed; another goes on"
cluster killed --shards 40 & driver=$!
until_blocks killed 6
kill -9 "$(pgrep -P $driver || echo $driver)" 2> /dev/null || true
wait $driver 2> /dev/null || true
run=$(ls killed/runs | cut -c1-12)
"$bmv" attach "$run" --cache killed > killed.out 2>> killed.err || fail "attach: status $?"
same killed
[ "$(arrays killed)" = 1 ] || fail "killed: $(arrays killed) arrays instead of one"

step "cancelled, and run again"
cluster cancelled --shards 40 & driver=$!
until_blocks cancelled 6
run=$(ls cancelled/runs | cut -c1-12)
"$bmv" cancel "$run" --cache cancelled
wait $driver && fail "cancelled: the driver says that all is done" || true
there=$(blocks cancelled)
cluster cancelled
same cancelled
grep -h '; run ' cancelled.err | tail -n 1
echo "$there objects were there"

step "the controller is away for 10 s"
cluster away --shards 40 & driver=$!
until_blocks away 6
"$slurm" controller stop
sleep 10
"$slurm" controller start
wait $driver || fail "away: the run ended with status $?"
same away
echo "the same bytes each time: $expected"
