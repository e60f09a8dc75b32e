#!/usr/bin/env bash
# slurm-up.sh FOLDER: Slurm with two nodes of one core on this machine, as root, without systemd, cgroups or a database.
# Debian: slurmctld slurmd slurm-client munge; for ranks of MPI libpmix2, which makes a folder of one name on each node, so that each has a TmpFS. slurm-down.sh FOLDER ends it. Then: export SLURM_CONF=FOLDER/etc/slurm.conf
set -euo pipefail
folder="$(realpath -m "$1")"
host="$(hostname -s)"
mkdir -p "$folder"/{etc,ctld,d.n1,d.n2,log,run,munge}
chmod 755 "$folder"
chmod 700 "$folder/munge"
(umask 077; head -c 1024 /dev/urandom > "$folder/munge/key")
{
  printf '%s\n' ClusterName=ci "SlurmctldHost=$host(127.0.0.1)" SlurmctldPort=16817 SlurmUser=root SlurmdUser=root \
    "AuthInfo=socket=$folder/run/munge.socket,cred_expire=5" ProctrackType=proctrack/linuxproc \
    SelectType=select/cons_tres SelectTypeParameters=CR_Core SchedulerParameters=sched_interval=1,bf_interval=1,sched_min_interval=100000 \
    "StateSaveLocation=$folder/ctld" "SlurmctldPidFile=$folder/run/ctld.pid" "SlurmctldLogFile=$folder/log/ctld.log" \
    "SlurmdSpoolDir=$folder/d.%n" "SlurmdPidFile=$folder/run/%n.pid" "SlurmdLogFile=$folder/log/%n.log" \
    "TmpFS=$folder/d.%n" ReturnToService=2 KillWait=10 SlurmdTimeout=10 RequeueExit=75
  for node in 1 2; do
    echo "NodeName=n$node NodeHostname=$host NodeAddr=127.0.0.1 Port=1682$node CPUs=1 RealMemory=2000"
  done
  echo "PartitionName=main Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP"
} > "$folder/etc/slurm.conf"
munged --key-file="$folder/munge/key" --socket="$folder/run/munge.socket" --pid-file="$folder/run/munged.pid" \
  --log-file="$folder/munge/log" --seed-file="$folder/munge/seed" --force
export SLURM_CONF="$folder/etc/slurm.conf"
slurmctld
slurmd -N n1
slurmd -N n2
for _ in $(seq 30); do
  [ "$(sinfo -h -t idle -o %D)" = 2 ] && exit 0
  sleep 1
done
tail -n 20 "$folder"/log/*
exit 1
