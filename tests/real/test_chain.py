"""The whole chain on real samples at their native resolution, by both engines, under the policies of the paper.

Networks are tiny and a training is two steps; nothing else differs from a full run: the layouts, names, sizes and bit
depths are the official ones, crops, losses and schedules those of params/refinenet_baseline.yaml.
"""

import json
from pathlib import Path

import pytest
import real_layouts
import warm
from engines import clone, for_dvc, hashes, run

from foggy_synscapes.datasets.index import read_index
from foggy_synscapes.io.images import read_ids, read_rgb
from foggy_synscapes.io.shards import Shard
from foggy_synscapes.io.tables import read_csv

ROWS = ("FC-498", "FS-498", "FC-FS-498")
SHORT = {"length": {"iterations": 2}, "validate": {"iterations": 1}}
NETWORK = {"backbone": "resnet18", "width": 8, "decoder": 8, "weights": "none"}


def overlay(roots: dict[str, str]) -> dict:
    """Params that differ from the paper's in sizes, lengths and roots alone."""
    both = {"beta": "0.005", "train": 1, "validation": 1}
    return {
        "base": "refinenet_baseline.yaml",
        "device": "cpu",
        "scenes": {"roots": roots, "shard_frames": 2, "shards": ["0000"]},
        "fog": {"frames": {"first": 1, "last": 1}},
        "subset": {
            "clear": {"C": {"train": 4, "validation": 1}},
            "partial": {"FC-498": {"beta": "0.01", "train": 4, "validation": 1}},
            "pure": {"FS-498": both},
            "mixed": {"FC-FS-498": {**both, "beta_foggy_cityscapes": "0.005", "ratio": [1, 4]}},
        },
        "train": {
            "threads": 1,
            "workers": 0,
            "from_weights": ["C"],
            "from_baseline": list(ROWS),
            "rows": {"C": None, **dict.fromkeys(ROWS, SHORT)},
            "refinenet": {**NETWORK, "baseline": SHORT},
            "bisenet": {**NETWORK, "baseline": SHORT, "fine_tuning": {"batch": 1}},  # of FS there is one image
        },
        "evaluate": {"threads": 1, "workers": 0},
        "tables": {"rows": [{"row": row, "training": "C", "fine_tuning": row} for row in ("C", *ROWS)]},
        "figures": {"images": 1},
        "tradeoff": {"row": "FC-498"},
    }


@pytest.fixture(scope="module")
def roots(real_data: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    return real_layouts.build(real_data, tmp_path_factory.mktemp("real samples") / "data")


@pytest.fixture(scope="module")
def chains(roots: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A clone in which Snakemake ran the chain, and one in which DVC did."""
    folders = []
    for engine in ("snakemake", "dvc"):
        folder = clone(tmp_path_factory.mktemp("chain") / engine)
        (folder / "params/real.yaml").write_text(json.dumps(overlay(roots)))
        with warm.jobs(tmp_path_factory.mktemp("warm") / "jobs", {}) as changes:
            if engine == "snakemake":
                run(folder, engine, "--cores", "2", "--configfile", "params/real.yaml", changes=changes)
            else:
                run(for_dvc(folder, "params/real.yaml"), engine, "repro", changes=changes)
        folders.append(folder)
    return folders[0], folders[1]


def test_both_engines_make_the_same_bytes(chains: tuple[Path, Path]) -> None:
    ours, theirs = map(hashes, chains)
    assert {f"results/tables/{name}.tex" for name in ("foggy_driving", "foggy_zurich", "cityscapes")} <= ours.keys()
    assert ours == theirs


def test_every_training_and_every_score_is_there(chains: tuple[Path, Path]) -> None:
    found = [
        path.parent.relative_to(chains[0] / "results/train") for path in chains[0].rglob("train/**/model.safetensors")
    ]
    assert len(found) == 2 * (1 + len(ROWS))
    for name in ("foggy_driving", "foggy_zurich"):
        table = read_csv(chains[0] / f"results/tables/{name}.csv")
        assert len(table) >= 2 * (1 + len(ROWS))


def test_indexes_list_the_official_names(chains: tuple[Path, Path], roots: dict[str, str]) -> None:
    listed = {name: read_index(*(chains[0] / "results/scenes/index" / name).glob("*.csv")) for name in roots}
    assert {name: len(index) for name, index in listed.items()} == {
        "synscapes": 2 * 4,
        "cityscapes": 5 * 2,
        "foggy_cityscapes": 5 * 3 + 1,
        "foggy_driving": 4 * 2 + 2,
        "foggy_zurich": 2 * 2 + 2,
    }
    assert "leftImg8bit/test/public/public_20161213_083206_leftImg8bit.png" in listed["foggy_driving"]


def test_images_keep_their_native_size_to_the_prediction(chains: tuple[Path, Path], roots: dict[str, str]) -> None:
    sizes = set()
    for test_set in ("foggy_driving", "foggy_zurich", "cityscapes"):
        with Shard(chains[0] / f"results/evaluate/{test_set}/refinenet/FC-498/seed-0/predictions.tar") as shard:
            for member in shard.names():
                size = read_ids(shard.read(member)).shape
                assert size == read_rgb(Path(roots[test_set]) / member).shape[:2]
                sizes.add(size)
    assert sizes == {*real_layouts.DRIVING_SIZES, (1080, 1920), (1024, 2048)}
    with Shard(chains[0] / "results/fog/beta_0.005/0000.tar") as shard:
        assert read_rgb(shard.read("00001_beta_0.005.png")).shape == (720, 1440, 3)


def test_the_samples_are_only_read(chains: tuple[Path, Path], roots: dict[str, str], real_data: Path) -> None:
    for path in (real_data / "synscapes/img").rglob("*.*"):
        copy = Path(roots["synscapes"]) / path.relative_to(real_data / "synscapes")
        assert copy.read_bytes() == path.read_bytes()
    assert "scenes" in run(
        chains[0], "foggy_synscapes", "trace", "results/tables/foggy_zurich.tex", "--params", "params/real.yaml"
    )
    assert "are what their run records say" in run(
        chains[0], "foggy_synscapes", "verify", "--params", "params/real.yaml"
    )
