#!/usr/bin/env bash
# A real Slurm on this machine runs the array of docs/cluster.md: eight shards give the tables of one process, and so they do after
# one of them was killed and run again. Then GNU parallel does the same. Exit status 77: what it needs is not here.
#
#   slurm_test.sh PROGRAM DOCS/cluster.md
set -euo pipefail
program=$(readlink -f "$1") page=$(readlink -f "$2")

skip() { echo "skipped: $*"; exit 77; }
fail() { echo "failed: $*" >&2; exit 1; }
for needed in slurmctld slurmd sbatch squeue scancel munged runuser; do
  command -v "$needed" >/dev/null || skip "$needed is not installed (Debian: slurm-wlm munge)"
done
[ "$(id -u)" = 0 ] || skip "Slurm's daemons need root"
pgrep -x slurmctld >/dev/null && skip "a Slurm is running already"

work=$(mktemp -d) host=$(hostname -s)
end_daemons() {
  for daemon in slurmd slurmctld munged; do
    [ -s "$work/$daemon.pid" ] && kill "$(cat "$work/$daemon.pid")" 2>/dev/null
  done
  sleep 0.5
  rm -rf "$work"
}
trap end_daemons EXIT
cd "$work"
chmod 755 .

# A key, a socket, ports and folders of its own: nothing of the system's is touched.
mkdir munge state spool
dd if=/dev/urandom of=munge/key bs=1024 count=1 status=none
chmod 700 munge && chmod 400 munge/key
cat >slurm.conf <<END
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
SlurmctldPort=26817
SlurmdPort=26818
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket
CryptoType=crypto/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=none
ReturnToService=2
JobAcctGatherType=jobacct_gather/none
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
KillWait=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$host Default=YES State=UP
END
export SLURM_CONF=$work/slurm.conf
munged --force --key-file=munge/key --socket="$work/munge.socket" --pid-file="$work/munged.pid" --log-file="$work/munged.log" \
  --seed-file="$work/munge/seed" || skip "munged does not start here"
slurmctld && slurmd || skip "Slurm's daemons do not start here"
for ((i = 0; ; ++i)); do
  sinfo --noheader --format=%t 2>/dev/null | grep -q idle && break
  [ "$i" -lt 100 ] || { tail -n 5 slurm*.log; skip "Slurm's node does not come up here"; }
  sleep 0.2
done

# Closed forms need no reference. A cell takes about half a second.
cat >e.toml <<'END'
title = "Shards"
scenes = ["builtin:lambert-sphere", "builtin:sphere-light"]
seeds = 6
budget = { samples = 48 }
resolution = [96, 96]
integrators = ["path", "photon-map", "irradiance-cache"]
END
export ETENDUE=$program XDG_CACHE_HOME=$work/cache
sed -n '/^#!\/bin\/bash$/,/^```$/p' "$page" | sed '$d' >shard.sh
grep -q SBATCH shard.sh || fail "no script in $page"
"$program" run e.toml --threads 1 --out one >one.txt 2>&1 || fail "$(cat one.txt)"

wait_for_queue() {
  for ((i = 0; i < 1200; ++i)); do
    [ -n "$(squeue --noheader)" ] || return 0
    sleep 0.25
  done
  fail "jobs do not end: $(squeue)"
}

# What the clock has no part in: the curves without their times, what methods declare, and each image's hash.
without_times() {
  cut -d, -f1-6,8- "$1/tables/curves.csv" | sort
  cat "$1/tables/expectations.csv" "$1/tables/failures.md"
  sed -En 's/.*"type":"cell",("scene.*"seed":[0-9]*),.*("image_hash":"[^"]*").*/\1 \2/p' "${@:2}" | sort
}

compare() {
  "$program" report out/e-shard-*-of-8 --out merged >report.txt 2>&1 || fail "$(cat report.txt)"
  without_times one one/runs.jsonl >expected.txt
  without_times merged out/e-shard-*-of-8/runs.jsonl >merged.txt
  [ "$(grep -c image_hash expected.txt)" = 36 ] || fail "$(grep -c image_hash expected.txt) cells, expected 36"
  diff expected.txt merged.txt || fail "$1: the tables of eight shards are not those of one process"
  echo "$1: the tables of 8 shards and 36 image hashes are those of one process"
}

job=$(sbatch --parsable shard.sh e.toml)
log=out/e-shard-3-of-8/runs.jsonl
for ((i = 0; i < 1200; ++i)); do
  grep -qs '"type":"cell"' "$log" && break
  sleep 0.05
done
scancel --full --signal=KILL "${job}_3"
wait_for_queue
grep -q '"type":"finished"' "$log" && fail "shard 3 was done before it could be killed"
if "$program" report out/e-shard-*-of-8 --out merged >report.txt 2>&1; then fail "report does not miss the end of shard 3"; fi
grep -q 'shard-3' report.txt || fail "report does not name shard 3: $(cat report.txt)"
sbatch --parsable --array=3 shard.sh e.toml >/dev/null
wait_for_queue
compare "Slurm, one shard killed and run again"

if command -v parallel >/dev/null; then
  rm -rf out merged
  parallel --will-cite --jobs 2 "$program" run e.toml --threads 1 --shard {}/8 ::: {0..7} >parallel.txt 2>&1 || fail "$(cat parallel.txt)"
  compare "GNU parallel"
fi
