"""From planar depth to distance along the ray, as the published code does it and as the camera really is."""

from dataclasses import dataclass

import numpy as np

from foggy_synscapes.camera import Camera

GEOMETRIES = ("paper", "exact")


@dataclass(frozen=True)
class Rays:
    """How much longer a pixel's ray is than its planar depth: sqrt((rows[y] + columns[x]) / scale).

    Parameters
    ----------
    rows : float64 (H,)
    columns : float64 (W,)
    scale : above 0; kept apart because the published formula divides last
    down, right : float64 (H,) and (W,), how far the ray of a row or column leads down or right per planar metre; None
        where only lengths are known. Models of fog that is not alike everywhere need them.
    """

    rows: np.ndarray
    columns: np.ndarray
    scale: float
    down: np.ndarray | None = None
    right: np.ndarray | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the images that these rays belong to."""
        return self.rows.size, self.columns.size

    def factor(self) -> np.ndarray:
        """Ray length per planar depth, float64 (H, W), at least 1."""
        return np.sqrt((self.rows[:, None] + self.columns[None, :]) / self.scale)

    def crop(self, top: int, left: int, height: int, width: int) -> "Rays":
        """Rays of a part of the image, in pixels."""
        rows, columns = slice(top, top + height), slice(left, left + width)
        down = None if self.down is None else self.down[rows]
        right = None if self.right is None else self.right[columns]
        return Rays(self.rows[rows], self.columns[columns], self.scale, down, right)

    def directions(self) -> tuple[np.ndarray, np.ndarray]:
        """`down` and `right`; ValueError where only lengths are known."""
        if self.down is None or self.right is None:
            raise ValueError("rays: without directions, which this fog model needs. Give planar depth and its camera")
        return self.down, self.right


def rays(camera: Camera, geometry: str = "paper", shape: tuple[int, int] | None = None) -> Rays:
    """Rays of a camera.

    `paper` numbers pixels from 1 and takes fx on both axes, as the published code does;
    `exact` takes fx and fy and pixel centres (column + 0.5, row + 0.5), rows and columns from 0.
    The two differ by at most 1 grey level in the fog on the real samples.

    Parameters
    ----------
    camera : in pixels
    geometry : "paper" or "exact"
    shape : rows and columns, where the image is not as large as the camera says (the published code never looks)

    Source: paper, section III; published code.

    >>> camera = Camera(fx=2.0, fy=2.0, u0=1.0, v0=1.0, resx=2, resy=1)
    >>> rays(camera).factor()               # distances of 0 and 1 pixel from the axis, 2 pixels in front of it
    array([[1.        , 1.11803399]])
    >>> rays(camera, "exact").factor()      # 0.5 pixels on both axes: sqrt(1 + 2 * 0.25^2)
    array([[1.06066017, 1.06066017]])
    """
    height, width = shape or (camera.resy, camera.resx)
    if geometry == "paper":
        across = np.arange(1, width + 1) - camera.u0
        down = np.arange(1, height + 1) - camera.v0
        return Rays(camera.fx**2 + down**2, across**2, camera.fx**2, down / camera.fx, across / camera.fx)
    if geometry == "exact":
        across = (np.arange(width) + 0.5 - camera.u0) / camera.fx
        down = (np.arange(height) + 0.5 - camera.v0) / camera.fy
        return Rays(1 + down**2, across**2, 1.0, down, across)
    raise ValueError(f"geometry: {geometry!r}, expected {' or '.join(GEOMETRIES)}")


def camera_from_window(
    zoom: float, columns: tuple[float, float], rows: tuple[float, float], resx: int, resy: int
) -> Camera:
    """Camera from what Synscapes writes into the headers of its depth files.

    Parameters
    ----------
    zoom : focal length per width of the undistorted image (`camera:zoom`)
    columns, rows : part of that image that was rendered, as shares from left to right and from bottom to top
        (`image:window`); it may reach beyond 0 and 1
    resx, resy : pixels

    On the real samples it agrees with their JSON within 4e-6 of the width.

    >>> camera_from_window(1.0, (0.0, 1.0), (0.0, 1.0), 200, 100)
    Camera(fx=200.0, fy=200.0, u0=100.0, v0=50.0, resx=200, resy=100)
    """
    wide, high = columns[1] - columns[0], rows[1] - rows[0]
    return Camera(
        fx=zoom * resx / wide,
        fy=zoom * resx / high,
        u0=resx * (0.5 - columns[0]) / wide,
        v0=resy * (rows[1] - 0.5) / high,
        resx=resx,
        resy=resy,
    )


def straight(shape: tuple[int, int]) -> Rays:
    """Rays for distances that lie along the ray already: a factor of 1 everywhere."""
    return Rays(np.ones(shape[0]), np.zeros(shape[1]), 1.0)
