"""How attenuation coefficients are spelt in names of folders and files."""

from decimal import Decimal


def beta_name(text: str) -> str:
    """Spell an attenuation coefficient in 1/m the way folders spell it: shortest decimal, no exponent.

    >>> beta_name("0.010")
    '0.01'

    Raises ValueError unless it is a finite number above 0.
    """
    try:
        value = float(text)
    except ValueError:
        raise ValueError(
            f"beta {text!r} is not a number; it is the attenuation coefficient in 1/m, e.g. 0.005"
        ) from None
    if not 0 < value < float("inf"):
        raise ValueError(f"beta {text} is not a positive finite number in 1/m, e.g. 0.005")
    return f"{Decimal(repr(value)):f}"
