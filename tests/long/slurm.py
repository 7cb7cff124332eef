"""The smoke chain on a real Slurm of one machine, against a local run: python tests/long/slurm.py [--keep]

munged, mariadbd, slurmdbd, slurmctld and slurmd of the Debian packages are started in a temporary folder, on free ports
of the loopback interface; nothing of the machine's own configuration is read or changed. Needs root, as slurmd does.
The chain then runs in a fresh clone by `snakemake --profile workflow/profiles/slurm` while three things go wrong:
  memory      `stability` is given too little memory, is killed, and has to come back with more
  node        slurmd and all it started are killed with SIGKILL during a training; the node comes back a little later
  GPU         one training asks for a GPU, which the node claims to have: only the request is real
Exit status 1 unless each happened and was recovered from, and every result equals that of `snakemake --cores 2`.
"""

import argparse
import os
import secrets
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))

from clones import PATIENCE, call, clone, free_ports, hashes, stop_in_order, table, wait_until

PROGRAMS = ("munged", "mariadbd", "mariadb-install-db", "slurmdbd", "slurmctld", "slurmd", "sacctmgr")
INSTALL = "apt-get install --no-install-recommends slurm-wlm slurmdbd mariadb-server munge"
SMOKE = ("--configfile", "params/smoke.yaml")
TOO_LITTLE = 400  # MB that the first attempt of `stability` gets; it needs about 550 with Snakemake around it

