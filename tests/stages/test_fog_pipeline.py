"""Fog as jobs of the pipeline: tables, shards, manifests, run records, blue skies, resumption; and unpack."""

import json
import tarfile
from pathlib import Path

import numpy as np
import pytest
from fog_frames import CAMERA, content, tree, write_frame, write_frames
from records import index_of, vouch

from foggy_synscapes.cli import main
from foggy_synscapes.datasets import synscapes
from foggy_synscapes.datasets.index import write_index
from foggy_synscapes.datasets.uris import Reader
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.fog.geometry import rays
from foggy_synscapes.fog.optics import foggy_images
from foggy_synscapes.frames import recipes
from foggy_synscapes.frames.compositing import composite
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.images import read_rgb
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.shards import Shard, read_manifest
from foggy_synscapes.io.tables import read_csv, write_csv
from foggy_synscapes.params import Params, check
from foggy_synscapes.stages import fog as stage

ROOT = Path(__file__).resolve().parents[2]
SHARD, MANIFEST = Path("results/fog/beta_0.005/0000.tar"), Path("results/fog/beta_0.005/0000.csv")


def index(root: Path, frames: range, shard: str) -> None:
    write_index(
        index_of("synscapes", shard),
        root,
        [path(n) for n in frames for path in (synscapes.rgb, synscapes.depth)],
    )
    vouch()


