#!/usr/bin/env bash
# The atlas of docs/cluster.md, built by a Slurm array on this machine alone: munged, slurmctld and
# slurmd run here, as root, for as long as the script does. The merged file is compared byte for byte
# with that of one process.
#
#   apt-get install -y slurmctld slurmd slurm-client munge
#   cargo build --release -p mlr-ga
#   tools/cluster/slurm.sh target/release/mlr-ga 8 --most-damaged-legs 1
#
# Arguments: the program, the number of parts, and options of `mlr-ga atlas build`.
set -euo pipefail

program=$(realpath "$1")
parts=$2
shift 2
options=("$@")

for command in munged slurmctld slurmd sbatch; do
    command -v "$command" >/dev/null || {
        echo "$command is needed: apt-get install -y slurmctld slurmd slurm-client munge" >&2
        exit 2
    }
done

work=$(mktemp -d)
host=$(hostname -s)
started=()
stop() {
    for pid in "${started[@]}"; do
        kill "$pid" 2>/dev/null || true
    done
    echo "logs of Slurm and of the parts: $work" >&2
}
trap stop EXIT

# Every message between Slurm's parts is signed by munge.
install -d -m 0700 -o munge -g munge "$work/munge"
chmod 0755 "$work"
(umask 077 && head -c 1024 /dev/urandom >"$work/munge/key")
chown munge:munge "$work/munge/key"
install -d -m 0755 -o munge -g munge "$work/socket"
runuser -u munge -- munged --foreground --key-file="$work/munge/key" \
    --socket="$work/socket/munge" --pid-file="$work/munge/pid" \
    --log-file="$work/munge/log" --seed-file="$work/munge/seed" >"$work/munged.out" 2>&1 &
started+=($!)
until [ -S "$work/socket/munge" ]; do sleep 0.2; done

export SLURM_CONF="$work/slurm.conf"
cat >"$SLURM_CONF" <<CONF
ClusterName=mlr
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$work/socket/munge
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
mkdir -p "$work/state" "$work/spool"
slurmctld -D >"$work/slurmctld.out" 2>&1 &
started+=($!)
slurmd -D >"$work/slurmd.out" 2>&1 &
started+=($!)
until sinfo --noheader --format=%T 2>/dev/null | grep -q idle; do sleep 0.5; done

mkdir "$work/parts"
cat >"$work/part.sbatch" <<'JOB'
#!/bin/sh
#SBATCH --job-name=atlas
#SBATCH --cpus-per-task=1
exec "$MLR_GA" --threads "$SLURM_CPUS_PER_TASK" atlas build \
    --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" \
    -o "parts/$SLURM_ARRAY_TASK_ID.part" "$@"
JOB
(
    cd "$work"
    MLR_GA=$program sbatch --wait --array="1-$parts" --output=part-%a.log part.sbatch "${options[@]}"
)
"$program" atlas merge "$work"/parts/*.part -o "$work/merged.atlas"
"$program" atlas build "${options[@]}" -o "$work/whole.atlas"
cmp "$work/merged.atlas" "$work/whole.atlas"
sha256sum "$work/merged.atlas" "$work/whole.atlas"
echo "$parts parts: the same $(stat -c %s "$work/whole.atlas") bytes"
