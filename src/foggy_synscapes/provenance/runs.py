"""Run records: beside its outputs, a step writes what made them, so that each number can be traced back.

A record holds the command, the params it read, SHA-256 of its inputs and outputs, digests of its code, versions, and
the instruction set. It holds no time, host or absolute path, so that equal runs write equal records.
"""

import importlib
import json
import os
import platform
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from foggy_synscapes import __version__
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import altered, write_bytes, write_text
from foggy_synscapes.io.files import check_name, read_json
from foggy_synscapes.io.hashing import sha256, sha256_bytes
from foggy_synscapes.io.stamps import CACHE, Stamps, stamp
from foggy_synscapes.jobs import Job
from foggy_synscapes.params import STAND_IN, Params, load
from foggy_synscapes.provenance import source_digest
from foggy_synscapes.results import RESULTS
from foggy_synscapes.steps import REGISTRIES, code_file

REAL, IMPORTED, NO_WEIGHTS = "real", "imported", "none"
VARIABLES = (
    *("ATEN_CPU_CAPABILITY", "BLIS_ARCH_TYPE", "CUBLAS_WORKSPACE_CONFIG", "DNNL_DEFAULT_FPMATH_MODE"),
    *("DNNL_MAX_CPU_ISA", "KMP_DETERMINISTIC_REDUCTION", "MATPLOTLIBRC", "MKL_CBWR", "MKL_DEBUG_CPU_TYPE"),
    *("MKL_ENABLE_INSTRUCTIONS", "NUMBA_CPU_FEATURES", "NUMBA_CPU_NAME", "NUMBA_DISABLE_JIT", "NUMBA_OPT"),
    *("NVIDIA_TF32_OVERRIDE", "ONEDNN_DEFAULT_FPMATH_MODE", "ONEDNN_MAX_CPU_ISA", "OPENBLAS_CORETYPE"),
    *("PYTHONOPTIMIZE", "TORCH_ALLOW_TF32_CUBLAS_OVERRIDE"),
)
"""Environment variables by which libraries choose other instructions, formats or orders of sums, where they are set."""


OF_DVC, DVC_PARAMS = "DVC_STAGE", Path("params.yaml")
"""Environment variable that DVC sets for the commands of its stages, and the params file that it reads."""
PLANNED = "FOGGY_PARAMS"
"""Environment variable by which a job knows the params with which its engine planned it; see `params_digest`."""


class Run:
    """One run of a job, from its start to its record.

    All of its modules are loaded, and code, params and inputs hashed, when it starts: what is edited afterwards has no
    part in it.

    job : what is run; read : the files that it really reads, where some of the job's may be missing

    Attributes
    ----------
    inputs : SHA-256 by file; params : values of the job's keys; code, libraries : see `source_digest`

    Raises
    ------
    FoggyError
        As `checked_inputs` does, and if the code that runs is not that of this folder, or was edited while it was
        loaded, or if an engine planned with other params.
    """

    def __init__(self, job: Job, read: Iterable[str | Path] | None = None) -> None:
        self.job = job
        if os.environ.get(PLANNED, digest := params_digest(job.params)) != digest:
            raise FoggyError(
                f"{' '.join(job.command)}: the params were edited after this run was planned. Nothing is made of them "
                "half way: run the same command again."
            )
        source_digest.check_origin()
        self.code, self.libraries = code_of(job)
        self._loaded = source_digest.Loaded(self.code)
        _check_code(job, self.code, self.libraries)
        self.params = recorded(job.params, *job.keys())
        self.inputs = checked_inputs(job.read() if read is None else read)
        self._stamps = {name: stamp(name) for name in self.inputs}
        self._params_of_dvc = DVC_PARAMS.read_bytes() if OF_DVC in os.environ and DVC_PARAMS.is_file() else None

    def identity(self) -> dict[str, Any]:
        """All that decides the bytes of the outputs, but for the machine: to tell whether half a job may go on."""
        versions = {"python": platform.python_version(), **self.libraries}
        return {"code": self.code, "versions": versions, "params": self.params, "inputs": self.inputs}

    def write(self, **contents: str | bytes) -> None:
        """Write outputs by their names; text in UTF-8."""
        for name, content in contents.items():
            write_bytes(self.job.output(name), content.encode() if isinstance(content, str) else content)

    def finish(self, processes: int = 1, device: str = "cpu") -> None:
        """Write the record of all that the job wrote.

        processes : number of processes that shared the arithmetic; device : where, "cpu" or "cuda"
        """
        self._loaded.check()
        self._check_params()
        for name, digest in self.inputs.items():
            if stamp(name) != self._stamps[name] and sha256(name) != digest:
                raise FoggyError(
                    f"{name}: was changed while {' '.join(self.job.command)} read it. What came of it has no run "
                    "record and is made again: run the same command."
                )
        stamps, outputs = stamps_of(self.job), sorted(self.job.outputs())
        digests = {path.as_posix(): stamps.take(path) for path in outputs}
        # After they were read: what is altered before that is none of this job's, and after that does not match.
        changed = [path for path in outputs if altered(path)]
        if changed:
            raise FoggyError(
                f"{changed[0]}: was changed by something else while {' '.join(self.job.command)} ran. It has no run "
                "record and is made again: run the same command."
            )
        record = self.identity() | {
            "command": self.job.command,
            "outputs": digests,
            "instructions": instructions(),
            "processes": processes,
            **({"gpu": gpu()} if device == "cuda" else {}),
        }
        record["versions"]["foggy-synscapes"] = __version__
        text = json.dumps(record, indent=1, sort_keys=True, ensure_ascii=False)
        for place in (self.job.output("record"), remembered(self.job)):
            write_text(place, text + "\n")
        stamps.save()
        if code_of(self.job) != (self.code, self.libraries):
            print("its code was edited meanwhile; this is of the code as it was, and out of date", file=sys.stderr)

    def _check_params(self) -> None:
        """Refuse to end with other params than DVC finds when it locks what ran."""
        before = self._params_of_dvc
        if before is None or DVC_PARAMS.read_bytes() == before:
            return
        if params_digest(load(DVC_PARAMS)) != params_digest(self.job.params):
            raise FoggyError(
                f"{DVC_PARAMS}: was edited while {' '.join(self.job.command)} ran, and DVC would take its results for "
                "those of the edited one. Run the same command again."
            )


