"""The table of what completed depth does wrong, and of what becomes of it in fog: by distance and by class."""

from collections.abc import Iterable, Mapping

from foggy_synscapes.depth.quality import FARTHEST, GROUPS, SUMS
from foggy_synscapes.labels import CLASSES

COLUMNS = ("beta", "by", "group", "pixels", "depth_m", "depth_percent", "transmittance", "levels")
HEAD = (
    "| | share of pixels | depth (m) | depth (%) | t | grey levels |",
    "|---|---:|---:|---:|---:|---:|",
)

Line = tuple[str, str, str, int, float, float, float, float]


def collect(beta: str, lines: Iterable[Mapping[str, str]]) -> list[Line]:
    """Mean absolute errors at a beta: of all pixels, by distance and by class.

    lines : of the tables of all shards, with the columns class, distance and those of `quality.SUMS`
    """
    sums: dict[tuple[str, str], list[float]] = {}
    for line in lines:
        values = [float(line[name]) for name in SUMS]
        for group in (("all", "all"), ("distance", line["distance"]), ("class", line["class"])):
            sums[group] = [a + b for a, b in zip(sums.get(group, [0.0] * len(SUMS)), values, strict=True)]
    order = [("all", "all"), *(("distance", name) for name in GROUPS), *(("class", name) for name in CLASSES)]
    found: list[Line] = []
    for by, name in order:
        if (by, name) in sums:
            pixels, depth, relative, t, levels = sums[by, name]
            means = depth / pixels, 100 * relative / pixels, t / pixels, levels / pixels
            found.append((beta, by, name, int(pixels), *means))
    return found


def csv_text(lines: list[Line]) -> str:
    """The lines as CSV, numbers as they are."""
    return "".join(",".join(map(str, line)) + "\n" for line in (COLUMNS, *lines))


def markdown(lines: list[Line], stand_in: bool) -> str:
    """The same as Markdown, a table for each beta."""
    text = [
        "# Errors of completed depth, and of the fog that is made of it",
        "",
        f"Mean absolute errors against true depth{' (stand-in)' if stand_in else ''}; depths beyond {FARTHEST:g} m "
        f"count as {FARTHEST:g} m.",
    ]
    for beta in dict.fromkeys(line[0] for line in lines):
        own = [line for line in lines if line[0] == beta]
        text += ["", f"## beta {beta} / m", "", *HEAD]
        for _, _, name, pixels, metres, percent, t, levels in own:
            share = f"{100 * pixels / own[0][3]:.1f} %"
            text.append(f"| {name} | {share} | {metres:.1f} | {percent:.1f} | {t:.3f} | {levels:.1f} |")
    return "\n".join(text) + "\n"
