"""Which environment variables change bytes, and whether the run record says so: `make variables`.

    python tests/long/variables.py [--only TEXT]

Trains a tiny network and makes fog of a frame under one variable after the other, and compares what comes out with what
comes without any. Bytes have to be equal, or the record has to name the variable; a refusal is as good.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))

import pytest
from engines import environment
from fog_frames import write_frames
from training_project import project_in

from foggy_synscapes.io.hashing import sha256

SWEPT = {
    "ATEN_CPU_CAPABILITY": ("default", "avx2"),
    "DNNL_DEFAULT_FPMATH_MODE": ("BF16",),
    "DNNL_MAX_CPU_ISA": ("SSE41",),
    "GOTO_NUM_THREADS": ("2",),
    "HDF5_USE_FILE_LOCKING": ("FALSE",),
    "KMP_AFFINITY": ("disabled",),
    "KMP_BLOCKTIME": ("0",),
    "KMP_DETERMINISTIC_REDUCTION": ("1",),
    "LANG": ("tr_TR.UTF-8",),
    "LC_ALL": ("POSIX",),
    "MALLOC_ARENA_MAX": ("1",),
    "MKL_CBWR": ("COMPATIBLE",),
    "MKL_ENABLE_INSTRUCTIONS": ("SSE4_2",),
    "MKL_NUM_THREADS": ("2",),
    "NPY_DISABLE_CPU_FEATURES": ("AVX2 FMA3",),
    "NPY_PROMOTION_STATE": ("legacy",),
    "NUMBA_CPU_FEATURES": ("",),
    "NUMBA_CPU_NAME": ("generic",),
    "NUMBA_DISABLE_JIT": ("1",),
    "NUMBA_NUM_THREADS": ("2",),
    "NUMBA_OPT": ("0",),
    "OMP_NUM_THREADS": ("1", "2"),
    "OMP_SCHEDULE": ("dynamic,1",),
    "OMP_WAIT_POLICY": ("PASSIVE",),
    "ONEDNN_DEFAULT_FPMATH_MODE": ("BF16",),
    "ONEDNN_MAX_CPU_ISA": ("SSE41",),
    "ONEDNN_PRIMITIVE_CACHE_CAPACITY": ("0",),
    "OPENBLAS_CORETYPE": ("Nehalem",),
    "OPENBLAS_NUM_THREADS": ("2",),
    "PYTHONHASHSEED": ("0", "4711"),
    "PYTHONOPTIMIZE": ("2",),
    "PYTHONUTF8": ("0",),
    "TORCH_CUDNN_V8_API_DISABLED": ("1",),
    "TORCHINDUCTOR_FREEZING": ("1",),
    "TZ": ("Pacific/Chatham",),
}
TRAIN = ("train", "--network", "bisenet", "--row", "C", "--seed", "0")
FOG = ("fog", "--synscapes", "frames", "--beta", "0.02", "--out", "foggy")
MODEL = Path("results/train/bisenet/C/seed-0/model.safetensors")


def prepared(folder: Path) -> None:
    """Write a tiny project and a frame into a folder."""
    with pytest.MonkeyPatch.context() as patch:
        project_in(folder, patch)
    write_frames(folder / "frames", 1)


def made(folder: Path, changes: dict[str, str]) -> tuple[dict[str, str], dict[str, str], str]:
    """SHA-256 of what comes out, what the training's record says of the machine, and why if a command refused."""
    shutil.rmtree(folder / "foggy", ignore_errors=True)
    shutil.rmtree((folder / MODEL).parent, ignore_errors=True)
    for arguments in (TRAIN, FOG):
        call = [sys.executable, "-m", "foggy_synscapes", *arguments]
        result = subprocess.run(call, cwd=folder, env=environment(changes), capture_output=True, text=True, check=False)
        if result.returncode:
            return {}, {}, result.stderr.strip().splitlines()[-1]
    files = [folder / MODEL, *sorted((folder / "foggy").rglob("*.png"))]
    record = json.loads((folder / MODEL).with_name("run.json").read_text(encoding="utf-8"))
    return {str(path.relative_to(folder)): sha256(path) for path in files}, record["instructions"], ""


def main() -> int:
    """Print a line for each variable; 1 where one changes bytes and no record says so."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", metavar="TEXT", help="only variables whose name holds this text")
    only = parser.parse_args().only
    for name in SWEPT:
        os.environ.pop(name, None)
    failed = 0
    print("| variable | value | model | fog | in the record |\n|" + " --- |" * 5, flush=True)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        prepared(folder)
        first, machine, refusal = made(folder, {})
        if refusal:
            raise SystemExit(refusal)
        for name, value in ((name, value) for name, values in SWEPT.items() if only in name for value in values):
            found, record, refusal = made(folder, {name: value})
            if refusal:
                print(f"| {name} | {value} | refused: {refusal} | | |", flush=True)
                continue
            equal = {path: found.get(path) == digest for path, digest in first.items()}
            fog = all(same for path, same in equal.items() if path != str(MODEL))
            told, known = ["other", "equal"], record != machine
            print(
                f"| {name} | {value} | {told[equal[str(MODEL)]]} | {told[fog]} | {'yes' if known else 'no'} |",
                flush=True,
            )
            # Fog has no record of the machine: it has to be the same everywhere.
            failed += not fog or (not equal[str(MODEL)] and not known)
    print(f"{failed} variables change bytes of which no record says why")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
