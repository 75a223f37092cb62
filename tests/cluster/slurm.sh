#!/usr/bin/env bash
# A cluster of Slurm on this machine alone: a controller and some virtual nodes, which listen on 127.0.0.1 only.
#
#   slurm.sh start            then: . "$CLUSTER/env"
#   slurm.sh stop             ends all that it started, jobs too, and removes the folder
#   slurm.sh crash NODE       a power cut: the node's daemon and its jobs die at once
#   slurm.sh cut NODE         a lost network: the daemon dies, its jobs go on
#   slurm.sh node NODE        starts a node again
#   slurm.sh broken NODE FILE starts a node again that lacks this program: a file system that is not mounted
#   slurm.sh controller stop|start
#
# CLUSTER (folder), PORT (first of NODES+1), NODES, CPUS (a node), TIMEOUT (seconds until a node counts as lost).
# Needs root, for Slurm's own user change and for host names of its own; installs Debian's packages where they are missing.
# Status 77: it cannot be had here, for a reason that is printed.
set -euo pipefail
CLUSTER=${CLUSTER:-${TMPDIR:-/tmp}/bmv-cluster}
PORT=${PORT:-17600} NODES=${NODES:-3} CPUS=${CPUS:-2} TIMEOUT=${TIMEOUT:-10}
export SLURM_CONF=$CLUSTER/slurm.conf BROKEN=

skip() { echo "SKIPPED: $*" >&2; exit 77; }
fail() { echo "slurm.sh: $*" >&2; exit 1; }
# until_true SECONDS COMMAND...
until_true() {
  local tries=$(($1 * 10)); shift
  while ! "$@" > /dev/null 2>&1; do
    tries=$((tries - 1)); [ $tries -gt 0 ] || return 1
    sleep 0.1
  done
}

install_packages() {
  command -v slurmctld slurmd sbatch munged > /dev/null && return
  [ "$(id -u)" = 0 ] || skip "Slurm is not installed, and only root can install it"
  command -v apt-get > /dev/null || skip "Slurm is not installed, and there is no apt-get"
  { apt-get update -q && DEBIAN_FRONTEND=noninteractive \
      apt-get install -y -q --no-install-recommends slurmctld slurmd slurm-client munge; } > /dev/null 2>&1 ||
    skip "the packages slurmctld slurmd slurm-client munge cannot be had"
}

# run_daemon NAME COMMAND...: in a session and with a host name of its own. Daemons bind the address of their host's name,
# so that name is localhost. The namespace of that name also marks what the daemon starts: slurmstepd has no environment.
run_daemon() {
  local name=$1; shift
  setsid unshare --uts ${BROKEN:+--mount} sh -c 'hostname localhost; readlink /proc/self/ns/uts > "$1"; shift
    [ -z "$BROKEN" ] || mount --bind /dev/null "$BROKEN"; exec "$@"' \
    sh "$CLUSTER/run/$name.ns" "$@" > "$CLUSTER/log/$name.out" 2>&1 < /dev/null &
  echo $! > "$CLUSTER/run/$name.pid"
}
# members NAME: processes of a daemon's namespace, those of slurmstepd first: one that saw its job die would report it.
members() {
  local ns process first="" rest=""
  ns=$(cat "$CLUSTER/run/$1.ns" 2> /dev/null) || return 0
  for process in /proc/[0-9]*; do
    [ "$(readlink "$process/ns/uts" 2> /dev/null)" = "$ns" ] || continue
    # It may be gone by now.
    if { tr '\0' ' ' < "$process/cmdline"; } 2> /dev/null | grep -q '^slurmstepd'; then first+=" ${process#/proc/}"; else rest+=" ${process#/proc/}"; fi
  done
  echo "$first$rest"
}
kill_members() { local process; for process in $(members "$1"); do kill -9 "$process" 2> /dev/null || true; done; }
is_daemon() { [ -e "$CLUSTER/run/$1.pid" ] && [ -d "/proc/$(cat "$CLUSTER/run/$1.pid")" ]; }

start_controller() {
  run_daemon slurmctld slurmctld -D "$@" -f "$SLURM_CONF"
  until_true 30 sh -c 'scontrol ping | grep -q "is UP"' || fail "the controller does not answer: $(tail -n 5 "$CLUSTER/log/slurmctld.log")"
}
start_node() { run_daemon "$1" slurmd -D -f "$SLURM_CONF" -N "$1"; }

