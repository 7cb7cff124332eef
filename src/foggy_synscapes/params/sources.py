"""What is known of values that belong to one row or one network: the published ones, where they stand, and why.

What is true of a key wherever it stands is said in its section; here stands what one place in the file adds to that.
"""

KNOWN: dict[str, str] = {
    "subset.clear.C": "published: 2,975 and 500 images; section IV",
    "subset.clear.C-control": "not in the paper: the clear-weather control, on the images of C",
    "subset.partial.FC-498": "published: 498 and 52 images; sections IV.A and IV.D",
    "subset.pure.FS-24500": "published: 24,500 and 500 images; section IV.A",
    "subset.pure.FS-498": "published: the first 498 images; section IV.B",
    "subset.pure.FS-ImageNet": "the list of FS-24500, for a start without Cityscapes; section IV.D",
    "subset.mixed.FC-FS-498": "published: 498 images in Table I; 24,500 as section IV.C implies; section IV.C",
    "subset.mixed.FC-FS-24500": "24,500 as section IV.C implies: Foggy Cityscapes is repeated",
    "train.rows.FC-FS-24500": "not stated; as many images as FS-24500",
    "train.rows.FC-498": "published: 50 epochs; section IV.A",
    "train.rows.FS-24500": "published: 1 epoch, validated every 500 images; section IV.A",
    "train.rows.FS-498": "not stated; as long as FC-498",
    "train.rows.FC-FS-498": "not stated; at full size as many images as FC-498",
    "train.rows.C-control": "not in the paper: as many images as a fine-tuning, FC-498",
    "train.rows.FS-ImageNet": (
        "section IV.D: reported as worse than row C; directly on Foggy Synscapes, from ImageNet weights"
    ),
    "train.rows.FS-ImageNet.length": "not stated; as long as FS-24500",
    "train.rows.FS-ImageNet.start": "BiSeNet starts from its own weights by its baseline's policy",
    "train.refinenet.backbone": "published: resnet101; RefineNet paper",
    "train.refinenet.width": "published: 64",
    "train.refinenet.decoder": "published: 256",
    "train.refinenet.weights": "published: the public Cityscapes model",
    "train.refinenet.baseline": "published: null: the public Cityscapes model; as in the SFSU paper",
    "train.refinenet.baseline.learning_rate": "from 0.02 on it diverges for some seeds on the stand-in",
    "train.refinenet.baseline.loss_stride": "4 is the output's own",
    "train.refinenet.fine_tuning.learning_rate": (
        "published: 0.00005; public SFSU fine-tuning code, of the same authors"
    ),
    "train.refinenet.fine_tuning.schedule": "published: constant; public SFSU fine-tuning code, of the same authors",
    "train.refinenet.fine_tuning.batch": "published: 1; public SFSU fine-tuning code, of the same authors",
    "train.refinenet.fine_tuning.crop": "published: [600, 600]; public SFSU fine-tuning code, of the same authors",
    "train.refinenet.fine_tuning.scale": "published: [0.7, 1.3]; public SFSU fine-tuning code, of the same authors",
    "train.refinenet.fine_tuning.class_balance": "published: true; RefineNet's released code",
    "train.refinenet.fine_tuning.loss_stride": "4 is the output's own",
    "train.bisenet.width": "published: 64",
    "train.bisenet.decoder": "published: 128",
    "train.bisenet.weights": "published: ImageNet",
    "train.bisenet.baseline.length": "published: 80 epochs of 2,975 images; section IV",
    "train.bisenet.baseline.validate": "not stated",
    "train.bisenet.baseline.learning_rate": (
        "published: 0.01; section IV; times new_layer_rate for layers without start weights"
    ),
    "train.bisenet.baseline.schedule": "published: poly; section IV",
    "train.bisenet.baseline.power": "published: 0.9; section IV",
    "train.bisenet.baseline.momentum": 'published: "0.09" as printed; section IV; 0.9 in every related code',
    "train.bisenet.baseline.weight_decay": "published: 0.0005; section IV",
    "train.bisenet.baseline.norm_weight_decay": "TorchSeg's recipe",
    "train.bisenet.baseline.batch": "published: 4; section IV",
    "train.bisenet.baseline.crop": "[1024, 1024] in the public recipe of this network; the paper does not state it",
    "train.bisenet.baseline.scale": "[0.75, 2.0] in the public recipe of this network; the paper does not state it",
    "train.bisenet.baseline.loss_stride": "8 in TorchSeg's fast variant",
    "train.bisenet.baseline.new_layer_rate": "published: 10.0; BiSeNet's public recipe",
    "train.bisenet.fine_tuning.learning_rate": "published: 0.001; section IV: 10 x lower, the rest unchanged",
    "train.bisenet.fine_tuning.crop": "[1024, 1024] in the public recipe of this network; the paper does not state it",
    "train.bisenet.fine_tuning.scale": "[0.75, 2.0] in the public recipe of this network; the paper does not state it",
    "train.bisenet.fine_tuning.loss_stride": "8 in TorchSeg's fast variant",
    "train.rows.FS-ImageNet.start.refinenet.policy.learning_rate": (
        "published: 0.0005; released RefineNet training code, from ImageNet weights"
    ),
    "train.rows.FS-ImageNet.start.refinenet.policy.schedule": (
        "published: constant; released RefineNet training code; then 0.1 x by hand"
    ),
    "train.rows.FS-ImageNet.start.refinenet.policy.backbone_rate": "published: 0.1; released RefineNet training code",
    "train.rows.FS-ImageNet.start.refinenet.policy.freeze_batch_norm": (
        "published: true; released RefineNet training code"
    ),
}
"""By dotted key."""
