"""Roots that are not the dataset that they should be: what is wrong, what was expected and where to get it is named.

`scenes` lists and hashes files and decodes none, so that a few bytes stand for each of them here.
"""

import shutil
from pathlib import Path

import pytest

from foggy_synscapes.datasets import DATASETS, cityscapes, foggy_cityscapes, foggy_driving, foggy_zurich, synscapes
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.params import Params, check
from foggy_synscapes.stages.scenes import scenes

TRAIN, VAL = "train/aachen/aachen_000000_000019", "val/frankfurt/frankfurt_000000_000294"
DRIVING, ZURICH = ("public/public_20161213_083206", False), ("web/web_8050286343_fb56b08ce7", True)
SEQUENCE = "GP010229/1508040913.0_frame_000955"
REFINED = "foggy_trainval_refined_filenames.txt"
FILES: dict[str, dict[str, str]] = {
    "synscapes": {
        name(frame): "bytes"
        for frame in (1, 2)
        for name in (synscapes.rgb, synscapes.depth, synscapes.class_, synscapes.meta)
    },
    "cityscapes": {name(frame): "bytes" for frame in (TRAIN, VAL) for name in (cityscapes.image, cityscapes.labels)},
    "foggy_cityscapes": {
        REFINED: f"{TRAIN}\n{VAL}\n",
        **{foggy_cityscapes.image(frame, "0.01"): "bytes" for frame in (TRAIN, VAL)},
    },
    "foggy_driving": {
        foggy_driving.IMAGES: "".join(f"{foggy_driving.image(*name)}\n" for name in (DRIVING, ZURICH)),
        foggy_driving.LABELS: "".join(f"{foggy_driving.labels(*name)}\n" for name in (DRIVING, ZURICH)),
        **{name(*each): "bytes" for each in (DRIVING, ZURICH) for name in (foggy_driving.image, foggy_driving.labels)},
    },
    "foggy_zurich": {
        foggy_zurich.list_path("RGB"): f"{foggy_zurich.image(SEQUENCE)}\n",
        foggy_zurich.list_path("gt_labelIds"): f"{foggy_zurich.labels(SEQUENCE)}\n",
        foggy_zurich.image(SEQUENCE): "bytes",
        foggy_zurich.labels(SEQUENCE): "bytes",
    },
}
HOMES = {
    "synscapes": "7dlabs.com",
    "cityscapes": "gtFine_trainvaltest.zip of cityscapes-dataset.com",
    "foggy_cityscapes": "leftImg8bit_trainvaltest_foggy.zip of cityscapes-dataset.com",
    "foggy_driving": "Foggy_Driving.zip of the page of SFSU",
    "foggy_zurich": "Foggy_Zurich.zip of the page of CMAda",
}


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def write(dataset: str, root: str = "root") -> Path:
    for path, text in FILES[dataset].items():
        (Path(root) / path).parent.mkdir(parents=True, exist_ok=True)
        (Path(root) / path).write_text(text)
    return Path(root)


def params(dataset: str, root: str) -> Params:
    shards = {"shard_frames": 2, "shards": ["0000"]} if dataset == "synscapes" else {}
    return check({"scenes": {"roots": {dataset: root}, **shards}}, "params.yaml")


def refusal(dataset: str, root: str = "root") -> str:
    """What `scenes` says of a root; it names the home of the dataset too."""
    with pytest.raises(FoggyError) as refused:
        scenes(params(dataset, root), dataset)
    message = str(refused.value)
    assert HOMES[dataset] in message
    for folder in DATASETS[dataset].folders:
        assert folder in message
    return message


@pytest.mark.parametrize("dataset", FILES)
def test_a_root_as_it_unpacks_is_listed(dataset: str, capsys: pytest.CaptureFixture) -> None:
    write(dataset)
    scenes(params(dataset, "root"), dataset)
    assert f"{len(FILES[dataset])} files of the real dataset listed" in capsys.readouterr().out


@pytest.mark.parametrize("other", FILES)
@pytest.mark.parametrize("dataset", FILES)
def test_the_root_of_another_dataset_is_known_as_that(dataset: str, other: str) -> None:
    if dataset != other:
        write(other)
        assert f"This looks like {other}" in refusal(dataset)


@pytest.mark.parametrize("dataset", FILES)
def test_another_archive_is_told_by_what_it_holds(dataset: str) -> None:
    Path("root/rightImg8bit/train").mkdir(parents=True)
    Path("root/license.txt").write_text("terms")
    assert f"Instead of {DATASETS[dataset].folders[0].split('/')[0]}, root holds license.txt, rightImg8bit." in refusal(
        dataset
    )


@pytest.mark.parametrize("dataset", FILES)
def test_an_archive_that_is_not_unpacked_is_named(dataset: str) -> None:
    Path("root").mkdir()
    Path("root/all.ZIP").write_bytes(b"PK")
    assert "all.ZIP is there, but not unpacked" in refusal(dataset)
    assert "It is a file: unpack it" in refusal(dataset, "root/all.ZIP")


@pytest.mark.parametrize("dataset", FILES)
def test_a_root_one_folder_too_high_or_too_low_is_told_where_the_dataset_is(dataset: str) -> None:
    write(dataset, "root/unpacked")
    assert f"The dataset is in root/unpacked: name that folder in scenes.roots.{dataset}" in refusal(dataset)
    low = f"root/unpacked/{DATASETS[dataset].folders[-1].split('/')[0]}"
    assert "The dataset is in root/unpacked: name that folder" in refusal(dataset, low)


