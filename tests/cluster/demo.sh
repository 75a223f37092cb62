#!/usr/bin/env bash
# The sensitivity of the solar X-ray monitor on a three-node Slurm of this machine, of which a node crashes, and on one
# machine: demo.sh BMV
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
bmv=$(realpath "$1")
pass=$(realpath "$here/../../studies/sxm/pass-1.json")
CLUSTER=$(mktemp -d "${TMPDIR:-/tmp}/bmv-demo-XXXXXX")/cluster
# munged runs as another user.
chmod 755 "$(dirname "$CLUSTER")"
export CLUSTER
trap '"$here/slurm.sh" stop; rm -rf "$(dirname "$CLUSTER")"' EXIT
status=0
"$here/slurm.sh" start || status=$?
[ $status != 77 ] || { echo "SKIPPED: no demonstration without Slurm"; exit 0; }
[ $status = 0 ] || exit $status
. "$CLUSTER/env"
cd "$CLUSTER/shared"
hash() { "$bmv" show "$pass" effects --json --cache "$1" 2> /dev/null | sha256sum | cut -c1-64; }

echo "== on three nodes; n2 crashes as soon as the first block is there"
"$bmv" run "$pass" --job sensitivity --engine slurm --cache cluster --poll 2 & driver=$!
until [ -n "$(find cluster/objects -type f 2> /dev/null | head -n 1)" ]; do sleep 0.02; done
"$here/slurm.sh" crash n2
echo "   n2 is gone: $(sinfo -h -N -o '%N %t' | tr '\n' ' ')"
wait $driver
echo "== on this machine"
"$bmv" run "$pass" --job sensitivity --cache here > /dev/null
[ "$(hash cluster)" = "$(hash here)" ] || { echo "FAILED: the results differ: $(hash cluster) and $(hash here)"; exit 1; }
echo "the same result: $(hash cluster)"
