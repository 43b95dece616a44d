"""A Slurm cluster of several nodes on the loopback interface of this machine.  It ends when it is closed.

It starts its own munged, slurmctld and one slurmd per node.  Their key, socket, ports, state, spools and logs
are in a temporary directory.  It does not touch another Slurm or munge on the machine.  It needs Debian's
slurm-wlm and munge, but no systemd and no cgroups.  As root, munged runs as its own user, and the jobs belong
to root.  As another user, all programs run as that user.
"""
import atexit
import ctypes
import os
import pathlib
import pwd
import shutil
import signal
import socket
import subprocess
import tempfile
import time

# slurm.conf(5)
CONFIGURATION = """\
ClusterName=lucerna
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort={controller_port}
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
# The latter sets the wait of a requeued job [s]; the default is two minutes.
AuthInfo=socket={directory}/munge/socket,cred_expire=10
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SelectType=select/cons_tres
# Interval [s] at which jobs that wait for a time, such as requeued ones, are checked.
SchedulerParameters=sched_interval=2
StateSaveLocation={directory}/state
SlurmctldPidFile={directory}/slurmctld.pid
SlurmctldLogFile={directory}/log/slurmctld
SlurmdSpoolDir={directory}/spool.%n
SlurmdPidFile={directory}/slurmd.%n.pid
SlurmdLogFile={directory}/log/slurmd.%n
SlurmdParameters=config_overrides
SlurmdTimeout=10
KillWait=5
ReturnToService=2
{nodes}
PartitionName=all Nodes=ALL Default=YES MaxTime=10 State=UP
"""
NODE = "NodeName={name} NodeHostname=localhost NodeAddr=127.0.0.1 Port={port} CPUs=2 RealMemory=1000"

# Prefix of a command: it ends with this process, even if that is killed.
ENDS_WITH_US = ["setpriv", "--pdeathsig=TERM"]


def wait_until(condition, seconds, what):
    """Returns `condition()` as soon as it is true; TimeoutError after the time limit."""
    end = time.monotonic() + seconds
    while not (answer := condition()):
        if time.monotonic() > end:
            raise TimeoutError(f"{what}: not within {seconds} s")
        time.sleep(0.1)
    return answer


def free_ports(count):
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


def children():
    """Process ids of this process's children."""
    found = []
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(stat.read_text().rpartition(")")[2].split()[1])  # after the name, which may contain anything
        except OSError:  # ended meanwhile
            continue
        if parent == os.getpid():
            found.append(int(stat.parent.name))
    return found


