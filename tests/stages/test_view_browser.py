"""The pages in a real browser: levels, dragging, swiping, keys and small screens."""

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from browser import WHY_NOT, Browser, found

from foggy_synscapes.camera import Camera
from foggy_synscapes.fog.airlight import Airlight, estimate
from foggy_synscapes.fog.geometry import Rays, rays
from foggy_synscapes.fog.optics import foggy_images, transmittance_images
from foggy_synscapes.frames.rendering import read_camera
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.images import read_depth, read_rgb
from foggy_synscapes.io.pictures import encode_jpeg
from foggy_synscapes.labels import IGNORE, PALETTE
from foggy_synscapes.view.colours import RIGHT, SAFE, WRONG
from foggy_synscapes.view.frame import BETAS, frame_page
from foggy_synscapes.view.planes import distances
from foggy_synscapes.view.predictions import Row, Shown, predictions_page

pytestmark = pytest.mark.skipif(found() is None, reason=WHY_NOT)
SIZE = (60, 120)
PAINTERS = ("WebGL", "canvas")
PHONE = (390, 844)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with Browser() as opened:
        yield opened


def scene() -> tuple[np.ndarray, np.ndarray, Rays]:
    """A frame of noise in front of an infinite sky, with one pixel of missing depth."""
    rng = np.random.default_rng(5)
    image = rng.integers(0, 256, (*SIZE, 3), dtype=np.uint8)
    depth = np.exp(rng.uniform(1, 7, SIZE)).astype(np.float32)
    depth[:10], depth[30, 60] = np.inf, 0
    return image, depth, rays(Camera(fx=100, fy=100, u0=60, v0=30, resx=SIZE[1], resy=SIZE[0]))


def shown(browser: Browser, change: str, shape: tuple[int, ...] = SIZE) -> np.ndarray:
    """What the page draws: uint8 (H, W, 3)."""
    found = np.frombuffer(browser.bytes(f"view.pixels({change})"), np.uint8).reshape(*shape, 4)
    assert (found[..., 3] == 255).all()
    return found[..., :3]


@pytest.fixture
def frame(browser: Browser, tmp_path: Path) -> tuple[np.ndarray, np.ndarray, Rays, Airlight]:
    """A frame, whose page is open."""
    image, depth, lines = scene()
    light = estimate(image)
    write_text(tmp_path / "frame.html", frame_page("frame.png", image, depth, lines, light, light, 0.02))
    browser.resize(1500, 1000)
    browser.open(tmp_path / "frame.html")
    yield image, depth, lines, light
    assert browser.complaints() == []


def beta(browser: Browser) -> float:
    return browser.run("view.state.beta")


@pytest.mark.parametrize("painter", PAINTERS)
def test_the_browser_draws_the_rendered_image_within_one_level(browser: Browser, frame: tuple, painter: str) -> None:
    image, depth, lines, light = frame
    browser.run(f"view.choose('{painter}')")
    assert browser.run("view.painter()") == painter
    rendered = foggy_images(image, depth, lines, light.levels, [0, *map(float, BETAS), 7])
    bound = 2 * (distances(lines.factor() * depth).worst() + 0.001)
    for wanted, one in zip(("0", *BETAS, "7"), rendered, strict=True):
        differs = np.abs(shown(browser, f"{{beta: {wanted}}}").astype(int) - one)
        assert differs.max() <= 1
        assert differs.mean() <= bound
    through = transmittance_images(depth, lines, [0.02])[0].astype(int)
    assert np.abs(shown(browser, "{beta: 0.02, shown: 1}")[..., 0] - through).max() <= 1
    assert (shown(browser, "{beta: 0.02, shown: 0, light: [9, 8, 7]}")[0, 0] == (9, 8, 7)).all()


