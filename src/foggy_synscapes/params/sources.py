"""What is known of values that belong to one row or one network: the published ones, where they stand, and why.

What is true of a key wherever it stands is said in its section; here stands what one place in the file adds to that.
"""

from typing import NamedTuple


class Known(NamedTuple):
    """published : the paper's value; source : where it stands; note : anything else."""

    published: str | None = None
    source: str | None = None
    note: str | None = None

    def words(self) -> list[str]:
        """The facts as phrases."""
        published = f"published: {self.published}" if self.published is not None else None
        return [fact for fact in (published, self.source, self.note) if fact is not None]


RELEASED = "released RefineNet training code"
SFSU = "public SFSU fine-tuning code, of the same authors"
RECIPE = "in the public recipe of this network; the paper does not state it"
CLEAR = "section IV"

LISTS = {
    "subset.clear.C": Known("2,975 and 500 images", CLEAR),
    "subset.clear.C-control": Known(note="not in the paper: the clear-weather control, on the images of C"),
    "subset.partial.FC-498": Known("498 and 52 images", "sections IV.A and IV.D"),
    "subset.pure.FS-24500": Known("24,500 and 500 images", "section IV.A"),
    "subset.pure.FS-498": Known("the first 498 images", "section IV.B"),
    "subset.pure.FS-ImageNet": Known(note="the list of FS-24500, for a start without Cityscapes; section IV.D"),
    "subset.mixed.FC-FS-498": Known("498 images in Table I; 24,500 as section IV.C implies", "section IV.C"),
}
ROWS = {
    "train.rows.FC-498": Known("50 epochs", "section IV.A"),
    "train.rows.FS-24500": Known("1 epoch, validated every 125 iterations", "section IV.A"),
    "train.rows.FS-498": Known(source="not stated", note="as long as FC-498"),
    "train.rows.FC-FS-498": Known(source="not stated", note="as many iterations as FC-498"),
    "train.rows.C-control": Known(note="not in the paper: as many iterations as a fine-tuning, FC-498"),
    "train.rows.FS-ImageNet": Known(
        source="section IV.D: reported as worse than row C", note="directly on Foggy Synscapes, from ImageNet weights"
    ),
    "train.rows.FS-ImageNet.length": Known(source="not stated", note="as long as FS-24500"),
    "train.rows.FS-ImageNet.start": Known(note="BiSeNet starts from its own weights by its baseline's policy"),
}
REFINENET = {
    "backbone": Known("resnet101", "RefineNet paper"),
    "width": Known("64"),
    "decoder": Known("256"),
    "weights": Known("the public Cityscapes model"),
    "baseline": Known("null: the public Cityscapes model", "as in the SFSU paper"),
    "baseline.learning_rate": Known(note="from 0.02 on it diverges for some seeds on the stand-in"),
    "baseline.loss_stride": Known(note="4 is the output's own"),
    "fine_tuning.learning_rate": Known("0.00005", SFSU),
    "fine_tuning.schedule": Known("constant", SFSU),
    "fine_tuning.batch": Known("1", SFSU),
    "fine_tuning.crop": Known("[600, 600]", SFSU),
    "fine_tuning.scale": Known("[0.7, 1.3]", SFSU),
    "fine_tuning.class_balance": Known("true", "RefineNet's released code"),
    "fine_tuning.loss_stride": Known(note="4 is the output's own"),
}
BISENET = {
    "width": Known("64"),
    "decoder": Known("128"),
    "weights": Known("ImageNet"),
    "baseline.length": Known("80 epochs of 2,975 images", CLEAR),
    "baseline.validate": Known(source="not stated"),
    "baseline.learning_rate": Known("0.01", CLEAR, "times new_layer_rate for layers without start weights"),
    "baseline.schedule": Known("poly", CLEAR),
    "baseline.power": Known("0.9", CLEAR),
    "baseline.momentum": Known('"0.09" as printed', CLEAR, "0.9 in every related code"),
    "baseline.weight_decay": Known("0.0005", CLEAR),
    "baseline.norm_weight_decay": Known(source="TorchSeg's recipe"),
    "baseline.batch": Known("4", CLEAR),
    "baseline.crop": Known(note=f"[1024, 1024] {RECIPE}"),
    "baseline.scale": Known(note=f"[0.75, 2.0] {RECIPE}"),
    "baseline.loss_stride": Known(note="8 in TorchSeg's fast variant"),
    "baseline.new_layer_rate": Known("10.0", "BiSeNet's public recipe"),
    "fine_tuning.learning_rate": Known("0.001", "section IV: 10 x lower, the rest unchanged"),
    "fine_tuning.crop": Known(note=f"[1024, 1024] {RECIPE}"),
    "fine_tuning.scale": Known(note=f"[0.75, 2.0] {RECIPE}"),
    "fine_tuning.loss_stride": Known(note="8 in TorchSeg's fast variant"),
}
IMAGENET = {
    "learning_rate": Known("0.0005", f"{RELEASED}, from ImageNet weights"),
    "schedule": Known("constant", RELEASED, "then 0.1 x by hand"),
    "backbone_rate": Known("0.1", RELEASED),
    "freeze_batch_norm": Known("true", RELEASED),
}
KNOWN = {
    **LISTS,
    **ROWS,
    **{f"train.refinenet.{key}": known for key, known in REFINENET.items()},
    **{f"train.bisenet.{key}": known for key, known in BISENET.items()},
    **{f"train.rows.FS-ImageNet.start.refinenet.policy.{key}": known for key, known in IMAGENET.items()},
}
"""By dotted key."""
