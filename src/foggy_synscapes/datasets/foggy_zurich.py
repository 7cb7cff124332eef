"""Foggy Zurich on disk: `RGB/SEQ/ID.png`, `gt_labelIds/SEQ/ID.png`, `gt_labelTrainIds/SEQ/ID.png`, and lists.

Its ground truth has no train class. testv2 names 40 images, testv1 16.
Source: Dai, Sakaridis, Hecker and Van Gool, Curriculum Model Adaptation, IJCV 2020.
"""

from foggy_synscapes.datasets.lists import listed

# Paths below the root of image, labelIds and trainIds, by name, e.g. `GP010229/1508040913.0_frame_000955`.
image, labels, train_labels = "RGB/{}.png".format, "gt_labelIds/{}.png".format, "gt_labelTrainIds/{}.png".format


def list_path(kind: str, version: str = "testv2") -> str:
    """Path of the list of RGB, gt_labelIds or gt_labelTrainIds files below the root."""
    return f"lists_file_names/{kind}_{version}_filenames.txt"


DATASET = listed(
    "Foggy Zurich-test",
    "Foggy Zurich",
    lambda scenes: (list_path("RGB", scenes.zurich_list), list_path("gt_labelIds", scenes.zurich_list)),
    settings=("scenes.zurich_list",),
    pixels=1920 * 1080,
    tests=lambda scenes: 40 if scenes.zurich_list == "testv2" else 16,
    folders=("RGB", "gt_labelIds", "lists_file_names"),
    home="Foggy_Zurich.zip of the page of CMAda, Curriculum Model Adaptation, ETH Zurich",
)
