"""Changed files given to every reader, and what became of each: python tests/helpers/fuzz.py COUNT [SEED] [READER ...]

Each batch runs in a process of its own, watched from here: what does not end within a time limit counts as a hang.
"""

import contextlib
import hashlib
import io
import json
import os
import resource
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

OUTCOMES = ("refused by name", "same output", "other output", "accepted", "unnamed", "traceback", "hang")
"""accepted: what no reader may take, such as damage that a checksum of the format tells."""
IN_FOLDER = ("settings.json", "airlight.csv", "made.csv")
BAD = ("accepted", "unnamed", "traceback", "hang")
KINDS = ("fifo", "socket", "folder", "device", "endless", "dangling", "loop", "sparse", "system")
LINKS = {"device": "/dev/null", "endless": "/dev/zero", "dangling": "nowhere", "system": "/proc/kmsg"}
LIMIT, START = 10, 120  # seconds without an answer: a hang; for what a reader imports
MEMORY = 12 << 30  # bytes of address space; libraries take 4: what is read without bound ends here
ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Reader:
    """One way of reading a file.

    file : what is changed; content : of a good one; read : what comes out of a path; how : it is changed
    mended : made again where it is wrong, instead of refused; member : of a shard, which can be no FIFO or the like
    """

    name: str
    file: str
    content: Callable[[], bytes]
    read: Callable[[Path], object]
    how: str
    mended: bool = False
    member: bool = False


@dataclass
class Counts:
    """Outcomes by reader, and examples of those that are bad."""

    outcomes: dict[str, Counter] = field(default_factory=dict)
    examples: list[str] = field(default_factory=list)

    def total(self) -> Counter:
        return sum(self.outcomes.values(), Counter())

    def add(self, reader: str, outcome: str, message: str, what: str) -> None:
        """Count one input, `what`, of a reader."""
        self.outcomes[reader][outcome] += 1
        if outcome in BAD:
            self.examples.append(f"{reader}: {outcome}: {what}: {message[-500:]}")

    def bad(self) -> int:
        return sum(self.total()[outcome] for outcome in BAD)

    def __str__(self) -> str:
        wide = max(map(len, self.outcomes))
        rows = [("", OUTCOMES), *((name, [found[each] for each in OUTCOMES]) for name, found in self.outcomes.items())]
        rows.append(("all", [self.total()[outcome] for outcome in OUTCOMES]))
        return "\n".join(f"{name:<{wide}}" + "".join(f"{cell!s:>17}" for cell in cells) for name, cells in rows)


def rgb() -> np.ndarray:
    return np.random.default_rng(1).integers(0, 256, (24, 40, 3), dtype=np.uint8)


def depth() -> np.ndarray:
    return (1 + 200 * np.random.default_rng(2).random((24, 40))).astype(np.float32)


def ids() -> np.ndarray:
    return np.random.default_rng(3).integers(0, 34, (24, 40)).astype(np.uint8)


def exr_content(**header: object) -> bytes:
    import OpenEXR

    more = {"image:window": (np.float32([0, 1]), np.float32([0, 1])), "camera:zoom": 10.0, **header}
    buffer = io.BytesIO()
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **more}, {"Z": depth()}).write(
        buffer
    )
    return buffer.getvalue()


def jpeg_content() -> bytes:
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(rgb()).save(buffer, "jpeg", quality=90)
    return buffer.getvalue()


def written(write: Callable[[Path], object]) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder) / "file")
        return (Path(folder) / "file").read_bytes()


def tar_content() -> bytes:
    from foggy_synscapes.io.shards import write_shard

    return written(lambda path: write_shard(path, [(f"{n}.png", bytes([n]) * 300) for n in range(4)]))


def camera_content() -> bytes:
    from fog_frames import camera_json

    return camera_json().encode()


def meta_content() -> bytes:
    from foggy_synscapes.datasets.synscapes import SCENE_KEYS

    scene = {key: number / 7 for number, key in enumerate(SCENE_KEYS)}
    return json.dumps({**json.loads(camera_content()), "scene": scene, "instance": {"1": {"class": 26}}}).encode()


