"""How far the outputs of one way of computing are from those of another."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Difference:
    """Summed over images: largest difference of logits, largest logit, pixels of another class, pixels."""

    largest: float = 0.0
    magnitude: float = 0.0
    changed: int = 0
    pixels: int = 0

    def add(self, reference: np.ndarray, logits: np.ndarray, classes: np.ndarray | None = None) -> None:
        """Count one image; reference, logits float32 (C, H, W); classes uint8 (H, W), by default those of `logits`.

        Raises ValueError if the shapes differ, or a logit is no number.
        """
        if reference.shape != logits.shape:
            raise ValueError(f"logits: shape {logits.shape}, expected {reference.shape}")
        classes = logits.argmax(axis=0) if classes is None else classes
        off = float(np.abs(logits - reference).max())
        if not np.isfinite(off):
            raise ValueError("logits: infinite or not a number")
        self.largest, self.magnitude = max(self.largest, off), max(self.magnitude, float(np.abs(reference).max()))
        self.changed += int((classes != reference.argmax(axis=0)).sum())
        self.pixels += classes.size

    @property
    def changed_percent(self) -> float:
        """Share of the pixels that are of another class, in percent."""
        return 100 * self.changed / self.pixels
