"""One line of the stability table."""

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