SLURM = """\
ClusterName=foggy
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ctld}
SlurmdPort={slurmd}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
ReturnToService=2
SlurmdTimeout=10
SlurmdParameters=config_overrides
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=task=1
JobAcctGatherParams=OverMemoryKill
AccountingStorageType=accounting_storage/slurmdbd
AccountingStorageHost=127.0.0.1
AccountingStoragePort={dbd}
AccountingStoragePass={folder}/munge/socket
AccountingStorageTRES=gres/gpu
AccountingStoreFlags=job_comment
GresTypes=gpu
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory=32000 Gres=gpu:1 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""
SLURMDBD = """\
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
DbdHost={host}
DbdAddr=127.0.0.1
DbdPort={dbd}
SlurmUser=root
PidFile={folder}/slurmdbd.pid
LogFile={folder}/slurmdbd.log
StorageType=accounting_storage/mysql
StorageHost=127.0.0.1
StoragePort={sql}
StorageUser=slurm
StoragePass={password}
StorageLoc=slurm
"""


class Cluster:
    """A Slurm of one node, with accounting, in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.host = folder, socket.gethostname().split(".")[0]
        self.daemons: dict[str, subprocess.Popen] = {}
        ports = dict(zip(("ctld", "slurmd", "dbd", "sql"), free_ports(4), strict=True))
        self.values = {"folder": folder, "host": self.host, "cpus": os.cpu_count(), **ports}
        self.values["password"] = secrets.token_hex(16)
        self.variables = {"SLURM_CONF": str(folder / "slurm.conf"), "USER": "root"}

    def start(self) -> None:
        """Start all daemons, each when the one it needs answers."""
        for name in ("munge", "state", "spool", "sql"):
            (self.folder / name).mkdir()
        self._write("slurm.conf", SLURM, 0o644)
        self._write("slurmdbd.conf", SLURMDBD, 0o600)
        (self.folder / "gres.conf").write_text("Name=gpu File=/dev/null\n")
        self._munge()
        self._database()
        self._daemon("slurmdbd", "slurmdbd", "-D")
        wait_until(lambda: self._good("sacctmgr", "--immediate", "add", "cluster", "foggy"), "slurmdbd")
        for what in (["account", "foggy"], ["user", "root", "account=foggy"]):
            self.ask("sacctmgr", "--immediate", "add", *what)
        self._daemon("slurmctld", "slurmctld", "-D")
        self.start_node()

    def start_node(self) -> None:
        """Start the node, or start it again."""
        self._daemon("slurmd", "slurmd", "-D", "-N", self.host)
        wait_until(lambda: self.node_state().startswith(("idle", "mix", "alloc")), "the node")

    def kill_node(self) -> int:
        """SIGKILL for slurmd and all jobs of the node, as a power cut would; how many processes died."""
        doomed = {psutil.Process(self.daemons["slurmd"].pid)}
        for process in psutil.process_iter():
            variables = _environment(process)
            if "SLURM_JOB_ID" in variables and variables.get("SLURM_CONF") == self.variables["SLURM_CONF"]:
                # A job step's slurmstepd belongs to nobody and tells nothing of itself; what it runs has it as parent.
                doomed |= {process, *(each for each in process.parents() if each.name() == "slurmstepd")}
        for process in doomed:
            process.kill()
        self.daemons["slurmd"].wait()
        return len(doomed)

    def node_state(self) -> str:
        """Such as idle, alloc or down."""
        return self.ask("sinfo", "--noheader", "--format=%t").strip()

    def ask(self, *command: str) -> str:
        """What a Slurm command says."""
        variables = {**os.environ, **self.variables}
        done = subprocess.run(command, env=variables, capture_output=True, text=True, timeout=PATIENCE, check=False)
        return done.stdout

    def running(self) -> list[str]:
        """Comments of the jobs that run, which name their rules."""
        return self.ask("squeue", "--noheader", "--states=RUNNING", "--format=%k").splitlines()

    def jobs(self) -> list[list[str]]:
        """State, requested memory, allocated resources and comment of every job and of its requeued attempts."""
        columns = "JobIDRaw,State,ReqMem,AllocTRES,Comment"
        text = self.ask("sacct", "-X", "--duplicates", "--noheader", "--parsable2", f"--format={columns}")
        return [line.split("|") for line in text.splitlines()]

    def stop(self) -> None:
        """Cancel what runs and stop all daemons, the last first."""
        if "slurmctld" in self.daemons:
            self.ask("scancel", "--user=root")
        for process in reversed(self.daemons.values()):
            process.terminate()
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def _write(self, name: str, text: str, mode: int) -> None:
        path = self.folder / name
        path.touch(mode)
        path.write_text(text.format(**self.values))

    def _good(self, *command: str) -> bool:
        variables = {**os.environ, **self.variables}
        return (
            subprocess.run(command, env=variables, capture_output=True, timeout=PATIENCE, check=False).returncode == 0
        )

    def _daemon(self, name: str, *command: str) -> None:
        with open(self.folder / f"{name}.out", "ab") as out:
            self.daemons[name] = subprocess.Popen(
                command, env={**os.environ, **self.variables}, stdin=subprocess.DEVNULL, stdout=out, stderr=out
            )

    def _munge(self) -> None:
        home = self.folder / "munge"
        (home / "key").write_bytes(secrets.token_bytes(128))
        (home / "key").chmod(0o600)
        for path in (home, home / "key"):
            shutil.chown(path, "munge", "munge")
        names = ("socket", "key-file", "pid-file", "log-file", "seed-file")
        files = {"key-file": "key", "pid-file": "pid", "log-file": "log", "seed-file": "seed"}
        options = [f"--{name}={home / files.get(name, name)}" for name in names]
        self._daemon("munged", "setpriv", "--reuid=munge", "--regid=munge", "--clear-groups", "munged", "-F", *options)
        wait_until((home / "socket").exists, "munged")

    def _database(self) -> None:
        data, bare = self.folder / "sql", ["--no-defaults", f"--socket={self.folder}/sql.socket"]
        made = ["mariadb-install-db", "--no-defaults", f"--datadir={data}", "--user=root"]
        subprocess.run([*made, "--auth-root-authentication-method=normal"], capture_output=True, check=True)
        network = [f"--port={self.values['sql']}", "--bind-address=127.0.0.1", f"--pid-file={self.folder}/sql.pid"]
        self._daemon("mariadbd", "mariadbd", *bare, f"--datadir={data}", "--user=root", *network)
        client = ["mariadb", *bare, "--user=root", "--execute"]
        wait_until(lambda: self._good(*client, "SELECT 1"), "mariadbd")
        user = f"CREATE USER slurm@127.0.0.1 IDENTIFIED BY '{self.values['password']}'"
        subprocess.run([*client, f"{user}; GRANT ALL ON slurm.* TO slurm@127.0.0.1;"], check=True)