def metrics_content() -> bytes:
    from foggy_synscapes.scoring.metrics import summarize

    return json.dumps(summarize(np.random.default_rng(0).integers(1, 99, (19, 20)), 3)).encode()


def record_content() -> bytes:
    record = {"command": ["foggy", "filter"], "inputs": {"a.csv": "0" * 64}, "outputs": {"results/b.csv": "1" * 64}}
    return json.dumps({**record, "code": {"fog": "2" * 64}, "params": {"fog.betas": ["0.01"]}, "processes": 1}).encode()


def model_content() -> bytes:
    import torch

    from foggy_synscapes.networks.config import NetworkConfig, Preprocessing
    from foggy_synscapes.networks.network import build
    from foggy_synscapes.networks.weights import dump

    torch.manual_seed(0)
    return dump(build(NetworkConfig("bisenet", "resnet18", width=8, decoder=4, classes=19)), Preprocessing())


def pickle_content() -> bytes:
    import torch

    buffer = io.BytesIO()
    torch.save({"state_dict": {"conv1.weight": torch.ones(8, 3, 7, 7), "bn1.running_mean": torch.ones(8)}}, buffer)
    return buffer.getvalue()


def matlab_content() -> bytes:
    import h5py

    def write(path: Path) -> None:
        with h5py.File(path, "w") as file:
            group = file.create_group("net")
            group["filters"], group["biases"] = np.ones((4, 3, 2, 2), np.float32), np.ones((4, 1), np.float32)

    return written(write)


def of(module: str, name: str, *arguments: object) -> Callable[[Path], object]:
    """Reads a path by a function of the project, which is imported when it is first needed."""

    def read(path: Path) -> object:
        return getattr(__import__(f"foggy_synscapes.{module}", fromlist=[name]), name)(path, *arguments)

    return read


def read_shard(path: Path) -> object:
    from foggy_synscapes.io.shards import Shard

    with Shard(path) as shard:
        return [(name, shard.read(name)) for name in shard.names()]


def read_listed(path: Path) -> object:
    from foggy_synscapes.datasets import lists

    return lists.read_list(path.parent, path.name)


def read_refined(path: Path) -> object:
    from foggy_synscapes.datasets import foggy_cityscapes

    return foggy_cityscapes.read_refined(path.parent, path.name)


def read_model(path: Path) -> object:
    model = of("stages.tradeoff", "_model")(path)
    return [value.numpy().tobytes() for value in model.network.state_dict().values()], model.preprocessing


def read_metrics(path: Path) -> object:
    read_scores = of("scoring.metrics", "read_scores")
    return read_scores(path) if os.path.lexists(path) else None


def read_weights(path: Path) -> object:
    return {name: value.numpy() for name, value in of("stages.weights", "_read")(path).items()}


def params_of(path: Path) -> object:
    return of("params", "load")(path).model_dump()


def composite(path: Path) -> object:
    """A recipe comes out of a shard: what reads it is given bytes."""
    from foggy_synscapes.frames.compositing import composite
    from foggy_synscapes.io.images import encode_depth, encode_png

    def read(uri: str, sha256: str) -> bytes:
        return encode_depth(depth()) if uri.endswith(".exr") else encode_png(rgb())

    return composite(path.read_bytes(), read, str(path))


def recipe_content() -> bytes:
    from foggy_synscapes.frames import recipes, rendering

    clear = rendering.Clear(rgb(), depth(), "rgb", "depth", 0)
    about = {
        "airlight": [251, 255, 249], "beta": "0.02", "geometry": "paper", "model": "homogeneous",
        "camera": {"fx": 44.0, "fy": 45.0, "u0": 20.5, "v0": 11.5, "resx": 40, "resy": 24},
        "inputs": [["synscapes:img/rgb/1.png", "0" * 64], ["synscapes:img/depth/1.exr", "1" * 64]],
    }  # fmt: skip
    digest = hashlib.sha256(recipes.pixels_of(clear, about).tobytes()).hexdigest()
    return json.dumps({**about, "pixels": digest}).encode()


