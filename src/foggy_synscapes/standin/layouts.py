"""The stand-in in the real layouts: which frames each dataset has, and the content of their files.

A frame knows its files without being rendered, so that what is there already can be left alone.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass

from foggy_synscapes import labels
from foggy_synscapes.datasets import cityscapes, foggy_cityscapes, foggy_driving, foggy_zurich, synscapes
from foggy_synscapes.io.images import encode_depth, encode_png
from foggy_synscapes.standin import annotate, frames, stereo
from foggy_synscapes.standin import fog as haze
from foggy_synscapes.standin.camera import Rig

Files = list[tuple[str, bytes]]

CITIES = {"train": ("aachen", "bochum"), "val": ("frankfurt", "lindau")}
"""Cities of the stand-in's splits; real ones of the same splits."""

STREAMS = {"train": frames.CITYSCAPES_TRAIN, "val": frames.CITYSCAPES_VAL}

DRIVING_SOURCES = ("public", "pedestrian", "web")

SEQUENCES = ("GP010229", "GP020397")
"""Drives of Foggy Zurich."""


@dataclass(frozen=True)
class SynscapesFrame:
    """Frame `id` (from 1) of Synscapes."""

    seed: int
    size: tuple[int, int]
    id: int

    def paths(self) -> list[str]:
        """Files of the frame below the root."""
        return [
            name(self.id)
            for name in (synscapes.rgb, synscapes.depth, synscapes.class_, synscapes.instance, synscapes.meta)
        ]

    def files(self) -> Files:
        """Render the frame."""
        scene = frames.synscapes(self.seed, self.id - 1, self.size)
        meta = {"camera": _camera(scene.rig), "instance": scene.instance, "scene": scene.scene}
        contents = (
            encode_png(scene.rgb),
            encode_depth(scene.depth),
            encode_png(scene.label_ids),
            encode_png(annotate.instance_colours(scene.instances)),
            _json(meta),
        )
        return list(zip(self.paths(), contents, strict=True))


