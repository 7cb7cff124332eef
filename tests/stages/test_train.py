"""`foggy train` on tiny files: what it writes, how it goes on, and what it refuses."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from fog_frames import CAMERA, write_frame
from records import vouch
from training_project import frame, hashes, interrupt, project_in, train, write_list, write_lists

from foggy_synscapes.cli import main
from foggy_synscapes.datasets import synscapes, uris
from foggy_synscapes.frames import recipes, rendering
from foggy_synscapes.io.hashing import sha256, sha256_bytes
from foggy_synscapes.io.images import encode_png
from foggy_synscapes.io.shards import write_shard
from foggy_synscapes.params import load


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A project to train in; gives a function that changes its params."""
    return project_in(tmp_path, monkeypatch)


@pytest.mark.parametrize("network", ["bisenet", "refinenet"])
def test_a_baseline_and_its_fine_tuning_leave_model_curve_and_record(project, network, capsys):
    assert train(network) == 0
    assert train(network, "FC-498") == 0
    for row in ("C", "FC-498"):
        assert list(hashes(network, row)) == ["curves.csv", "model.safetensors", "run.json"]
    record = json.loads(Path(f"results/train/{network}/FC-498/seed-0/run.json").read_text())
    assert f"results/train/{network}/C/seed-0/model.safetensors" in record["inputs"]
    assert record["params"]["train"][network]["fine_tuning"]["batch"] == 2
    assert "stages.train" in record["code"]
    with open(f"results/train/{network}/C/seed-0/curves.csv") as file:
        rows = list(csv.DictReader(file))
    assert [row["step"] for row in rows] == ["1", "2", "3"]
    assert [bool(row["validation_loss"]) for row in rows] == [False, True, True]
    assert "(kept)" in capsys.readouterr().out


def test_training_again_gives_the_same_bytes_and_another_seed_others(project):
    assert train() == 0
    first = hashes()
    assert train() == 0
    assert hashes() == first
    assert train(seed="1") == 0
    assert hashes(seed="1")["model.safetensors"] != first["model.safetensors"]


@pytest.mark.parametrize("step", [1, 2])
def test_an_interrupted_training_goes_on_to_the_same_bytes(project, monkeypatch, step, capsys):
    assert train() == 0
    first = hashes()
    for name in first:
        Path("results/train/bisenet/C/seed-0", name).unlink()
    interrupt(monkeypatch, step)
    assert train() == 0
    assert "going on from" in capsys.readouterr().out
    assert hashes() == first


def test_a_snapshot_of_other_params_is_put_aside_in_one_line_and_training_begins_anew(project, monkeypatch, capsys):
    project(("bisenet", "baseline", "learning_rate"), 0.5)
    assert train() == 0
    wanted = hashes()
    for name in wanted:
        Path("results/train/bisenet/C/seed-0", name).unlink()
    project(("bisenet", "baseline", "learning_rate"), 0.01)
    interrupt(monkeypatch, 1)
    project(("bisenet", "baseline", "learning_rate"), 0.5)
    capsys.readouterr()
    assert train() == 0
    (line,) = [line for line in capsys.readouterr().err.splitlines() if "put aside" in line]
    assert "snapshot.safetensors: taken with other settings: " in line
    assert "bisenet.baseline.learning_rate: 0.01 -> 0.5" in line
    assert hashes() == wanted
    assert Path(".foggy/aside/results/train/bisenet/C/seed-0/snapshot.safetensors").is_file()


def test_a_large_list_is_read_again_each_time_to_the_same_bytes(project):
    assert train() == 0
    first = hashes()
    project(("cache",), 0)
    assert train() == 0
    assert hashes() == first


def refused(capsys, *parts, **arguments):
    before = {path for path in Path("results/train").rglob("*") if path.is_file()}
    assert train(**arguments) == 1
    message = capsys.readouterr().err
    assert "Traceback" not in message
    for part in parts:
        assert part in message
    assert {path for path in Path("results/train").rglob("*") if path.is_file()} == before


def replace_label(pixels):
    """Put another label map in the place of the first, listed as it is."""
    entries = write_lists("C")
    data = encode_png(pixels)
    Path("results/scenes/cityscapes/label_0.png").write_bytes(data)
    entries[0][3] = sha256_bytes(data)
    write_list("C", "train", entries[:4])


def test_a_label_of_200_is_refused(project, capsys):
    replace_label(np.full((48, 64), 200, np.uint8))
    refused(capsys, "label_0.png", "200")


def test_a_train_id_map_is_refused(project, capsys):
    pixels = np.zeros((48, 64), np.uint8)
    pixels[:20], pixels[20:30] = 10, 2
    replace_label(pixels)
    refused(capsys, "label_0.png", "trainIds")


def test_a_label_of_another_size_is_refused(project, capsys):
    replace_label(np.full((48, 60), 7, np.uint8))
    refused(capsys, "label_0.png", "48 x 60", "image_0.png", "48 x 64")


