"""foggy fog knows by content what it made each image of: not by times, places or names."""

import os
import shutil
import time
from pathlib import Path

import pytest
from fog_frames import SIZE, tree, write_frame, write_frames

from foggy_synscapes.cli import main
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.images import encode_png, read_rgb

IMAGES = [f"beta_0.02/foggy_img/0000{frame}_beta_0.02.png" for frame in (1, 2, 3)]


@pytest.fixture
def root(tmp_path: Path) -> Path:
    return write_frames(tmp_path / "synscapes", 3)


@pytest.fixture
def out(root: Path, tmp_path: Path) -> Path:
    assert fog(root, tmp_path / "out") == 0
    return tmp_path / "out"


def fog(root: Path, out: Path, *options: str) -> int:
    return main(["fog", "--synscapes", str(root), "--beta", "0.02", "--out", str(out), *options])


def fresh(root: Path, tmp_path: Path) -> dict[str, bytes]:
    """What a clean run makes of the frames as they are now."""
    assert fog(root, tmp_path / "fresh") == 0
    return tree(tmp_path / "fresh")


def test_a_disk_that_is_mounted_elsewhere_changes_nothing(root: Path, out: Path, tmp_path: Path, capsys) -> None:
    before = tree(out)
    shutil.copytree(root, tmp_path / "elsewhere")  # with other times, too
    root.rename(tmp_path / "gone")
    out.rename(tmp_path / "moved")
    capsys.readouterr()
    assert fog(tmp_path / "elsewhere", tmp_path / "moved") == 0
    assert "0 images made, 3 kept" in capsys.readouterr().out
    assert tree(tmp_path / "moved") == before


def test_folders_that_were_swapped_are_noticed(root: Path, out: Path, tmp_path: Path, capsys) -> None:
    """Same names and times, other content."""
    (tmp_path / "other").mkdir()
    for frame in (1, 2, 3):
        write_frame(tmp_path / "other", frame + 10)
        for path, end in (("img/rgb", "png"), ("img/depth", "exr"), ("meta", "json")):
            source = tmp_path / "other" / path / f"{frame + 10}.{end}"
            source.rename(source.with_name(f"{frame}.{end}"))
            old = (root / path / f"{frame}.{end}").stat()
            os.utime(source.with_name(f"{frame}.{end}"), ns=(old.st_atime_ns, old.st_mtime_ns))
    (root / "img").rename(tmp_path / "kept")
    (tmp_path / "other/img").rename(root / "img")
    assert fog(root, out) == 0
    assert "3 images in" in (told := capsys.readouterr().out)
    assert "were not as these inputs make them, and were made again" in told
    assert tree(out) == fresh(root, tmp_path)


@pytest.mark.parametrize("file", ["img/rgb/2.png", "img/depth/2.exr"])
@pytest.mark.parametrize("shift", [-3600, 3600])
def test_a_clock_that_is_wrong_hides_no_change(root: Path, out: Path, tmp_path: Path, file: str, shift: int) -> None:
    """Images from the future, or inputs from the past: times tell nothing."""
    write_frame(tmp_path / "other", 9)
    shutil.copyfile(tmp_path / "other" / file.replace("2.", "9."), root / file)
    now = time.time()
    os.utime(root / file, (1e9, 1e9))
    for image in IMAGES:
        os.utime(out / image, (now + shift, now + shift))
    assert fog(root, out) == 0
    assert tree(out) == fresh(root, tmp_path)


def test_images_that_were_replaced_are_made_again(root: Path, out: Path, capsys) -> None:
    before, later = tree(out), time.time() + 3600
    shutil.copyfile(out / IMAGES[0], out / IMAGES[1])  # another frame's
    (out / IMAGES[2]).write_bytes(encode_png(read_rgb(out / IMAGES[2])[: SIZE[0] // 2]))  # of another size
    for image in IMAGES:
        os.utime(out / image, (later, later))
    capsys.readouterr()
    assert fog(root, out) == 0
    told = capsys.readouterr().out
    assert "2 images in" in told
    assert "2 images made, 1 kept" in told
    assert tree(out) == before


@pytest.mark.parametrize(
    "content", [b"", b"id,red\n", b"\xff\xfe", b"id,red,green,blue,row,column\n1,9,9,9,0,0\n", None]
)
@pytest.mark.parametrize("file", ["airlight.csv", "made.csv"])
def test_a_damaged_table_is_made_again(root: Path, out: Path, file: str, content: bytes | None) -> None:
    before = tree(out)
    (out / file).unlink()
    if content is not None:
        (out / file).write_bytes(content)
    assert fog(root, out) == 0
    assert tree(out) == before


def test_a_line_that_was_cut_off_or_changed_costs_its_image_alone(root: Path, out: Path, capsys) -> None:
    before = tree(out)
    lines = (out / "made.csv").read_bytes().splitlines(keepends=True)
    changed = lines[2].replace(b",251,", b",252,")
    assert changed != lines[2]
    (out / "made.csv").write_bytes(b"".join([*lines[:2], changed, lines[3][:-5]]))
    capsys.readouterr()
    assert fog(root, out) == 0
    assert "2 images made, 1 kept" in capsys.readouterr().out
    assert tree(out) == before


def test_frames_that_were_left_out_stay_so_until_they_change(tmp_path: Path, capsys) -> None:
    root, out = write_frames(tmp_path / "synscapes", 5), tmp_path / "out"
    for _ in range(2):
        assert fog(root, out, "--blue-airlight", "drop") == 0
        assert "blue atmospheric light in 1 frames, left out: 5" in capsys.readouterr().out
    assert not (out / "beta_0.02/foggy_img/00005_beta_0.02.png").exists()
    write_frame(tmp_path / "other", 4)
    shutil.copyfile(tmp_path / "other/img/rgb/4.png", root / "img/rgb/5.png")
    assert fog(root, out, "--blue-airlight", "drop") == 0
    assert (out / "beta_0.02/foggy_img/00005_beta_0.02.png").is_file()


def test_a_beta_more_makes_that_alone(root: Path, out: Path, capsys) -> None:
    assert fog(root, out, "--beta", "0.01") == 0
    assert "3 images made, 3 kept" in capsys.readouterr().out


def test_inputs_are_held_against_checksums(root: Path, tmp_path: Path, capsys) -> None:
    sums = root / "SHA256SUMS"
    paths = sorted(path for path in root.rglob("*") if path.is_file())
    sums.write_text("".join(f"{sha256(path)} *{path.relative_to(root).as_posix()}\n" for path in paths))
    assert fog(root, tmp_path / "one", "--checksums", str(sums)) == 0
    depth = root / "img/depth/2.exr"
    write_frame(tmp_path / "other", 9)
    shutil.copyfile(tmp_path / "other/img/depth/9.exr", depth)
    assert fog(root, tmp_path / "two", "--checksums", str(sums), "--keep-going") == 1
    error = capsys.readouterr().err
    assert f"{depth}: its sha256 is " in error
    assert "1 of 3 frames broken" in error
    write_frame(root, 4)
    assert fog(root, tmp_path / "three", "--checksums", str(sums)) == 1
    assert "img/rgb/4.png: not in " in capsys.readouterr().err
