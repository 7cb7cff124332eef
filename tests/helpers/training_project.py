"""A project of a few tiny images and networks, in which `foggy train` takes seconds."""

import csv
from pathlib import Path

import numpy as np
import yaml
from records import vouch

from foggy_synscapes.cli import main
from foggy_synscapes.io.hashing import sha256, sha256_bytes
from foggy_synscapes.io.images import encode_png
from foggy_synscapes.stages import train as stage

ROOT = Path(__file__).resolve().parents[2]
COLUMNS = ("image", "image_sha256", "label", "label_sha256")


def frame(number):
    """An image of blocks of four classes (road, building, sky, car), each of its own grey."""
    random = np.random.default_rng(number)
    labels = np.kron(random.choice([7, 11, 23, 26], (3, 4)), np.ones((16, 16))).astype(np.uint8)
    return np.repeat((labels * 9)[..., None], 3, axis=2).astype(np.uint8), labels


def write_lists(row, count=6):
    """Cityscapes-like files and the two lists of a row."""
    folder = Path("results/scenes/cityscapes")
    folder.mkdir(parents=True, exist_ok=True)
    entries = []
    for number in range(count):
        entry = []
        for kind, pixels in zip(("image", "label"), frame(number), strict=True):
            data = encode_png(pixels)
            (folder / f"{kind}_{number}.png").write_bytes(data)
            entry += [f"cityscapes:{kind}_{number}.png", sha256_bytes(data)]
        entries.append(entry)
    for name, part in (("train", entries[:4]), ("validation", entries[4:])):
        write_list(row, name, part)
    return entries


def write_list(row, name, entries):
    path = Path("results/subset") / row / f"{name}.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *entries])
    vouch(path)


def project_in(tmp_path, monkeypatch):
    """A folder with tiny networks in its params and a list for C and FC-498; returns a function that changes params."""
    monkeypatch.chdir(tmp_path)
    document = yaml.safe_load((ROOT / "params.yaml").read_text())
    train = document["train"]
    train |= {"curve": 1, "snapshot": 1, "seeds": ["0", "1"]}
    train["rows"]["FC-498"] = {"length": {"epochs": 1}, "validate": {"epochs": 1}}
    for name in ("bisenet", "refinenet"):
        network = train[name]
        network |= {"width": 8, "decoder": 4}
        network["baseline"] |= {"length": {"iterations": 3}, "validate": {"iterations": 2}}
        for policy in (network["baseline"], network["fine_tuning"]):
            policy |= {"batch": 2, "crop": [32, 32]}

    def change(path=(), value=None, section="train"):
        inner = document[section]
        for key in path[:-1]:
            inner = inner[key]
        if path:
            inner[path[-1]] = value
        Path("params.yaml").write_text(yaml.safe_dump(document, sort_keys=False))

    change()
    write_lists("C")
    write_lists("FC-498")
    return change


def train(network="bisenet", row="C", seed="0"):
    return main(["train", "--network", network, "--row", row, "--seed", seed])


def hashes(network="bisenet", row="C", seed="0"):
    folder = Path("results/train") / network / row / f"seed-{seed}"
    return {path.name: sha256(path) for path in sorted(folder.iterdir())}


def interrupt(monkeypatch, step):
    """Let a training end like one that was killed, when it saves its snapshot after a step."""
    saved = []

    def write(path, data):
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        Path(path).write_bytes(data)
        saved.append(path)
        if len(saved) == step:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(stage, "write_bytes", write)
        assert train() == 1
    assert list(hashes()) == ["snapshot.safetensors"]
