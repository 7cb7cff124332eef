"""What is not what it seems is refused, and said with the file and the key."""

import io
import json
import os
import signal
import struct
import subprocess
import sys
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from fog_frames import camera_json
from PIL import Image

from foggy_synscapes.datasets import index
from foggy_synscapes.datasets.predictions import find_pairs
from foggy_synscapes.datasets.synscapes import read_camera
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.checksums import Checksums
from foggy_synscapes.io.files import number, read_bytes, read_json
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.images import encode_png, read_depth, read_rgb
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.processes import in_processes

RNG = np.random.default_rng(5)
RGB = RNG.integers(0, 256, (40, 64, 3), dtype=np.uint8)
DEPTH = (RNG.random((40, 64)) * 100).astype(np.float32)


def exr(**header: object) -> bytes:
    buffer = io.BytesIO()
    OpenEXR.File({"type": OpenEXR.scanlineimage, **header}, {"Z": DEPTH}).write(buffer)
    return buffer.getvalue()


def jpeg(image: Image.Image, **options: object) -> bytes:
    buffer = io.BytesIO()
    image.save(buffer, "jpeg", quality=90, **options)
    return buffer.getvalue()


def test_the_checksum_of_a_png_stream_counts_though_its_chunks_are_whole() -> None:
    data = encode_png(RGB)
    (size,) = struct.unpack_from(">I", data, 33)
    stream = data[41 : 41 + size]
    changed = stream[:-1] + bytes([stream[-1] ^ 1])
    chunk = b"IDAT" + changed
    whole = data[:33] + struct.pack(">I", size) + chunk + struct.pack(">I", zlib.crc32(chunk)) + data[45 + size :]
    with pytest.raises(FoggyError, match=r"^a\.png: cannot be decoded: .*checksum"):
        read_rgb(whole, "a.png")


def test_interlaced_images_are_read(tmp_path: Path) -> None:
    """Written by hand: the seven passes of Adam7, without a filter."""
    starts = (0, 0, 8, 8), (0, 4, 8, 8), (4, 0, 8, 4), (0, 2, 4, 4), (2, 0, 4, 2), (0, 1, 2, 2), (1, 0, 2, 1)
    rows = b"".join(b"\0" + row.tobytes() for top, left, down, right in starts for row in RGB[top::down, left::right])

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 64, 40, 8, 2, 0, 0, 1))
    data = b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    np.testing.assert_array_equal(read_rgb(data), RGB)


