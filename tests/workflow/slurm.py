"""A SLURM cluster of one node on the loopback, in a folder of its own, beside the system's."""

import os
import shutil
import socket
import subprocess
from contextlib import contextmanager

import psutil
from runs import wait_until

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
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
ReturnToService=2
MinJobAge=600
KillWait=5
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=8000 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP DefMemPerCPU=500
"""


def missing_programs():
    """Programs of SLURM that this machine lacks."""
    return [name for name in (*DAEMONS, *CLIENTS) if find(name) is None]


def find(name):
    return shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin:/sbin")


@contextmanager
def one_node_cluster(folder):
    """A running cluster: the folder of its client programs, to be put first on the path."""
    for name in ("state", "spool", "bin"):
        (folder / name).mkdir(parents=True)
    host = socket.gethostname().split(".")[0]
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(2)]
    controller_port, node_port = (each.getsockname()[1] for each in sockets)
    for each in sockets:
        each.close()  # the ports are free again
    conf = folder / "slurm.conf"
    values = {
        "host": host,
        "folder": folder,
        "controller_port": controller_port,
        "node_port": node_port,
    }
    user = subprocess.run(["id", "-un"], capture_output=True, text=True, check=True).stdout.strip()
    conf.write_text(CONF.format(**values, user=user))
    for name in CLIENTS:
        # Programs that know the cluster's configuration: job steps are started without SLURM's
        # variables.
        program = folder / "bin" / name
        program.write_text(f'#!/bin/sh\nSLURM_CONF="{conf}" exec {find(name)} "$@"\n')
        program.chmod(0o755)
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder}
    daemons = [
        subprocess.Popen([find("slurmctld"), "-D", "-f", conf, "-c"], **quiet),
        subprocess.Popen([find("slurmd"), "-D", "-f", conf, "-N", host, "-c"], **quiet),
    ]
    try:
        if not wait_until(lambda: state_of(folder) == "idle", seconds=60):
            logs = "".join((folder / f"{name}.log").read_text()[-1500:] for name in DAEMONS)
            msg = f"the cluster is not idle: {state_of(folder)}\n{logs}"
            raise RuntimeError(msg)
        yield folder / "bin"
    finally:
        for daemon in reversed(daemons):
            daemon.terminate()
            try:
                daemon.wait(timeout=15)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()


def state_of(folder):
    answer = subprocess.run(
        [folder / "bin/sinfo", "-h", "-o", "%T"], capture_output=True, text=True, check=False
    )
    return (answer.stdout + answer.stderr).strip()


def steps_at_work():
    """Processes of each job step at work, a list for each."""
    steps = [each for each in psutil.process_iter(["name"]) if each.info["name"] == "slurmstepd"]
    for step in steps:
        try:
            yield step.children(recursive=True)
        except psutil.NoSuchProcess:
            continue


def scripts_at_work(name):
    """Python processes of job steps that run a script of the workflow, by its file's name."""
    for process in (each for step in steps_at_work() for each in step):
        try:
            if "python" in process.name() and name in " ".join(process.cmdline()):
                yield process
        except psutil.NoSuchProcess:
            continue
