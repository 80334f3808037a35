"""Debian's Slurm (slurm-wlm, munge) on the loopback of this machine: a controller and nodes, all started and ended by one process."""

import os
import pathlib
import shutil
import signal
import socket
import subprocess
import tempfile
import time

PROGRAMS = {"munged": "munge", "slurmctld": "slurm-wlm", "slurmd": "slurm-wlm", "sbatch": "slurm-wlm"}

# Cores are promised, not measured: the nodes share one machine.
CONFIGURATION = """
ClusterName=loopback
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
MailProg=/bin/true
ReturnToService=2
SlurmdTimeout={timeout}
InactiveLimit=0
KillWait=2
MinJobAge=600
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def missing():
    """Debian packages that are not installed."""
    found = {**os.environ, "PATH": os.environ["PATH"] + ":/usr/sbin:/sbin"}
    return sorted({package for program, package in PROGRAMS.items() if not shutil.which(program, path=found["PATH"])})


def free_ports(count):
    """Ports of the loopback that nobody listens on."""
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class Cluster:
    """`nodes` nodes of four cores, as they are told. Use it in a `with`: whatever happens, nothing that it started stays."""

    def __init__(self, nodes=2, seconds_until_down=10):
        self.nodes = [f"n{k + 1}" for k in range(nodes)]
        self.seconds_until_down = seconds_until_down
        self.daemons = {}

    def __enter__(self):
        self._temporary = tempfile.TemporaryDirectory(prefix="balance-slurm-")
        self.folder = pathlib.Path(self._temporary.name)
        self.folder.chmod(0o755)  # munged serves nobody through a folder that is closed
        self.environment = {**os.environ, "SLURM_CONF": str(self.folder / "slurm.conf"),
                            "PATH": os.environ["PATH"] + ":/usr/sbin:/sbin"}
        try:
            self._configure()
            self._start_munge()
            self._start("slurmctld", "slurmctld", "-D", "-c")
            for name in self.nodes:
                self.start_node(name)
            self.wait(self._all_idle, 60, "nodes that are idle")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for name in reversed(list(self.daemons)):
            self._stop(name, signal.SIGTERM)
        for pid in self._left_over():
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        self._temporary.cleanup()

    def run(self, *command, **options):
        """Standard output of a command that succeeds."""
        done = subprocess.run(command, env=self.environment, text=True, capture_output=True, check=False, **options)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
        return done.stdout.strip()

    def start_node(self, name):
        self._start(name, "slurmd", "-D", "-N", name)

    def kill_node(self, name):
        """As when a machine's daemon dies: what it has started goes on, until the daemon comes back."""
        self._stop(name, signal.SIGKILL)

    def wait(self, condition, seconds, what):
        """What the condition gives as soon as it is true."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            found = condition()
            if found:
                return found
            for name, daemon in self.daemons.items():
                if daemon.poll() is not None:
                    raise RuntimeError(f"{name} ended with exit code {daemon.returncode}\n{self.last_words()}")
            time.sleep(0.05)
        raise RuntimeError(f"no {what} after {seconds} s\n{self.last_words()}")

    def last_words(self):
        logs = sorted(self.folder.glob("*.log"))
        return "\n".join(f"{log.name}: {line}" for log in logs for line in log.read_text(errors="replace").splitlines()[-8:])

    def _configure(self):
        ports = free_ports(1 + len(self.nodes))
        user = self.run("id", "-un")
        text = CONFIGURATION.format(folder=self.folder, port=ports[0], user=user, host=socket.gethostname(),
                                    timeout=self.seconds_until_down)
        for name, port in zip(self.nodes, ports[1:]):
            text += f"NodeName={name} NodeHostname={socket.gethostname()} NodeAddr=127.0.0.1 Port={port} CPUs=4 State=UNKNOWN\n"
            (self.folder / f"spool-{name}").mkdir()
        (self.folder / "state").mkdir()
        (self.folder / "slurm.conf").write_text(text, encoding="utf-8")

    def _start_munge(self):
        munge = self.folder / "munge"
        munge.mkdir()
        key = munge / "key"
        key.touch(mode=0o600)
        key.write_bytes(os.urandom(1024))
        self._start("munged", "munged", "--foreground", "--num-threads=2",
                    *(f"--{what}-file={munge / what}" for what in ("key", "pid", "log", "seed")), f"--socket={munge / 'socket'}")
        self.wait((munge / "socket").exists, 20, "socket of munged")

    def _start(self, name, *command):
        output = (self.folder / f"{name}.log").open("a")
        self.daemons[name] = subprocess.Popen(command, env=self.environment, stdout=output, stderr=subprocess.STDOUT,
                                              stdin=subprocess.DEVNULL, cwd=self.folder, start_new_session=True)
        output.close()

    def _stop(self, name, how):
        daemon = self.daemons.pop(name)
        if daemon.poll() is None:
            daemon.send_signal(how)
        try:
            daemon.wait(20)
        except subprocess.TimeoutExpired:
            daemon.kill()
            daemon.wait()

    def _all_idle(self):
        listed = subprocess.run(["sinfo", "-h", "-N", "-o", "%N %T"], env=self.environment, text=True, capture_output=True, check=False)
        return sorted(listed.stdout.split("\n"))[1:] == [f"{name} idle" for name in self.nodes]

    def _left_over(self):
        """Processes of this very cluster, which have its configuration in their environment: steps of daemons that were killed."""
        mark = f"SLURM_CONF={self.folder}/slurm.conf".encode()
        for entry in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                if mark in (entry / "environ").read_bytes().split(b"\0") and int(entry.name) != os.getpid():
                    yield int(entry.name)
            except OSError:
                pass  # it has ended, or is not ours
