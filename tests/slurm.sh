#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# `ntc bake --plan slurm` on a cluster of one node, whose daemons run on loopback for as long as this takes: tasks are preempted,
# requeued and run out of time, and the files are those of a bake that nobody disturbed.
#   bash tests/slurm.sh NTC
# "SKIP: reason" where the daemons are missing or cannot start here.
set -uo pipefail

ntc="$(realpath "$1")"
work="$(mktemp -d)"
node="$(hostname -s)"
export SLURM_CONF="$work/slurm.conf"
daemons=()

finish() {
    local file
    scancel --quiet --state=PENDING --state=RUNNING 2>/dev/null
    for file in "$work"/slurmd.pid "$work"/slurmctld.pid "$work"/munged.pid; do
        [[ -s "$file" ]] && daemons+=("$(cat "$file")")
    done
    [[ ${#daemons[@]} -eq 0 ]] || kill "${daemons[@]}" 2>/dev/null
    wait_for 50 no_daemons || kill -KILL "${daemons[@]}" 2>/dev/null
    rm -rf "$work"
}
no_daemons() { ! kill -0 "${daemons[@]}" 2>/dev/null; }

# wait_for TENTHS COMMAND…: until it succeeds, or so many tenths of a second are over.
wait_for() {
    local left="$1"
    shift
    until "$@" >/dev/null 2>&1; do
        left=$((left - 1))
        [[ "$left" -gt 0 ]] || return 1
        sleep 0.1
    done
}
skip() {
    echo "SKIP: slurm: $1"
    exit 0
}
fail() {
    echo "ERROR: slurm: $1"
    squeue --array --all
    tail -n 5 "$work"/slurmctld.log "$work"/slurmd.log
    tail -n 40 "$work"/out/.bake/slurm-*.log
    exit 1
}

for program in munged slurmctld slurmd sbatch; do
    command -v "$program" >/dev/null || skip "no $program"
done
[[ "$(id -u)" -eq 0 ]] || skip "the daemons need root"
trap finish EXIT
chmod 755 "$work" # munged refuses folders that others may write

head -c 128 /dev/urandom >"$work/munge.key"
chmod 600 "$work/munge.key"
munged --force --socket="$work/munge" --key-file="$work/munge.key" --pid-file="$work/munged.pid" --log-file="$work/munged.log" \
    --seed-file="$work/munge.seed" >"$work/start.log" 2>&1 || skip "munged does not start: $(tail -n 1 "$work/start.log")"
# Ports of this process's own; credentials that expire soon, because a requeued task waits until they have.
cat >"$SLURM_CONF" <<CONF
ClusterName=openntc
SlurmctldHost=$node(127.0.0.1)
SlurmctldPort=$((20000 + $$ % 10000))
SlurmdPort=$((30000 + $$ % 10000))
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge,cred_expire=5
CredType=cred/munge
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/builtin
SchedulerParameters=sched_interval=1,batch_sched_delay=0
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
NodeName=$node NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=art Nodes=$node Default=YES PriorityTier=1 State=UP
PartitionName=urgent Nodes=$node PriorityTier=2 State=UP
CONF
mkdir -p "$work/state" "$work/spool"
slurmctld -c >>"$work/start.log" 2>&1 || skip "slurmctld does not start: $(tail -n 1 "$work/start.log")"
slurmd -c >>"$work/start.log" 2>&1 || skip "slurmd does not start: $(tail -n 1 "$work/start.log")"
is_idle() { [[ "$(sinfo --noheader --partition=art --format=%t)" == idle ]]; }
wait_for 100 is_idle || skip "the node does not come up: $(grep -aE 'error|fatal' "$work"/slurm*.log | tail -n 1)"

# Materials, and steps that take some seconds on this machine: of so many that starting the program, which a loaded machine does
# slowly, is little of it.
mkdir -p "$work/art"
for i in 1 2; do
    { printf 'P6 8 8 255\n'; yes "a pattern $i of texels" | head -c 192; } >"$work/art/M${i}_D.ppm"
done
begin="$(date +%s%N)"
"$ntc" bake "$work/art" -o "$work/pace" --steps 400 --bits-per-pixel 1 --threads 1 --quiet >/dev/null 2>&1 || fail "a bake fails"
steps=$((400 * 12000000000 / ($(date +%s%N) - begin)))
settings=(--steps "$steps" --bits-per-pixel 1 --save-every 0.05)

"$ntc" bake "$work/art" -o "$work/out" "${settings[@]}" --plan slurm --threads 1 || fail "the plan"
array="$(sbatch --parsable "$work/out/bake.sbatch")" || fail "sbatch"
states() { find "$work/out/.bake" -name '*.state' | wc -l; }
has_states() { [[ "$(states)" -eq 2 ]]; }
runs() { [[ "$(squeue --noheader --array --state=RUNNING --partition=art --format=%i | wc -l)" -eq "$1" ]]; }
restarts() { scontrol show job "${array}_$1" | grep -o 'Restarts=[0-9]*' | cut -d= -f2; }
restarted() { [[ "$(restarts 0)" -ge "$1" && "$(restarts 1)" -ge "$1" ]]; }

wait_for 200 has_states || fail "no states of running tasks"
# Preemption: what is urgent wants the whole node.
sbatch --quiet --partition=urgent --exclusive --output=/dev/null --wrap true || fail "sbatch of what is urgent"
wait_for 100 restarted 1 || fail "the tasks were not preempted"
has_states || fail "$(states) states were kept of 2 preempted tasks"
find "$work/out" -name '*.ntc' | grep -q . && fail "a task was through before it was preempted"
wait_for 300 runs 2 || fail "preempted tasks do not start again"
work_again() { [[ "$(cat "$work"/out/.bake/slurm-*.log | grep -c ' materials to make')" -eq 4 ]]; }
wait_for 100 work_again || fail "preempted tasks do not work again"

# Requeued by hand, and out of time: Slurm tells the script alone.
scontrol requeue "${array}_0" || fail "scontrol requeue"
scancel --batch --signal=USR1 "${array}_1" || fail "scancel"
wait_for 100 restarted 2 || fail "the tasks did not start a third time"
find "$work/out" -name '*.ntc' | grep -q . && fail "a task was through before it was requeued"
is_empty() { [[ -z "$(squeue --noheader --all)" ]]; }
wait_for 600 is_empty || fail "the tasks do not end"

"$ntc" bake "$work/art" -o "$work/out" "${settings[@]}" --dry-run | grep -q '2 materials: 2 unchanged' || fail "something is left to make"
"$ntc" bake "$work/art" -o "$work/whole" "${settings[@]}" --quiet >/dev/null 2>&1 || fail "the whole bake"
for i in 1 2; do
    cmp "$work/out/M$i.ntc" "$work/whole/M$i.ntc" || fail "M$i.ntc: other bytes"
done
"$ntc" bake "$work/art" -o "$work/out" "${settings[@]}" --plan slurm | grep -q 'nothing to make' || fail "a plan of nothing"
echo "slurm: two tasks of $steps steps, each preempted, then requeued or out of time: the same bytes"