def _environment(process: psutil.Process) -> dict[str, str]:
    try:
        return process.environ()
    except psutil.Error:
        return {}  # it has ended by now


@contextmanager
def running(folder: Path) -> Iterator[Cluster]:
    """A cluster that is stopped whatever happens."""
    cluster = Cluster(folder)
    try:
        cluster.start()
        yield cluster
    finally:
        cluster.stop()


def break_node(cluster: Cluster, told: list[str]) -> None:
    """Wait for a training to run, kill the node, and bring it back when Slurm has noticed."""
    wait_until(lambda: any("train" in comment for comment in cluster.running()), "a training", 1200)
    time.sleep(5)
    told.append(f"node: {cluster.kill_node()} processes killed")
    wait_until(lambda: cluster.node_state().startswith("down"), "the node's death")
    told.append("node: seen as down by Slurm")
    cluster.start_node()
    told.append("node: back")


def check(cluster: Cluster, told: list[str], same: bool) -> list[str]:
    """What did not happen, or was not recovered from; prints what did."""
    jobs = cluster.jobs()
    killed = [job for job in jobs if "stability" in job[4]]
    print(table(("state", "jobs"), sorted(Counter(job[1].split()[0] for job in jobs).items())))
    print("stability:", ", ".join(f"{job[1]} with {job[2]}" for job in killed))
    print("\n".join(told))
    granted = sorted({job[4] for job in jobs if "gres/gpu=1" in job[3]})
    print(f"GPU granted to: {', '.join(granted) or 'nobody'}")
    asked = [job[2] for job in killed]
    demands = {
        "the job without memory came back with more": len(set(asked)) > 1 and killed[-1][1] == "COMPLETED",
        "a job was lost with its node": "node: back" in told and any(job[1] == "NODE_FAIL" for job in jobs),
        "a GPU was granted to the training that asked": granted == ["rule_train_refinenet_C_wildcards_0"],
        "results equal those of a local run": same,
    }
    return [what for what, held in demands.items() if not held]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--keep", action="store_true", help="leave the temporary folder")
    options = parser.parse_args()
    stop_in_order()
    missing = [name for name in PROGRAMS if shutil.which(name) is None]
    if missing:
        raise SystemExit(f"{', '.join(missing)} not found. On Debian: {INSTALL}")
    if os.geteuid():
        raise SystemExit("slurmd starts jobs as their users: run this as root, on a machine of your own")
    base = Path(tempfile.mkdtemp(prefix="foggy-slurm-"))
    base.chmod(0o755)
    try:
        local, remote = clone(base / "local"), clone(base / "remote")
        (base / "cluster").mkdir()
        with running(base / "cluster") as cluster:
            told: list[str] = []
            trouble = threading.Thread(target=break_node, args=(cluster, told), daemon=True)
            trouble.start()
            done = call(
                remote,
                *("snakemake", "--profile", "workflow/profiles/slurm", *SMOKE),
                *("--slurm-init-seconds-before-status-checks", "3", "--latency-wait", "5"),
                *("--set-resources", f"stability:mem_mb=attempt*{TOO_LITTLE}", "train_refinenet_C:gpu=1"),
                **cluster.variables,
            )
            trouble.join(PATIENCE)
            print(f"Slurm: {done.seconds:.0f} s")
            alone = call(local, "snakemake", "--cores", "2", *SMOKE)
            print(f"local, 2 cores: {alone.seconds:.0f} s")
            ours, theirs = hashes(local), hashes(remote)
            print(f"{len(ours)} results, {sum(theirs.get(path) != digest for path, digest in ours.items())} differ")
            failed = check(cluster, told, ours == theirs)
        if failed:
            raise SystemExit("not shown: " + "; ".join(failed))
    finally:
        if options.keep:
            print(f"kept: {base}", file=sys.stderr)
        else:
            shutil.rmtree(base)


if __name__ == "__main__":
    main()