def test_a_real_frame_is_drawn_within_one_level_and_opens_soon(
    browser: Browser, real_data: Path, tmp_path: Path
) -> None:
    folder = real_data / "synscapes"
    image, depth = read_rgb(folder / "img/rgb/1.png"), read_depth(folder / "img/depth/1.exr")
    lines, light = rays(read_camera(folder / "camera.json")), estimate(image)
    page = frame_page("1.png", image, depth, lines, light, light, 0.02)
    assert len(page) < 5e6
    write_text(tmp_path / "real.html", page)
    browser.resize(1500, 1000)
    browser.open(tmp_path / "real.html")
    # A second on an idle machine; other work on this one makes it longer.
    assert browser.run("await view.ready") < 10_000
    rendered = foggy_images(image, depth, lines, light.levels, [float(each) for each in BETAS])
    for painter in PAINTERS:
        browser.run(f"view.choose('{painter}')")
        for wanted, one in zip(BETAS, rendered, strict=True):
            differs = np.abs(shown(browser, f"{{beta: {wanted}}}", image.shape[:2]).astype(int) - one)
            assert (differs.max(), differs.mean() < 0.002) == (1, True)


def test_dragging_the_slider_changes_the_fog_and_what_is_drawn(browser: Browser, frame: tuple) -> None:
    before = shown(browser, "{}")
    seen = []
    for share in (0.2, 0.5, 0.9, 1.0):
        browser.drag("#density", [share], "#density")
        seen.append(beta(browser))
        browser.run("view.set({beta: 0.02})")
    assert seen == sorted(seen)
    assert seen[0] < 1e-3 < 0.1 < seen[-1]
    browser.drag("#density", [0.5, 0.8, 0.9], "#density")
    assert (shown(browser, "{}") != before).any()
    assert float(browser.run("document.getElementById('visibility').value")) == pytest.approx(
        2.996 / beta(browser), rel=0.01
    )


def test_numbers_and_buttons_set_density_and_visibility(browser: Browser, frame: tuple) -> None:
    browser.click("#betas button:nth-child(6)")
    assert beta(browser) == 0.06
    browser.run(
        "const field = document.getElementById('visibility'); field.value = 599.2;"
        "return void field.dispatchEvent(new Event('input'));"
    )
    assert beta(browser) == pytest.approx(0.005)
    browser.click("#betas button:first-child")
    assert beta(browser) == 0
    assert (shown(browser, "{}") == frame[0]).all()


def test_the_cursor_tells_distance_and_transmittance(browser: Browser, frame: tuple) -> None:
    image, depth, lines, _ = frame
    row, column = 40, 30
    left, top, width, height = browser.box("#stage")
    browser.run("view.set({beta: 0.01})")
    browser.mouse("move", left + (column + 0.5) / SIZE[1] * width, top + (row + 0.5) / SIZE[0] * height)
    said = browser.run("document.getElementById('readout').textContent")
    metres = float((lines.factor() * depth)[row, column])
    assert said.startswith(f"row {row}, column {column}: {metres:.4g} m, transmittance {np.exp(-0.01 * metres):.4f}")
    assert f"clear {' '.join(map(str, image[row, column]))} →" in said
    browser.mouse("move", left + 5, top + 5)
    assert "infinitely far, transmittance 0.0000" in browser.run("document.getElementById('readout').textContent")


def test_airlight_is_picked_from_the_image_and_estimated_again(browser: Browser, frame: tuple) -> None:
    image, _, _, light = frame
    browser.click("#pick")
    browser.click("#stage", 50.5 / SIZE[1], 20.5 / SIZE[0])
    assert browser.run("view.state.light") == image[20, 50].tolist()
    browser.key("e")
    assert browser.run("view.state.light") == [*light.levels]