def test_a_vanished_file_is_named(project, capsys):
    Path("results/scenes/cityscapes/image_5.png").unlink()
    refused(capsys, "image_5.png")


def test_a_changed_file_is_named(project, capsys):
    Path("results/scenes/cityscapes/image_2.png").write_bytes(encode_png(frame(9)[0]))
    refused(capsys, "image_2.png", "changed")


def test_a_missing_list_is_named(project, capsys):
    Path("results/subset/C/validation.csv").unlink()
    refused(capsys, "validation.csv")


def test_an_empty_list_is_refused(project, capsys):
    write_list("C", "train", [])
    refused(capsys, "train.csv", "no image")


def test_a_batch_larger_than_the_list_is_refused(project, capsys):
    project(("bisenet", "baseline", "batch"), 8)
    refused(capsys, "batch: 8", "has 4")


def test_zero_iterations_are_refused(project, capsys):
    project(("bisenet", "baseline", "length"), {"iterations": 0})
    refused(capsys, "bisenet.baseline.length.iterations")


def test_a_loss_that_is_no_number_names_the_images(project, capsys):
    project(("bisenet", "baseline", "learning_rate"), 1e30)
    project(("snapshot",), 100)
    refused(capsys, "loss is", "cityscapes:image_")


def test_a_baseline_of_another_width_is_refused(project, capsys):
    assert train() == 0
    project(("bisenet", "width"), 16)
    refused(capsys, "model.safetensors", "width 8, wanted 16", row="FC-498")


def test_a_missing_baseline_is_named(project, capsys):
    refused(capsys, "bisenet/C/seed-0/model.safetensors", "missing. It is made by an earlier step", row="FC-498")


def test_a_baseline_that_is_no_model_is_refused(project, capsys):
    path = Path("results/train/bisenet/C/seed-0/model.safetensors")
    path.parent.mkdir(parents=True)
    path.write_bytes(b"not weights")
    vouch(path)
    refused(capsys, "model.safetensors", "safetensors file", row="FC-498")


@pytest.mark.parametrize("arguments", [{"row": "X"}, {"seed": "-1"}, {"seed": "x"}, {"network": "unet"}])
def test_a_wrong_call_ends_with_status_2(project, arguments):
    assert train(**arguments) == 2


def test_a_baseline_that_is_not_trained_is_its_weights(project):
    """As in the paper, whose RefineNet baseline is a public model."""
    assert train() == 0
    Path("weights.safetensors").write_bytes(Path("results/train/bisenet/C/seed-0/model.safetensors").read_bytes())
    project(("bisenet", "weights"), "weights.safetensors")
    project(("bisenet", "baseline"), None)
    assert train(seed="1") == 0
    assert hashes(seed="1")["model.safetensors"] == hashes(seed="0")["model.safetensors"]
    assert Path("results/train/bisenet/C/seed-1/curves.csv").read_text().count("\n") == 1
    assert train(row="FC-498", seed="1") == 0


def test_no_training_and_no_weights_is_a_contradiction(project, capsys):
    project(("bisenet", "baseline"), None)
    assert train() == 1
    assert "baseline: null takes the model in `weights` as row C, but weights is none" in capsys.readouterr().err


def test_an_imported_backbone_is_a_start(project, capsys):
    import torch

    from foggy_synscapes.networks import NetworkConfig
    from foggy_synscapes.networks.network import build

    source = build(NetworkConfig("bisenet", "resnet18", width=8, decoder=4)).backbone
    torch.save(source.state_dict(), "resnet18.pth")
    assert main(["weights", "import", "resnet18.pth", "--network", "bisenet", "--out", "start.safetensors"]) == 0
    assert "backbone of bisenet on resnet18" in capsys.readouterr().out
    assert train() == 0
    random = hashes()["model.safetensors"]
    project(("bisenet", "weights"), "start.safetensors")
    assert train() == 0
    assert hashes()["model.safetensors"] != random
    record = json.loads(Path("results/train/bisenet/C/seed-0/run.json").read_text())
    assert "start.safetensors" in record["inputs"]


@pytest.mark.parametrize("workers", [0, 2])
def test_a_file_that_vanishes_while_it_trains_is_named(project, monkeypatch, capsys, workers):
    from foggy_synscapes.datasets import pairs

    project(("cache",), 0)
    project(("workers",), workers)
    project(("snapshot",), 100)
    first = pairs.PairDataset.__init__

    def vanish(self, path, *arguments):
        first(self, path, *arguments)
        Path("results/scenes/cityscapes/image_2.png").unlink(missing_ok=True)

    monkeypatch.setattr(pairs.PairDataset, "__init__", vanish)
    refused(capsys, "image_2.png: missing. It was there when it was listed.")