def stamps_of(job: Job) -> Stamps:
    """What is known on this machine of the content of a job's files."""
    return Stamps(CACHE / "stamps" / job.output("record"))


def remembered(job: Job) -> Path:
    """Where this machine keeps a copy of a job's record, for when all that the job made is removed."""
    return CACHE / "records" / job.output("record")


def params_digest(params: Params) -> str:
    """SHA-256 of all values of params, however they are written."""
    return sha256_bytes(params.model_dump_json(by_alias=True).encode())


def _check_code(job: Job, *code: dict[str, str]) -> None:
    """Refuse to run other code than DVC compared when it planned: it would lock what was not run."""
    place = Path(code_file(job.step, job.values))
    if OF_DVC in os.environ and place.is_file() and place.read_text(encoding="utf-8") != code_text(*code):
        raise FoggyError(
            f"{' '.join(job.command)}: the code was edited after DVC planned this. Run the same command again."
        )


def code_text(*found: dict[str, str]) -> str:
    """What counts of the code of a job, a line each, as DVC compares it."""
    return "".join(f"{name} {value}\n" for values in found for name, value in values.items())


def code_of(job: Job) -> tuple[dict[str, str], dict[str, str]]:
    """Digests by module of a job's code, and the versions of its libraries."""
    return source_digest.code(job.step.word, tuple(job.code()), REGISTRIES)


def versions_now(names: Iterable[str]) -> dict[str, str]:
    """Today's versions of what a record names: Python, this package and libraries."""
    own = {"python": platform.python_version(), "foggy-synscapes": __version__}
    return {name: own.get(name) or source_digest.version(name) for name in names}


def checked_inputs(paths: Iterable[str | Path]) -> dict[str, str]:
    """SHA-256 by file of what a step reads, made sure to be what the records of their makers say.

    To be called before anything is made of the files. Those outside of `results` have no maker and are only hashed.

    Raises
    ------
    FoggyError
        If a file is missing or has no record, or was changed, or only half of its step's files were written.
    """
    hashes = {}
    for path in map(Path, sorted({str(path) for path in paths})):
        made_here = path.parts[0] == RESULTS
        if made_here and not path.is_file():
            raise FoggyError(f"{path}: missing. It is made by an earlier step: run `snakemake` or `dvc repro`.")
        hashes[path.as_posix()] = digest = sha256(path)
        place = record_of(path)
        if made_here and not place.is_file():
            raise FoggyError(
                f"{path}: no run record beside it ({place}), so nothing says what made it. Was its step cut off, or "
                "the file put there by hand? Delete it and run the engine again."
            )
        record = read_run(place) if made_here else {"outputs": {path.as_posix(): digest}}
        recorded = record["outputs"].get(path.as_posix())
        if recorded != digest:
            said = f"has sha256 {recorded[:12]}..." if recorded else "does not name it"
            raise FoggyError(
                f"{path}: is not what its step wrote: its sha256 is {digest[:12]}..., but {place} {said}. Make it "
                f"again: {' '.join(record['command'])} (with the --params of this run), or delete it and run the "
                "engine again."
            )
    return hashes


