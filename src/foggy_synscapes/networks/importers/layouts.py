"""The layouts of public weights: those that the networks declare, and those of backbones alone."""

from collections.abc import Iterable

from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.networks.backbone_names import caffe_backbone, caffe_name, torchvision_backbone
from foggy_synscapes.networks.declaration import Layout
from foggy_synscapes.networks.preprocessing import Preprocessing

TORCHVISION = Layout(
    "torchvision",
    None,
    marks=(r"layer1\.0\.conv1\.weight", r"bn1\.running_mean"),
    backbone=torchvision_backbone,
    translate=lambda name, _config: name.removeprefix("backbone."),
    ignored=r"fc\.(weight|bias)",
)
CAFFE = Layout(
    "caffe",
    None,
    marks=(r"res2a_branch2a\.weight",),
    backbone=caffe_backbone,
    translate=caffe_name,
    preprocessing=Preprocessing("BGR", 1.0, (103.939, 116.779, 123.68), (1.0, 1.0, 1.0)),
    settings={"stride_in": "1x1"},
    ignored=r"fc1000\.(weight|bias)",
)


def layouts() -> dict[str, Layout]:
    """All layouts by name; those of backbones come last, as their names occur in files of whole networks too."""
    own = [layout for name in NETWORKS for layout in NETWORKS[name].layouts]
    return {layout.name: layout for layout in (*own, TORCHVISION, CAFFE)}


def detect(names: Iterable[str]) -> Layout:
    """The layout of a file by its tensors' names; ValueError if there is none, listing what is known."""
    names, known = list(names), layouts()
    found = next((layout for layout in known.values() if layout.fits(names)), None)
    # Light-weight forms of networks have torchvision's names in the backbone, and these in a decoder that is not ours.
    if found is None or (found.network is None and any(name.startswith("p_ims1d2") for name in names)):
        raise ValueError(
            f"unknown layout: {len(names)} tensors such as {sorted(names)[:4]}; known are {', '.join(known)}. "
            "Light-weight forms of networks are not among them."
        )
    return found
