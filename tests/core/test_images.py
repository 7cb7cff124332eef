"""Images: what is written is valid anywhere, and what is read is what was asked for or an error that names the file."""

import io
import struct
import zlib
from pathlib import Path

import numpy as np
import OpenEXR
import OpenImageIO as oiio
import pytest
from PIL import Image

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.images import (
    encode_depth,
    encode_png,
    is_whole_png,
    read_depth,
    read_grey16,
    read_ids,
    read_rgb,
)

RNG = np.random.default_rng(1)
RGB = RNG.integers(0, 256, (37, 53, 3), dtype=np.uint8)
DEPTH = RNG.random((7, 9), dtype=np.float32) * 100


def pillow(image: Image.Image, **options: object) -> bytes:
    buffer = io.BytesIO()
    image.save(buffer, "png", **options)
    return buffer.getvalue()


def exr(path: Path, channels: dict[str, np.ndarray], **header: object) -> Path:
    OpenEXR.File({"type": OpenEXR.scanlineimage, **header}, channels).write(str(path))
    return path


@pytest.mark.parametrize(
    "pixels",
    [RGB, RGB[:, :, 1], RGB[:1, :1], RGB[:, ::-2], RGB[::3, :, 0], RGB[:, :, 0].astype(np.uint16) * 251],
    ids=["colour", "grey", "one pixel", "mirrored view", "strided view", "16 bit"],
)
def test_every_reader_gets_back_the_pixels_that_were_written(pixels: np.ndarray, tmp_path: Path) -> None:
    for level in range(4):
        data = encode_png(pixels, level)
        read = read_rgb if pixels.ndim == 3 else read_grey16 if pixels.dtype == np.uint16 else read_ids
        ours = read(data)
        assert ours.dtype == pixels.dtype
        np.testing.assert_array_equal(ours, pixels)
        np.testing.assert_array_equal(np.asarray(Image.open(io.BytesIO(data))), pixels)
        path = tmp_path / "image.png"
        path.write_bytes(data)
        theirs = oiio.ImageInput.open(str(path)).read_image(pixels.dtype.name)
        np.testing.assert_array_equal(theirs.reshape(pixels.shape), pixels)


def test_a_png_is_the_same_bytes_each_time_and_its_checksums_hold() -> None:
    data = encode_png(RGB)
    assert data == encode_png(RGB.copy())
    at = 8
    while at < len(data):
        (size,) = struct.unpack_from(">I", data, at)
        assert struct.unpack_from(">I", data, at + 8 + size)[0] == zlib.crc32(data[at + 4 : at + 8 + size])
        at += 12 + size
    assert at == len(data)


def test_images_of_other_programs_are_read(tmp_path: Path) -> None:
    np.testing.assert_array_equal(read_rgb(pillow(Image.fromarray(RGB), optimize=True)), RGB)
    np.testing.assert_array_equal(read_ids(pillow(Image.fromarray(RGB[..., 0]))), RGB[..., 0])
    # A colour that is declared transparent is still that colour.
    np.testing.assert_array_equal(read_rgb(pillow(Image.fromarray(RGB), transparency=(1, 2, 3))), RGB)
    Image.fromarray(RGB).save(tmp_path / "image.tif")
    np.testing.assert_array_equal(read_rgb(tmp_path / "image.tif"), RGB)


@pytest.mark.parametrize(
    ("read", "data", "message"),
    [
        (read_rgb, pillow(Image.fromarray(RGB).convert("RGBA")), "8-bit RGB with alpha, expected 8-bit RGB"),
        (read_rgb, pillow(Image.fromarray(RGB[..., 0])), "8-bit grey, expected 8-bit RGB"),
        (read_rgb, pillow(Image.fromarray(RGB[..., 0].astype(np.uint16))), "16-bit grey, expected 8-bit RGB"),
        (read_ids, pillow(Image.fromarray(RGB)), "8-bit RGB, expected 8-bit grey. Is this the colour preview"),
        (read_ids, pillow(Image.fromarray(RGB[..., 0]).convert("P")), "8-bit palette, expected 8-bit grey"),
        (read_ids, pillow(Image.fromarray(RGB[..., 0] > 9)), "1-bit grey, expected 8-bit grey"),
        (read_ids, encode_png(RGB[..., 0].astype(np.uint16)), "16-bit grey, expected 8-bit grey"),
        (read_grey16, encode_png(RGB[..., 0]), "8-bit grey, expected 16-bit grey"),
        (read_rgb, b"", r"not a PNG file \(0 bytes\)"),
        (read_rgb, b"GIF89a" * 20, "not a PNG file"),
    ],
)
def test_an_image_of_another_kind_is_refused_by_name(read, data: bytes, message: str) -> None:
    with pytest.raises(FoggyError, match=f"^frame 7: {message}"):
        read(data, "frame 7")


