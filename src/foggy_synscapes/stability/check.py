"""One line of the stability table, and what all of them say."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

COLUMNS = ("area", "quantity", "case", "format", "expected", "found", "worst_ulp", "worst_error", "verdict")
HOLDS, FAILS = "holds", "fails"


@dataclass(frozen=True)
class Check:
    """A quantity at an extreme: what it has to be, what it is, and whether that is good enough.

    worst_ulp : largest error in units in the last place, worst_error : largest absolute error; None where neither says
    anything
    """

    area: str
    quantity: str
    case: str
    format: str
    expected: str
    found: str
    good: bool
    worst_ulp: float | None = None
    worst_error: float | None = None

    @property
    def verdict(self) -> str:
        """Whether the quantity is what it has to be."""
        return HOLDS if self.good else FAILS

    def row(self) -> tuple[str, ...]:
        """Cells in the order of COLUMNS."""
        numbers = ("" if value is None else f"{value:.3g}" for value in (self.worst_ulp, self.worst_error))
        return (self.area, self.quantity, self.case, self.format, self.expected, self.found, *numbers, self.verdict)


def summary(checks: Sequence[Check]) -> str:
    """What does not hold, first, and how many hold by area: Markdown that follows from the checks."""
    failed = [check for check in checks if not check.good]
    lines = [f"Of {len(checks)} checks {len(checks) - len(failed)} hold. These do not:", ""]
    lines += [
        f"- {one.area}, {one.quantity} in {one.format}: {one.case}; expected {one.expected}, found {one.found}"
        for one in failed
    ]
    areas = Counter(check.area for check in checks)
    held = Counter(check.area for check in checks if check.good)
    return "\n".join([*lines, "", f"By area: {', '.join(f'{area} {held[area]} of {areas[area]}' for area in areas)}."])