@pytest.mark.parametrize("progressive", [False, True])
def test_half_a_jpeg_is_refused_though_it_has_an_end(tmp_path: Path, progressive: bool) -> None:
    path, whole = tmp_path / "a.jpg", jpeg(Image.fromarray(RGB), progressive=progressive)
    path.write_bytes(whole)
    assert read_rgb(path).shape == RGB.shape
    path.write_bytes(whole[: len(whole) // 2] + b"\xff\xd9")
    with pytest.raises(FoggyError, match=r"a\.jpg: cannot be decoded: .*premature end"):
        read_rgb(path)


def test_a_jpeg_in_the_colours_of_printing_inks_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.jpg"
    path.write_bytes(jpeg(Image.fromarray(RGB).convert("CMYK")))
    with pytest.raises(FoggyError, match=r"a\.jpg: CMYK of uint8, expected 3 channels"):
        read_rgb(path)


@pytest.mark.parametrize("name", ["NO", "RLE", "ZIPS", "ZIP", "PIZ"])
def test_depth_without_loss_is_read_as_it_was_written(name: str) -> None:
    np.testing.assert_array_equal(read_depth(exr(compression=getattr(OpenEXR, f"{name}_COMPRESSION")), "a.exr"), DEPTH)


@pytest.mark.parametrize("name", ["PXR24", "B44", "DWAA", "DWAB"])
def test_depth_with_loss_is_refused_by_the_name_of_its_compression(name: str) -> None:
    with pytest.raises(FoggyError, match=rf"^a\.exr: compressed by {name}, which rounds depth"):
        read_depth(exr(compression=getattr(OpenEXR, f"{name}_COMPRESSION")), "a.exr")


def test_depth_in_several_parts_is_refused() -> None:
    parts, buffer = [OpenEXR.Part({"type": OpenEXR.scanlineimage}, {"Z": DEPTH}, name) for name in "ab"], io.BytesIO()
    OpenEXR.File(parts).write(buffer)
    with pytest.raises(FoggyError, match=r"^a\.exr: 2 parts"):
        read_depth(buffer.getvalue(), "a.exr")


@pytest.mark.parametrize(
    "value", ["1:30", "1_0", "010", "0x10", "on", "No", "2001-01-01", ".inf", ".NaN", "[1, 1:30]", "!!int '3'"]
)
def test_yaml_that_reads_in_two_ways_is_refused_with_its_key(tmp_path: Path, value: str) -> None:
    (tmp_path / "a.yaml").write_text(f"section:\n  a_key: {value}\n")
    with pytest.raises(FoggyError, match=r"a\.yaml: not a readable params file: a_key: .* is no plain number or word"):
        read_yaml(tmp_path / "a.yaml")


def test_plain_yaml_is_read(tmp_path: Path) -> None:
    text = "a: 1\nb: -0.5\nc: 5.0e-5\nd: true\ne: null\nf: '1:30'\ng: [1, two]\nh: ~\ni:\n'010': x\n"
    (tmp_path / "a.yaml").write_text(text)
    found = {"a": 1, "b": -0.5, "c": 5e-5, "d": True, "e": None, "f": "1:30", "g": [1, "two"], "h": None, "i": None}
    assert read_yaml(tmp_path / "a.yaml") == {**found, "010": "x"}


@pytest.mark.parametrize("value", ["true", '"44.0"', "null", "NaN", "Infinity", "[44.0]", "1e400"])
def test_a_camera_has_numbers_and_nothing_that_could_be_taken_for_one(tmp_path: Path, value: str) -> None:
    path = tmp_path / "camera.json"
    path.write_text(camera_json().replace("44.0", value))
    with pytest.raises(FoggyError, match=r"camera\.json: camera\.intrinsic\.fx: .*expected a finite number"):
        read_camera(path)


def test_a_key_that_stands_twice_is_named(tmp_path: Path) -> None:
    path = tmp_path / "camera.json"
    path.write_text(camera_json().replace('"fx": 44.0', '"fx": 44.0, "fx": 45.0'))
    with pytest.raises(FoggyError, match=r"camera\.json: .*key 'fx' stands twice"):
        read_camera(path)


def test_numbers_are_numbers() -> None:
    assert number(3) == 3.0
    for value in (True, "3", None, float("nan"), float("inf"), [3]):
        with pytest.raises(ValueError, match="expected a finite number"):
            number(value)


def test_what_has_no_end_or_is_too_long_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "long").write_bytes(bytes(100))
    assert len(read_bytes(tmp_path / "long", limit=100)) == 100
    with pytest.raises(FoggyError, match=r"long: more than 99 bytes"):
        read_bytes(tmp_path / "long", limit=99)
    with pytest.raises(FoggyError, match=r"/proc/self/status: its size changes while it is read"):
        read_bytes("/proc/self/status")
    os.mkfifo(tmp_path / "fifo")
    for read in (read_bytes, read_json, sha256, read_rgb, Checksums):
        with pytest.raises(FoggyError, match=r"fifo: is a FIFO, expected a plain file"):
            read(tmp_path / "fifo")


def test_links_that_lead_back_are_no_endless_folder(tmp_path: Path) -> None:
    (tmp_path / "labels").mkdir()
    (tmp_path / "labels/a.png").write_bytes(encode_png(RGB[..., 0]))
    (tmp_path / "labels/back").symlink_to(tmp_path / "labels")
    with pytest.raises(FoggyError, match=r"labels/back: is the same folder as .*labels"):
        find_pairs(tmp_path / "labels", tmp_path / "labels")


def _end(task: int) -> int:
    if task == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return task


def test_a_process_that_dies_is_one_message_with_its_task() -> None:
    with pytest.raises(FoggyError, match=r"a process was killed, perhaps for lack of memory, at task 3"):
        list(in_processes(_end, range(4), 2, lambda task: f"task {task}"))
    assert list(in_processes(_end, [5, 1, 2], 2)) == [5, 1, 2]


@pytest.mark.parametrize(("name", "value"), [("NUMBA_DISABLE_JIT", "1"), ("MPLBACKEND", "of_another_machine")])
def test_variables_for_debuggers_and_notebooks_change_nothing(tmp_path: Path, name: str, value: str) -> None:
    make: dict[str, Callable[[], bytes]] = {"rgb/a.png": lambda: encode_png(RGB), "depth/a.exr": exr}
    for file, content in make.items():
        (tmp_path / file).parent.mkdir()
        (tmp_path / file).write_bytes(content())
    document = json.loads(camera_json())
    document["camera"]["intrinsic"] |= {"resx": 64, "resy": 40}
    (tmp_path / "camera.json").write_text(json.dumps(document))
    call = "import sys; from foggy_synscapes.cli import main; import foggy_synscapes; status = main(sys.argv[1:])\n"
    call += (
        "import matplotlib; from matplotlib.figure import Figure; Figure().savefig('a.png'); raise SystemExit(status)"
    )
    files = ["--rgb", "rgb", "--depth", "depth", "--camera", "camera.json", "--beta", "0.02", "--out", "out"]
    done = subprocess.run(
        [sys.executable, "-c", call, "fog", *files], cwd=tmp_path, env={**os.environ, name: value}, capture_output=True
    )
    assert done.returncode == 0, done.stderr.decode()


def listed(folder: Path, *names: str) -> Path:
    (folder / "SHA256SUMS").write_text("".join(f"{sha256(folder / name)}  {name}\n" for name in names))
    return folder / "SHA256SUMS"


def test_an_index_is_held_against_checksums(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    root = tmp_path / "data"
    root.mkdir()
    (root / "a.txt").write_text("a")
    (root / "b.txt").write_text("b")
    sums = listed(root, "a.txt")
    index.write_index(Path("index/x/all.csv"), root, ["a.txt"], Checksums(sums))
    with pytest.raises(FoggyError, match=r"b\.txt: not in .*SHA256SUMS"):
        index.write_index(Path("index/x/all.csv"), root, ["a.txt", "b.txt"], Checksums(sums))
    (root / "a.txt").write_text("c")
    with pytest.raises(FoggyError, match=r"a\.txt: its sha256 is .* but .*SHA256SUMS has"):
        index.write_index(Path("index/x/all.csv"), root, ["a.txt"], Checksums(sums))


def test_names_with_line_ends_are_listed_as_sha256sum_does_it(tmp_path: Path) -> None:
    odd = tmp_path / "a\nb\\c"
    odd.write_text("x")
    told = subprocess.run(["sha256sum", odd.name], cwd=tmp_path, capture_output=True, check=True).stdout
    (tmp_path / "SHA256SUMS").write_bytes(told)
    assert Checksums(tmp_path / "SHA256SUMS").of(odd) == sha256(odd)
    (tmp_path / "SHA256SUMS").write_text("no checksum\n")
    with pytest.raises(FoggyError, match=r"SHA256SUMS, line 1: 'no checksum' is not as sha256sum writes it"):
        Checksums(tmp_path / "SHA256SUMS")
