"""The functions of the package for notebooks and programs: fog, scores and depth, on arrays or files.

Images are uint8 (H, W, 3), distances metres, densities of fog 1/m, ids of classes as Cityscapes has them. Wrong arrays
raise ValueError; files that are missing, damaged or of another kind raise FoggyError, which names them.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog import optics
from foggy_synscapes.fog.airlight import Airlight, estimate
from foggy_synscapes.fog.geometry import Rays, rays, straight

__all__ = [
    "Airlight",
    "Camera",
    "FoggyError",
    "airlight",
    "attenuation",
    "complete",
    "distance",
    "fog",
    "read_camera",
    "read_depth",
    "read_image",
    "score",
    "transmittance",
    "visibility",
]

File = str | Path
Image = np.ndarray | File
Several = float | Sequence[float] | np.ndarray


def fog(
    image: Image,
    depth: Image,
    beta: Several = 0.02,
    camera: Camera | File | None = None,
    *,
    airlight: Airlight | Sequence[int] | None = None,
    geometry: str = "paper",
    depth_is: str = "z",
    model: str = "homogeneous",
) -> np.ndarray:
    """Fog on an image: uint8 (H, W, 3), or (B, H, W, 3) where several betas are given.

    The pixels are those of `foggy fog`, which are those of the published code.

    Parameters
    ----------
    image : uint8 (H, W, 3), or a file of 8-bit RGB
    depth : float32 or float64 (H, W), metres, at least 0, infinity where nothing is; or a file of such metres, see
        `read_depth`. Taken in float32, exact to 6e-8 of itself. 0 is a distance of 0, where no fog is; `foggy fog
        --rgb` refuses it unless --missing says what it means
    beta : attenuation coefficient, 1/m, at least 0, one or several; 0 gives the image. See `attenuation`
    camera : of the image, or its JSON file; only where `depth_is` "ray" it can be left out
    airlight : three levels, 0 to 255; without it that of the image itself, see `airlight`
    geometry : "paper" or "exact", how depth becomes distance, see `distance`
    depth_is : "z", along the optical axis, as Synscapes and stereo have it, or "ray", along the ray of each pixel
    model : of fog, NAME or NAME:KEY=VALUE,..., as `foggy fog --model` has it, e.g. "layered:scale_height=10"

    Raises
    ------
    ValueError
        If shapes or types differ from these, a depth or beta is negative or not a number, there is no camera, or
        a value of the model is out of its range.
    FoggyError
        If a file is missing, damaged or of another kind, or there is no such model.

    Source: Koschmieder 1924; paper, equations (1) and (2): F = t R + (1 - t) L with t = exp(-beta l).

    >>> image, depth = np.full((1, 2, 3), 100, np.uint8), np.array([[100.0, np.inf]])
    >>> fog(image, depth, beta=np.log(2) / 100, depth_is="ray", airlight=(200, 200, 200)).tolist()
    [[[150, 150, 150], [200, 200, 200]]]
    >>> fog(image, depth, [0, 0.01, 0.02], depth_is="ray", airlight=(200, 200, 200))[:, 0, 0, 0].tolist()
    [100, 163, 186]
    """
    from foggy_synscapes.fog.models import chosen

    pixels, metres = _image(image), _depth(depth)
    optics.count_zero_depth(metres)
    light = estimate(pixels) if airlight is None else airlight
    levels = light.levels if isinstance(light, Airlight) else tuple(light)
    if any(not 0 <= level <= 255 for level in levels):
        raise ValueError(f"airlight: {levels}, expected three levels from 0 to 255")
    betas = np.asarray(beta, np.float64)
    if betas.ndim > 1:
        raise ValueError(f"beta: shape {betas.shape}, expected one number of 1/m, or several")
    which = _rays(metres.shape, camera, geometry, depth_is)
    foggy = chosen(model).images(pixels, metres, which, levels, betas.reshape(-1).tolist())
    return foggy[0] if betas.ndim == 0 else foggy


def transmittance(
    distance: Image, beta: Several = 0.02, camera: Camera | File | None = None, *, geometry: str = "paper"
) -> np.ndarray:
    """Share of light that comes through: float64, 0 to 1, of the shape of `distance`; (B, ...) for several betas.

    Parameters
    ----------
    distance : metres along the ray, any shape, at least 0, infinity allowed; with a camera: depth along the optical
        axis, (H, W), or a file of it
    beta : attenuation coefficient, 1/m, at least 0, one or several
    camera, geometry : as in `fog`

    Raises ValueError if a distance or beta is negative or not a number, or the camera is of another size; FoggyError as
    `fog` does.

    Source: Beer and Lambert's law; paper, equation (2): t = exp(-beta l).

    >>> transmittance([0, 100, np.inf], np.log(2) / 100).tolist()
    [1.0, 0.5, 0.0]
    >>> transmittance(100.0, [0, 0.01]).round(3).tolist()
    [1.0, 0.368]
    """
    along = _along(distance) if camera is None else _by_camera(distance, camera, geometry)
    betas = np.asarray(beta, np.float64)
    if betas.ndim == 0:
        return optics.transmittance(along, float(betas))
    return np.stack([optics.transmittance(along, float(each)) for each in betas])


def distance(depth: Image, camera: Camera | File, *, geometry: str = "paper") -> np.ndarray:
    """Distance along the ray of each pixel: float64 (H, W), metres, of depth along the optical axis.

    Parameters
    ----------
    depth : float32 or float64 (H, W), metres, or a file of it
    camera : of these images, or its JSON file
    geometry : "paper" counts pixels from 1 and takes fx on both axes, as the published code does; "exact" takes fx and
        fy and the centres of pixels

    Raises ValueError if the camera is of another size or the geometry unknown; FoggyError as `fog` does.

    Source: paper, section III; published code.

    >>> distance(np.full((1, 2), 10.0), Camera(fx=2, fy=2, u0=1, v0=1, resx=2, resy=1)).round(3).tolist()
    [[10.0, 11.18]]
    """
    return _by_camera(depth, camera, geometry)


def airlight(image: Image) -> Airlight:
    """Airlight of an image, the colour that fog has in it: three levels, 0 to 255, and the pixel that they are of.

    image : uint8 (H, W, 3), or a file of 8-bit RGB

    Raises ValueError if the array has another shape or type; FoggyError as `fog` does.

    Source: He, Sun and Tang, Single Image Haze Removal Using Dark Channel Prior, 2011; published code.

    >>> image = np.zeros((2, 2, 3), np.uint8)
    >>> airlight(image).levels
    (0, 0, 0)
    """
    return estimate(_image(image))


def visibility(beta: Several) -> Any:
    """Meteorological optical range in metres at an attenuation coefficient in 1/m: a number, or an array of them.

    Raises ValueError unless all betas are finite and above 0.

    Source: paper, section III: MOR = 2.996 / beta, at which a contrast of 5 % is left.

    >>> round(visibility(0.02), 1)
    149.8
    >>> visibility([0.005, 0.01]).round().tolist()
    [599.0, 300.0]
    """
    return _each(optics.meteorological_optical_range, beta)


def attenuation(visibility: Several) -> Any:
    """Attenuation coefficient beta in 1/m at a meteorological optical range in metres: a number, or an array of them.

    Raises ValueError unless all ranges are finite and above 0. Source: as `visibility`.

    >>> attenuation(150).__round__(5)
    0.01997
    """
    return _each(optics.attenuation, visibility)


def score(
    predictions: Any,
    labels: Any,
    *,
    encoding: str | None = None,
    predictions_encoding: str | None = None,
    labels_encoding: str | None = None,
    test_set: str | None = None,
    jobs: int = 1,
) -> dict[str, Any]:
    """Scores of predicted classes: what `foggy evaluate` writes as metrics.json, with IoU in percent.

    The result has "classes" (name, iou, tp, fp, fn of each of the 19 classes of Cityscapes; iou is None where no pixel
    is annotated), "mean_iou" ("annotated": over the annotated classes; "as_published": over all 19, absent ones as 0),
    "annotated_classes", "images", "confusion" (19 x 19 counts, rows are the truth) and further means.

    Parameters
    ----------
    predictions, labels : ids of classes, 0 to 255: an integer array (H, W), several of them, of equal size in pairs, or
        one array (N, H, W); or two folders of 8-bit grey PNG, paired by their names
    encoding : "trainIds" or "labelIds" of both, where the ids do not tell it; `predictions_encoding` and
        `labels_encoding` : of one
    test_set : name of a test set, such as "foggy_driving"; `labels` is then the folder that its archive unpacks to
    jobs : processes that read folders

    Raises
    ------
    ValueError
        If arrays are no ids, differ in number or size, the encoding is open or contradicted, or nothing is labelled.
    FoggyError
        The same of files, which it names.

    Source: Everingham et al., The PASCAL Visual Object Classes Challenge, 2010: IoU = tp / (tp + fp + fn).

    >>> truth, guess = np.array([[0, 0, 10, 255]]), np.array([[0, 10, 10, 10]])     # trainIds: road, sky, ignored
    >>> scores = score(guess, truth, encoding="trainIds")
    >>> [(each["name"], each["iou"]) for each in scores["classes"] if each["iou"] is not None]
    [('road', 50.0), ('sky', 50.0)]
    >>> scores["mean_iou"]["annotated"]
    50.0
    """
    from foggy_synscapes.datasets import scores

    guess, truth = predictions_encoding or encoding, labels_encoding or encoding
    if isinstance(predictions, File) and isinstance(labels, File):
        folders = Path(predictions), Path(labels)
        if test_set is not None:
            return scores.of_test_set(test_set, folders[1], folders[0], None, guess, jobs)
        return scores.of_folders(*folders, guess, truth, jobs)
    if test_set is not None or isinstance(predictions, File) or isinstance(labels, File):
        raise ValueError("predictions, labels: expected two folders, or arrays on both sides and no test_set")
    return scores.of_arrays(predictions, labels, guess, truth)


def complete(
    left: Image,
    right: Image,
    disparity: Image,
    camera: Camera | File,
    baseline: float | None = None,
    *,
    seed: int | None = None,
    superpixels: int = 2048,
) -> np.ndarray:
    """Depth at every pixel of the left view of a stereo camera: float64 (H, W), metres along the optical axis.

    Parameters
    ----------
    left, right : uint8 (H, W, 3), or files of 8-bit RGB
    disparity : of the left view as Cityscapes stores it, uint16 (H, W): 256 d + 1 pixels, 0 where none is known; or a
        16-bit PNG
    camera : of the left view, or a camera file of Cityscapes, which has the baseline too
    baseline : metres between both cameras
    seed : of the random permutations, 0 to 2^32 - 1 (default: the published one)
    superpixels : into how many parts of one plane each the image is divided; the published number

    Raises ValueError if shapes or types differ, the image is too small, no baseline is known, or too little disparity
    is reliable; FoggyError as `fog` does.

    Source: Sakaridis, Dai and Van Gool, Semantic Foggy Scene Understanding with Synthetic Data, 2018, section 3.2.

    >>> view = np.random.default_rng(0).integers(0, 256, (64, 96, 3), np.uint8)
    >>> camera = Camera(fx=100, fy=100, u0=48, v0=32, resx=96, resy=64)
    >>> moved = np.roll(view, -4, axis=1)                              # the right view, with everything 4 pixels off
    >>> depth = complete(view, moved, np.full((64, 96), 1 + 256 * 4, np.uint16), camera, 0.2, superpixels=16)
    >>> depth[32, 48].item()                                           # 0.2 metres * 100 pixels / 4 pixels
    5.0
    """
    from foggy_synscapes.depth import completion

    chosen = completion.SEED if seed is None else seed
    views, stored = (_image(left), _image(right)), _disparity(disparity)
    if isinstance(camera, File):
        from foggy_synscapes.frames.stereo import of_path, read_stereo

        stereo = read_stereo(of_path(Path(camera)), stored.shape[1], stored.shape[0])
    elif baseline is None:
        raise ValueError("baseline: missing; give the metres between both cameras, or a camera file of Cityscapes")
    else:
        stereo = completion.Stereo(camera, baseline)
    return completion.complete(*views, stored, stereo, chosen, superpixels).depth


def read_image(path: File) -> np.ndarray:
    """Read an image of 8-bit RGB, PNG, JPEG or TIFF: uint8 (H, W, 3). Raises FoggyError if it is anything else.

    >>> read_image("street.png")
    Traceback (most recent call last):
    foggy_synscapes.errors.FoggyError: street.png: missing...
    """
    from foggy_synscapes.io.images import read_rgb

    return read_rgb(Path(path))


def read_depth(path: File, scale: float | None = None) -> np.ndarray:
    """Read depth: float32 or float64 (H, W), metres, of any format that `foggy fog --depth` takes.

    scale : metres per stored unit, such as 0.001 for millimetres in a 16-bit PNG; without it the file has to hold
        metres as floating point. With it, not a number is where 0 is stored, which means that there is no depth;
        where that is the sky: `np.nan_to_num(depth, nan=np.inf)`

    Raises FoggyError if the file is missing, damaged or of another kind, or holds whole numbers without a scale.

    >>> read_depth("street.exr")
    Traceback (most recent call last):
    foggy_synscapes.errors.FoggyError: street.exr: missing...
    """
    from foggy_synscapes.frames import metres

    return metres.read(Path(path), scale)


def read_camera(path: File) -> Camera:
    """Read a camera, in pixels: JSON with fx, fy, u0, v0, resx, resy, or what else `foggy fog --camera` takes.

    Raises FoggyError if the file is anything else, or does not say how large the images are.

    >>> read_camera("camera.json")
    Traceback (most recent call last):
    foggy_synscapes.errors.FoggyError: camera.json: missing...
    """
    from foggy_synscapes.frames import cameras

    return cameras.read_camera(Path(path))


def _image(image: Image) -> np.ndarray:
    return read_image(image) if isinstance(image, File) else np.asarray(image)


def _depth(depth: Image) -> np.ndarray:
    """Depth in float32; ValueError if it is of another kind, so that neither levels nor ids pass for metres."""
    metres = read_depth(depth) if isinstance(depth, File) else np.asarray(depth)
    if metres.dtype == np.float32:
        return metres
    if metres.dtype != np.float64:
        raise ValueError(f"depth: {metres.dtype} {metres.shape}, expected float32 or float64 (H, W), in metres")
    with np.errstate(over="ignore"):  # beyond 3e38 metres lies infinity
        return metres.astype(np.float32)


def _by_camera(depth: Image, camera: Camera | File, geometry: str) -> np.ndarray:
    metres = np.asarray(read_depth(depth) if isinstance(depth, File) else depth, np.float64)
    return metres * _rays(metres.shape, camera, geometry, "z").factor()


def _along(distance: Image) -> np.ndarray:
    if isinstance(distance, File):
        raise ValueError("camera: missing; a depth file becomes distance along the ray by the camera")
    return np.asarray(distance, np.float64)


def _disparity(disparity: Image) -> np.ndarray:
    if isinstance(disparity, File):
        from foggy_synscapes.io.images import read_grey16

        return read_grey16(Path(disparity))
    return np.asarray(disparity)


def _rays(shape: tuple[int, ...], camera: Camera | File | None, geometry: str, depth_is: str) -> Rays:
    if len(shape) != 2:
        raise ValueError(f"depth: shape {shape}, expected (H, W)")
    if depth_is == "ray":
        return straight((shape[0], shape[1]))
    if depth_is != "z":
        raise ValueError(f"depth_is: {depth_is!r}, expected 'z' (along the optical axis) or 'ray'")
    if camera is None:
        raise ValueError("camera: missing; it turns depth into distance. Where it is distance: depth_is='ray'")
    if isinstance(camera, File):
        from foggy_synscapes.frames import cameras

        camera = cameras.read_camera(Path(camera), shape)
    if not isinstance(camera, Camera):
        raise ValueError(f"camera: {type(camera).__name__}, expected Camera or a file")
    if (camera.resy, camera.resx) != shape:
        size = f"{shape[1]} x {shape[0]}"
        raise ValueError(
            f"camera: of {camera.resx} x {camera.resy} pixels, but depth has {size}; give that of the images"
        )
    return rays(camera, geometry)


def _each(function: Any, values: Several) -> Any:
    numbers = np.asarray(values, np.float64)
    if numbers.ndim == 0:
        return function(float(numbers))
    return np.array([function(float(each)) for each in numbers.reshape(-1)]).reshape(numbers.shape)
