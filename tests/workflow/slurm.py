"""A SLURM cluster of one node on this machine's loopback, in a folder of its own, without touching the system's."""

import os
import shutil
import signal
import socket
import subprocess
from contextlib import contextmanager
from pathlib import Path

from runs import wait_until

PACKAGES = ("slurm-wlm", "slurm-client", "slurmctld", "slurmd")
DAEMONS = ("slurmctld", "slurmd")
CLIENTS = ("sbatch", "srun", "squeue", "scancel", "sinfo", "sacct", "scontrol")
CONF = """\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/none
CredType=cred/none
SlurmctldPort={controller_port}
SlurmdPort={node_port}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
MpiDefault=none
ReturnToService=2
MinJobAge=600
KillWait=5
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory={memory_mb} State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP DefMemPerCPU=500
"""


def missing_programs():
    """Programs of SLURM that this machine lacks, after an attempt to install Debian's packages if root may."""
    needed = (*DAEMONS, *CLIENTS)
    missing = [name for name in needed if find(name) is None]
    if missing and os.geteuid() == 0 and shutil.which("apt-get"):
        install = ["apt-get", "install", "-y", "--no-install-recommends", *PACKAGES]
        quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
        subprocess.run(install, check=False, capture_output=True, env=quiet, timeout=300)
        missing = [name for name in needed if find(name) is None]
    return missing


def find(name):
    return shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin:/sbin")


def free_ports(n):
    sockets = [socket.socket() for _ in range(n)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


def write_clients(folder, conf):
    """Programs that know the cluster's configuration: job steps are started without SLURM's variables."""
    folder.mkdir()
    for name in CLIENTS:
        path = folder / name
        path.write_text(f'#!/bin/sh\nSLURM_CONF="{conf}" exec {find(name)} "$@"\n')
        path.chmod(0o755)


@contextmanager
def one_node_cluster(folder, cpus=2, memory_mb=8000):
    """Start the cluster; gives the folder of its client programs, to be put first on the path; stops it at the end."""
    folder = Path(folder)
    for name in ("state", "spool"):
        (folder / name).mkdir(parents=True)
    host = socket.gethostname().split(".")[0]
    controller_port, node_port = free_ports(2)
    conf = folder / "slurm.conf"
    values = {"host": host, "folder": folder, "controller_port": controller_port, "node_port": node_port}
    user = subprocess.run(["id", "-un"], capture_output=True, text=True, check=True).stdout.strip()
    conf.write_text(CONF.format(**values, user=user, cpus=cpus, memory_mb=memory_mb))
    write_clients(folder / "bin", conf)
    try:
        for words in (["slurmctld", "-f", conf, "-c"], ["slurmd", "-f", conf, "-N", host, "-c"]):
            subprocess.run([find(words[0]), *map(str, words[1:])], check=True, timeout=60, cwd=folder)
        if not wait_until(lambda: state_of(folder) == "idle", seconds=60):
            logs = "".join((folder / f"{name}.log").read_text()[-1500:] for name in DAEMONS)
            msg = f"the cluster is not idle: {state_of(folder)}\n{logs}"
            raise RuntimeError(msg)
        yield folder / "bin"
    finally:
        for name in reversed(DAEMONS):
            stop(folder / f"{name}.pid")


def state_of(folder):
    told = subprocess.run([folder / "bin/sinfo", "-h", "-o", "%T"], capture_output=True, text=True, check=False)
    return (told.stdout + told.stderr).strip()


def runs(pid, kind=0):
    """Whether a process is there to take a signal."""
    try:
        os.kill(pid, kind)
    except ProcessLookupError:
        return False
    return True


def stop(pid_file, seconds=15):
    """End a daemon by its pid file, and wait until it is gone."""
    if not pid_file.exists():
        return
    pid = int(pid_file.read_text())
    for kind in (signal.SIGTERM, signal.SIGKILL):
        if not runs(pid, kind) or wait_until(lambda: not runs(pid), seconds):
            return
