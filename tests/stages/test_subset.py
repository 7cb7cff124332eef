"""subset: the right frames in the right order, counts asserted, nothing asked for that is not there."""

from pathlib import Path

import pytest
from records import index_of, vouch

from foggy_synscapes.datasets import cityscapes, foggy_cityscapes, synscapes
from foggy_synscapes.datasets.index import write_index
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.hashing import sha256_bytes
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.shards import write_manifest, write_shard
from foggy_synscapes.io.tables import read_csv, write_csv
from foggy_synscapes.params import check
from foggy_synscapes.stages.subset import run, subset
from foggy_synscapes.subsets.mixed import interleave

ROOT = Path(__file__).resolve().parents[2]
REFINED = {
    "train": ["train/aachen/aachen_000002_000019", "train/aachen/aachen_000000_000019"],
    "val": ["val/ulm/ulm_000000_000019"],
}


def counts(document: dict, **lists: dict) -> dict:
    for rows in document["subset"].values():
        for name, entry in rows.items():
            entry |= lists.get(name.replace("-", "_"), {"train": 2, "validation": 1})
    document["fog"]["frames"] = {"first": 4, "last": 2}
    return document


@pytest.fixture
def document(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict:
    """Three Cityscapes frames and one for validation, of which three are refined; eight foggy frames in two shards."""
    monkeypatch.chdir(tmp_path)
    document = read_yaml(ROOT / "params.yaml")
    for dataset in document["scenes"]["roots"]:
        document["scenes"]["roots"][dataset] = str(tmp_path / dataset)
    document["scenes"] |= {"shards": ["0000", "0001"], "shard_frames": 5}
    frames = [f"train/aachen/aachen_00000{number}_000019" for number in range(3)] + ["val/ulm/ulm_000000_000019"]
    listed("cityscapes", [path for frame in frames for path in (cityscapes.image(frame), cityscapes.labels(frame))])
    refined = "".join(f"{frame}\n" for split in REFINED.values() for frame in split)
    write_text(tmp_path / "foggy_cityscapes" / document["scenes"]["refined_list"], refined)
    images = [foggy_cityscapes.image(frame, beta) for frame in frames for beta in ("0.005", "0.01")]
    listed("foggy_cityscapes", images, [document["scenes"]["refined_list"]])
    ids = [1, 2, 4, 5, 6, 7, 9, 10]
    write_csv("results/filter/kept.csv", ("id",), [(frame,) for frame in ids])
    for shard in (0, 1):
        own = [frame for frame in ids if (frame - 1) // 5 == shard]
        members = [(synscapes.foggy_name(frame, "0.005"), str(frame).encode()) for frame in own]
        manifest = write_shard(f"results/fog/beta_0.005/000{shard}.tar", members)
        write_manifest(f"results/fog/beta_0.005/000{shard}.csv", manifest)
        listed("synscapes", [synscapes.class_(frame) for frame in own], part=f"000{shard}")
    vouch()
    return counts(document, FS_24500={"train": 4, "validation": 2}, FC_FS_498={"train": 3, "validation": 2})


def listed(dataset: str, paths: list[str], others: tuple | list = (), part: str = "all") -> None:
    for path in paths:
        write_bytes(Path(dataset) / path, path.encode())
    write_index(index_of(dataset, part), Path(dataset), [*paths, *others])
    vouch()


def frames_of(row: str, part: str = "train") -> list[str]:
    return [
        Path(line["image"].partition("#")[2] or line["image"]).name[:15]
        for line in read_csv(f"results/subset/{row}/{part}.csv")
    ]


def test_purely_synthetic_lists_take_the_first_and_the_last_kept_frames(document: dict) -> None:
    params = check(document, "params.yaml")
    subset(params, "FS-24500")
    subset(params, "FS-498")
    assert [name[:5] for name in frames_of("FS-24500")] == ["00001", "00002", "00004", "00005"]
    assert [name[:5] for name in frames_of("FS-24500", "validation")] == ["00009", "00010"]
    assert [name[:5] for name in frames_of("FS-498")] == ["00001", "00002"]
    line = read_csv("results/subset/FS-498/train.csv")[0]
    assert line == {
        "image": "fog:beta_0.005/0000.tar#00001_beta_0.005.png",
        "image_sha256": sha256_bytes(b"1"),
        "label": "synscapes:img/class/1.png",
        "label_sha256": sha256_bytes(b"img/class/1.png"),
    }


def test_partially_synthetic_lists_follow_the_refined_list_and_take_labels_of_cityscapes(document: dict) -> None:
    subset(check(document, "params.yaml"), "FC-498")
    lines = read_csv("results/subset/FC-498/train.csv")
    assert [line["label"] for line in lines] == [f"cityscapes:{cityscapes.labels(frame)}" for frame in REFINED["train"]]
    assert all(line["image"].endswith("_leftImg8bit_foggy_beta_0.01.png") for line in lines)


def test_a_mix_has_two_purely_synthetic_images_for_each_partially_synthetic_one(document: dict) -> None:
    subset(check(document, "params.yaml"), "FC-FS-498")
    sources = [line["image"].partition(":")[0] for line in read_csv("results/subset/FC-FS-498/train.csv")]
    assert sources == ["fog", "fog", "foggy_cityscapes", "fog", "foggy_cityscapes"]


@pytest.mark.parametrize(
    ("ratio", "mixed"), [((2, 1), "aaxaayaax"), ((1, 1), "axayaxayaxay"), ((1, 5), "a" + "xyxyx" + "a" + "yxyxy")]
)
def test_foggy_cityscapes_is_repeated_at_every_ratio(ratio: tuple[int, int], mixed: str) -> None:
    count = mixed.count("a")
    assert "".join(interleave(["a"] * count, ["x", "y"], ratio)) == mixed


def test_training_and_validation_never_share_a_frame(document: dict) -> None:
    document = counts(document, FS_24500={"train": 7, "validation": 2})
    document["fog"]["frames"] = {"first": 7, "last": 2}
    with pytest.raises(FoggyError, match="asks for 7 training and 2 validation frames, but the filter kept 8"):
        subset(check(document, "params.yaml"), "FS-24500")
    assert not Path("results/subset").exists()


def test_asking_for_more_than_there_is_names_the_list(document: dict) -> None:
    document = counts(document, C={"train": 4, "validation": 1}, FS_24500={"train": 4, "validation": 2})
    with pytest.raises(FoggyError, match=r"subset\.clear\.C\.train: asks for 4 frames, but there are 3"):
        subset(check(document, "params.yaml"), "C")


def test_a_frame_without_fog_or_without_labels_is_named(document: dict) -> None:
    write_manifest("results/fog/beta_0.005/0000.csv", [])
    vouch()
    with pytest.raises(FoggyError, match="no shard holds frame 1"):
        subset(check(document, "params.yaml"), "FS-498")
    listed("cityscapes", [cityscapes.image("train/aachen/aachen_000000_000019")])
    with pytest.raises(
        FoggyError, match=r"gtFine/train/aachen/aachen_000000_000019_gtFine_labelIds\.png is not in its index"
    ):
        subset(
            check(counts(document, C={"train": 1, "validation": 1}, FS_24500={"train": 4, "validation": 2}), "p"), "C"
        )


@pytest.mark.parametrize("line", ["train/aachen/../../../etc/passwd", "test/x/x_000000_000000", "aachen_000000_000019"])
def test_a_refined_list_that_is_none_is_refused(document: dict, line: str) -> None:
    name = document["scenes"]["refined_list"]
    write_text(Path("foggy_cityscapes") / name, line + "\n")
    write_index(index_of("foggy_cityscapes"), Path("foggy_cityscapes"), [name])
    vouch()
    with pytest.raises(FoggyError, match=r"line 1: .* is not like train/aachen"):
        subset(check(document, "params.yaml"), "FC-498")


def test_an_unknown_row_is_a_wrong_call() -> None:
    from argparse import Namespace

    with pytest.raises(UsageError, match=r"--row FS-5: not in subset\.clear, which has C"):
        run(Namespace(params=ROOT / "params.yaml", row="FS-5"))
