"""How a process computes: the settings of a GPU reach PyTorch, and a step waits for the device once."""

import importlib

import policies
import pytest
import torch
from torch.utils.data._utils.pin_memory import pin_memory

from foggy_synscapes.networks import NetworkConfig
from foggy_synscapes.networks.bisenet_layers import PooledNorm
from foggy_synscapes.networks.device import take
from foggy_synscapes.networks.network import build
from foggy_synscapes.networks.weights import Model, Preprocessing
from foggy_synscapes.provenance import runs
from foggy_synscapes.training.learner import Arithmetic, Learner
from foggy_synscapes.training.loader import Batch

pytestmark = pytest.mark.usefixtures("one_thread")
BISENET = NetworkConfig("bisenet", "resnet18", width=8, decoder=4, classes=4)
REFINENET = NetworkConfig("refinenet", "resnet18", width=8, decoder=4, classes=4, auxiliary=False)


@pytest.fixture
def settings():
    """PyTorch's settings of this process are put back."""
    yield
    take("cpu", 1)


def batch(count=4, size=64):
    random = torch.Generator().manual_seed(2)
    images = torch.randint(0, 256, (count, 3, size, size), dtype=torch.uint8, generator=random)
    labels = torch.randint(0, 4, (count, size, size), dtype=torch.uint8, generator=random)
    return Batch(images, labels, list(range(count)))


def learner(config=BISENET, policy=policies.POLICY, **arithmetic):
    torch.manual_seed(1)
    return Learner(Model(build(config), Preprocessing()), policy, Arithmetic(**arithmetic))


@pytest.mark.usefixtures("settings")
def test_on_a_cpu_auto_is_the_cpu_and_results_repeat():
    if torch.cuda.is_available():
        pytest.skip("there is a GPU, which auto takes")
    assert take("auto", 1) == take("cpu", 1) == "cpu"
    assert torch.are_deterministic_algorithms_enabled()
    assert torch.get_float32_matmul_precision() == "highest"
    with pytest.raises(ValueError, match=r"device: cuda, but PyTorch .* finds no GPU. Ask for cpu or auto"):
        take("cuda", 1)


@pytest.mark.usefixtures("settings")
@pytest.mark.parametrize("asked", [False, True])
def test_the_settings_of_a_gpu_reach_pytorch(monkeypatch, asked):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.delenv("CUBLAS_WORKSPACE_CONFIG", raising=False)
    assert take("auto", 1, tf32=asked, deterministic=asked, search=asked) == "cuda"
    # Resizing bilinearly on a GPU takes PyTorch's slow way exactly where this is on.
    assert torch.are_deterministic_algorithms_enabled() is asked
    assert torch.get_float32_matmul_precision() == ("high" if asked else "highest")
    assert torch.backends.cudnn.allow_tf32 is torch.backends.cudnn.benchmark is asked
    assert torch.backends.cudnn.deterministic is asked
    assert take("cpu", 1) == "cpu"
    assert torch.are_deterministic_algorithms_enabled()


def test_a_batch_is_pinned_by_pytorchs_loader(monkeypatch):
    pinned = []

    def pin(tensor):
        pinned.append(tensor)
        return tensor.clone(memory_format=torch.preserve_format)

    monkeypatch.setattr(torch.Tensor, "pin_memory", pin)
    given = batch()
    taken = pin_memory(given)
    assert isinstance(taken, Batch)
    assert pinned[0] is given.images
    assert pinned[1] is given.labels
    assert taken.images is not given.images
    assert taken.indices == given.indices


# What makes a GPU's queue run dry: each of these waits for all that was asked of it before.
WAITS = ("item", "tolist", "cpu", "numpy", "nonzero", "__float__", "__int__", "__bool__", "__index__")