def test_memory_that_does_not_do_names_the_setting(project, monkeypatch, capsys):
    from foggy_synscapes.training import loop

    def train_in_little_memory(*_arguments, **_more):
        raise RuntimeError("[enforce fail at alloc_cpu.cpp] DefaultCPUAllocator: can't allocate memory")

    monkeypatch.setattr(loop, "train", train_in_little_memory)
    refused(capsys, "not enough memory", "train.bisenet.*.accumulate")


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (RuntimeError("CUDA error: an illegal memory access was encountered"), False),
        ("OutOfMemoryError", True),
    ],
    ids=["illegal access", "too little"],
)
def test_only_want_of_memory_is_called_so(project, monkeypatch, capsys, error, told):
    import torch

    from foggy_synscapes.training import loop

    def fail(*_arguments, **_more):
        raise torch.OutOfMemoryError("CUDA out of memory. Tried to allocate 2 GiB") if told else error

    monkeypatch.setattr(loop, "train", fail)
    assert train() == 1
    message = capsys.readouterr().err
    assert ("not enough memory" in message) is told
    assert ("illegal memory access" in message) is not told


def test_a_gpu_that_is_not_there_is_named(project, capsys):
    import torch

    if torch.cuda.is_available():
        pytest.skip("there is a GPU")
    project(("device",), "cuda")
    refused(capsys, "device: cuda, but PyTorch", "finds no GPU")


def test_auto_is_the_cpu_where_there_is_no_gpu(project):
    import torch

    if torch.cuda.is_available():
        pytest.skip("there is a GPU, which auto takes")
    assert train() == 0
    first = hashes()
    project(("device",), "auto")
    assert train() == 0
    assert hashes()["model.safetensors"] == first["model.safetensors"]
    assert "gpu" not in json.loads(Path("results/train/bisenet/C/seed-0/run.json").read_text())


def test_a_public_model_is_row_c_where_the_baseline_is_not_trained(project, capsys):
    assert train() == 0
    Path("results/train/bisenet/C/seed-0/model.safetensors").rename("public.safetensors")
    project(("bisenet", "weights"), "public.safetensors")
    project(("bisenet", "baseline"), None)
    assert train() == 0
    assert sha256("public.safetensors") == hashes()["model.safetensors"]


def write_foggy_lists(row, recipe):
    """A shard of foggy images, or of their recipes, and the lists of a row that name its members."""
    folder, beta, fog = Path("results/scenes/synscapes"), "0.005", load("params.yaml").fog
    index, members, entries = {}, [], []
    for number in range(1, 7):
        write_frame(folder, number)
        label = encode_png(frame(number)[1][:24, :40])
        (folder / f"{number}.png").write_bytes(label)
        paths = synscapes.rgb(number), synscapes.depth(number)
        index |= {path: sha256(folder / path) for path in paths}
        clear = rendering.read_clear(*(folder / path for path in paths), *paths)
        light, _ = rendering.airlight_of(clear.image, rendering.KEEP)
        name = synscapes.foggy_name(number, beta)
        if recipe:
            name, data = uris.recipe(name), recipes.write(clear, CAMERA, fog, light, beta, number, index)
        else:
            rays = rendering.rays_of(clear, CAMERA, "", fog.geometry)
            (data,) = rendering.foggy_pngs(fog.model, clear, rays, light, [beta], 0)
        members.append((name, data))
        entries.append([uris.of_fog(beta, "0000", name), sha256_bytes(data), f"synscapes:{number}.png"])
        entries[-1].append(sha256_bytes(label))
    write_shard("results/fog/beta_0.005/0000.tar", members)
    write_list(row, "train", entries[:4])
    write_list(row, "validation", entries[4:])


def test_fog_on_the_fly_trains_the_same_model_as_fog_ahead(project):
    models = []
    for recipe in (False, True):
        write_foggy_lists("C", recipe)
        assert train() == 0
        models.append(hashes()["model.safetensors"])
    assert models[0] == models[1]


def test_log_and_curve_are_there_while_it_trains(project, monkeypatch, capfd):
    interrupt(monkeypatch, 2)
    # What an engine writes to a log is there before the end: the curve up to the step that was cut off, and a speed.
    with open("results/logs/train/bisenet/C/seed-0/curves.csv") as file:
        assert [row["step"] for row in csv.DictReader(file)] == ["1", "2"]
    told = capfd.readouterr()
    assert "its curve so far is results/logs/train/bisenet/C/seed-0/curves.csv" in told.out
    assert "train bisenet C: 2 of 6 images, loss " in told.err
    assert "images/s" in told.err
    assert train() == 0
    curves = [
        Path(folder, "bisenet/C/seed-0/curves.csv").read_bytes() for folder in ("results/logs/train", "results/train")
    ]
    assert curves[0] == curves[1]
    assert "images/s" not in Path("results/train/bisenet/C/seed-0/run.json").read_text()