def foggy(path: Path) -> object:
    """`foggy fog` on a frame of which one file is changed, or in a folder where one is."""
    from fog_frames import tree

    from foggy_synscapes.cli import main
    from foggy_synscapes.errors import FoggyError

    place, out = Path.cwd(), Path.cwd() / "out"
    if path.name in IN_FOLDER:
        shutil.copytree(place / "made", out)
        (out / path.name).unlink(missing_ok=True)
        path.rename(out / path.name)
    elif out.exists():
        shutil.rmtree(out)
    call = ["fog", "--rgb", str(place / "rgb"), "--depth", str(place / "depth"), "--camera", str(place / "camera.json")]
    told = io.StringIO()
    with contextlib.redirect_stderr(told), contextlib.redirect_stdout(io.StringIO()):
        status = main([*call, "--beta", "0.02", "--out", str(out)])
    if status:
        raise FoggyError(told.getvalue())
    return {name: data for name, data in tree(out).items() if not name.startswith("settings")}


def read_given(path: Path) -> object:
    """Depth, or a camera, of any format."""
    from foggy_synscapes.frames.cameras import parse
    from foggy_synscapes.io.depth_files import FORMATS, read_stored
    from foggy_synscapes.io.files import read_bytes

    data = read_bytes(path)
    return read_stored(data, path) if path.suffix in FORMATS else vars(parse(data, path, Path("image_02/0.png")))


def array_content(ending: str) -> bytes:
    """Depth as NumPy saves it."""
    buffer = io.BytesIO()
    values = depth()
    np.save(buffer, values) if ending == "npy" else np.savez_compressed(buffer, depth=values)
    return buffer.getvalue()


KITTI = b"calib_time: 09-Jan-2012\nS_rect_02: 4.0e+01 2.4e+01\nP_rect_02: 44 0 20 2 0 44 12 0 0 0 1 0\n"
FRAMES = b"frame cameraID K[0,0] K[1,1] K[0,2] K[1,2]\n0 2 44 44 20 12\n"


def png_of(make: Callable[[], np.ndarray]) -> Callable[[], bytes]:
    from foggy_synscapes.io.images import encode_png

    return lambda: encode_png(make())


TABLE = b"name,size,sha256\n" + b"".join(b"%05d.png,%d,%s\n" % (n, 7 * n, b"0" * 64) for n in range(5))
INDEX = TABLE.replace(b"name", b"path")
LIST = "".join(f"RGB/a/{n}.png\n" for n in range(5)).encode()
REFINED = "".join(f"train/aachen/aachen_{n:06d}_000019\n" for n in range(5)).encode()


def params_content() -> bytes:
    return (ROOT / "params/smoke.yaml").read_bytes()


def made_content() -> bytes:
    """Of files in the folder that `foggy fog` writes to, it is what it wrote there."""
    return b""