@pytest.mark.parametrize("dataset", FILES)
def test_a_renamed_root_is_found_beside_the_named_one(dataset: str) -> None:
    write(dataset, "My_Dataset")
    assert "my-dataset is no folder. Beside it is 'My_Dataset'" in refusal(dataset, "my-dataset")


@pytest.mark.parametrize(("dataset", "folder"), [(name, each) for name in FILES for each in DATASETS[name].folders])
def test_a_folder_that_was_renamed_or_never_unpacked_is_named(dataset: str, folder: str) -> None:
    root, last = write(dataset), Path(folder).name
    (root / folder).rename(root / Path(folder).with_name(last.upper() if last != "RGB" else "rgb"))
    spelled = last.upper() if last != "RGB" else "rgb"
    assert f"There is '{spelled}' where '{last}' is expected" in refusal(dataset)
    shutil.rmtree(root / Path(folder).with_name(spelled))
    assert f"Instead of {last}, " in refusal(dataset)


@pytest.mark.parametrize(("dataset", "path"), [(name, path) for name in FILES for path in FILES[name]])
def test_each_file_that_unpacking_left_out_is_named(dataset: str, path: str) -> None:
    root = write(dataset)
    if path == cityscapes.image(TRAIN) or path == cityscapes.image(VAL):
        return  # without its image there is no such frame; too few frames are refused where they are asked for
    (root / path).unlink()
    assert path in refusal(dataset)


@pytest.mark.parametrize(("dataset", "path"), [(name, path) for name in FILES for path in FILES[name]])
def test_an_empty_file_is_taken_for_a_cut_off_one(dataset: str, path: str) -> None:
    root = write(dataset)
    (root / path).write_text("")
    message = refusal(dataset)
    assert Path(path).name in message
    assert "is empty; was unpacking cut off?" in message or "names no" in message or "no leftImg8bit_foggy" in message


def test_how_many_files_are_missing_is_said() -> None:
    root = write("cityscapes")
    shutil.rmtree(root / "gtFine/train")
    shutil.rmtree(root / "gtFine/val")
    (root / "gtFine/test").mkdir()
    message = refusal("cityscapes")
    assert "It is the first of 2 among 4 files. Instead of train, root/gtFine holds test." in message


@pytest.mark.parametrize(("dataset", "path"), [(name, path) for name in FILES for path in FILES[name]])
def test_an_ending_in_capitals_is_named(dataset: str, path: str) -> None:
    root = write(dataset)
    wrong = Path(path).with_suffix(Path(path).suffix.upper())
    (root / path).rename(root / wrong)
    message = refusal(dataset) if "leftImg8bit/" not in path or dataset != "cityscapes" else misspelt(dataset)
    assert wrong.name in message


def misspelt(dataset: str) -> str:
    with pytest.raises(FoggyError, match=r"should end in _leftImg8bit\.png, letter by letter") as refused:
        scenes(params(dataset, "root"), dataset)
    return str(refused.value)


def test_names_in_small_letters_are_named() -> None:
    root = write("cityscapes")
    label = root / cityscapes.labels(TRAIN)
    label.rename(label.with_name(label.name.lower()))
    assert f"There is {label.name.lower()!r} where {label.name!r} is expected" in refusal("cityscapes")


def test_labels_of_another_city_are_named() -> None:
    root = write("cityscapes")
    label = root / cityscapes.labels(TRAIN)
    label.rename(label.with_name(label.name.replace("aachen", "bochum")))
    message = refusal("cityscapes")
    assert f"{label}: missing." in message
    assert "root/gtFine/train/aachen holds bochum_000000_000019_gtFine_labelIds.png" in message
    label.parent.rename(label.parent.with_name("bochum"))
    assert "Instead of aachen, root/gtFine/train holds bochum." in refusal("cityscapes")


def test_an_image_in_the_folder_of_another_city_is_refused() -> None:
    image = write("cityscapes") / cityscapes.image(TRAIN)
    image.rename(image.with_name(image.name.replace("aachen", "bochum")))
    assert "bochum_000000_000019_leftImg8bit.png: is of another city than aachen" in refusal("cityscapes")


@pytest.mark.parametrize(
    ("dataset", "path", "before", "after"),
    [
        ("foggy_driving", foggy_driving.LABELS, "test/public/", "test/pedestrian/"),
        ("foggy_driving", foggy_driving.LABELS, "083206", "082948"),
        ("foggy_zurich", foggy_zurich.list_path("gt_labelIds"), "GP010229", "GP020397"),
    ],
)
def test_a_list_that_pairs_an_image_with_labels_of_elsewhere_is_refused(
    dataset: str, path: str, before: str, after: str
) -> None:
    listed = write(dataset) / path
    listed.write_text(listed.read_text().replace(before, after))
    assert "but labels of another frame" in refusal(dataset)


def test_a_refined_list_of_another_city_than_is_there_is_refused() -> None:
    root = write("foggy_cityscapes")
    (root / REFINED).write_text(f"{TRAIN}\n{VAL.replace('frankfurt', 'munster')}\n")
    message = refusal("foggy_cityscapes")
    assert "Instead of munster, root/leftImg8bit_foggy/val holds frankfurt." in message


def test_datasets_that_share_a_root_are_not_taken_for_one_another() -> None:
    for dataset in ("cityscapes", "foggy_cityscapes", "foggy_zurich"):
        write(dataset)
    for dataset in ("cityscapes", "foggy_cityscapes", "foggy_zurich"):
        scenes(params(dataset, "root"), dataset)
    (Path("root") / cityscapes.labels(VAL)).unlink()
    assert "This looks like" not in refusal("cityscapes")
