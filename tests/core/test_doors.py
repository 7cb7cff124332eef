"""The doors: what each way of installing brings, and that fog and scores need nothing beyond theirs.

`make doors` installs them into empty environments and measures them.
"""

import ast
import platform
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import doors
import numpy as np
import pytest
from fog_frames import CAMERA, camera_json, content, write_frames

from foggy_synscapes import cli
from foggy_synscapes.io.images import encode_depth, encode_png

PROJECT = tomllib.loads((doors.ROOT / "pyproject.toml").read_text())["project"]
HERE = (sys.version_info[:2], platform.system()) == ((3, 11), "Linux")
# Refuses to find what the bare installation does not bring, as if it were not installed; also in processes of its own.
ALONE = """\
import sys
from importlib import metadata

allowed = {"foggy_synscapes", "_distutils_hack", *sys.stdlib_module_names}
brought = set(sys.argv.pop(1).split(","))
for name in brought:
    for path in metadata.files(name):
        allowed.add(path.parts[0].partition(".")[0])



class Nothing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] not in allowed:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


sys.meta_path.insert(0, Nothing())
"""


def alone(code: str, *arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run code where nothing but the bare installation can be imported."""
    call = [sys.executable, "-c", ALONE + code, ",".join(doors.held()[doors.BARE]), *arguments]
    return subprocess.run(call, cwd=cwd, capture_output=True, text=True, check=False)


def foggy(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run a command so."""
    return alone("from foggy_synscapes.cli import main\nsys.exit(main(sys.argv[1:]))\n", *arguments, cwd=cwd)


@pytest.mark.parametrize("door", doors.held())
def test_a_door_brings_the_packages_that_are_held(door: str) -> None:
    """Of other systems and versions of Python, requirements differ."""
    if door != doors.BARE and not HERE:
        pytest.skip("the list is that of Python 3.11 on Linux")
    assert doors.resolved(door) == doors.held()[door], "tests/helpers/doors.json holds the list"


def test_fog_and_scores_are_small() -> None:
    bare = doors.held()[doors.BARE]
    assert len(bare) <= doors.MOST_PACKAGES
    assert {"openexr", "pyspng"} <= {*bare}
    assert not {"pandas", "scipy", "jinja2", "torch", "snakemake", "dvc", "matplotlib"} & {*bare}


def test_doors_lie_in_one_another() -> None:
    extras = {name: {*texts} for name, texts in PROJECT["optional-dependencies"].items()}
    assert extras["train"] <= extras["experiment"]
    assert extras["train"] == extras["gpu"]
    assert extras["train"] < extras["export"]
    assert not extras["experiment"] & {*PROJECT["dependencies"]}


def test_the_page_on_installing_has_the_counts() -> None:
    lines = (doors.ROOT / "docs/install.md").read_text().splitlines()
    for door, packages in doors.held().items():
        call = "`pip install foggy-synscapes`" if door == doors.BARE else f"`pip install 'foggy-synscapes[{door}]'`"
        (line,) = [line for line in lines if line.startswith(f"| {call} |")]
        assert line.split("|")[3].strip() == str(len(packages))


def test_the_lock_file_holds_every_door() -> None:
    """`make` installs from it, whatever a door is called."""
    locked = re.findall(r"^([a-z0-9_.-]+)==", (doors.ROOT / "requirements.lock").read_text(), re.MULTILINE)
    for door in doors.held():
        assert {*doors.held()[door]} - {"setuptools"} <= {*map(doors.canonical, locked)}


def test_fog_needs_nothing_else(tmp_path: Path) -> None:
    write_frames(tmp_path / "synscapes", 2)
    options = ["--synscapes", "synscapes", "--beta", "0.02", "--out", "out", "--transmittance"]
    result = foggy("fog", *options, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "2 frames, 1 betas, 4 images made" in result.stdout


def test_scores_need_nothing_else(tmp_path: Path) -> None:
    ids = np.arange(19, dtype=np.uint8).reshape(1, 19)
    for folder in ("labels", "predictions"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "a.png").write_bytes(encode_png(ids))
    folders = "--predictions", "predictions", "--labels", "labels"
    result = foggy("evaluate", *folders, "--encoding", "trainIds", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "mean IoU 100.00 %" in result.stdout


def test_the_functions_of_the_package_need_nothing_else(tmp_path: Path) -> None:
    image, depth = content(1)
    (tmp_path / "a.png").write_bytes(encode_png(image))
    (tmp_path / "a.exr").write_bytes(encode_depth(depth))
    (tmp_path / "camera.json").write_text(camera_json())
    code = """
import foggy_synscapes as fs
assert fs.fog("a.png", "a.exr", [0.01, 0.02], "camera.json").shape[0] == 2
assert fs.transmittance("a.exr", 0.01, "camera.json").max() < 1
assert fs.airlight("a.png").levels == (251, 255, 249)
assert fs.score([[[0, 1]]], [[[0, 1]]], encoding="trainIds")["images"] == 1
"""
    result = alone(code, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert CAMERA.resx == image.shape[1]


@pytest.mark.parametrize("word", [*cli.PIPELINE, *cli.TOOLS])
def test_a_command_that_needs_more_says_what_to_install(word: str, tmp_path: Path, monkeypatch, capsys) -> None:
    def missing(name: str) -> None:
        raise ModuleNotFoundError("No module named 'pydantic'", name="pydantic")

    monkeypatch.setattr(cli.commands.importlib, "import_module", missing)
    assert cli.main([word, "--help"]) == 1
    assert (
        "needs pydantic, which is not installed. Install it: pip install 'foggy-synscapes[" in capsys.readouterr().err
    )


@pytest.mark.parametrize(("package", "extra"), [("torch", "train"), ("onnx", "export"), ("pandas", "experiment")])
def test_the_extra_that_is_named_brings_the_package(package: str, extra: str) -> None:
    assert f"[{extra}]" in cli._not_installed(ModuleNotFoundError("x", name=f"{package}.sub"))
    assert package in doors.held()[extra]
    for each, packages in cli.EXTRAS.items():
        asked = {doors.canonical(re.split(r"[\s<>=\[]", text)[0]) for text in doors.asked(each)}
        assert {doors.canonical(name) for name in packages} <= asked


def test_the_wheel_says_who_made_it_and_for_what() -> None:
    assert PROJECT["authors"] == [{"name": "Foggy Synscapes contributors"}]
    assert PROJECT["urls"] == {"Paper": "https://arxiv.org/abs/1910.03997"}
    assert {"Typing :: Typed", "Programming Language :: Python :: 3.11"} <= {*PROJECT["classifiers"]}
    assert (doors.ROOT / "src/foggy_synscapes/py.typed").is_file()


def test_imports_take_no_time() -> None:
    """0.3 s is promised; what is counted here does not depend on the machine: nothing but the package is imported."""
    code = "import sys; before = {*sys.modules}; import foggy_synscapes; print(sorted({*sys.modules} - before))"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert [name for name in ast.literal_eval(told) if name.partition(".")[0] not in sys.stdlib_module_names] == [
        "foggy_synscapes"
    ]
    code = "import sys; from foggy_synscapes import Camera, airlight, fog, score, transmittance; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    heavy = {"numba", "OpenEXR", "OpenImageIO", "pyspng", "isal", "tqdm", "pandas", "torch", "pydantic", "matplotlib"}
    assert not heavy & {*loaded}
