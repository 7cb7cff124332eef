"""Notes inside a PNG file, which tell of one image what the settings of its folder do not (PNG specification, tEXt)."""

import struct
import zlib

SIGNATURE, LENGTH = 8, 25
"""Bytes before the first chunk; of that chunk, IHDR, with its length, type and checksum."""
TEXT = b"tEXt"


def with_note(png: bytes, key: str, text: str) -> bytes:
    """The file with a note behind its header; key and text in Latin-1, the key of 1 to 79 characters."""
    body = key.encode("latin-1") + b"\0" + text.encode("latin-1")
    place = SIGNATURE + LENGTH
    return (
        png[:place]
        + struct.pack(">I", len(body))
        + TEXT
        + body
        + struct.pack(">I", zlib.crc32(TEXT + body))
        + png[place:]
    )


def note(png: bytes, key: str) -> str | None:
    """The note of a key; None where there is none.

    >>> note(with_note(bytes(33), "fog model", "none"), "fog model")
    'none'
    """
    start, begin = png.find(TEXT, SIGNATURE), key.encode("latin-1") + b"\0"
    while start >= 4:
        (length,) = struct.unpack(">I", png[start - 4 : start])
        body = png[start + 4 : start + 4 + length]
        if body.startswith(begin):
            return body[len(begin) :].decode("latin-1")
        start = png.find(TEXT, start + 4 + length)
    return None