@dataclass(frozen=True)
class CityscapesFrame:
    """Frame `number` (from 0) of a split of Cityscapes with `count` frames."""

    seed: int
    size: tuple[int, int]
    split: str
    number: int
    count: int

    def name(self) -> str:
        """Split, city and stem."""
        cities = CITIES[self.split]
        first = -(-self.count // len(cities))
        city, sequence = cities[self.number // first], self.number % first
        return f"{self.split}/{city}/{city}_{sequence:06d}_000019"

    def paths(self) -> list[str]:
        """Files of the frame below the root."""
        kinds = (cityscapes.image, cityscapes.labels, cityscapes.instances, cityscapes.disparity, cityscapes.camera)
        return [kind(self.name()) for kind in kinds]

    def files(self) -> Files:
        """Render the frame."""
        scene, disparity = frames.cityscapes(self.seed, STREAMS[self.split], self.number, self.size)
        intrinsic = {name: value for name, value in scene.rig.intrinsic().items() if name not in ("resx", "resy")}
        camera = {"extrinsic": {"baseline": stereo.BASELINE, **scene.rig.extrinsic()}, "intrinsic": intrinsic}
        contents = (
            encode_png(scene.rgb),
            encode_png(scene.label_ids),
            encode_png(annotate.instance_ids(scene.label_ids, scene.instances)),
            encode_png(disparity),
            _json(camera),
        )
        return list(zip(self.paths(), contents, strict=True))


@dataclass(frozen=True)
class FoggyCityscapesFrame:
    """A refined frame of Foggy Cityscapes, made again from the seed of its clear frame."""

    clear: CityscapesFrame

    def paths(self) -> list[str]:
        """Files of the frame below the root."""
        return [foggy_cityscapes.image(self.clear.name(), beta) for beta in foggy_cityscapes.BETAS]

    def files(self) -> Files:
        """Render the frame."""
        clear = self.clear
        scene, disparity = frames.cityscapes(clear.seed, STREAMS[clear.split], clear.number, clear.size)
        foggy = haze.from_stereo(scene, disparity, [float(beta) for beta in foggy_cityscapes.BETAS])
        return list(zip(self.paths(), map(encode_png, foggy), strict=True))


@dataclass(frozen=True)
class DrivingFrame:
    """Frame `number` (from 0) of the finely or coarsely annotated part of Foggy Driving."""

    seed: int
    size: tuple[int, int]
    number: int
    coarse: bool

    def name(self) -> str:
        """Source and stem."""
        source = DRIVING_SOURCES[self.number % len(DRIVING_SOURCES)]
        return f"{source}/{source}_20190{2 if self.coarse else 1}01_{self.number:06d}"

    def dense(self) -> bool:
        """Whether the frame is in the list of densely foggy ones."""
        return haze.DRIVING_BETAS[self.number % len(haze.DRIVING_BETAS)] >= haze.DENSE

    def paths(self) -> list[str]:
        """Files of the frame below the root: image, labelIds and, if fine, instance ids beside them."""
        labels_path = foggy_driving.labels(self.name(), self.coarse)
        paths = [foggy_driving.image(self.name(), self.coarse), labels_path]
        return paths if self.coarse else [*paths, labels_path.replace("_labelIds", "_instanceIds")]

    def files(self) -> Files:
        """Render the frame."""
        shot = frames.foggy_driving(self.seed, self.number, self.size, self.coarse)
        contents = [encode_png(shot.rgb), encode_png(shot.label_ids)]
        if not self.coarse:
            contents.append(encode_png(annotate.instance_ids(shot.label_ids, shot.instances)))
        return list(zip(self.paths(), contents, strict=True))


@dataclass(frozen=True)
class ZurichFrame:
    """Frame `number` (from 0) of Foggy Zurich."""

    seed: int
    size: tuple[int, int]
    number: int

    def name(self) -> str:
        """Sequence and id."""
        sequence, place = SEQUENCES[self.number % len(SEQUENCES)], self.number // len(SEQUENCES)
        return f"{sequence}/{1508040913 + self.number}.0_frame_{place * 15 + 10:06d}"

    def paths(self) -> list[str]:
        """Files of the frame below the root."""
        return [kind(self.name()) for kind in (foggy_zurich.image, foggy_zurich.labels, foggy_zurich.train_labels)]

    def files(self) -> Files:
        """Render the frame."""
        shot = frames.foggy_zurich(self.seed, self.number, self.size)
        train_ids = labels.to_train_ids(shot.label_ids, self.name())
        return list(zip(self.paths(), map(encode_png, (shot.rgb, shot.label_ids, train_ids)), strict=True))


Frame = SynscapesFrame | CityscapesFrame | FoggyCityscapesFrame | DrivingFrame | ZurichFrame


def synscapes_frames(seed: int, size: tuple[int, int], count: int) -> list[Frame]:
    """All frames of Synscapes, in the order of their ids."""
    return [SynscapesFrame(seed, size, number) for number in range(1, count + 1)]


def cityscapes_frames(seed: int, size: tuple[int, int], counts: dict[str, int]) -> list[CityscapesFrame]:
    """All frames of both splits of Cityscapes."""
    return [CityscapesFrame(seed, size, split, k, counts[split]) for split in CITIES for k in range(counts[split])]


def foggy_cityscapes_frames(
    seed: int, size: tuple[int, int], counts: dict[str, int], refined: dict[str, int]
) -> list[FoggyCityscapesFrame]:
    """The refined frames of both splits; ValueError if there are not as many."""
    return [
        FoggyCityscapesFrame(CityscapesFrame(seed, size, split, number, counts[split]))
        for split in CITIES
        for number in frames.refined(seed, STREAMS[split], counts[split], refined[split])
    ]


def driving_frames(seed: int, size: tuple[int, int], fine: int, coarse: int) -> list[DrivingFrame]:
    """The finely, then the coarsely annotated frames of Foggy Driving."""
    return [DrivingFrame(seed, size, k, False) for k in range(fine)] + [
        DrivingFrame(seed, size, k, True) for k in range(coarse)
    ]


def zurich_frames(seed: int, size: tuple[int, int], count: int) -> list[ZurichFrame]:
    """All frames of Foggy Zurich."""
    return [ZurichFrame(seed, size, number) for number in range(count)]


def refined_list(chosen: list[FoggyCityscapesFrame], path: str) -> Files:
    """The list of refined frames, at the path that the params name."""
    return [_lines(path, (frame.clear.name() for frame in chosen))]


def driving_lists(chosen: list[DrivingFrame]) -> Files:
    """The five list files of Foggy Driving, with the names and line form of the real ones."""
    dense, fine = [frame for frame in chosen if frame.dense()], [frame for frame in chosen if not frame.coarse]
    folder = "lists_file_names"
    return [
        _lines(foggy_driving.LABELS, (frame.paths()[1] for frame in chosen)),
        _lines(f"{folder}/gt_testdense_filenames.txt", (frame.paths()[1] for frame in dense)),
        _lines(foggy_driving.IMAGES, (frame.paths()[0] for frame in chosen)),
        _lines(f"{folder}/leftImg8bit_testdense_filenames.txt", (frame.paths()[0] for frame in dense)),
        _lines(f"{folder}/leftImg8bit_testfine_filenames.txt", (frame.paths()[0] for frame in fine)),
    ]


def zurich_lists(chosen: list[ZurichFrame]) -> Files:
    """The six list files of Foggy Zurich; testv1 names two of five frames, as 16 of 40 in the real set."""
    lists = []
    for version, part in (("testv1", chosen[: max(1, len(chosen) * 2 // 5)]), ("testv2", chosen)):
        for k, kind in enumerate(("RGB", "gt_labelIds", "gt_labelTrainIds")):
            lists.append(_lines(foggy_zurich.list_path(kind, version), (frame.paths()[k] for frame in part)))
    return lists


def _camera(rig: Rig) -> dict[str, dict[str, float]]:
    return {"extrinsic": rig.extrinsic(), "intrinsic": rig.intrinsic()}


def _lines(path: str, lines: Iterator[str]) -> tuple[str, bytes]:
    return path, "".join(f"{line}\n" for line in lines).encode()


def _json(document: dict) -> bytes:
    return (json.dumps(document, indent=1, sort_keys=True) + "\n").encode()