READERS = (
    Reader("RGB PNG", "a.png", png_of(rgb), of("io.images", "read_rgb"), "png"),
    Reader("label PNG", "a.png", png_of(ids), of("io.images", "read_ids"), "png"),
    Reader("16-bit PNG", "a.png", png_of(lambda: ids().astype(np.uint16) * 900), of("io.images", "read_grey16"), "png"),
    Reader("JPEG", "a.jpg", jpeg_content, of("io.images", "read_rgb"), "jpeg"),
    Reader("EXR", "a.exr", exr_content, of("io.images", "read_depth"), "exr"),
    Reader("camera in EXR", "a.exr", exr_content, of("frames.rendering", "read_camera"), "exr"),
    Reader("shard", "0000.tar", tar_content, read_shard, "tar"),
    Reader("manifest", "0000.csv", lambda: TABLE, of("io.shards", "read_manifest"), "csv"),
    Reader("index", "all.csv", lambda: INDEX, of("datasets.index", "read_index"), "csv"),
    Reader("table", "a.csv", lambda: TABLE, of("io.tables", "read_csv", ("name",)), "csv"),
    Reader("list", "list.txt", lambda: LIST, read_listed, "text"),
    Reader("refined list", "list.txt", lambda: REFINED, read_refined, "text"),
    Reader("camera", "camera.json", camera_content, of("datasets.synscapes", "read_camera"), "json_tree"),
    Reader("meta", "1.json", meta_content, of("datasets.synscapes", "read_meta"), "json_tree"),
    Reader("metrics", "metrics.json", metrics_content, read_metrics, "json_tree"),
    Reader("run record", "run.json", record_content, of("provenance.runs", "read_run"), "json_tree"),
    Reader("recipe", "recipe.json", recipe_content, composite, "json_tree", member=True),
    Reader("params", "params.yaml", params_content, params_of, "yaml"),
    Reader("model", "model.safetensors", model_content, read_model, "safetensors"),
    Reader("weights", "weights.safetensors", model_content, read_weights, "safetensors"),
    Reader("pickle", "weights.pth", pickle_content, read_weights, "damage"),
    Reader("MATLAB", "weights.mat", matlab_content, read_weights, "damage"),
    Reader("depth .npy", "a.npy", lambda: array_content("npy"), read_given, "damage"),
    Reader("depth .npz", "a.npz", lambda: array_content("npz"), read_given, "damage"),
    Reader("depth EXR of any channel", "a.exr", exr_content, read_given, "exr"),
    Reader("camera of KITTI", "calib.txt", lambda: KITTI, read_given, "text"),
    Reader("camera of Virtual KITTI", "intrinsic.txt", lambda: FRAMES, read_given, "text"),
    Reader("fog: image", "rgb/a.png", png_of(rgb), foggy, "png"),
    Reader("fog: depth", "depth/a.exr", exr_content, foggy, "exr"),
    Reader("fog: camera", "camera.json", camera_content, foggy, "json_tree"),
    Reader("fog: settings", "settings.json", made_content, foggy, "json_tree"),
    Reader("fog: airlight", "airlight.csv", made_content, foggy, "csv", mended=True),
    Reader("fog: what was made", "made.csv", made_content, foggy, "csv", mended=True),
)  # fmt: skip


def digest(value: object) -> str:
    def plain(value: object) -> object:
        if isinstance(value, np.ndarray):
            return value.dtype.str, value.shape, value.tobytes()
        if isinstance(value, dict):
            return [(key, plain(each)) for key, each in value.items()]
        return [plain(each) for each in value] if isinstance(value, list | tuple) else value

    return hashlib.sha256(repr(plain(value)).encode("utf-8", "surrogatepass")).hexdigest()


def put(path: Path, kind: str) -> Any:
    """Something else in place of a file; what has to be kept alive while it is read."""
    path.unlink(missing_ok=True)
    if kind == "fifo":
        os.mkfifo(path)
    elif kind == "socket":
        listening = socket.socket(socket.AF_UNIX)
        listening.bind(os.path.relpath(path))
        return listening
    elif kind == "folder":
        path.mkdir()
    elif kind == "sparse":
        with open(path, "wb") as file:
            file.truncate(1 << 43)
    else:
        path.symlink_to(LINKS.get(kind, path.name))
    return None


def clear(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


class Case:
    """A reader and its good file, in a folder of its own."""

    def __init__(self, reader: Reader, folder: Path) -> None:
        self.reader, self.path = reader, folder / reader.file
        for name, content in (
            ("rgb/a.png", png_of(rgb)),
            ("depth/a.exr", exr_content),
            ("camera.json", camera_content),
        ):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content())
        self.good = reader.content()
        if reader.file in IN_FOLDER:
            foggy(folder / "none")
            (folder / "out").rename(folder / "made")
            self.good = (folder / "made" / reader.file).read_bytes()
        self.path.write_bytes(self.good)
        self.output = digest(reader.read(self.path))

    def outcome(self, refuse: bool) -> tuple[str, str]:
        """What becomes of the file that is there now."""
        from foggy_synscapes.errors import FoggyError

        try:
            found = digest(self.reader.read(self.path))
        except FoggyError as error:
            named = self.path.name in str(error)
            return ("refused by name" if named else "unnamed"), str(error)
        except Exception:
            return "traceback", traceback.format_exc()
        if refuse and not (self.reader.mended and found == self.output):
            return "accepted", ""
        return ("same output" if found == self.output else "other output"), ""


