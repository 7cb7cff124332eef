"""The five datasets in miniature, in their official layouts, names and formats, made from real samples.

What the samples hold is copied as it is: two Synscapes frames (image, depth), Cityscapes frames (image, labels,
disparity, camera), the lists of Foggy Driving. What they do not hold is derived from them:
- Synscapes: class maps by geometry (sky beyond 1 km, a flat road, the rest building), metadata of one camera.
- Cityscapes: one frame takes the name of a validation frame; labelIds of the frame that has instanceIds alone.
- Foggy Cityscapes: fog on the Cityscapes frames, as if each stood on a flat street.
- Foggy Driving: the first frames of its lists, cut out of these images at sizes that vary as the real ones do.
- Foggy Zurich: these images resized to 1920 x 1080.
Scores on them mean nothing; sizes, bit depths, names and label encodings are those of the datasets.
"""

import json
import shutil
from pathlib import Path

import numpy as np

from foggy_synscapes.datasets import cityscapes, foggy_cityscapes, foggy_driving, foggy_zurich, synscapes
from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.images import encode_png, read_depth, read_grey16, read_ids, read_rgb
from foggy_synscapes.labels import LABEL_IDS, to_train_ids

ROOTS = {
    "synscapes": "Synscapes",
    "cityscapes": "Cityscapes",
    "foggy_cityscapes": "FoggyCityscapes",
    "foggy_driving": "Foggy_Driving",
    "foggy_zurich": "Foggy_Zurich",
}
"""Folders of the datasets, as params/paper.yaml names them below its folder data."""
VALIDATION = {"train/aachen/aachen_000004_000019": "val/frankfurt/frankfurt_000000_000294"}
REFINED = "foggy_trainval_refined_filenames.txt"
ZURICH = ("GP010229/1508040913.0_frame_000955", "GP010229/1508040913.0_frame_000961")
DRIVING_SIZES = ((960, 1280), (768, 1024), (720, 1270), (683, 1024))  # rows, columns
ROAD, BUILDING, SKY = 7, 11, 23  # labelIds
CAMERA_HEIGHT = 1.22  # metres; `camera.extrinsic.z` of both samples
AIRLIGHT = 235.0


def build(samples: Path, folder: Path) -> dict[str, str]:
    """Write the five datasets below a folder; the folder of each by its key in `scenes.roots`."""
    roots = {name: folder / place for name, place in ROOTS.items()}
    _synscapes(samples / "synscapes", roots["synscapes"])
    frames = _cityscapes(samples / "cityscapes", roots["cityscapes"])
    foggy = _foggy_cityscapes(roots["cityscapes"], roots["foggy_cityscapes"], frames)
    labels = {name: read_ids(roots["cityscapes"] / cityscapes.labels(name)) for name in frames}
    pairs = [(foggy[name], labels[name]) for name in frames]
    _foggy_driving(samples / "foggy_driving_lists", roots["foggy_driving"], pairs)
    _foggy_zurich(roots["foggy_zurich"], pairs)
    return {name: str(root) for name, root in roots.items()}


def _copy(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, target)


def _synscapes(samples: Path, root: Path) -> None:
    camera = json.loads((samples / "camera.json").read_text())["camera"]
    keys = (samples / "scene_keys.txt").read_text().split()
    intrinsic = camera["intrinsic"]
    rows = np.arange(intrinsic["resy"])[:, None]
    for frame in (1, 2):
        for path in (synscapes.rgb(frame), synscapes.depth(frame)):
            _copy(samples / path, root / path)
        depth = read_depth(root / synscapes.depth(frame))
        below = depth * (rows - intrinsic["v0"]) / intrinsic["fy"]  # metres below the camera
        ids = np.where(depth > 1000, SKY, np.where(below > CAMERA_HEIGHT - 0.2, ROAD, BUILDING))
        write_bytes(root / synscapes.class_(frame), encode_png(ids.astype(np.uint8)))
        scene = dict.fromkeys(keys, 0.25 + frame)
        write_text(root / synscapes.meta(frame), json.dumps({"camera": camera, "instance": {}, "scene": scene}))


