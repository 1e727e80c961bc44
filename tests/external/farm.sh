#!/usr/bin/env bash
# vitrine farm on a real Slurm of one node, started here, and with GNU parallel: three small captures, one of them photographed with the lens
# cap on. One task is stopped while it trains, is requeued, and must end with the digests of a run alone; slurmd is killed and comes back.
#
#   tests/external/farm.sh [BUILD]       BUILD: folder of the build (default: build of this checkout)
#
# Needs root (munge, slurmctld and slurmd are started with settings of their own); otherwise it exits with 77, which ctest counts as skipped.
set -euo pipefail

skip() { echo "skipped: $*"; exit 77; }
fail() { echo "error: $*" >&2; cat "$work"/res/logs/*.log 2>/dev/null | tail -n 40 >&2; exit 1; }
say() { printf '\n== %s\n' "$*"; }

[ "$(id -u)" -eq 0 ] || skip "not root, and a Slurm of its own needs it"
checkout="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
vitrine="$(realpath "${1:-$checkout/build}")/bin/vitrine"
[ -x "$vitrine" ] || fail "there is no $vitrine"
source "$checkout/pipeline/setup.sh"
install_packages slurm-wlm munge parallel
work="$(mktemp -d /var/tmp/vitrine-farm.XXXXXX)"
pids=()
cleanup() {
  kill "${pids[@]}" 2>/dev/null || true
  pkill -x slurmd || true
  pkill -x slurmctld || true
  sleep 2  # the daemons write their state when they end
  rm -rf "$work"
}
trap cleanup EXIT

say "captures"
mkdir -p "$work/caps/good" "$work/caps/stopped" "$work/caps/lens cap"
cp "$checkout"/sample_data/cabinet/photos/*[02468].* "$work/caps/good/"
cp "$work"/caps/good/* "$work/caps/stopped/"
for photo in "$work"/caps/good/*; do ffmpeg -loglevel error -f lavfi -i color=black:s=320x240 -frames:v 1 "$work/caps/lens cap/$(basename "${photo%.*}").png"; done
options=(--preset preview --set ingest.max_side=320 --set optimize.iterations=150 --set refine.fine_tune.iterations=10)
"$vitrine" farm plan "$work/caps" -o "$work/res" --cores 1 -- "${options[@]}"

say "Slurm"
mkdir -p /run/munge "$work/slurm/state" "$work/slurm/spool"
chown munge /run/munge
[ -s /etc/munge/munge.key ] || { dd if=/dev/urandom of=/etc/munge/munge.key bs=1024 count=1 status=none; chown munge /etc/munge/munge.key; chmod 400 /etc/munge/munge.key; }
pgrep -x munged >/dev/null || setpriv --reuid munge --regid munge --clear-groups /usr/sbin/munged
cat >"$work/slurm/slurm.conf" <<CONF
ClusterName=farm
SlurmctldHost=$(hostname -s)
SlurmUser=root
AuthType=auth/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
ReturnToService=2
SlurmdTimeout=20
StateSaveLocation=$work/slurm/state
SlurmdSpoolDir=$work/slurm/spool
SlurmctldPidFile=$work/slurm/slurmctld.pid
SlurmdPidFile=$work/slurm/slurmd.pid
SlurmctldLogFile=$work/slurm/slurmctld.log
SlurmdLogFile=$work/slurm/slurmd.log
MessageTimeout=60
NodeName=$(hostname -s) CPUs=$(nproc) RealMemory=$(($(awk '/MemTotal/{print $2}' /proc/meminfo) / 1024 - 1024)) State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF="$work/slurm/slurm.conf"
slurmctld
slurmd
for _ in $(seq 60); do sinfo -h -o %T | grep -q idle && break; sleep 1; done
sinfo -h -o %T | grep -q idle || fail "Slurm did not come up: $(tail -n 3 "$work/slurm/slurmctld.log")"

job="$("$vitrine" farm submit "$work/res" --engine slurm --at-once 2 | grep -oE '[0-9]+' | head -n 1)"
echo "job $job"
# The tasks are in the order of their names: good 1, lens cap 2, stopped 3.
training() { grep -qs '"optimize' "$work/res/stopped/events.jsonl" && grep -qs 'step' "$work/res/stopped/events.jsonl"; }
for _ in $(seq 3600); do training && break; sleep 0.5; done
training || fail "the third task never trained"
say "SIGTERM to the task that trains"
scancel --signal=TERM --batch "${job}_3"
for _ in $(seq 240); do grep -qsi requeu "$work/slurm/slurmctld.log" && break; sleep 0.5; done
grep -qsi requeu "$work/slurm/slurmctld.log" || fail "the task was not requeued"
say "slurmd is killed and comes back"
sleep 5
pkill -9 -x slurmd || true
sleep 3
slurmd
for _ in $(seq 2400); do
  [ -z "$(squeue -h -j "$job" 2>/dev/null)" ] && break
  scontrol release "$job" 2>/dev/null || true  # a requeued task is held for a while where slurmd was away
  sleep 1
done
[ -z "$(squeue -h -j "$job" 2>/dev/null)" ] || fail "the array did not end: $(squeue -j "$job")"

say "states"
"$vitrine" farm status "$work/res" | tee "$work/status.txt"
grep -q "2 of 3 are done" "$work/status.txt" || fail "two captures should be done"
grep -qE "lens cap .*exit [0-9]+" "$work/status.txt" || fail "the capture with the lens cap on should have failed by name"
grep -q "lens cap" "$work/res/index.html" || fail "index.html does not name it"
digests() { python3 -c 'import json, sys; print([(s["name"], s["content_digest"]) for s in json.load(open(sys.argv[1]))["stages"]])' "$1"; }
[ "$(digests "$work/res/stopped/run.json")" = "$(digests "$work/res/good/run.json")" ] || fail "the requeued task has other bytes than the one that ran alone"

say "GNU parallel: the same plan again goes on where it stands"
mv "$work/res" "$work/slurm_res"
"$vitrine" farm plan "$work/caps" -o "$work/res" --cores 1 -- "${options[@]}" >/dev/null
code=0
"$vitrine" farm submit "$work/res" --engine parallel --at-once 2 || code=$?
[ $code -eq 1 ] || fail "GNU parallel should say that one task failed, got $code"
[ "$(awk 'NR > 1 && $7 == 0' "$work/res/joblog.tsv" | wc -l)" -eq 2 ] || fail "the job log should have two tasks without an error"
[ "$(digests "$work/res/good/run.json")" = "$(digests "$work/slurm_res/good/run.json")" ] || fail "other bytes than under Slurm"
say "passed"