def child(names: list[str], count: int, seed: int, skip: int) -> None:
    """Try readers, each on other kinds of files and then on changed ones; a line before each of them and after it.

    skip : inputs of the first reader that were tried before
    """
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    for name in names:
        (reader,) = [each for each in READERS if each.name == name]
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            say("reader", name)
            try_reader(Case(reader, Path(folder)), count, seed, skip)
            os.chdir(ROOT)
        skip = 0


def try_reader(case: Case, count: int, seed: int, skip: int) -> None:
    import mutations
    from hypothesis import HealthCheck, Phase, given, settings
    from hypothesis import seed as seeded
    from hypothesis import strategies as st

    def try_one(what: str, refuse: bool) -> None:
        say("try", what)
        say(*case.outcome(refuse), what)

    kinds = () if case.reader.member else KINDS
    for kind in kinds[skip:count]:
        clear(Path("out"))
        clear(case.path)
        kept = put(case.path, kind)
        try_one(kind, refuse=kind not in ("device", "dangling"))  # that a file is not there, is said elsewhere
        del kept
    how, left = getattr(mutations, case.reader.how), count - max(len(kinds), skip)

    @seeded(seed + skip)
    @settings(
        max_examples=max(left, 1), database=None, deadline=None, phases=(Phase.generate,),
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(st.data())
    def changed(data: st.DataObject) -> None:
        new = how(data.draw, case.good)
        clear(Path("out"))
        clear(case.path)
        case.path.write_bytes(new.data)
        try_one(new.what, new.refuse and new.data != case.good)

    if left > 0:
        changed()


def say(*parts: str) -> None:
    print(json.dumps(parts), flush=True)


def lines(process: subprocess.Popen) -> Iterator[list[str] | None]:
    """What a child says; None where it says nothing for too long. It is given longer to import what a reader needs."""
    assert process.stdout is not None
    limit = START
    while select.select([process.stdout], [], [], limit)[0]:
        line = process.stdout.readline()
        if not line:
            return
        said = json.loads(line)
        limit = LIMIT if said[0] == "try" else START
        yield said
    yield None


def fuzz(count: int, seed: int, names: list[str]) -> Counts:
    """Outcomes of so many inputs for each reader."""
    counts = Counts({name: Counter() for name in names})
    left, tried = list(names), 0
    while left:
        call = [sys.executable, __file__, "--child", json.dumps([left, count, seed, tried])]
        process = subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        last = ""
        for said in lines(process):
            kind, *rest = said or ("hang", "", last)
            if kind == "reader":
                left = left[left.index(rest[0]) :]
            elif kind == "try":
                last = rest[0]
            else:
                counts.add(left[0], kind, *rest)
        process.kill()
        errors = process.communicate()[1]
        tried = counts.outcomes[left[0]].total()
        if process.returncode == 0:
            break
        if not last:
            raise RuntimeError(f"{left[0]}: its good file is not read: {errors[-2000:]}")
        if process.returncode != -signal.SIGKILL:  # by our own hand where it hung
            counts.add(left[0], "traceback", errors[-600:], last)
            tried += 1
        if tried >= count:
            left, tried = left[1:], 0
    return counts


def main(arguments: list[str]) -> int:
    """Print the counts; 1 where any is bad."""
    if arguments[:1] == ["--child"]:
        child(*json.loads(arguments[1]))
        return 0
    seed = int(arguments[1]) if len(arguments) > 1 else 0
    names = arguments[2:] or [reader.name for reader in READERS]
    counts = fuzz(int(arguments[0]), seed, names)
    print(counts)
    print("\n".join(counts.examples[:40]))
    return counts.bad() > 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
