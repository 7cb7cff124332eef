"""Files from strangers are data: they are refused or harmless, they run nothing, and nothing outside is touched."""

import io
import json
import re
import struct
import tarfile
from pathlib import Path

import pandas as pd
import pytest
from records import vouch

from foggy_synscapes.cli import main
from foggy_synscapes.datasets.index import COLUMNS, read_index
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.shards import Shard
from foggy_synscapes.io.tables import write_csv
from foggy_synscapes.params import check
from foggy_synscapes.provenance.runs import read_run
from foggy_synscapes.tables import formats
from foggy_synscapes.tables.table import LABELS, Table

ROOT = Path(__file__).resolve().parents[2]
OUTSIDE = ["../../x", "/etc/hostname", "a/../../x", "a\\..\\x", "./x", ""]


@pytest.fixture(autouse=True)
def nothing_else_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "inner/most").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "inner/most")
    yield
    assert [path.name for path in tmp_path.iterdir()] == ["inner"]
    assert [path.name for path in (tmp_path / "inner").iterdir()] == ["most"]
    assert not list(tmp_path.rglob("x"))


def refused(arguments: list[str], capsys: pytest.CaptureFixture, *parts: str) -> None:
    assert main(arguments) in (1, 2)
    message = capsys.readouterr().err
    assert "Traceback" not in message
    for part in parts:
        assert part in message


@pytest.mark.parametrize("beta", ["0.005; touch x", "$(touch x)", "`touch x`", "0.005\ntouch x", "../../x", "0.005' x"])
def test_a_beta_that_is_no_number_is_refused(beta: str, capsys: pytest.CaptureFixture) -> None:
    refused(["fog", "--synscapes", ".", "--beta", beta, "--out", "out"], capsys, "beta")
    refused(["fog", "--beta", beta, "--shard", "0000", "--params", str(ROOT / "params.yaml")], capsys, "beta")
    document = read_yaml(ROOT / "params.yaml")
    document["fog"]["betas"] = [beta]
    write_text("params.yaml", json.dumps(document))
    refused(["params", "--check"], capsys, "fog.betas.0: beta")


@pytest.mark.parametrize("word", ["x; touch x", "../../x", "$(touch x)", "a b", "-x", "x" * 65, "x\n"])
def test_a_row_a_seed_a_shard_or_a_list_that_is_no_plain_word_is_refused(word: str) -> None:
    document = read_yaml(ROOT / "params.yaml")
    rows, train, scenes = document["subset"]["clear"], document["train"], document["scenes"]
    changes = [
        (rows, word, rows["C"]),
        (train, "seeds", [word]),
        (train, "networks", [word]),
        (scenes, "shards", [word]),
        (scenes, "refined_list", word),
        (document["evaluate"], "test_sets", [word]),
    ]
    for section, key, value in changes:
        before = dict(section)
        section[key] = value
        with pytest.raises(FoggyError, match=r"^params\.yaml: "):
            check(document, "params.yaml")
        section.clear()
        section.update(before)
    check(document, "params.yaml")


@pytest.mark.parametrize("text", ["[" * 100_000, "{a: " * 5_000, "a: " + "[[" * 3_000])
def test_yaml_that_is_nested_without_end_is_refused(text: str, capsys: pytest.CaptureFixture) -> None:
    write_text("params.yaml", text)
    refused(["params", "--check"], capsys, "params.yaml: not a readable params file")


def test_yaml_that_would_grow_by_aliases_is_refused(capsys: pytest.CaptureFixture) -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]" for n in range(1, 12)]
    write_text("params.yaml", "\n".join(lines))
    refused(["params", "--check"], capsys, "aliases are not allowed")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: !!python/object/new:os.system [touch x]", "could not determine a constructor"),
        ("a: !!binary eA==\n", "a: eA== is no plain number or word"),
        ("? [a]\n: 1", "a key must be a word"),
        ("a: " + "9" * 5000, "not a readable params file|unknown key"),
        ("#" + " " * 1_000_001, "more than 1,000,000 bytes"),
        ("\x00", "not a readable params file"),
    ],
)
def test_yaml_that_is_more_than_data_is_refused(text: str, message: str, capsys: pytest.CaptureFixture) -> None:
    write_text("params.yaml", text)
    assert main(["params", "--check"]) == 1
    told = capsys.readouterr().err
    assert re.search(message, told)
    assert "Traceback" not in told


