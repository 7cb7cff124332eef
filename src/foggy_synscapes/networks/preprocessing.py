"""What turns 8-bit images into a network's input.

PyTorch is imported where tensors are computed with, so that reading a network's declaration does not wait for it.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from torch import Tensor


@dataclass(frozen=True)
class Preprocessing:
    """What turns 8-bit RGB into a network's input: (value * scale - mean) / std, per channel in the given order.

    The default is ImageNet's mean and standard deviation, which torchvision's, TorchSeg's and CoinCheung's weights use.
    """

    channels: str = "RGB"
    scale: float = 1 / 255
    mean: tuple[float, float, float] = (0.485, 0.456, 0.406)
    std: tuple[float, float, float] = (0.229, 0.224, 0.225)

    def __post_init__(self) -> None:
        if self.channels not in ("RGB", "BGR"):
            raise ValueError(f"preprocessing: channels {self.channels!r}, expected RGB or BGR")
        if len(self.mean) != 3 or len(self.std) != 3 or min(self.std) <= 0:
            raise ValueError(f"preprocessing: mean {self.mean} and std {self.std}, expected three each, std above 0")

    def apply(self, images: "Tensor") -> "Tensor":
        """uint8 (B, 3, H, W) in RGB order -> float32 of the same shape, pixel by pixel in memory."""
        import torch

        if self.channels == "BGR":
            images = images.flip(1)
        batch, _, height, width = images.shape
        std, mean = (torch.tensor(values, dtype=torch.float64) for values in (self.std, self.mean))
        # Constants as long as a row: with three of them the innermost loop would have three steps only.
        factor, offset = (values.float().repeat(width).to(images.device) for values in (self.scale / std, -mean / std))
        rows = images.permute(0, 2, 3, 1).reshape(batch, height, width * 3).to(torch.float32)
        return rows.mul_(factor).add_(offset).view(batch, height, width, 3).permute(0, 3, 1, 2)
