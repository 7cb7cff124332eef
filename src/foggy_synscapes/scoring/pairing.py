"""Which prediction belongs to which label map, told from their names alone.

Datasets name the maps of one frame differently: `x_leftImg8bit.png`, `x_gtFine_labelIds.png`, `x.png` in another
folder. The part that tells what kind of file it is does not count; the folder counts unless a side is flat.
"""

import re
from collections.abc import Callable, Iterable
from pathlib import PurePosixPath

# What a file is, at the end of its name, in Cityscapes and what follows its naming. More than one may stand there.
_KIND = re.compile(
    r"_(leftImg8bit|rgb_anon|foggy|beta_[0-9.e+-]+|gt|gtFine|gtCoarse|pred|preds|prediction|predictions"
    r"|labelIds|labelTrainIds|labels?|trainIds)$",
    re.IGNORECASE,
)
_IDS = re.compile(r"_(labelIds|labelTrainIds|trainIds)$", re.IGNORECASE)
# Maps of ids lie among these in the folders of Cityscapes.
_OTHER = re.compile(r"_(color|instanceIds|instanceTrainIds|panoptic)$", re.IGNORECASE)


def named_encoding(name: str) -> str | None:
    """Encoding that a file's own name states: "labelIds", "trainIds" or None.

    >>> named_encoding("aachen/aachen_000000_000019_gtFine_labelTrainIds.png")
    'trainIds'
    """
    found = _IDS.search(PurePosixPath(name).stem)
    if not found:
        return None
    return "labelIds" if found[1].lower() == "labelids" else "trainIds"


def is_other_map(name: str) -> bool:
    """Whether a name is that of a colour picture or an instance map of Cityscapes."""
    return bool(_OTHER.search(PurePosixPath(name).stem))


def frame(name: str) -> str:
    """Name of the frame that a file belongs to: the folder and the name without what kind of file it is.

    >>> frame("test/web/a_000001_leftImg8bit.png"), frame("web/a_000001_gtFine_labelIds.png"), frame("s/2.0_f_1.png")
    ('test/web/a_000001', 'web/a_000001', 's/2.0_f_1')
    """
    path = PurePosixPath(name)
    stem = path.stem
    while (shorter := _KIND.sub("", stem)) != stem and shorter:
        stem = shorter
    return str(path.with_name(stem))


def pair(labels: Iterable[str], predictions: Iterable[str]) -> list[tuple[str, str]]:
    """Pair relative paths of label maps with those of predictions, one to one: sorted (label, prediction).

    Files are paired by folder and frame; where folders differ between the two sides, by frame alone, provided
    that no two files of a side share it. Raises ValueError naming the files that stay alone on either side, or that are
    two for one frame.
    """
    labels, predictions = sorted(labels), sorted(predictions)
    by_path = _keys(labels, frame), _keys(predictions, frame)
    by_name = _keys(labels, _last), _keys(predictions, _last)
    unique = all(len(names) == 1 for side in by_name for names in side.values())
    matched = [len(set(one) & set(other)) for one, other in (by_path, by_name)]
    truth, guess = by_name if unique and matched[1] > matched[0] else by_path
    problems = [
        f"{len(names)} {side} for one frame: {_few(names)}"
        for side, keys in (("label maps", truth), ("predictions", guess))
        for names in keys.values()
        if len(names) > 1
    ][:1]
    missing = [names[0] for key, names in truth.items() if key not in guess]
    extra = [names[0] for key, names in guess.items() if key not in truth]
    if missing:
        problems.append(f"{len(missing)} of {len(labels)} label maps without a prediction: {_few(missing)}")
    if extra:
        problems.append(f"{len(extra)} of {len(predictions)} predictions without a label map: {_few(extra)}")
    if problems:
        raise ValueError("; ".join(problems))
    return sorted((names[0], guess[key][0]) for key, names in truth.items())


def _keys(names: list[str], key: Callable[[str], str]) -> dict[str, list[str]]:
    keys: dict[str, list[str]] = {}
    for name in names:
        keys.setdefault(key(name), []).append(name)
    return keys


def _last(name: str) -> str:
    return PurePosixPath(frame(name)).name


def _few(names: list[str], shown: int = 3) -> str:
    return ", ".join(names[:shown]) + (f" and {len(names) - shown} more" if len(names) > shown else "")