def test_a_mapping_of_many_keys_is_read_in_no_time() -> None:
    write_text("params.yaml", "\n".join(f"k{n}: 1" for n in range(20_000)))
    assert len(read_yaml("params.yaml")) == 20_000


@pytest.mark.parametrize("name", OUTSIDE)
def test_an_index_that_names_a_file_outside_of_its_dataset_is_refused(name: str) -> None:
    write_csv("results/scenes/index/foggy_zurich/all.csv", COLUMNS, [(name, 1, "0" * 64)])
    with pytest.raises(FoggyError, match=r"index/foggy_zurich/all\.csv: not a readable index: unsafe member name"):
        read_index(Path("results/scenes/index/foggy_zurich/all.csv"))


@pytest.mark.parametrize("name", OUTSIDE)
def test_a_shard_with_a_member_outside_of_its_folder_is_refused(name: str, capsys: pytest.CaptureFixture) -> None:
    Path("results/fog/beta_0.005").mkdir(parents=True)
    shard = Path("results/fog/beta_0.005/0000.tar")
    with tarfile.open(shard, "w", format=tarfile.USTAR_FORMAT) as tar:
        entry = tarfile.TarInfo(name)
        entry.size = 1
        tar.addfile(entry, io.BytesIO(b"x"))
    with pytest.raises(FoggyError, match="not a readable shard"):
        Shard(shard)
    write_csv(shard.with_suffix(".csv"), ("name", "size", "sha256"), [("a.png", 1, "0" * 64)])
    refused(["unpack", str(shard), "--out", "out"], capsys, "not a readable shard")


@pytest.mark.parametrize("name", OUTSIDE)
def test_a_run_record_that_names_outputs_elsewhere_is_refused(name: str, capsys: pytest.CaptureFixture) -> None:
    record = {"command": ["foggy", "tables"], "params": {}, "inputs": {}, "outputs": {name: "0" * 64}}
    write_text("results/tables/run.json", json.dumps(record))
    with pytest.raises(FoggyError, match="not a run record of this project: unsafe member name"):
        read_run(Path("results/tables/run.json"))
    refused(["verify"], capsys, "results/tables/run.json")


def test_json_that_is_nested_without_end_is_refused(capsys: pytest.CaptureFixture) -> None:
    write_text("results/tables/run.json", "[" * 100_000)
    refused(["verify"], capsys, "results/tables/run.json: not a readable run record")
    write_text("camera.json", "[" * 100_000)
    refused(
        ["fog", "--rgb", ".", "--depth", ".", "--camera", "camera.json", "--beta", "0.01", "--out", "out"], capsys, ""
    )


@pytest.mark.parametrize(
    "data",
    [
        struct.pack("<Q", 2**63) + b"{}",
        struct.pack("<Q", 200_000_000) + b" " * 100,
        struct.pack("<Q", 8) + b'{"a": {}',
        struct.pack("<Q", 2_000) + b"[" * 2_000,
        b"",
    ],
)
def test_a_safetensors_file_whose_header_lies_is_refused_as_a_model(data: bytes, capsys: pytest.CaptureFixture) -> None:
    model = Path("results/train/bisenet/C/seed-0/model.safetensors")
    model.parent.mkdir(parents=True)
    model.write_bytes(data)
    write_csv("results/scenes/index/foggy_zurich/all.csv", COLUMNS, [])
    vouch()
    job = ["--network", "bisenet", "--row", "C", "--seed", "0", "--test-set", "foggy_zurich"]
    refused(["evaluate", *job, "--params", str(ROOT / "params.yaml")], capsys, "model.safetensors")


def test_words_of_a_params_file_are_printed_not_run() -> None:
    words = "\\input{/etc/passwd} <script>alert(1)</script> | a"
    index = pd.MultiIndex.from_tuples([("BiSeNet", words)], names=["network", "row"])
    labels = pd.DataFrame([[words, words, "2"]], index=index, columns=LABELS)
    cells = pd.DataFrame([["1.0"]], index=index, columns=["road"])
    table = Table("t", words, labels, cells, cells == "", [words])
    assert "\\input" not in formats.latex([table], "made")
    assert "<script" not in formats.html([table], words)
    row = next(line for line in formats.markdown([table]).splitlines() if line.startswith("| BiSeNet"))
    assert row.count("|") - row.count("\\|") == 5
    frame = pd.DataFrame([[words]], columns=[words])
    assert "\\input" not in formats.long_latex(frame, words, "t")
    assert [line.count("|") - line.count("\\|") for line in formats.long_markdown(frame).splitlines()] == [2, 2, 2]