start() {
  install_packages
  [ "$(id -u)" = 0 ] || skip "a cluster of several nodes on one machine needs root"
  unshare --uts true 2> /dev/null || skip "host names of their own are not allowed here"
  slurmd -V > /dev/null || skip "slurmd does not run here"
  ! is_daemon slurmctld || fail "it runs already in $CLUSTER"
  rm -rf "$CLUSTER"
  mkdir -p "$CLUSTER"/{run,log,state,munge,shared}
  local node memory
  for node in $(seq "$NODES"); do mkdir -p "$CLUSTER/spool/n$node"; done
  memory=$(($(awk '/^MemTotal/ {print int($2 / 1024)}' /proc/meminfo) / NODES - 100))
  # Timers are short, so that a test sees a lost node in seconds; production has minutes.
  cat > "$SLURM_CONF" <<CONF
ClusterName=bmv$PORT
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort=$PORT
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
AuthType=auth/munge
AuthInfo=socket=$CLUSTER/run/munge.socket
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$CLUSTER/state
SlurmdSpoolDir=$CLUSTER/spool/%n
SlurmctldPidFile=$CLUSTER/run/slurmctld.own
SlurmdPidFile=$CLUSTER/run/%n.own
SlurmctldLogFile=$CLUSTER/log/slurmctld.log
SlurmdLogFile=$CLUSTER/log/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SlurmctldTimeout=30
SlurmdTimeout=$TIMEOUT
MessageTimeout=5
KillWait=${KILL_WAIT:-5}
UnkillableStepTimeout=15
BatchStartTimeout=10
ReturnToService=2
MaxArraySize=${MAX_ARRAY:-1001}
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0,sched_interval=5,bf_interval=2
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
NodeName=n[1-$NODES] NodeHostname=localhost NodeAddr=127.0.0.1 Port=[$((PORT + 1))-$((PORT + NODES))] CPUs=$CPUS RealMemory=$memory State=UNKNOWN
PartitionName=main Nodes=n[1-$NODES] Default=YES MaxTime=INFINITE PriorityTier=1 State=UP
PartitionName=urgent Nodes=n[1-$NODES] MaxTime=INFINITE PriorityTier=10 State=UP
CONF
  { echo "export SLURM_CONF='$SLURM_CONF'"; echo "export CLUSTER='$CLUSTER'"; } > "$CLUSTER/env"
  dd if=/dev/urandom of="$CLUSTER/munge/key" bs=64 count=1 status=none
  chmod 600 "$CLUSTER/munge/key"; chmod 700 "$CLUSTER/munge"; chmod 755 "$CLUSTER" "$CLUSTER/run"
  chown -R munge: "$CLUSTER/munge"; chown munge: "$CLUSTER/run"
  trap '[ $? = 0 ] || stop > /dev/null 2>&1' EXIT
  setsid setpriv --reuid=munge --regid=munge --clear-groups munged --foreground --num-threads=2 \
    --key-file="$CLUSTER/munge/key" --socket="$CLUSTER/run/munge.socket" --pid-file="$CLUSTER/munge/pid" \
    --log-file="$CLUSTER/munge/log" --seed-file="$CLUSTER/munge/seed" > "$CLUSTER/log/munged.out" 2>&1 < /dev/null &
  echo $! > "$CLUSTER/run/munged.pid"
  until_true 10 munge -n -S "$CLUSTER/run/munge.socket" || fail "munged does not answer"
  start_controller -i
  for node in $(seq "$NODES"); do start_node "n$node"; done
  until_true 30 sh -c "[ \"\$(sinfo -h -N -t idle -o %N | sort -u | wc -l)\" = $NODES ]" || fail "the nodes are not idle: $(sinfo -h -N -l)"
}

stop() {
  [ -d "$CLUSTER/run" ] || return 0
  local name
  if is_daemon slurmctld; then
    timeout 5 squeue -h -o %A 2> /dev/null | sort -u | xargs -r timeout 10 scancel 2> /dev/null || true
    until_true 10 sh -c '[ -z "$(timeout 3 squeue -h)" ]' || true
  fi
  for name in $(cd "$CLUSTER/run" && ls -- *.ns 2> /dev/null | sed 's/\.ns$//' | grep -v slurmctld) slurmctld; do kill_members "$name"; done
  if is_daemon munged && tr '\0' ' ' < "/proc/$(cat "$CLUSTER/run/munged.pid")/cmdline" | grep -q "$CLUSTER"; then
    kill "$(cat "$CLUSTER/run/munged.pid")" 2> /dev/null || true
  fi
  rm -rf "$CLUSTER"
}

case ${1:-} in
  start) start ;;
  stop) stop ;;
  crash) kill_members "$2"; rm -f "$CLUSTER/run/$2.pid" ;;
  cut) kill -9 "$(cat "$CLUSTER/run/$2.pid")"; rm -f "$CLUSTER/run/$2.pid" ;;
  node) start_node "$2"; until_true 30 sh -c "! sinfo -h -n $2 -o %t | grep -qE '[*]|down|unk'" || fail "$2 does not come back" ;;
  broken) BROKEN=$3 start_node "$2"; until_true 30 sh -c "! sinfo -h -n $2 -o %t | grep -qE '[*]|down|unk'" || fail "$2 does not come back" ;;
  controller) if [ "$2" = stop ]; then kill_members slurmctld; rm -f "$CLUSTER/run/slurmctld.pid"; else start_controller; fi ;;
  *) fail "start, stop, crash NODE, cut NODE, node NODE, controller stop|start" ;;
esac
