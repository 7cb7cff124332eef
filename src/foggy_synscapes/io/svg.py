"""Boxes and arrows from left to right as SVG: what a box hangs on stands left of it."""

import html
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

CHARACTER, HEADING = 6.7, 8.6  # width in pixels of a character of 12 and of 14 pixels, in the widest of the fonts below
LINE, PAD, BETWEEN, GAP, WAY = 16, 9, 40, 18, 10  # pixels; WAY: of an arrow that passes between boxes
FONT = "font-family='DejaVu Sans, Verdana, Helvetica, sans-serif'"
EDGE, WRONG, FILL, INK = "#7a8599", "#d55e00", "#eef3fa", "#16202e"


@dataclass(frozen=True)
class Box:
    """A box: its title, further lines, what a pointer on it shows, and whether something is wrong with it."""

    title: str
    lines: Sequence[str] = ()
    hint: str = ""
    wrong: bool = False

    @property
    def width(self) -> float:
        """Pixels."""
        widths = [HEADING * len(self.title), *(CHARACTER * len(line) for line in self.lines)]
        return max(widths) + 2 * PAD

    @property
    def height(self) -> float:
        """Pixels."""
        return LINE * (1 + len(self.lines)) + 2 * PAD


@dataclass
class _Place:
    """A box, or a point that an arrow passes, in a column."""

    box: Box | None
    before: list[str] = field(default_factory=list)
    after: list[str] = field(default_factory=list)
    x: float = 0
    y: float = 0  # of its middle
    width: float = 0

    @property
    def height(self) -> float:
        return self.box.height if self.box else WAY


def drawing(boxes: dict[str, Box], arrows: Iterable[tuple[str, str]], about: str) -> str:
    """Boxes by key and arrows between them, from the first key to the second, as an SVG file.

    about : what the picture is, for those who do not see it

    Each box stands as far right as what hangs on it allows. Raises ValueError where arrows run in a circle.

    >>> drawing({"a": Box("a"), "b": Box("b")}, [("a", "b")], "two boxes").count("<rect")
    2
    """
    pairs = sorted({(one, other) for one, other in arrows})
    column = _columns(boxes, pairs)
    places = {key: _Place(box, width=box.width) for key, box in boxes.items()}
    columns: list[list[str]] = [[] for _ in range(max(column.values(), default=0) + 1)]
    for key in boxes:
        columns[column[key]].append(key)
    for one, other in pairs:
        last = one
        for number in range(column[one] + 1, column[other]):
            way = f"{one}\0{other}\0{number}"
            places[way] = _Place(None)
            columns[number].append(way)
            last = _join(places, last, way)
        _join(places, last, other)
    _sort(places, columns)
    width, height = _lay_out(places, columns)
    body = [*(_arrow(places, one, other) for one in places for other in places[one].after), *_boxes(places)]
    return (
        f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width:.0f} {height:.0f}' width='{width:.0f}' "
        f"height='{height:.0f}' role='img'>\n<title>{html.escape(about)}</title>\n"
        f"<defs><marker id='tip' viewBox='0 0 8 8' refX='7' refY='4' markerWidth='8' markerHeight='8' orient='auto'>"
        f"<path d='M0 0 8 4 0 8z' fill='{EDGE}'/></marker></defs>\n" + "\n".join(filter(None, body)) + "\n</svg>\n"
    )


def _columns(boxes: dict[str, Box], pairs: list[tuple[str, str]]) -> dict[str, int]:
    """Number of each box's column, from the left: its longest way to the right counted from there."""
    after: dict[str, list[str]] = {key: [] for key in boxes}
    for one, other in pairs:
        after[one].append(other)
    behind: dict[str, int] = {}
    for round_ in range(len(boxes) + 1):
        found = {key: 1 + max((behind.get(other, 0) for other in after[key]), default=-1) for key in boxes}
        if found == behind:
            break
        if round_ == len(boxes):
            raise ValueError("arrows run in a circle")
        behind = found
    last = max(behind.values(), default=0)
    return {key: last - behind[key] for key in boxes}


def _join(places: dict[str, _Place], one: str, other: str) -> str:
    places[one].after.append(other)
    places[other].before.append(one)
    return other


def _sort(places: dict[str, _Place], columns: list[list[str]]) -> None:
    """Order each column by where its neighbours stand, back and forth, so that few arrows cross."""

    def order(keys: list[str], side: str, beside: list[str]) -> None:
        at = {key: (number + 0.5) / len(beside) for number, key in enumerate(beside)}
        own = {key: (number + 0.5) / len(keys) for number, key in enumerate(keys)}

        def middle(key: str) -> tuple[float, float]:
            found = [at[other] for other in getattr(places[key], side) if other in at]
            return (sum(found) / len(found) if found else own[key]), own[key]

        keys.sort(key=middle)

    for _ in range(4):
        for number in range(len(columns) - 2, -1, -1):
            order(columns[number], "after", columns[number + 1])
        for number in range(1, len(columns)):
            order(columns[number], "before", columns[number - 1])


def _lay_out(places: dict[str, _Place], columns: list[list[str]]) -> tuple[float, float]:
    """Give each place its coordinates; width and height of the whole."""
    height = max(sum(places[key].height + GAP for key in keys) for keys in columns) + GAP if places else 2 * GAP
    x = float(GAP)
    for keys in columns:
        wide = max((places[key].width for key in keys), default=0)
        y = (height - sum(places[key].height + GAP for key in keys) + GAP) / 2
        for key in keys:
            place = places[key]
            place.width = wide  # boxes of a column are of one width, and arrows pass it straight
            place.x, place.y = x, y + place.height / 2
            y += place.height + GAP
        x += wide + BETWEEN
    return x - BETWEEN + GAP, height


def _arrow(places: dict[str, _Place], one: str, other: str) -> str:
    start, end = places[one], places[other]
    x1, x2 = start.x + start.width, end.x
    bend = (x2 - x1) / 2
    path = f"M{x1:.1f} {start.y:.1f}C{x1 + bend:.1f} {start.y:.1f} {x2 - bend:.1f} {end.y:.1f} {x2:.1f} {end.y:.1f}"
    if end.box is None:
        path += f"h{end.width:.1f}"
    tip = " marker-end='url(#tip)'" if end.box else ""
    return f"<path d='{path}' fill='none' stroke='{EDGE}' stroke-width='1.6'{tip}/>"


def _boxes(places: dict[str, _Place]) -> Iterable[str]:
    for place in places.values():
        box = place.box
        if box is None:
            continue
        top = place.y - box.height / 2
        edge, thick = (WRONG, 3) if box.wrong else (EDGE, 1.2)
        yield "<g>" + (f"<title>{html.escape(box.hint)}</title>" if box.hint else "")
        yield (
            f"<rect x='{place.x:.1f}' y='{top:.1f}' width='{place.width:.1f}' height='{box.height:.1f}' rx='6' "
            f"fill='{FILL}' stroke='{edge}' stroke-width='{thick}'/>"
        )
        for number, text in enumerate([box.title, *box.lines]):
            size, weight = (14, "bold") if number == 0 else (12, "normal")
            y = top + PAD + LINE * (number + 0.8)
            yield (
                f"<text x='{place.x + PAD:.1f}' y='{y:.1f}' font-size='{size}' font-weight='{weight}' fill='{INK}' "
                f"{FONT}>{html.escape(text)}</text>"
            )
        yield "</g>"
