"""Files that are wrong in ways that only someone who knows their format comes upon, drawn by hypothesis.

Each function takes `draw` of hypothesis and a whole file, and gives a `Changed`.
"""

import json
import struct
import tarfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from hypothesis import strategies as st

Draw = Callable[[st.SearchStrategy], Any]
SIGNATURE = b"\x89PNG\r\n\x1a\n"
EXTREMES = (0, 1, 2, 127, 128, 255, 2**15, 2**31 - 1, 2**31, 2**32 - 1)
# What a reader of numbers, names or truth values does not expect.
ODD = (
    None, True, False, "", "12", "nan", "x" * 3000, 0, -1, 2**63, 10**400, 0.5, -0.0, 1e308, [], {}, [[[]]], {"a": {}},
    "../x", "/etc/hostname", "\u0000", "\ud7ff",
)  # fmt: skip
NOT_FINITE = (float("nan"), float("inf"), -float("inf"))


@dataclass(frozen=True)
class Changed:
    """A changed file.

    refuse : whether no reader may take it: it contradicts a checksum of its format, or itself
    """

    data: bytes
    what: str
    refuse: bool = False


def pick(draw: Draw, values: Any) -> Any:
    return draw(st.sampled_from(list(values)))


def place(draw: Draw, end: int) -> int:
    return draw(st.integers(0, max(0, end - 1)))


def damage(draw: Draw, data: bytes) -> Changed:
    """Damage as disks and networks do it, at any place."""
    if not data:
        return Changed(b"\0", "one byte")
    at, other = place(draw, len(data)), place(draw, len(data))
    first, last = sorted((at, other))
    what = pick(draw, ("flip", "flip", "byte", "cut", "zeros", "twice", "lost", "more", "empty", "number"))
    changed = bytearray(data)
    if what == "flip":
        changed[at] ^= 1 << draw(st.integers(0, 7))
    elif what == "byte":
        changed[at] = draw(st.integers(0, 255))
    elif what == "cut":
        changed = changed[:at]
    elif what == "zeros":
        changed[first:last] = bytes(last - first)
    elif what == "twice":
        changed[last:last] = changed[first:last]
    elif what == "lost":
        del changed[first : min(last, first + 64)]
    elif what == "more":
        changed[at:at] = draw(st.binary(min_size=1, max_size=40))
    elif what == "number":
        changed[at : at + 4] = struct.pack(pick(draw, ("<I", ">I")), pick(draw, EXTREMES))
    else:
        changed = bytearray()
    return Changed(bytes(changed), what)


def chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png(draw: Draw, data: bytes) -> Changed:
    """A PNG whose chunks, header, rows or checksums are others; their other checksums are made to fit."""
    chunks, at = [], 8
    while at < len(data):
        (size,) = struct.unpack_from(">I", data, at)
        chunks.append((data[at + 4 : at + 8], data[at + 8 : at + 8 + size]))
        at += 12 + size
    header, stream, end = chunks[0], zlib.decompress(chunks[1][1]), chunks[-1]
    what = pick(draw, ("damage", "header", "order", "adler", "rows", "short", "long", "pieces", "unknown", "crc"))
    packed, refuse = zlib.compress(stream), False
    if what == "damage":
        changed = damage(draw, data)
        # A chunk that says of itself that it may be left out can be lost; what follows the end does not count.
        return Changed(changed.data, f"damage: {changed.what}", not changed.data.startswith(data))
    if what == "header":
        body = bytearray(header[1])
        field = pick(draw, ((0, ">I"), (4, ">I"), (8, "B"), (9, "B"), (10, "B"), (11, "B"), (12, "B")))
        size = struct.calcsize(field[1])
        value = pick(draw, EXTREMES) % 2 ** (8 * size)
        refuse = struct.unpack_from(field[1], body, field[0])[0] != value
        struct.pack_into(field[1], body, field[0], value)
        header = header[0], bytes(body)
    elif what == "adler":
        packed, refuse = packed[:-1] + bytes([packed[-1] ^ 1 << draw(st.integers(0, 7))]), True
    elif what == "rows":
        rows = bytearray(stream)
        rows[place(draw, len(rows))] = draw(st.integers(0, 255))
        packed = zlib.compress(bytes(rows), draw(st.integers(0, 9)))
    elif what == "short":
        packed, refuse = zlib.compress(stream[: place(draw, len(stream))]), True
    elif what == "long":
        packed, refuse = zlib.compress(stream + bytes(pick(draw, (1, 1000, 10**7)))), True
    parts = [header, (b"IDAT", packed), end]
    if what == "pieces":
        cut = place(draw, len(packed))
        parts[1:2] = [(b"IDAT", packed[:cut]), (b"IDAT", b""), (b"IDAT", packed[cut:])]
    elif what == "unknown":
        kind = pick(draw, (b"tEXt", b"zTXt", b"fooB", b"FOOB", b"PLTE", b"tRNS", b"gAMA", b"IHDR", b"acTL", b"eXIf"))
        parts.insert(place(draw, 4), (kind, draw(st.binary(max_size=30))))
    elif what == "order":
        parts = draw(st.permutations(parts))
    whole = SIGNATURE + b"".join(chunk(*part) for part in parts)
    if what == "crc":
        whole, refuse = whole[:29] + bytes([whole[29] ^ 1]) + whole[30:], True
    return Changed(whole, what, refuse)