class SlurmCluster:
    """A context manager.  `environment` is that of a user of the cluster."""

    def __init__(self, nodes=("n1", "n2", "n3")):
        self.nodes = nodes
        self.daemons = {}
        self.directory = None
        self.environment = None

    def __enter__(self):
        # Processes that a daemon leaves behind become our children, so they can be ended by id.
        pr_set_child_subreaper = 36
        if ctypes.CDLL(None, use_errno=True).prctl(pr_set_child_subreaper, 1, 0, 0, 0) != 0:
            raise OSError(ctypes.get_errno(), "prctl")
        self.directory = pathlib.Path(tempfile.mkdtemp(prefix="lucerna-slurm."))
        atexit.register(self.__exit__)  # also if a test run is interrupted
        try:
            self._start()
        except BaseException:
            self._print_logs()
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        """Ends every process that this process started, and their orphans.  May be called twice."""
        for how, seconds in ((signal.SIGTERM, 10), (signal.SIGKILL, 10)):
            end = time.monotonic() + seconds
            signalled = set()
            while (left := children()) and time.monotonic() < end:
                for pid in set(left) - signalled:
                    os.kill(pid, how)  # our child, not yet waited for, so its id is not reused
                    signalled.add(pid)
                for daemon in self.daemons.values():
                    daemon.poll()
                own = {daemon.pid for daemon in self.daemons.values()}
                for pid in set(children()) - own:
                    os.waitpid(pid, os.WNOHANG)
                time.sleep(0.05)
        shutil.rmtree(self.directory, ignore_errors=True)

    def run(self, *command, check=True, **options):
        """Output of a Slurm command with a user's environment."""
        result = subprocess.run(command, env=self.environment, text=True, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, timeout=60, **options)
        if check and result.returncode != 0:
            raise RuntimeError(f"{' '.join(map(str, command))}: {result.stdout}")
        return result.stdout.strip()

    def job(self, job_id):
        """Slurm's data of a job, in the form of scontrol."""
        shown = self.run("scontrol", "--oneliner", "show", "job", job_id)
        return dict(field.split("=", 1) for field in shown.split() if "=" in field)

    def processes(self, program):
        """The process ids of `program` among the users of this cluster."""
        found = []
        for process in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                if (process / "comm").read_text().strip() == program and \
                        f"SLURM_CONF={self.directory}/".encode() in (process / "environ").read_bytes():
                    found.append(int(process.name))
            except OSError:  # it has ended, or belongs to another user
                pass
        return found

    def fail(self, node):
        """Ends a node's slurmd and its processes, and marks the node as down.  Slurm would do so
        itself after a while."""
        daemon = self.daemons.pop(node)
        daemon.kill()
        daemon.wait()
        for program in ("slurmstepd", "lucernad", "bash"):
            for pid in self.processes(program):
                if f"SLURMD_NODENAME={node}\0".encode() in pathlib.Path(f"/proc/{pid}/environ").read_bytes():
                    os.kill(pid, signal.SIGKILL)
        self.run("scontrol", "update", f"NodeName={node}", "State=DOWN", "Reason=test")

    def repair(self, node):
        self._daemon(node, "slurmd", "-D", "-N", node)

        def is_back():
            if self.run("sinfo", "-h", "-n", node, "-o", "%t") in ("idle", "mix", "alloc"):
                return True
            # On a slow machine the node may be back by itself by now.  Then Slurm refuses the change.
            self.run("scontrol", "update", f"NodeName={node}", "State=RESUME", check=False)
            return False
        self._wait(is_back, 120, f"{node} is back")

    def wait_for(self, job_id, seconds, states=("COMPLETED", "FAILED", "CANCELLED", "TIMEOUT", "NODE_FAIL")):
        """The state in which a job ended."""
        def state():
            now = self.job(job_id)["JobState"]
            return now if now in states else None
        return wait_until(state, seconds, f"job {job_id}: one of {', '.join(states)}")

    def _start(self):
        for name in ("munge", "state", "log", *(f"spool.{node}" for node in self.nodes)):
            (self.directory / name).mkdir()
        self.directory.chmod(0o755)  # munge's user needs access
        ports = free_ports(1 + len(self.nodes))
        configuration = self.directory / "slurm.conf"
        configuration.write_text(CONFIGURATION.format(
            directory=self.directory, user=pwd.getpwuid(os.getuid()).pw_name, controller_port=ports[0],
            nodes="\n".join(NODE.format(name=name, port=port)
                            for name, port in zip(self.nodes, ports[1:]))))
        self.environment = {name: value for name, value in os.environ.items()
                            if not name.startswith(("SLURM_", "SBATCH_", "SALLOC_", "SRUN_"))}
        self.environment["SLURM_CONF"] = str(configuration)
        self.environment["PATH"] += ":/usr/sbin:/sbin"

        munge = self.directory / "munge"
        key = munge / "key"
        key.touch(0o600)
        key.write_bytes(os.urandom(128))
        as_munge = []
        if os.getuid() == 0:
            as_munge = ["--reuid=munge", "--regid=munge", "--clear-groups"]
            for path in (munge, key):
                shutil.chown(path, "munge", "munge")
        self._daemon("munged", "munged", "--foreground", f"--socket={munge}/socket", f"--key-file={key}",
                     f"--pid-file={munge}/pid", f"--seed-file={munge}/seed", f"--log-file={munge}/log",
                     privileges=as_munge)
        self._wait(lambda: (munge / "socket").exists(), 120, "munged's socket")
        self._daemon("slurmctld", "slurmctld", "-D")
        for node in self.nodes:
            self._daemon(node, "slurmd", "-D", "-N", node)
        self._wait(lambda: self.run("sinfo", "-h", "-N", "-o", "%N %t", check=False).splitlines() ==
                   [f"{node} idle" for node in self.nodes], 120, "every node idle")

    def _daemon(self, name, *command, privileges=()):
        with open(self.directory / "log" / f"{name}.out", "w") as out:
            self.daemons[name] = subprocess.Popen(
                [*ENDS_WITH_US, *privileges, *command], env=self.environment, stdin=subprocess.DEVNULL,
                stdout=out, stderr=subprocess.STDOUT)

    def _wait(self, condition, seconds, what):
        def all_run():
            for name, daemon in self.daemons.items():
                if daemon.poll() is not None:
                    raise RuntimeError(f"{name} ended with {daemon.returncode}")
            return condition()
        return wait_until(all_run, seconds, what)

    def _print_logs(self):
        for log in sorted([*self.directory.glob("log/*"), *self.directory.glob("munge/log")]):
            if text := log.read_text(errors="replace").strip():
                print(f"== {log.name}", *text.splitlines()[-15:], sep="\n")
