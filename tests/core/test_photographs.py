"""The encoder for photographs: any reader gets the pixels back, whatever they are, and it is worth having."""

import io
import zlib

import numpy as np
import OpenImageIO as oiio
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from PIL import Image

from foggy_synscapes.io import photographs
from foggy_synscapes.io.images import encode_png, read_rgb
from foggy_synscapes.io.photographs import (
    CODING,
    LONGEST,
    STEP,
    code_lengths,
    encode_photograph,
    encode_photographs,
)

RNG = np.random.default_rng(7)


def photograph(rows: int, columns: int) -> np.ndarray:
    """Slopes with the noise of a camera under a sky without any."""
    slope = np.add.outer(np.arange(rows), np.arange(columns))[..., None] // 3 % 200
    image = (slope + RNG.normal(0, 3, (rows, columns, 3))).clip(0, 255).astype(np.uint8)
    image[: rows // 5] = 251, 255, 249
    return image


def read_everywhere(data: bytes) -> np.ndarray:
    pixels = read_rgb(data)  # libspng
    np.testing.assert_array_equal(np.asarray(Image.open(io.BytesIO(data))), pixels)  # Pillow and zlib
    return pixels


@settings(max_examples=150, deadline=None)
@given(
    arrays.arrays(
        np.uint8,
        st.tuples(st.integers(1, 30), st.integers(1, 60), st.just(3)),
        elements=st.integers(0, 255),
        fill=st.sampled_from([0, 7, 255]),
    )
)
def test_any_pixels_come_back(pixels: np.ndarray) -> None:
    np.testing.assert_array_equal(read_everywhere(encode_photograph(pixels)), pixels)


@pytest.mark.parametrize("block", [1, 50, 3000, 800_000])
@pytest.mark.parametrize("shape", [(1, 1), (1, 400), (400, 1), (13, 17), (32, 30), (33, 30), (64, 300)])
def test_blocks_of_any_size_and_images_of_any_shape(shape: tuple[int, int], block: int, monkeypatch) -> None:
    monkeypatch.setattr(photographs, "BLOCK", block)
    for pixels in (
        photograph(*shape),
        RNG.integers(0, 256, (*shape, 3), dtype=np.uint8),
        np.zeros((*shape, 3), np.uint8),
    ):
        np.testing.assert_array_equal(read_everywhere(encode_photograph(pixels)), pixels)


@pytest.mark.parametrize("height", [1, STEP, STEP + 1, 70])
def test_images_side_by_side_are_those_one_by_one(height: int, monkeypatch) -> None:
    monkeypatch.setattr(photographs, "BLOCK", 6000)  # blocks of 32 and of 6 rows
    noise = RNG.integers(0, 256, (height, 61, 3), dtype=np.uint8)
    images = np.stack([photograph(height, 61), noise, np.full_like(noise, 255)])
    asked = []

    def draw(rows: slice, out: np.ndarray) -> None:
        asked.append(range(height)[rows])
        part = images[:, rows].astype(np.uint8)
        lines = out[:, : part.shape[1] * 184].reshape(3, -1, 184)
        lines[:, :, 0] = 1
        lines[:, :, 1:4] = part[:, :, 0]
        lines[:, :, 4:] = (part[:, :, 1:] - part[:, :, :-1]).reshape(3, -1, 180)

    files = list(encode_photographs((3, height, 61), draw))
    assert files == [encode_photograph(image) for image in images]
    assert [row for rows in asked[1:] for row in rows] == list(range(height))
    assert list(asked[0]) == list(range(0, height, STEP))


@pytest.mark.parametrize("run", [*range(1, 40), 85, 86, 87, 88, 172, 173, 300, 1000])
def test_runs_of_every_length(run: int) -> None:
    """Equal pixels become zeros, and zeros copies of at most 258: no length may be lost, also not 258 + 1 or + 2."""
    pixels = RNG.integers(0, 256, (2, run + 11, 3), dtype=np.uint8)
    pixels[0, 5 : 5 + run] = 9
    np.testing.assert_array_equal(read_everywhere(encode_photograph(pixels)), pixels)


def test_openimageio_reads_it(tmp_path) -> None:
    pixels = photograph(90, 130)
    (tmp_path / "a.png").write_bytes(encode_photograph(pixels))
    np.testing.assert_array_equal(oiio.ImageInput.open(str(tmp_path / "a.png")).read_image("uint8"), pixels)


def test_it_is_the_same_bytes_each_time_also_from_views() -> None:
    pixels = photograph(200, 300)
    assert encode_photograph(pixels) == encode_photograph(pixels.copy())
    assert encode_photograph(pixels[::2, ::-1]) == encode_photograph(pixels[::2, ::-1].copy())


def test_photographs_are_no_larger_than_with_a_search_for_matches() -> None:
    pixels = photograph(360, 720)
    assert len(encode_photograph(pixels)) < len(encode_png(pixels, 1))


@pytest.mark.parametrize("level", [0, 1, 128, 255])
def test_the_checksum_is_that_of_zlib_also_for_the_largest_sums(level: int) -> None:
    lines = np.full(3 * photographs.SUMMED + 5, level, np.uint8)
    lines[::7] = 254
    for size in (0, 1, photographs.SUMMED, photographs.SUMMED + 1, lines.size):
        for before in (1, 65520 << 16 | 65519):
            assert photographs.adler32(lines[:size], before) == zlib.adler32(lines[:size], before)


def test_a_plain_sky_takes_little_space() -> None:
    assert len(encode_photograph(np.full((720, 1440, 3), 251, np.uint8))) < 15_000


@pytest.mark.parametrize(
    "pixels",
    [np.zeros((2, 2), np.uint8), np.zeros((2, 2, 4), np.uint8), np.zeros((0, 2, 3), np.uint8), np.zeros((2, 2, 3))],
)
def test_what_is_no_colour_image_is_refused(pixels: np.ndarray) -> None:
    with pytest.raises(ValueError, match="pixels: "):
        encode_photograph(pixels)


@given(arrays.arrays(np.int64, st.integers(2, 286), elements=st.integers(1, 10**9)))
def test_codes_are_complete_and_short_enough(counts: np.ndarray) -> None:
    """Kraft's sum of a complete code is 1: a decoder accepts it, and no bit is wasted."""
    lengths = code_lengths(counts)
    assert lengths.max() <= LONGEST
    assert sum(2.0 ** -int(length) for length in lengths) == 1


def test_code_lengths_by_hand() -> None:
    """Counts 1, 1, 2, 4: the rare two share a node of 2, which joins the 2, which joins the 4."""
    assert code_lengths(np.array([4, 1, 2, 1])).tolist() == [1, 3, 2, 3]
    # A Fibonacci row would need 19 bits for its rarest symbols.
    counts = [1, 1]
    while len(counts) < 20:
        counts.append(counts[-1] + counts[-2])
    assert code_lengths(np.array(counts)).max() <= LONGEST


def test_match_lengths_are_those_of_the_standard() -> None:
    """RFC 1951, section 3.2.5: 3 is 257, 11 and 12 are 265 with one bit, 257 is 284 with 31, 258 is 285 alone."""
    assert (CODING[1][[3, 10, 11, 12, 13, 257, 258]] == [257, 264, 265, 265, 266, 284, 285]).all()
    assert (CODING[2][[3, 10, 11, 12, 19, 257, 258]] == [0, 0, 1, 1, 2, 5, 0]).all()


def test_the_stream_is_one_that_zlib_ends_at_its_last_byte() -> None:
    data = encode_photograph(photograph(30, 40))
    start = data.index(b"IDAT")
    size = int.from_bytes(data[start - 4 : start], "big")
    decoder = zlib.decompressobj()
    rows = decoder.decompress(data[start + 4 : start + 4 + size])
    assert decoder.eof
    assert not decoder.unused_data
    assert len(rows) == 30 * 121