def exr(draw: Draw, data: bytes) -> Changed:
    """An EXR with another attribute, another version, or damage."""
    what = pick(draw, ("damage", "damage", "attribute", "attribute", "name", "lost", "version"))
    if what == "damage":
        return Changed(damage(draw, data).data, what)
    if what == "version":
        return Changed(data[:4] + struct.pack("<I", 2 | pick(draw, (0, 0x200, 0x400, 0x800, 0x1000))) + data[8:], what)
    at, places = 8, []
    while data[at]:
        name_end = data.index(b"\0", at)
        kind_end = data.index(b"\0", name_end + 1)
        (size,) = struct.unpack_from("<I", data, kind_end + 1)
        places.append((at, name_end, kind_end + 5, size))
        at = kind_end + 5 + size
    begin, name_end, value, size = pick(draw, places)
    name = data[begin:name_end].decode()
    if what == "lost":
        return Changed(data[:begin] + data[value + size :], f"no {name}")
    if what == "name":
        return Changed(data[:begin] + b"other" + data[name_end:], f"{name} renamed")
    changed = bytearray(data)
    if size >= 4 and draw(st.booleans()):
        struct.pack_into("<i", changed, value + 4 * place(draw, size // 4), pick(draw, (-1, *EXTREMES[:-2], -(2**31))))
    elif size:
        changed[value + place(draw, size)] = draw(st.integers(0, 14))
    return Changed(bytes(changed), name)


def tar(draw: Draw, data: bytes) -> Changed:
    """A tar file whose members are of another name, kind, size or order; their headers' checksums are made to fit."""
    what = pick(draw, ("damage", "name", "kind", "size", "twice", "pax", "order", "end"))
    if what == "damage":
        return Changed(damage(draw, data).data, what)
    if what == "end":
        return Changed(data[: 512 * place(draw, len(data) // 512)], what)
    header, size = bytearray(data[:512]), int(data[124:135], 8)
    body = data[512 : 512 + (size + 511) // 512 * 512]
    rest, refuse = data[512 + len(body) :], False
    if what == "name":
        name = pick(draw, (b"../x", b"/etc/x", b"", b"a/../../x", b"\xff\xfe", b"a\\x", b"./a", b"zz.png"))
        header[:100], refuse = name.ljust(100, b"\0"), name != b"\xff\xfe"
    elif what == "kind":
        kind = draw(st.integers(0, 255))
        header[156], refuse = kind, kind not in (0, ord("0"))
    elif what == "size":
        # Never the size itself: then other bytes would stand for the member.
        field = pick(draw, (b"77777777777\0", b"\x80" + b"\xff" * 11, b"\xff" * 12, b"\x80" + bytes(5) + b"\x7f" * 6))
        header[124:136], refuse = field, True
    struct.pack_into("8s", header, 148, b"        ")
    header[148:156] = b"%06o\0 " % sum(header)
    first = bytes(header) + body
    if what == "twice":
        return Changed(first + first + rest, what, refuse=True)
    if what == "order":
        return Changed(rest[:1024] + first + rest[1024:], what)
    if what == "pax":
        record = pick(draw, (b"20 path=../../x/y/z\n", b"25 size=99999999999999999\n", b"9999999 a=b\n"))
        extra = tarfile.TarInfo("pax")
        extra.type, extra.size = pick(draw, (b"x", b"g", b"L", b"K", b"S")), len(record)
        first = extra.tobuf(tarfile.USTAR_FORMAT) + record.ljust(512, b"\0") + first
        return Changed(first + rest, what, refuse=True)
    return Changed(first + rest, what, refuse)


def spots(tree: Any, path: tuple = ()) -> list[tuple]:
    """Where the values of a JSON document are, leaves and branches."""
    inner = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    return [spot for key, value in inner for spot in [(*path, key), *spots(value, (*path, key))]]


def json_tree(draw: Draw, data: bytes) -> Changed:
    """A JSON document with another value, one key less or one twice."""
    tree = json.loads(data)
    where = pick(draw, spots(tree))
    parent = tree
    for key in where[:-1]:
        parent = parent[key]
    key, before = where[-1], parent[where[-1]]
    what = pick(draw, ("value", "value", "not finite", "bool", "text", "lost", "twice", "damage", "deep", "bom"))
    number = isinstance(before, int | float) and not isinstance(before, bool)
    if what == "value":
        parent[key] = pick(draw, ODD)
    elif what == "not finite":
        parent[key] = pick(draw, NOT_FINITE)
    elif what == "bool" and number:
        parent[key] = draw(st.booleans())
    elif what == "text" and number:
        parent[key] = str(before)
    elif what == "lost":
        del parent[key]
    elif what == "damage":
        return Changed(damage(draw, data).data, what)
    elif what == "deep":
        return Changed(b"[" * pick(draw, (900, 10**5)), what, refuse=True)
    elif what == "bom":
        return Changed(b"\xef\xbb\xbf" + data, what)
    text = json.dumps(tree)
    if what == "twice" and isinstance(parent, dict):
        again = f"{json.dumps(key)}: {json.dumps(before)}"
        text = text.replace(again, f"{again}, {again}", 1)
        return Changed(text.encode(), f"{key} twice", refuse=text.count(again) > 1)
    # Whether a reader looks at this value, it knows: only numbers of cameras and scores are asked to be refused.
    return Changed(text.encode("utf-8", "surrogatepass"), f"{what} {'.'.join(map(str, where))}")


def safetensors(draw: Draw, data: bytes) -> Changed:
    """A safetensors file with another header, or another length of it."""
    size = int.from_bytes(data[:8], "little")
    header, rest = data[8 : 8 + size], data[8 + size :]
    what = pick(draw, ("header", "header", "length", "damage", "short"))
    if what == "damage":
        return Changed(damage(draw, data).data, what)
    if what == "length":
        return Changed(
            struct.pack("<Q", pick(draw, (0, 1, size - 1, size + 1, 10**8, 2**63, 2**64 - 1))) + data[8:], what
        )
    if what == "short":
        return Changed(data[: place(draw, len(data))], what, refuse=True)
    changed = json_tree(draw, header)
    return Changed(struct.pack("<Q", len(changed.data)) + changed.data + rest, f"header: {changed.what}")


def csv(draw: Draw, data: bytes) -> Changed:
    """A table with another cell, one more or less, or a column twice."""
    lines = [line.split(",") for line in data.decode().splitlines()]
    what = pick(draw, ("cell", "cell", "cell", "more", "less", "column", "line", "damage", "quote", "nul", "long"))
    row = pick(draw, range(len(lines)))
    cell = place(draw, len(lines[row]))
    refuse = False
    if what == "cell":
        lines[row][cell] = pick(
            draw, ("", "x", "-1", "1e400", "nan", "0x10", "1_0", "../x", "/etc/x", "9" * 5000, "\u0660", " 1", "inf")
        )
    elif what in ("more", "less"):
        lines[row] = [*lines[row], "1"] if what == "more" else lines[row][:-1]
        refuse = len(lines) > 1
    elif what == "column":
        lines = [[*line, line[cell % len(line)]] for line in lines]
        refuse = True
    elif what == "line":
        lines.insert(row, lines[row])
    elif what == "damage":
        return Changed(damage(draw, data).data, what)
    elif what == "quote":
        lines[row][cell] = '"' + lines[row][cell]
    elif what == "nul":
        lines[row][cell] = "\0"
    else:
        lines[row][cell] = "x" * 200_000
    return Changed("".join(",".join(line) + "\n" for line in lines).encode(), what, refuse)


def text(draw: Draw, data: bytes) -> Changed:
    """A list of names with another line."""
    lines = data.decode().splitlines()
    row = place(draw, len(lines))
    what = pick(draw, ("line", "line", "twice", "lost", "damage", "long", "ends"))
    if what == "line":
        lines[row] = pick(draw, ("../x", "/etc/x", "a\\b", "\0", "\u2028", "x" * 5000, "a//b", ".", "", " "))
    elif what == "twice":
        lines.insert(row, lines[place(draw, len(lines))])
    elif what == "lost":
        del lines[row]
    elif what == "damage":
        return Changed(damage(draw, data).data, what)
    elif what == "long":
        lines = lines * 10 + [f"x{n}" for n in range(20_000)]
    return Changed(("\r\n" if what == "ends" else "\n").join(lines).encode("utf-8", "surrogatepass"), what)


def yaml(draw: Draw, data: bytes) -> Changed:
    """A params file with another value, a trap of YAML 1.1, an alias, a tag or a key twice."""
    lines = data.decode().splitlines()
    rows = [number for number, line in enumerate(lines) if ": " in line and not line.lstrip().startswith("#")]
    row = pick(draw, rows)
    key, _, _ = lines[row].partition(": ")
    what = pick(draw, ("value", "trap", "trap", "twice", "tag", "alias", "damage", "deep", "tab"))
    traps = ("1:30", "1_0", "010", "0x10", "0b1", "on", "off", "yes", "No", "2001-01-01", ".inf", ".nan", "!!int '3'")
    refuse = what in ("trap", "tag", "alias") or (what == "twice" and not key.lstrip().startswith("- "))
    if what == "value":
        lines[row] = (
            f"{key}: {pick(draw, ('-1', '1e400', 'x', '[]', '{}', '[[1]]', 'null', '0.5', '~', '*a', '>', '|'))}"
        )
    elif what == "trap":
        lines[row] = f"{key}: {pick(draw, traps)}"
    elif what == "twice":
        lines.insert(row, lines[row])
    elif what == "tag":
        lines[row] = f"{key}: !!python/object/new:os.system [touch x]"
    elif what == "alias":
        lines[row] = f"{key}: &a [*a]"
    elif what == "deep":
        return Changed(b"a: " + b"[" * pick(draw, (900, 5000)), what, refuse=True)
    elif what == "tab":
        lines[row] = "\t" + lines[row]
    else:
        return Changed(damage(draw, data).data, what)
    return Changed("\n".join(lines).encode(), f"{what}: {lines[row].strip()}", refuse)


def jpeg(draw: Draw, data: bytes) -> Changed:
    """A JPEG cut off, with its end put back, or damaged."""
    what = pick(draw, ("damage", "cut", "half", "half"))
    scan = data.rindex(b"\xff\xda") + 14
    if what == "damage":
        return Changed(damage(draw, data).data, what)
    cut = data[: scan + place(draw, (len(data) - scan) * 3 // 4)]
    return Changed(cut if what == "cut" else cut + b"\xff\xd9", what, refuse=True)