@pytest.fixture
def params(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Params:
    """Eight frames; 3 is filtered out, 5 has a blue sky; of those kept the first 4 and the last 2 are asked for."""
    monkeypatch.chdir(tmp_path)
    write_frames(Path("synscapes"), 8)
    index(Path("synscapes"), range(1, 7), "0000")
    index(Path("synscapes"), range(7, 9), "0001")
    index(Path("synscapes"), range(0), "0002")
    camera = tuple(vars(CAMERA).values())
    write_csv("results/filter/kept.csv", ("id", *vars(CAMERA)), [(n, *camera) for n in (1, 2, 4, 5, 6, 7, 8)])
    vouch()
    return change()


def change(**fog: object) -> Params:
    document = read_yaml(ROOT / "params.yaml")
    document["scenes"]["roots"]["synscapes"] = "synscapes"
    document["scenes"] |= {"shards": ["0000", "0001", "0002"], "shard_frames": 6}
    document["fog"] |= {"frames": {"first": 4, "last": 2}, **fog}
    frames = document["fog"]["frames"]
    for rows in document["subset"].values():
        for row in rows.values():
            row |= {"train": frames["first"], "validation": frames["last"]}
    document["tables"]["rows"] = document["tables"]["rows"][:1]  # C, which names no number of images
    return check(document, "params.yaml")


def make(params: Params, shard: str = "0000") -> None:
    stage.airlight(params, shard)
    stage.fog(params, "0.005", shard)


def names(shard: Path = SHARD) -> list[str]:
    with Shard(shard) as members:
        return members.names()


def test_a_shard_holds_the_frames_that_are_asked_for(params: Params) -> None:
    make(params)
    make(params, "0001")
    assert names() == [f"0000{n}_beta_0.005.png" for n in (1, 2, 4, 5)]
    assert names(SHARD.with_name("0001.tar")) == [f"0000{n}_beta_0.005.png" for n in (7, 8)]
    assert [row["id"] for row in read_csv("results/fog/airlight/0000.csv")] == ["1", "2", "4", "5"]
    with Shard(SHARD) as shard:
        for frame in (1, 5):
            image, depth = content(frame)
            expected = foggy_images(image, depth, rays(CAMERA), estimate(image).levels, [0.005])[0]
            np.testing.assert_array_equal(read_rgb(shard.read(f"0000{frame}_beta_0.005.png")), expected)


def test_manifest_and_run_record_say_what_was_made_from_what(params: Params) -> None:
    make(params)
    with Shard(SHARD) as shard:
        for member in read_manifest(MANIFEST):
            assert len(shard.read(member.name)) == member.size
    record = json.loads(SHARD.with_suffix(".run.json").read_text())
    assert record["command"] == ["foggy", "fog", "--beta", "0.005", "--shard", "0000"]
    assert record["outputs"] == {path.as_posix(): sha256(path) for path in (MANIFEST, SHARD)}
    assert sorted(record["inputs"]) == [
        "results/filter/kept.csv", "results/fog/airlight/0000.csv", "results/scenes/index/synscapes/0000.csv"
    ]  # fmt: skip
    assert "fog.kernel" in record["code"]
    assert str(Path.cwd()) not in SHARD.with_suffix(".run.json").read_text()


def test_a_shard_without_frames_is_an_empty_shard(params: Params) -> None:
    make(params, "0002")
    assert names(SHARD.with_name("0002.tar")) == []
    assert read_manifest(MANIFEST.with_name("0002.csv")) == []
    with tarfile.open(SHARD.with_name("0002.tar")) as tar:
        assert tar.getnames() == []


@pytest.mark.parametrize("answer", ["keep", "drop", "grey"])
def test_blue_skies_are_in_the_table_and_answered_as_asked(params: Params, answer: str, capsys) -> None:
    make(change(blue_airlight=answer))
    row = read_csv("results/fog/airlight/0000.csv")[3]
    assert (row["id"], row["blue_sky"], row["treatment"]) == ("5", "1", answer)
    assert all(
        (row["blue_sky"], row["treatment"]) == ("0", "") for row in read_csv("results/fog/airlight/0000.csv")[:3]
    )
    said = capsys.readouterr().out
    assert f"4 frames of shard 0000; 1 blue, fog.blue_airlight {answer}" in said
    if answer == "drop":
        assert names() == [f"0000{n}_beta_0.005.png" for n in (1, 2, 4)]
        assert "1 left out for their blue airlight" in said
        return
    with Shard(SHARD) as shard:
        sky = read_rgb(shard.read("00005_beta_0.005.png"))[0, 0].tolist()
    assert sky == {"keep": [150, 190, 240], "grey": [184, 184, 184]}[answer]


def test_an_interrupted_shard_goes_on_and_ends_with_the_same_bytes(params: Params, monkeypatch) -> None:
    make(params)
    whole = tree(Path("results/fog"))
    SHARD.unlink()
    rendered: list[str] = []
    real = stage.rendering.foggy_pngs

    def interrupted(model, clear, *rest):
        if len(rendered) == 2:
            raise KeyboardInterrupt
        rendered.append(clear.rgb_name)
        return real(model, clear, *rest)

    monkeypatch.setattr(stage.rendering, "foggy_pngs", interrupted)
    with pytest.raises(KeyboardInterrupt):
        stage.fog(params, "0.005", "0000")
    assert not SHARD.exists()
    # The second finished image is damaged since: it is made again, the first is kept.
    (SHARD.parent / ".0000" / "00002_beta_0.005.png").write_bytes(b"half")
    monkeypatch.setattr(
        stage.rendering, "foggy_pngs", lambda *given: (rendered.append(given[1].rgb_name), real(*given))[1]
    )
    stage.fog(params, "0.005", "0000")
    assert rendered == [f"synscapes/img/rgb/{n}.png" for n in (1, 2, 2, 4, 5)]
    assert tree(Path("results/fog")) == whole


def test_what_other_params_left_behind_is_not_taken_over(params: Params, monkeypatch) -> None:
    stage.airlight(params, "0000")
    with monkeypatch.context() as patch:
        patch.setattr(stage, "write_shard", lambda path, members: next(members) and 1 / 0)
        with pytest.raises(ZeroDivisionError):
            stage.fog(params, "0.005", "0000")
    assert (SHARD.parent / ".0000" / "00001_beta_0.005.png").is_file()
    stage.fog(change(geometry="exact"), "0.005", "0000")
    image, depth = content(1)
    with Shard(SHARD) as shard:
        ours = read_rgb(shard.read("00001_beta_0.005.png"))
    np.testing.assert_array_equal(
        ours, foggy_images(image, depth, rays(CAMERA, "exact"), estimate(image).levels, [0.005])[0]
    )


def test_data_that_changed_since_it_was_indexed_is_refused(params: Params) -> None:
    write_frame(Path("synscapes"), 2)
    Path("synscapes/img/depth/2.exr").write_bytes(b"new")
    stage.airlight(params, "0000")
    with pytest.raises(FoggyError, match=r"img/depth/2\.exr: its content changed since it was listed"):
        stage.fog(params, "0.005", "0000")
    assert not SHARD.exists()


def test_a_frame_outside_the_index_or_the_table_is_named(params: Params) -> None:
    with pytest.raises(FoggyError, match=r"airlight/0000\.csv: missing"):
        stage.fog(params, "0.005", "0000")
    stage.airlight(params, "0000")
    index(Path("synscapes"), range(1, 2), "0000")
    with pytest.raises(FoggyError, match=r"img/rgb/2\.png is not in its index"):
        stage.fog(params, "0.005", "0000")
    index(Path("synscapes"), range(1, 7), "0000")
    table = read_csv("results/fog/airlight/0000.csv")
    write_csv("results/fog/airlight/0000.csv", tuple(table[0]), [tuple(row.values()) for row in table[:2]])
    vouch()
    with pytest.raises(FoggyError, match="no frame 4"):
        stage.fog(params, "0.005", "0000")


def test_more_frames_than_were_kept_are_refused(params: Params) -> None:
    with pytest.raises(FoggyError, match="asks for the first 6 and the last 2 kept frames, but the filter kept 7"):
        stage.airlight(change(frames={"first": 6, "last": 2}), "0000")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--shard", "0000"], "either --airlight or one --beta"),
        (["--airlight"], "a job of the pipeline has --shard"),
        (["--shard", "0000", "--airlight", "--beta", "0.005"], "either --airlight or one --beta"),
        (["--shard", "0009", "--airlight"], "--shard 0009: not in scenes.shards"),
        (["--shard", "0000", "--beta", "0.5"], "--beta 0.5 --shard 0000: not in fog.betas"),
        (["--shard", "0000", "--beta", "0.005", "--out", "x"], "--out is not for jobs of the pipeline"),
    ],
)
def test_a_wrong_job_ends_with_status_2(options: list[str], message: str, capsys) -> None:
    assert main(["fog", "--params", str(ROOT / "params.yaml"), *options]) == 2
    assert message in capsys.readouterr().err