def test_swiping_shows_the_clear_image_left_of_the_divider(browser: Browser, frame: tuple, tmp_path: Path) -> None:
    browser.run("view.set({beta: 0.3, light: [255, 0, 0]})")
    browser.key("s")
    browser.drag("#divider", [0.4, 0.25], "#stage")
    assert float(browser.run("document.getElementById('divider').getAttribute('aria-valuenow')")) == 25
    browser.picture(tmp_path / "swiped.png")
    left, top, width, height = map(round, browser.box("#stage"))
    picture = read_rgb(tmp_path / "swiped.png")[top : top + height // 7, left : left + width].astype(int)
    red = (picture == (255, 0, 0)).all(axis=2).mean(axis=0)  # the sky is noise where clear, and red in this fog
    assert red[: int(0.23 * width)].max() < 0.05
    assert red[int(0.27 * width) :].min() > 0.95
    browser.run("document.getElementById('divider').focus()")
    browser.key("ArrowRight")
    assert float(browser.run("document.getElementById('divider').getAttribute('aria-valuenow')")) == 27


def test_keys_set_density_map_and_crosshair(browser: Browser, frame: tuple) -> None:
    browser.key("4")
    assert beta(browser) == 0.03
    browser.key("+")
    assert beta(browser) > 0.03
    browser.key("0")
    assert beta(browser) == 0
    browser.key("t")
    assert browser.run("view.state.shown") == 1
    browser.run("document.getElementById('stage').focus()")
    browser.key("ArrowDown")
    browser.key("ArrowLeft", shift=True)
    assert "row 31, column 40:" in browser.run("document.getElementById('readout').textContent")


def test_a_small_screen_is_not_scrolled_sideways_and_fingers_swipe(browser: Browser, frame: tuple) -> None:
    browser.resize(*PHONE, touch=True)
    assert browser.run("document.documentElement.scrollWidth") == PHONE[0]
    browser.run("return void (document.getElementById('compare').click(), window.scrollTo(0, 0))")
    browser.touch("#divider", [0.4, 0.8], "#stage")
    assert float(browser.run("document.getElementById('divider').getAttribute('aria-valuenow')")) == 80
    browser.resize(1500, 1000)


def test_frames_a_second_are_measured(browser: Browser, frame: tuple) -> None:
    assert browser.run("await view.measure(0.5)") > 0
    assert browser.run("document.getElementById('speed').textContent").endswith("frames/s")
    assert beta(browser) == 0.02


# Ground truth and two predictions of 4 x 6 pixels: A is wrong in the left half, B in the lower half.
TRUTH = np.full((4, 6), 13, np.uint8)
TRUTH[0, 0] = IGNORE
A, B = TRUTH.copy(), TRUTH.copy()
A[:, :3], B[2:] = 14, 2
A[0, 0] = 14


@pytest.fixture
def run(browser: Browser, tmp_path: Path) -> Path:
    """The page of a run of two rows on three images, which is open; in the second the rows change places."""
    photo = encode_jpeg(np.full((*TRUTH.shape, 3), 99, np.uint8))
    images = [
        Shown("first.png", photo, TRUTH, [A, B]),
        Shown("second.png", photo, TRUTH, [B, A]),
        Shown("third.png", photo, TRUTH, [A, TRUTH]),
    ]
    path = tmp_path / "run.html"
    write_text(path, predictions_page("Predictions", [Row("Net", "C", 40.0), Row("Net", "FS", 50.0)], images, True))
    browser.resize(1500, 1000)
    browser.open(path)
    yield path
    assert browser.complaints() == []


def overlay(browser: Browser, side: str) -> np.ndarray:
    return np.frombuffer(browser.bytes(f"view.pixels('{side}')"), np.uint8).reshape(*TRUTH.shape, 4)


def painted(ids: np.ndarray, palette: np.ndarray) -> np.ndarray:
    table = np.zeros((256, 3), np.uint8)
    table[: len(palette)] = palette
    return table[ids]


def test_maps_are_painted_in_the_palette_that_is_chosen(browser: Browser, run: Path) -> None:
    assert browser.run("[view.state.a, view.state.b]") == ["0", "1"]
    for palette, key in ((PALETTE, ""), (SAFE, "c"), (PALETTE, "c")):
        if key:
            browser.key(key)
        assert (overlay(browser, "a")[..., :3] == painted(A, palette)).all()
        assert (overlay(browser, "truth")[..., :3] == painted(TRUTH, palette)).all()
    browser.run("view.set({only: 13})")
    assert ((overlay(browser, "b")[..., 3] > 0) == (B == 13)).all()


def test_errors_and_changes_are_marked_where_there_is_truth(browser: Browser, run: Path) -> None:
    browser.key("e")
    wrong = overlay(browser, "a")
    counted = TRUTH != IGNORE
    assert ((wrong[..., 3] > 0) == (counted & (A != TRUTH))).all()
    assert (wrong[wrong[..., 3] > 0][:, :3] == WRONG).all()
    browser.key("e")
    change = overlay(browser, "b")
    better, worse = counted & (A != TRUTH) & (B == TRUTH), counted & (A == TRUTH) & (B != TRUTH)
    assert (change[better][:, :3] == RIGHT).all()
    assert (change[worse][:, :3] == WRONG).all()
    assert (change[~better & ~worse][:, 3] == 0).all()


def test_outlines_part_classes_whatever_their_colours(browser: Browser, run: Path) -> None:
    browser.key("o")
    lines = overlay(browser, "b")
    assert (lines[2, 1:, :3] == 255).all()
    assert (lines[1, 1:, :3] == 0).all()


def test_classes_are_sorted_by_their_change_in_this_image(browser: Browser, run: Path) -> None:
    lines = browser.run("view.lines()")
    assert [line["class"] for line in lines] == ["car"]
    counted = TRUTH != IGNORE
    for line, key, guess in ((lines[0], "a", A), (lines[0], "b", B)):
        hit = (counted & (guess == 13)).sum()
        assert line[key] == pytest.approx(100 * hit / counted.sum(), abs=1e-3)
    assert lines[0]["change"] == pytest.approx(lines[0]["b"] - lines[0]["a"])
    row = browser.run("document.querySelector('#table tbody tr').innerText")
    assert f"{lines[0]['b'] - lines[0]['a']:+.1f}".replace("-", "−") in row


def test_images_are_ordered_by_the_change_between_two_rows(browser: Browser, run: Path) -> None:
    def names() -> list[str]:
        return browser.run("[...document.getElementById('image').options].map((each) => each.text.split(' ')[0])")

    assert names() == ["first.png", "second.png", "third.png"]
    browser.run("view.set({order: 'gain'})")
    assert names()[0] == "third.png"
    browser.run("view.set({order: 'loss'})")
    assert names()[-1] == "third.png"
    assert browser.run("return view.lines().length")


def test_keys_page_through_images_and_rows(browser: Browser, run: Path) -> None:
    def state(key: str) -> object:
        time.sleep(0.2)  # maps are unpacked in the background
        return browser.run(f"view.state.{key}")

    browser.key("ArrowRight")
    assert state("image") == 1
    browser.key("ArrowLeft")
    browser.key("ArrowLeft")
    assert state("image") == 2
    browser.key("a")
    assert state("a") == "1"
    browser.key("A", shift=True)
    browser.key("x")
    assert (state("a"), state("b")) == ("1", "0")


def test_the_divider_shows_one_row_left_and_the_other_right(browser: Browser, run: Path, tmp_path: Path) -> None:
    browser.run("await view.set({opacity: 1})")
    browser.key("s")
    browser.drag("#divider", [0.5, 0.75], "#stage-a")
    browser.picture(tmp_path / "swiped.png")
    left, top, width, height = map(round, browser.box("#stage-a"))
    line = read_rgb(tmp_path / "swiped.png")[top + height * 7 // 8, left : left + width]
    at = [line[int(share * width)].tolist() for share in (0.2, 0.6, 0.9)]
    assert at == [PALETTE[14].tolist(), PALETTE[13].tolist(), PALETTE[2].tolist()]
    assert browser.run("document.getElementById('pane-b').hidden")


def test_panes_lie_below_each_other_on_a_small_screen(browser: Browser, run: Path) -> None:
    assert browser.box("#stage-a")[1] == browser.box("#stage-b")[1]
    browser.resize(*PHONE, touch=True)
    assert browser.box("#stage-a")[1] < browser.box("#stage-b")[1]
    assert browser.run("document.documentElement.scrollWidth") == PHONE[0]
    browser.resize(1500, 1000)


def test_a_damaged_page_says_so(browser: Browser, tmp_path: Path) -> None:
    image, depth, lines = scene()
    text = frame_page("frame.png", image, depth, lines, estimate(image), estimate(image), 0.02)
    write_text(tmp_path / "damaged.html", text.replace('id="blob-distance">', 'id="blob-distance">!'))
    with pytest.raises(RuntimeError):
        browser.open(tmp_path / "damaged.html")
    assert not browser.run("document.getElementById('problem').hidden")
