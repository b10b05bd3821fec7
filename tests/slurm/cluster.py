"""A SLURM cluster of two nodes on this machine: its own key, ports and folder, gone with its context.

It needs the programs of Debian's packages slurm-wlm and munge and no rights: every daemon and every
job belongs to the user who starts it. Nothing outside a temporary folder is read or written, and
no message leaves the machine.
"""

import getpass
import os
import secrets
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import psutil

NODES = ("node1", "node2")

PATIENCE = 60.0
"""Seconds that a start or a command may take; usually it is two or less."""

MEND = "On Debian, apt-get install slurm-wlm munge brings all that it needs."
"""What to do where a SLURM does not come up."""

PROGRAMS = ("munged", "slurmctld", "slurmd", "srun", "sbatch", "squeue", "sinfo")

CONFIGURATION = """\
ClusterName=tests
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort={controller}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
# A requeued job starts when the credential of its last start has expired, by default after 120 s.
AuthInfo=socket={folder}/munge.socket,cred_expire=10
# The controller listens on its own address and no other.
CommunicationParameters=NoCtldInAddrAny
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
AccountingStorageType=accounting_storage/none
# What a node was doing is done anew when the node is lost, and that is noticed in seconds.
JobRequeue=1
MessageTimeout=5
SlurmdTimeout=5
# A node that is back takes part again.
ReturnToService=2
# Waiting jobs are looked at every two seconds instead of every thirty.
SchedulerParameters=bf_interval=2,sched_interval=2
# One job a node, however many processors the machine has.
SlurmdParameters=config_overrides
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""

NODE = "NodeName={name} NodeHostname=localhost NodeAddr=127.0.0.1 Port={port} CPUs=1\n"

# PR_SET_CHILD_SUBREAPER: what a daemon starts stays its descendant, also when it is orphaned, so
# that all of it can be found and ended. PR_SET_PDEATHSIG: the daemon ends with the tests.
START = """
import ctypes, os, signal, sys
prctl = ctypes.CDLL(None).prctl
prctl(36, 1)
prctl(1, signal.SIGKILL)
os.execv(sys.argv[1], sys.argv[1:])
"""


class ClusterError(RuntimeError):
    """No cluster can be had here; the sentence says why."""


@dataclass(frozen=True)
class Job:
    """A job as the controller knows it; one of an array is ARRAY_INDEX."""

    id: str
    state: str
    node: str
    restarts: int


class Cluster:
    """A running cluster.

    Args:
        folder: for all its files; short, for the sockets' sake.
        stack: ends the daemons.
    """

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self._folder = folder
        self._programs = _find_programs()
        self._daemons: dict[str, subprocess.Popen[bytes]] = {}
        self._configure()
        self.environment = _environment() | {"SLURM_CONF": str(folder / "slurm.conf")}
        """Of a process whose SLURM is this one."""
        stack.callback(self._end_all)
        self._start("munged", "--foreground", *self._munge_options())
        self._wait_for((folder / "munge.socket").exists, "munged")
        self._start("slurmctld", "-D", "-c")
        for node in NODES:
            self.restart(node)

    def run(self, program: str, *arguments: str) -> str:
        """Output of a command of SLURM's.

        Raises:
            ClusterError: it fails or takes too long.
        """
        try:
            return subprocess.run(
                [self._programs.get(program, program), *arguments],
                env=self.environment,
                cwd=self._folder,
                capture_output=True,
                text=True,
                timeout=PATIENCE,
                check=True,
            ).stdout
        except subprocess.CalledProcessError as error:
            raise ClusterError(f"{program} failed: {error.stderr.strip()} {MEND}") from error
        except subprocess.TimeoutExpired as error:
            raise ClusterError(f"{program} took more than {PATIENCE:g} s. {MEND}") from error

    def jobs(self) -> list[Job]:
        """Every job since the start, those that are over too."""
        columns = "JobArrayID:|,State:|,NodeList:|,RestartCnt:|"
        listing = self.run("squeue", "--noheader", "--array", "--states=all", "-O", columns)
        rows = (line.split("|") for line in listing.splitlines())
        return [Job(name, state, node, int(restarts)) for name, state, node, restarts, _ in rows]

    def kill(self, node: str) -> None:
        """End a node as a power failure does: its daemon and its jobs at once, without a word."""
        self._end(self._daemons.pop(node))

    def restart(self, node: str) -> None:
        """Start a node and wait until it takes jobs."""
        self._start("slurmd", "-D", "-N", node, name=node)

        def ready() -> bool:
            with suppress(ClusterError):
                return self.run("sinfo", "--noheader", "-n", node, "-o", "%t").strip() == "idle"
            return False

        self._wait_for(ready, node)

    def _configure(self) -> None:
        self._folder.chmod(0o755)  # munged insists that everybody reaches its socket
        key = self._folder / "munge.key"
        key.touch(0o600)
        key.write_bytes(secrets.token_bytes(128))
        (self._folder / "state").mkdir()
        controller, *ports = _free_ports(1 + len(NODES))
        text = CONFIGURATION.format(controller=controller, user=getpass.getuser(), folder=self._folder)
        nodes = [NODE.format(name=n, port=p) for n, p in zip(NODES, ports, strict=True)]
        (self._folder / "slurm.conf").write_text("".join([*nodes, text]))

    def _munge_options(self) -> list[str]:
        names = {"key-file": "key", "socket": "socket", "pid-file": "pid", "seed-file": "seed"}
        return [f"--{option}={self._folder / f'munge.{name}'}" for option, name in names.items()]

    def _start(self, program: str, *arguments: str, name: str = "") -> None:
        name = name or program
        with (self._folder / f"{name}.out").open("ab") as log:
            self._daemons[name] = subprocess.Popen(
                [sys.executable, "-c", START, self._programs[program], *arguments],
                env=self.environment,
                cwd=self._folder,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,  # Ctrl-C is the tests' affair
            )

    def _wait_for(self, ready: Callable[[], bool], name: str) -> None:
        """Wait until a daemon is up.

        Raises:
            ClusterError: with its last words, if it is not.
        """
        patience = time.monotonic() + PATIENCE
        while not ready():
            if self._daemons[name].poll() is not None or time.monotonic() > patience:
                phrase = (self._folder / f"{name}.out").read_text().strip().splitlines()[-3:]
                raise ClusterError(f"{name} does not come up: {' '.join(phrase)} {MEND}")
            time.sleep(0.1)

    def _end_all(self) -> None:
        while self._daemons:
            self._end(self._daemons.popitem()[1])

    @staticmethod
    def _end(daemon: subprocess.Popen[bytes]) -> None:
        """Kill a daemon with all that it has started.

        First everything stands still, so that nothing tells of another's end or begins something.
        """
        still: list[psutil.Process] = []
        with suppress(psutil.NoSuchProcess):
            head = psutil.Process(daemon.pid)
            while moving := [p for p in (head, *head.children(recursive=True)) if p not in still]:
                for process in moving:
                    with suppress(psutil.NoSuchProcess):
                        process.suspend()
                still += moving
        for process in still:
            with suppress(psutil.NoSuchProcess):
                process.kill()
        daemon.wait(PATIENCE)


@contextmanager
def running_cluster() -> Iterator[Cluster]:
    """A cluster while the context lasts.

    Raises:
        ClusterError: there can be none here.
    """
    with TemporaryDirectory(prefix="slurm-", dir="/tmp") as folder, ExitStack() as stack:
        yield Cluster(Path(folder), stack)


def _find_programs() -> dict[str, str]:
    # A user's path need not have the daemons on it.
    path = os.pathsep.join([os.environ.get("PATH", os.defpath), "/usr/sbin", "/sbin"])
    result = {name: shutil.which(name, path=path) for name in PROGRAMS}
    if absent := [name for name, program in result.items() if program is None]:
        raise ClusterError(
            f"No SLURM can be started here, there is no {', '.join(absent)}; on Debian, "
            "apt-get install slurm-wlm munge brings them."
        )
    return {name: program for name, program in result.items() if program}


def _environment() -> dict[str, str]:
    """That of this process without what another SLURM may have put in."""
    foreign = ("SLURM", "SBATCH", "SRUN", "SQUEUE", "SINFO")
    return {key: value for key, value in os.environ.items() if not key.startswith(foreign)}


def _free_ports(number: int) -> list[int]:
    with ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(number)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]
