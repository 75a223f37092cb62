#!/usr/bin/env bash
# Runs on a real three-node Slurm of this machine give the bytes of one thread, whatever happens meanwhile.
#
#   check.sh BMV short        shards in several numbers, and a node that crashes
#   check.sh BMV              also: a network that parts with two writers of one block, a driver that is killed, a run that
#                             is cancelled and resumed, a controller that is away for 10 s, a node that fails all its shards,
#                             tasks that are preempted, tasks whose time is over
#   check.sh BMV STEP...      these steps alone: broken preempted time
#
# SAMPLES and PLATES set how long a block takes: 40 blocks. Status 0 also where Slurm cannot be had, which is said.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
bmv=$(realpath "$1")
which=${2:-all}
shift 2 2> /dev/null || shift
chosen=" $which $* "
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
fail() { echo "FAILED: $*" >&2; tail -n 20 "$work"/*.err >&2 || true; exit 1; }
hash() { "$bmv" show study/pass-1.json --json --cache "$1" 2> /dev/null | sha256sum | cut -c1-64; }
# cluster NAME OPTION...: a run into the cache NAME
cluster() { local name=$1; shift; "$bmv" run study --engine slurm --cache "$name" --poll 2 --retry-delay 2 "$@" > "$name.out" 2>> "$name.err"; }
same() { [ "$(hash "$1")" = "$expected" ] || fail "$1: other bytes"; [ ! -e "$1/conflict" ] || fail "$1: a block was computed twice with other bytes"; }
blocks() { find "$1/objects" -type f ! -name '.tmp-*' 2> /dev/null | wc -l; }
# until_blocks NAME COUNT
until_blocks() { local tries=600; until [ "$(blocks "$1")" -ge "$2" ]; do tries=$((tries - 1)); [ $tries -gt 0 ] || fail "$1: no $2 blocks"; sleep 0.1; done; }
# numbers NAME: a hash of the result of a program that waits. It is another one for each pause, so its results have other keys.
numbers() { cat "$1"/objects/*/* | grep -a 'bmv-object/1 result' -B 1 | head -n 1 | sha256sum; }
# waits NAME SECONDS OPTION...: a run of that program, with this pause, into a cache of its own. It may run on the nodes as it may here.
waits() { local name=$1 pause=$2; shift 2; python3 "$here/study.py" "w-$name" 41 16 pause "$pause"
  "$bmv" run "w-$name" --allow-commands --cache "$name" --poll 2 --retry-delay 2 --engine slurm "$@" > "$name.out" 2>> "$name.err"; }
waited() { [ -d here ] || { python3 "$here/study.py" w-here 41 16 pause 0; "$bmv" run w-here --allow-commands --cache here > /dev/null 2>&1; }
  [ "$(numbers "$1")" = "$(numbers here)" ] || fail "$1: other numbers"; [ ! -e "$1/conflict" ] || fail "$1: a block was computed twice with other bytes"; }
takes() { [ "$which" = all ] || [[ $chosen == *" $1 "* ]]; }
arrays() { grep -c ' shards\?; run ' "$1.err" || true; }

if takes short; then
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
# Shards must outlast the time until a node counts as lost.
waits cut 0.6 --shards 6 & driver=$!
until_blocks cut 3
"$slurm" cut n2
wait $driver || fail "cut: the run ended with status $?"
"$slurm" node n2
# The second writers may still be at work.
tries=90; while squeue -h | grep -q .; do tries=$((tries - 1)); [ $tries -gt 0 ] || break; sleep 1; done
twice=$(cat cut/runs/*/*/records/*.json | grep -o '"index":[0-9]*' | sort | uniq -d | wc -l)
[ "$twice" -gt 0 ] || fail "cut: no shard ran twice"
waited cut
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
fi

if takes broken; then
step "n2 lacks the program and fails all that it is given"
"$slurm" crash n2
"$slurm" broken n2 "$bmv"
waits broken 0.02 --shards 20 || fail "broken: the run ended with status $?"
waited broken
grep -q "n2 failed 2 times in a row: it is not used any more" broken.err || fail "broken: n2 was not excluded"
echo "$(grep -c 'on n2: ' broken.err) shards failed on n2, $(arrays broken) arrays"
"$slurm" crash n2
"$slurm" node n2
fi

if takes preempted; then
step "tasks are preempted by a job of another partition"
waits preempted 0.2 --shards 6 & driver=$!
until_blocks preempted 6
sbatch -p urgent -N 3 --exclusive --output=/dev/null --wrap 'sleep 5' > /dev/null
wait $driver || fail "preempted: the run ended with status $?"
waited preempted
again=$(cat preempted/runs/*/*/records/*.json | grep -c '"restart":[1-9]' || true)
[ "$again" -gt 0 ] || fail "preempted: no task was started again"
echo "$again tasks were started again, $(arrays preempted) array"
fi

if takes time; then
step "the time of the tasks is over before they are through"
waits time 0.5 --shards 3 --time 00:02:00 || fail "time: the run ended with status $?"
waited time
[ "$(arrays time)" -gt 1 ] || fail "time: nothing was submitted again"
echo "$(arrays time) arrays: $(grep -h '; run ' time.err | tr '\n' ';')"
fi