def _cityscapes(samples: Path, root: Path) -> list[str]:
    """Names of the frames, sorted."""
    names = []
    for path in sorted((samples / "leftImg8bit").glob("*/*/*.png")):
        own = path.relative_to(samples / "leftImg8bit").as_posix().removesuffix("_leftImg8bit.png")
        name = VALIDATION.get(own, own)
        names.append(name)
        for kind in (
            cityscapes.image,
            cityscapes.labels,
            cityscapes.instances,
            cityscapes.disparity,
            cityscapes.camera,
        ):
            if (samples / kind(own)).is_file():
                _copy(samples / kind(own), root / kind(name))
        if not (root / cityscapes.labels(name)).is_file():
            instances = read_grey16(samples / cityscapes.instances(own))
            ids = np.where(instances >= 1000, instances // 1000, instances)
            write_bytes(root / cityscapes.labels(name), encode_png(ids.astype(np.uint8)))
    return sorted(names)


def _foggy_cityscapes(clear: Path, root: Path, frames: list[str]) -> dict[str, np.ndarray]:
    """The foggy image of each frame at the largest published beta."""
    camera = json.loads(next((clear / "camera").rglob("*.json")).read_text())["intrinsic"]
    foggy = {}
    for name in frames:
        image = read_rgb(clear / cityscapes.image(name))
        rows = np.arange(image.shape[0])[:, None]
        distance = camera["fy"] * CAMERA_HEIGHT / np.maximum(rows - camera["v0"], 1.0)  # metres
        distance = np.where(read_ids(clear / cityscapes.labels(name)) == SKY, np.inf, distance)
        for beta in foggy_cityscapes.BETAS:
            transmittance = np.exp(-float(beta) * distance)[..., None]
            foggy[name] = np.rint(image * transmittance + AIRLIGHT * (1 - transmittance)).astype(np.uint8)
            write_bytes(root / foggy_cityscapes.image(name, beta), encode_png(foggy[name], 0))
    write_text(root / REFINED, "".join(f"{name}\n" for name in frames))
    return foggy


def _foggy_driving(lists: Path, root: Path, pairs: list[tuple[np.ndarray, np.ndarray]]) -> None:
    images, labels = (
        (lists / Path(path).name).read_text().split() for path in (foggy_driving.IMAGES, foggy_driving.LABELS)
    )
    both = list(zip(images, labels, strict=True))
    chosen = [
        pair for coarse in (False, True) for pair in [one for one in both if ("gtCoarse" in one[1]) == coarse][:2]
    ]
    for (image, label), (rows, columns), (foggy, ids) in zip(chosen, DRIVING_SIZES, pairs, strict=False):
        ids = ids[:rows, :columns].copy()
        if "gtCoarse" in label:
            ids[::16] = 0  # what is not annotated
        write_bytes(root / image, encode_png(foggy[:rows, :columns], 0))
        write_bytes(root / label, encode_png(ids))
    kept = {path for pair in chosen for path in pair}
    for path in sorted(lists.glob("*.txt")):
        listed = [line for line in path.read_text().split() if line in kept]
        write_text(root / "lists_file_names" / path.name, "".join(f"{line}\n" for line in listed))


def _foggy_zurich(root: Path, pairs: list[tuple[np.ndarray, np.ndarray]]) -> None:
    for name, (foggy, ids) in zip(ZURICH, pairs, strict=False):
        rows, columns = (np.arange(size) * old // size for size, old in zip((1080, 1920), ids.shape, strict=True))
        ids = ids[np.ix_(rows, columns)]
        ids[ids == LABEL_IDS[16]] = 0  # its ground truth has no train
        write_bytes(root / foggy_zurich.image(name), encode_png(foggy[np.ix_(rows, columns)], 0))
        write_bytes(root / foggy_zurich.labels(name), encode_png(ids))
        write_bytes(root / foggy_zurich.train_labels(name), encode_png(to_train_ids(ids, name)))
    for version, names in (("testv1", ZURICH[:1]), ("testv2", ZURICH)):
        for kind in ("RGB", "gt_labelIds", "gt_labelTrainIds"):
            text = "".join(f"{kind}/{name}.png\n" for name in names)
            write_text(root / foggy_zurich.list_path(kind, version), text)