def record_of(path: Path) -> Path:
    """Where the run record of a result lies: `NAME.run.json` where the step writes several records, or `run.json`.

    >>> record_of(Path("nowhere/results/0000.csv")).as_posix()
    'nowhere/results/run.json'
    """
    own = path.with_suffix(".run.json")
    return own if own.is_file() else path.with_name("run.json")


def read_run(path: Path) -> dict[str, Any]:
    """One run record.

    Raises FoggyError if it is no JSON object with command, inputs and outputs, or names outputs outside of the folder.
    """
    record = read_json(path, "run record", "Run its step again.")
    if not isinstance(record, dict) or not {"command", "inputs", "outputs"} <= record.keys():
        raise FoggyError(f"{path}: not a run record: command, inputs or outputs missing. Run its step again.")
    try:
        for part in ("inputs", "outputs"):
            if not isinstance(record[part], dict) or not all(isinstance(each, str) for each in record[part].values()):
                raise ValueError(f"{part} are not SHA-256 by file")
        if not isinstance(record["command"], list) or not all(isinstance(word, str) for word in record["command"]):
            raise ValueError("the command is no list of words")
        for name in record["outputs"]:
            check_name(name)
    except ValueError as error:
        raise FoggyError(f"{path}: not a run record of this project: {error}. Delete it.") from error
    return record


def read_runs(folder: str | Path = RESULTS) -> dict[Path, dict[str, Any]]:
    """All run records below a folder by their own path, sorted; raises FoggyError as `read_run` does."""
    return {path: read_run(path) for path in sorted(Path(folder).rglob("*run.json"))}


def state(path: str | Path, recorded: str) -> str:
    """Whether a file is as recorded: "unchanged", "changed" or "missing"."""
    if not Path(path).is_file():
        return "missing"
    return "unchanged" if sha256(path) == recorded else "changed"


def instructions() -> dict[str, str]:
    """Machine and instruction set extensions as NumPy finds them, and the environment's limits on them.

    >>> {"extensions", "machine"} <= instructions().keys()
    True
    """
    # By name, because no job computes with NumPy through this: another version of it re-runs nothing for that. No
    # public function returns these features; NPY_DISABLE_CPU_FEATURES is respected.
    features = importlib.import_module("numpy._core._multiarray_umath").__cpu_features__
    found = " ".join(sorted(name for name, there in features.items() if there))
    limits = {name: os.environ[name] for name in VARIABLES if os.environ.get(name)}
    return {"machine": platform.machine(), "extensions": found, **limits}


def gpu() -> dict[str, str]:
    """What decides the bytes that a GPU makes: its model, the driver, and the versions of CUDA and cuDNN."""
    torch = importlib.import_module("torch")
    driver = Path("/sys/module/nvidia/version")  # PyTorch knows the driver's level of CUDA only
    return {
        "model": torch.cuda.get_device_name(),
        "driver": driver.read_text(encoding="ascii").strip() if driver.is_file() else "unknown",
        "cuda": str(torch.version.cuda),
        "cudnn": str(torch.backends.cudnn.version()),
    }


def recorded(params: Params, *keys: str) -> dict[str, Any]:
    """Values of dotted keys, nested as in the params file and spelt as in JSON.

    A dataset's folder becomes "real" and a file of weights "imported": what they hold is recorded by hashes.

    Raises KeyError if a key is not in the params.
    """
    return select(without_folders(params), *keys)


def without_folders(params: Params) -> dict[str, Any]:
    """All values of params as run records state them, nested as in the params file."""
    values = params.model_dump(mode="json", by_alias=True)
    roots, train = values["scenes"]["roots"], values["train"]
    roots.update({name: REAL for name, folder in roots.items() if folder != STAND_IN})
    starts = [start for row in train["rows"].values() if row for start in row["start"].values()]
    for each in (*train.values(), *starts):
        if isinstance(each, dict) and each.get("weights", NO_WEIGHTS) != NO_WEIGHTS:
            each["weights"] = IMPORTED
    return values


def select(values: dict[str, Any], *keys: str) -> dict[str, Any]:
    """The part of nested values that dotted keys name; of a list, the named value of each of its entries.

    >>> select({"fog": {"betas": ["0.005"], "png_level": 0}, "rows": [{"row": "C"}]}, "fog.betas", "rows.row")
    {'fog': {'betas': ['0.005']}, 'rows': {'row': ['C']}}
    """
    chosen: dict[str, Any] = {}
    for key in keys:
        source: Any = values
        target = chosen
        *outer, last = key.split(".")
        for part in outer:
            source, target = source[part], target.setdefault(part, {})
        target[last] = [entry[last] for entry in source] if isinstance(source, list) else source[last]
    return chosen


def leaves(values: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Dotted keys and values of what is no mapping, in the order of the keys.

    >>> dict(leaves({"fog": {"frames": {"first": 2}}}))
    {'fog.frames.first': 2}
    """
    for key, value in values.items():
        if isinstance(value, dict):
            yield from leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value
