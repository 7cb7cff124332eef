"""How numbers are printed: one decimal, halves away from zero."""

from decimal import ROUND_HALF_UP, Decimal

MISSING = "--"  # a run that does not exist
DASH = "-"  # a class that the test set does not have


def round_half_up(value: float | Decimal, places: int = 1) -> Decimal:
    """Round an unrounded value once; a float counts as the decimal that it prints as, so that 0.25 gives 0.3.

    >>> round_half_up(0.25), round_half_up(1.15), round_half_up(-0.04)
    (Decimal('0.3'), Decimal('1.2'), Decimal('0.0'))
    """
    exact = value if isinstance(value, Decimal) else Decimal(repr(float(value)))
    rounded = exact.quantize(Decimal(1).scaleb(-places), ROUND_HALF_UP)
    return rounded.copy_abs() if rounded == 0 else rounded


def signed(value: float | Decimal, places: int = 1) -> str:
    """A difference with its sign; zero has none.

    >>> signed(1.25), signed(-2.0), signed(0.01)
    ('+1.3', '-2.0', '0.0')
    """
    rounded = round_half_up(value, places)
    return f"+{rounded}" if rounded > 0 else str(rounded)