def test_unpack_makes_the_folders_that_fog_alone_would(params: Params, capsys) -> None:
    make(params)
    assert main(["unpack", str(SHARD), "--out", "unpacked"]) == 0
    assert "4 images in unpacked" in capsys.readouterr().out
    Path("camera.json").write_text(json.dumps({"camera": {"intrinsic": vars(CAMERA)}}))
    options = ["--camera", "camera.json", "--ids", "1,2,4,5", "--beta", "0.005", "--out", "alone"]
    assert main(["fog", "--synscapes", "synscapes", *options]) == 0
    alone = {name: data for name, data in tree(Path("alone")).items() if name.endswith(".png")}
    assert tree(Path("unpacked")) == alone


def test_unpack_refuses_a_shard_that_is_not_as_its_manifest_says(params: Params, capsys) -> None:
    make(params)
    data = bytearray(SHARD.read_bytes())
    data[700] ^= 1
    SHARD.write_bytes(data)
    assert main(["unpack", str(SHARD), "--out", "unpacked"]) == 1
    assert "0000.tar#00001_beta_0.005.png: its content changed" in capsys.readouterr().err
    lines = MANIFEST.read_text().splitlines()
    MANIFEST.write_text("\n".join(lines[:-1]) + "\n")
    assert main(["unpack", str(SHARD), "--out", "unpacked"]) == 1
    assert "its members are not those of 0000.csv" in capsys.readouterr().err


def reader() -> Reader:
    return Reader({"synscapes": Path("synscapes")})


def test_a_recipe_gives_the_pixels_of_the_rendered_image(params: Params) -> None:
    make(params)
    with Shard(SHARD) as shard:
        rendered = {name: read_rgb(shard.read(name)) for name in shard.names()}
    make(change(render="on_the_fly"))
    assert names() == [name.replace(".png", ".json") for name in rendered]
    with Shard(SHARD) as shard:
        for name, image in rendered.items():
            made = composite(shard.read(name.replace(".png", ".json")), reader().read, name)
            np.testing.assert_array_equal(made, image)
    assert SHARD.stat().st_size < 20_000


def test_a_recipe_is_kept_after_an_interruption(params: Params, monkeypatch: pytest.MonkeyPatch) -> None:
    params = change(render="on_the_fly")
    make(params)
    whole = sha256(SHARD)
    SHARD.unlink()
    written = []

    def stop(*arguments: object) -> bytes:
        if len(written) == 2:
            raise KeyboardInterrupt
        written.append(arguments)
        return write(*arguments)

    write = recipes.write
    with monkeypatch.context() as patch:
        patch.setattr(recipes, "write", stop)
        with pytest.raises(KeyboardInterrupt):
            stage.fog(params, "0.005", "0000")
    stage.fog(params, "0.005", "0000")
    assert sha256(SHARD) == whole


def recipe_with(**changed: object) -> bytes:
    with Shard(SHARD) as shard:
        return json.dumps(json.loads(shard.read("00001_beta_0.005.json")) | changed).encode()


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"pixels": "0" * 64}, "other pixels come out than when the recipe was written"),
        ({"beta": "0.01"}, "other pixels come out"),
        ({"haze": 1}, "not a readable recipe of a foggy image: expected airlight, beta"),
        ({"inputs": [["synscapes:../../etc/passwd", "0"], ["synscapes:img/depth/1.exr", "0"]]}, "not the name of an"),
        ({"inputs": [["synscapes:img/rgb/1.png", "0"], ["synscapes:img/depth/1.exr", "0"]]}, "changed since it was"),
    ],
)
def test_a_recipe_that_was_altered_is_refused(params: Params, changed: dict, said: str) -> None:
    make(change(render="on_the_fly"))
    with pytest.raises(FoggyError, match=said):
        composite(recipe_with(**changed), reader().read, "fog:0000.tar#00001_beta_0.005.json")


def test_what_is_no_json_is_no_recipe(params: Params) -> None:
    with pytest.raises(FoggyError, match="fog:a: not a readable recipe of a foggy image"):
        composite(b"\x89PNG", reader().read, "fog:a")


def test_recipes_are_not_unpacked_as_images(params: Params, capsys) -> None:
    make(change(render="on_the_fly"))
    assert main(["unpack", str(SHARD), "--out", "plain"]) == 1
    assert "holds recipes, not images" in capsys.readouterr().err
    assert not Path("plain").exists()
