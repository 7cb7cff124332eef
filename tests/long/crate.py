"""Whether the lineage of a table is a valid Workflow Run RO-Crate: `make crate`.

    python tests/long/crate.py [--clone DIR]

Exports the lineage of a table of a finished smoke run (DIR, or one that is made here) by `foggy trace --crate`, and has
roc-validator, in an environment of its own because it excludes the version of rich that is used here, check what the
profile requires. The validator fetches the crate's JSON-LD context; it is given the one that the package rocrate
brings, which is of version 1.3, with the terms of workflows as version 1.1 spells them.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import venv
from importlib.resources import files
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))

from clones import call, clone

VALIDATOR = "roc-validator==0.13.0"
PROFILE = "workflow-run-crate-0.5"
TABLE = "results/tables/foggy_zurich.tex"
CONTEXT = "https://w3id.org/ro/crate/1.1/context"
# RO-Crate 1.1, section "Workflows and scripts"; later versions moved these terms to bioschemas.org/terms.
TERMS = {
    "ComputationalWorkflow": "https://bioschemas.org/ComputationalWorkflow",
    "FormalParameter": "https://bioschemas.org/FormalParameter",
    "input": "https://bioschemas.org/ComputationalWorkflow#input",
    "output": "https://bioschemas.org/ComputationalWorkflow#output",
}
# Python starts with this module: both ways by which the validator fetches get the file instead.
INSTEAD_OF_THE_NETWORK = f"""\
import email.message, os, urllib.request, urllib.response
import requests.adapters

DATA = open(os.environ["CRATE_CONTEXT"], "rb").read()


class Local(urllib.request.HTTPSHandler):
    def https_open(self, request):
        assert request.full_url == "{CONTEXT}", request.full_url
        headers = email.message.Message()
        headers["Content-Type"] = "application/ld+json"
        answer = urllib.response.addinfourl(open(os.environ["CRATE_CONTEXT"], "rb"), headers, request.full_url, 200)
        answer.msg = "OK"
        return answer


def send(adapter, request, **options):
    assert request.url == "{CONTEXT}", request.url
    answer = requests.models.Response()
    answer.status_code, answer._content, answer.url, answer.request = 200, DATA, request.url, request
    answer.headers["Content-Type"] = "application/ld+json"
    return answer


urllib.request.install_opener(urllib.request.build_opener(Local))
requests.adapters.HTTPAdapter.send = send
"""


def context() -> str:
    """The JSON-LD context that the package rocrate brings, with the terms of version 1.1."""
    document = json.loads((files("rocrate") / "data/ro-crate.jsonld").read_text(encoding="utf-8"))
    document["@context"].update(TERMS)
    return json.dumps(document)


def validate(crate: Path, scratch: Path) -> int:
    """Install the validator and run it; its exit status."""
    venv.create(scratch / "venv", with_pip=True)
    programs = scratch / "venv/bin"
    subprocess.run([programs / "python", "-m", "pip", "install", "--quiet", VALIDATOR], check=True)
    (scratch / "context.jsonld").write_text(context(), encoding="utf-8")
    (scratch / "start").mkdir()
    (scratch / "start/sitecustomize.py").write_text(INSTEAD_OF_THE_NETWORK, encoding="utf-8")
    options = ["-p", PROFILE, "--skip-availability-check", "--no-cache", "--no-paging", "--verbose"]
    command = [programs / "rocrate-validator", "--disable-color", "-y", "validate", *options, crate]
    changes = {"PYTHONPATH": str(scratch / "start"), "CRATE_CONTEXT": str(scratch / "context.jsonld")}
    return subprocess.run(command, env={**os.environ, **changes}, check=False).returncode


def main() -> int:
    """The exit status of the validator: 0 where every required check is passed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--clone", type=Path, metavar="DIR", help="clone with a finished smoke run, where there is one")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        scratch = Path(name)
        folder = options.clone
        if folder is None:
            folder = clone(scratch / "clone")
            call(folder, "snakemake", "--cores", "2", "--configfile", "params/smoke.yaml")
        crate = scratch / "crate.zip"
        print(call(folder, sys.executable, "-m", "foggy_synscapes", "trace", TABLE, "--crate", str(crate)).text)
        return validate(crate, scratch)


if __name__ == "__main__":
    sys.exit(main())