def test_damaged_images_are_refused_wherever_the_damage_is(tmp_path: Path) -> None:
    data = encode_png(RGB)
    for end in range(0, len(data), 97):
        with pytest.raises(FoggyError, match="frame 7"):
            read_rgb(data[:end], "frame 7")
    for place in range(8, len(data), 89):
        changed = bytearray(data)
        changed[place] ^= 0x10
        with pytest.raises(FoggyError, match="frame 7"):
            read_rgb(bytes(changed), "frame 7")
    path = tmp_path / "a.png"
    path.write_bytes(data[:-1])
    assert not is_whole_png(path)
    path.write_bytes(data)
    assert is_whole_png(path)
    assert not is_whole_png(tmp_path / "b.png")


def test_a_deflate_stream_that_ends_early_is_refused_though_its_checksums_hold() -> None:
    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 50, 50, 8, 2, 0, 0, 0))
    for body in (b"", zlib.compress(bytes(100)), b"no deflate stream"):
        with pytest.raises(FoggyError, match="frame 7: cannot be decoded"):
            read_rgb(b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", body) + chunk(b"IEND", b""), "frame 7")


def test_an_image_that_claims_to_be_huge_is_refused_before_decoding() -> None:
    data = bytearray(encode_png(RGB))
    data[16:24] = struct.pack(">II", 60000, 60000)
    with pytest.raises(FoggyError, match="claims 60000 x 60000 pixels"):
        read_rgb(bytes(data), "bomb.png")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    for read in (read_rgb, read_ids, read_grey16, read_depth):
        with pytest.raises(FoggyError, match=r"nowhere\.file: missing"):
            read(tmp_path / "nowhere.file")


@pytest.mark.parametrize(
    "pixels", [RGB.astype(np.float32), RGB[..., :2], RGB[:0], RGB[0, 0], np.zeros((4, 5, 4), np.uint8)]
)
def test_what_is_no_image_is_not_encoded(pixels: np.ndarray) -> None:
    with pytest.raises(ValueError, match="pixels: "):
        encode_png(pixels)
    with pytest.raises(ValueError, match="level: 9"):
        encode_png(RGB, 9)


def test_depth_survives_bit_by_bit(tmp_path: Path) -> None:
    depth = DEPTH.copy()
    depth.flat[:4] = 0, np.inf, 1e-38, 8935.25
    path = tmp_path / "depth.exr"
    path.write_bytes(encode_depth(depth))
    np.testing.assert_array_equal(read_depth(path), depth)
    assert read_depth(path).dtype == np.float32
    np.testing.assert_array_equal(read_depth(path.read_bytes(), "a.exr"), depth)
    np.testing.assert_array_equal(oiio.ImageInput.open(str(path)).read_image("float")[..., 0], depth)
    assert encode_depth(depth) == encode_depth(depth.copy())
    with pytest.raises(ValueError, match="depth: float64"):
        encode_depth(depth.astype(np.float64))


def test_depth_of_another_kind_is_refused_by_name(tmp_path: Path, capfd: pytest.CaptureFixture) -> None:
    cases = {
        "channel B, G, R, expected 1 named Z. Is this the colour preview": exr(
            tmp_path / "a.exr", dict.fromkeys("RGB", DEPTH)
        ),
        "channel Y, expected 1 named Z": exr(tmp_path / "b.exr", {"Y": DEPTH}),
        "5 channels, expected 1 named Z": exr(tmp_path / "c.exr", dict.fromkeys("ABGRZ", DEPTH)),
        "channel Z is float16, expected float32": exr(tmp_path / "d.exr", {"Z": DEPTH.astype(np.float16)}),
    }
    whole = encode_depth(DEPTH)
    for name, data in (("e", whole[: len(whole) // 2]), ("f", b""), ("g", encode_png(RGB)), ("h", whole[:300])):
        path = tmp_path / f"{name}.exr"
        path.write_bytes(data)
        cases[f"{name}.exr: not a readable EXR file"] = path
    for message, path in cases.items():
        with pytest.raises(FoggyError, match=message) as caught:
            read_depth(path)
        assert str(path) in str(caught.value)
    # The EXR library prints its own complaints: none may reach the terminal beside our one message.
    assert capfd.readouterr() == ("", "")


def test_depth_that_covers_a_part_of_its_image_is_refused(tmp_path: Path) -> None:
    window = (np.array([0, 0], np.int32), np.array([19, 19], np.int32))
    path = exr(tmp_path / "part.exr", {"Z": DEPTH}, displayWindow=window)
    with pytest.raises(FoggyError, match=r"part\.exr: a part of its image only"):
        read_depth(path)
