"""Foggy Driving on disk: 33 finely labelled images in `test`, 68 coarsely labelled ones in `test_extra`.

`leftImg8bit/SPLIT/SOURCE/NAME_leftImg8bit.png` with `gtFine/test/SOURCE/NAME_gtFine_labelIds.png` or
`gtCoarse/test_extra/SOURCE/NAME_gtCoarse_labelIds.png`; SOURCE is pedestrian, public or web. Sizes vary.
Source: Sakaridis, Dai and Van Gool, Semantic Foggy Scene Understanding with Synthetic Data, IJCV 2018.
"""

from foggy_synscapes.datasets.lists import listed

IMAGES = "lists_file_names/leftImg8bit_testall_filenames.txt"
LABELS = "lists_file_names/gt_testall_filenames.txt"


def image(name: str, coarse: bool) -> str:
    """Path of an image, e.g. of `web/web_8050286343_fb56b08ce7`, below the root."""
    return f"leftImg8bit/{'test_extra' if coarse else 'test'}/{name}_leftImg8bit.png"


def labels(name: str, coarse: bool) -> str:
    """Path of the labelIds below the root."""
    return f"gtCoarse/test_extra/{name}_gtCoarse_labelIds.png" if coarse else f"gtFine/test/{name}_gtFine_labelIds.png"


DATASET = listed(
    "Foggy Driving",
    "Foggy Driving",
    lambda _scenes: (IMAGES, LABELS),
    pixels=1280 * 960,  # counted as if all had this size
    tests=lambda _scenes: 101,
    folders=("leftImg8bit", "gtFine", "gtCoarse", "lists_file_names"),
    home="Foggy_Driving.zip of the page of SFSU, Semantic Foggy Scene Understanding with Synthetic Data, ETH Zurich",
)