@pytest.mark.parametrize("precision", ["float32", "bfloat16"])
@pytest.mark.parametrize("accumulate", [1, 2])
@pytest.mark.parametrize("config", [BISENET, REFINENET], ids=["bisenet", "refinenet"])
def test_a_step_waits_for_the_device_once(monkeypatch, config, accumulate, precision):
    teacher = learner(config, policies.changed(policies.POLICY, accumulate=accumulate), precision=precision)
    teacher.step(batch())
    counted = []
    for name in WAITS:
        whole = getattr(torch.Tensor, name)

        def count(tensor, *arguments, name=name, whole=whole, **more):
            # The optimiser counts its steps in a tensor that stays on the CPU; a loss comes in float64.
            counted.append(name)
            return whole(tensor, *arguments, **more)

        monkeypatch.setattr(torch.Tensor, name, count)
    teacher.step(batch())
    monkeypatch.undo()
    assert counted == ["__float__"]


def test_float16_scales_the_loss_and_learns_in_float32(monkeypatch):
    teacher = learner(precision="float16")
    assert teacher.scaler.is_enabled()
    exact = learner()
    assert teacher.step(batch()) == pytest.approx(exact.step(batch()), rel=0.05)
    for (name, ours), theirs in zip(teacher.network.named_parameters(), exact.network.parameters(), strict=True):
        assert ours.dtype == torch.float32, name
        assert torch.isfinite(ours).all(), name
        assert ours.grad is not None, name
        assert theirs.grad is not None, name
    # A scale that overflows skips the step and halves itself.
    before = {name: tensor.clone() for name, tensor in teacher.network.named_parameters()}
    teacher.scaler.load_state_dict({**teacher.scaler.state_dict(), "scale": 2.0**40})
    teacher.step(batch())
    assert all(torch.equal(tensor, before[name]) for name, tensor in teacher.network.named_parameters())
    assert teacher.scaler.get_scale() == 2.0**39


def test_one_image_a_pass_trains_bisenet():
    policy = policies.changed(policies.POLICY, accumulate=4, loss="cross_entropy", learning_rate=0.01)
    teacher = learner(policy=policy)
    losses = [teacher.step(batch()) for _ in range(12)]
    assert losses[-1] < losses[0]
    norm = teacher.network.whole.bn
    assert isinstance(norm, PooledNorm)
    assert int(norm.num_batches_tracked) == 0  # a mean with momentum asks for no count
    assert float(norm.running_mean.abs().max()) > 0


def test_a_single_pooled_value_is_normalised_by_what_came_before():
    norm = PooledNorm(2).train()
    norm.running_mean.copy_(torch.tensor([1.0, 2.0]))
    norm.running_var.copy_(torch.tensor([4.0, 9.0]))
    found = norm(torch.tensor([3.0, 8.0]).view(1, 2, 1, 1))
    assert found.flatten().tolist() == pytest.approx([1.0, 2.0], rel=1e-4)
    # A tenth of the way, by momentum: the variance to (3 - 1)^2 and (8 - 2)^2.
    assert norm.running_mean.tolist() == pytest.approx([1.2, 2.6])
    assert norm.running_var.tolist() == pytest.approx([4.0, 11.7])
    whole = torch.rand(3, 2, 1, 1)
    plain = torch.nn.BatchNorm2d(2).train()
    plain.load_state_dict(norm.state_dict())
    assert torch.equal(norm(whole), plain(whole))


def test_a_gpu_is_recorded_by_what_decides_its_bytes(monkeypatch):
    monkeypatch.setattr(torch.cuda, "get_device_name", lambda: "NVIDIA Something")
    monkeypatch.setattr(torch.backends.cudnn, "version", lambda: 91002)
    monkeypatch.setattr(torch.version, "cuda", "13.0")
    found = runs.gpu()
    assert sorted(found) == ["cuda", "cudnn", "driver", "model"]
    assert (found["model"], found["cuda"], found["cudnn"]) == ("NVIDIA Something", "13.0", "91002")
    assert importlib.import_module("json").dumps(found)
