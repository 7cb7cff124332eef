"""How a network is trained: learning rates, their schedule, and what is decayed or frozen. Without PyTorch."""

from typing import Annotated, Literal

from pydantic import Field, FiniteFloat, model_validator

from foggy_synscapes.schema import Section, setting

BASELINE = "C"
"""The row from whose selected snapshot the rows in `train.from_baseline` start."""
Pixels = Annotated[int, Field(ge=1)]
Factor = Annotated[FiniteFloat, Field(gt=0)]


class Duration(Section):
    """A number of images, of epochs or of iterations."""

    inline = True
    whole = True

    images: int | None = setting("drawn, whatever the batch", default=None, unit="images", ge=1)
    epochs: int | None = setting("times as many images as are listed", default=None, unit="epochs", ge=1)
    iterations: int | None = setting("of one batch each", default=None, unit="iterations", ge=1)

    @model_validator(mode="after")
    def _one_of_them(self) -> "Duration":
        if [self.images, self.epochs, self.iterations].count(None) != 2:
            raise ValueError("give either images, epochs or iterations")
        return self

    def steps(self, listed: int, batch: int) -> int:
        """Iterations for a list of so many images, the last one begun counting as whole."""
        if self.iterations is not None:
            return self.iterations
        return -(-(self.images or (self.epochs or 0) * listed) // batch)


class Policy(Section):
    """One training policy. It is the section of the params too; what has a default is alike in most policies."""

    learning_rate: FiniteFloat = setting("at the first step, before backbone_rate and new_layer_rate", gt=0)
    schedule: Literal["poly", "constant"] = setting(
        "poly: learning_rate * (1 - step / steps) ** power (PSPNet)", default="poly"
    )
    power: FiniteFloat = setting("of the polynomial decay", default=0.9, gt=0, source="PSPNet")
    momentum: FiniteFloat = setting(
        "of stochastic gradient descent, without Nesterov's correction", default=0.9, ge=0, lt=1
    )
    weight_decay: FiniteFloat = setting("of weights", default=0.0005, ge=0)
    norm_weight_decay: FiniteFloat = setting("of batch norm and biases", default=0.0, ge=0)
    batch: int = setting("of a step", unit="images", ge=1)
    accumulate: int = setting("forward passes into which a batch is split where memory is short", default=1, ge=1)
    crop: tuple[Pixels, Pixels] = setting("rows and columns", unit="pixels")
    scale: tuple[Factor, Factor] = setting("random resizing before the crop: smallest and largest factor")
    flip: bool = setting("left and right at random", default=True)
    class_balance: bool = setting(
        "crops around pixels of classes drawn alike (RefineNet's released code)", default=False
    )
    loss: Literal["cross_entropy", "ohem"] = setting(
        "ohem: online hard example mining (TorchSeg)", default="cross_entropy"
    )
    ohem_threshold: FiniteFloat = setting(
        "probability of the true class below which a pixel is hard", default=0.7, gt=0, lt=1
    )
    ohem_kept: FiniteFloat = setting("share of the pixels that count at least: 1/16", default=0.0625, ge=0, le=1)
    auxiliary_weight: FiniteFloat = setting("of the losses of auxiliary heads, as BiSeNet's", default=1.0, ge=0)
    loss_stride: Literal[1, 2, 4, 8] = setting(
        "between those that the loss looks at", default=1, unit="pixels", published="1"
    )
    backbone_rate: FiniteFloat = setting("times the learning rate, of the backbone", default=1.0, gt=0)
    new_layer_rate: FiniteFloat = setting("times the learning rate, of all other layers", default=1.0, gt=0)
    freeze_batch_norm: bool = setting("keep its running statistics and parameters as they are", default=False)

    @model_validator(mode="after")
    def _consistent(self) -> "Policy":
        if self.batch % self.accumulate:
            raise ValueError(f"accumulate: {self.accumulate} passes do not divide a batch of {self.batch} images")
        if self.scale[0] > self.scale[1]:
            raise ValueError(f"scale: from {self.scale[0]} to {self.scale[1]}, expected the smaller factor first")
        return self

    def rate(self, step: int, steps: int) -> float:
        """Learning rate of a step, counted from 0, before the factors of `parameters.parameter_groups`.

        Raises ValueError if there is no such step.

        Source of the polynomial: Zhao et al., Pyramid Scene Parsing Network, CVPR 2017, section 5.1.
        """
        if not 0 <= step < steps:
            raise ValueError(f"step: {step}, expected 0 to {steps - 1}")
        return self.learning_rate * (1 if self.schedule == "constant" else (1 - step / steps) ** self.power)
