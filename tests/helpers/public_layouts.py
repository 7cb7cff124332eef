"""Public networks as plain functions of named tensors, and their checkpoints under each public layout's names.

Written down once more, so that names, sizes and computation are held against something that shares no code with the
project.
"""

import re
from itertools import pairwise

import torch
import torch.nn.functional as functional

from foggy_synscapes.networks.importing import convert
from foggy_synscapes.networks.weights import dump_tensors, load_model

WIDTH, DECODER, CLASSES = 8, 12, 5
DEPTHS = {"resnet18": (2, 2, 2, 2), "resnet50": (3, 4, 6, 3), "resnet101": (3, 4, 23, 3)}
IMAGE = torch.randn(2, 3, 64, 96, generator=torch.Generator().manual_seed(8))


class File:
    """Random tensors under the names of a public file."""

    def __init__(self):
        self.tensors = {}
        self.random = torch.Generator().manual_seed(4)

    def conv(self, name, inputs, outputs, kernel, bias=False):
        scale = (inputs * kernel * kernel) ** -0.5
        self.tensors[f"{name}.weight"] = torch.randn(outputs, inputs, kernel, kernel, generator=self.random) * scale
        if bias:
            self.tensors[f"{name}.bias"] = torch.randn(outputs, generator=self.random)

    def norm(self, name, channels):
        for value in ("weight", "bias", "running_mean"):
            self.tensors[f"{name}.{value}"] = torch.randn(channels, generator=self.random) * 0.5
        self.tensors[f"{name}.running_var"] = torch.rand(channels, generator=self.random) + 0.5
        self.tensors[f"{name}.num_batches_tracked"] = torch.tensor(7)

    def unit(self, name, inputs, outputs, kernel):
        self.conv(f"{name}.conv", inputs, outputs, kernel)
        self.norm(f"{name}.bn", outputs)

    def resnet(self, prefix, backbone):
        bottleneck = backbone != "resnet18"
        self.conv(f"{prefix}conv1", 3, WIDTH, 7)
        self.norm(f"{prefix}bn1", WIDTH)
        inputs = WIDTH
        for stage, depth in enumerate(DEPTHS[backbone], start=1):
            middle = WIDTH * 2 ** (stage - 1)
            outputs = middle * 4 if bottleneck else middle
            for block in range(depth):
                place = f"{prefix}layer{stage}.{block}"
                sides = [inputs, middle, middle, outputs] if bottleneck else [inputs, middle, outputs]
                for number, (before, after) in enumerate(pairwise(sides), start=1):
                    self.conv(f"{place}.conv{number}", before, after, 1 if bottleneck and number != 2 else 3)
                    self.norm(f"{place}.bn{number}", after)
                if block == 0 and (stage > 1 or inputs != outputs):
                    self.conv(f"{place}.downsample.0", inputs, outputs, 1)
                    self.norm(f"{place}.downsample.1", outputs)
                inputs = outputs
        return [WIDTH * 2**stage * (4 if bottleneck else 1) for stage in range(4)]


class Reader:
    """Public networks as functions of named tensors, in evaluation."""

    def __init__(self, tensors):
        self.t = tensors

    def conv(self, x, name, stride=1):
        weight = self.t[f"{name}.weight"]
        return functional.conv2d(x, weight, self.t.get(f"{name}.bias"), stride, weight.shape[-1] // 2)

    def norm(self, x, name):
        mean, variance, weight, bias = (
            self.t[f"{name}.{value}"] for value in ("running_mean", "running_var", "weight", "bias")
        )
        return functional.batch_norm(x, mean, variance, weight, bias)

    def unit(self, x, name, stride=1, relu=True):
        x = self.norm(self.conv(x, f"{name}.conv", stride), f"{name}.bn")
        return functional.relu(x) if relu else x

    def resnet(self, x, prefix, stride_in=2):
        x = functional.relu(self.norm(self.conv(x, f"{prefix}conv1", 2), f"{prefix}bn1"))
        x = functional.max_pool2d(x, 3, 2, 1)
        maps = []
        for stage in range(1, 5):
            for block in range(50):
                place = f"{prefix}layer{stage}.{block}"
                if f"{place}.conv1.weight" not in self.t:
                    break
                stride = 2 if stage > 1 and block == 0 else 1
                depth = 3 if f"{place}.conv3.weight" in self.t else 2
                y = x
                for number in range(1, depth + 1):
                    here = stride if number == (stride_in if depth == 3 else 1) else 1
                    y = self.norm(self.conv(y, f"{place}.conv{number}", here), f"{place}.bn{number}")
                    y = functional.relu(y) if number < depth else y
                if f"{place}.downsample.0.weight" in self.t:
                    x = self.norm(self.conv(x, f"{place}.downsample.0", stride), f"{place}.downsample.1")
                x = functional.relu(x + y)
            maps.append(x)
        return maps

    def residual_units(self, x, name, count):
        for number in range(1, count + 1):
            y = self.conv(functional.relu(x), f"{name}.0.{number}_conv")
            x = x + self.conv(functional.relu(y), f"{name}.0.{number}_conv_relu_varout_dimred")
        return x

    def drsleep(self, x, stride_in=2):
        maps = self.resnet(x, "", stride_in)
        out = None
        for level in range(1, 5):
            x = self.conv(maps[4 - level], f"p_ims1d2_outl{level}_dimred")
            x = self.residual_units(x, f"adapt_stage{level}_b", 2)
            if out is not None:
                out = self.conv(out, f"mflow_conv_g{level - 1}_b3_joint_varout_dimred")
                out = functional.interpolate(out, size=x.shape[2:], mode="bilinear", align_corners=True)
                x = self.conv(x, f"adapt_stage{level}_b2_joint_varout_dimred") + out
            x = top = functional.relu(x)
            for number in range(1, 5):
                top = functional.max_pool2d(top, 5, 1, 2)
                top = self.conv(top, f"mflow_conv_g{level}_pool.0.{number}_outvar_dimred")
                x = x + top
            out = self.residual_units(x, f"mflow_conv_g{level}_b", 3)
        return self.conv(out, "clf_conv")

    def attention(self, x, unit, weights):
        x = self.unit(x, unit)
        return x * torch.sigmoid(weights(x.mean((2, 3), keepdim=True)))

    def torchseg(self, x):
        def enlarged(maps, like):
            return functional.interpolate(maps, size=like.shape[2:], mode="bilinear", align_corners=True)

        spatial = x
        for name, stride in (("conv_7x7", 2), ("conv_3x3_1", 2), ("conv_3x3_2", 2), ("conv_1x1", 1)):
            spatial = self.unit(spatial, f"spatial_path.{name}", stride)
        blocks = self.resnet(x, "context_path.")[::-1]
        last = enlarged(self.unit(blocks[0].mean((2, 3), keepdim=True), "global_context.1"), blocks[0])
        for i in range(2):
            maps = self.attention(
                blocks[i],
                f"arms.{i}.conv_3x3",
                lambda m, i=i: self.unit(m, f"arms.{i}.channel_attention.1", relu=False),
            )
            last = self.unit(enlarged(maps + last, blocks[i + 1]), f"refines.{i}")
        fused = self.unit(torch.cat([spatial, last], 1), "ffm.conv_1x1")
        weights = self.conv(fused.mean((2, 3), keepdim=True), "ffm.channel_attention.1.conv")
        weights = self.conv(functional.relu(weights), "ffm.channel_attention.2.conv")
        fused = fused + fused * torch.sigmoid(weights)
        logits = self.conv(self.unit(fused, "heads.2.conv_3x3"), "heads.2.conv_1x1")
        return functional.interpolate(logits, scale_factor=8, mode="bilinear", align_corners=True)

    def coincheung(self, x):
        def arm(maps, name):
            def weights(m):
                return self.norm(self.conv(m, f"{name}.conv_atten"), f"{name}.bn_atten")

            return self.attention(maps, f"{name}.conv", weights)

        _, _, feat16, feat32 = self.resnet(x, "cp.resnet.")
        up = arm(feat32, "cp.arm32") + self.unit(feat32.mean((2, 3), keepdim=True), "cp.conv_avg")
        up = self.unit(functional.interpolate(up, scale_factor=2.0), "cp.conv_head32")
        up = arm(feat16, "cp.arm16") + up
        up = self.unit(functional.interpolate(up, scale_factor=2.0), "cp.conv_head16")
        for name, stride in (("conv1", 2), ("conv2", 2), ("conv3", 2), ("conv_out", 1)):
            x = self.unit(x, f"sp.{name}", stride)
        fused = self.unit(torch.cat([x, up], 1), "ffm.convblk")
        weights = self.norm(self.conv(fused.mean((2, 3), keepdim=True), "ffm.conv"), "ffm.bn")
        fused = fused + fused * torch.sigmoid(weights)
        logits = self.conv(self.unit(fused, "conv_out.conv"), "conv_out.conv_out")
        return functional.interpolate(logits, scale_factor=8, mode="bilinear", align_corners=False)


def drsleep(backbone="resnet18"):
    file = File()
    sides = file.resnet("", backbone)
    for level in range(1, 5):
        channels = DECODER * 2 if level == 1 else DECODER
        file.conv(f"p_ims1d2_outl{level}_dimred", sides[4 - level], channels, 3)
        for group, count in ((f"adapt_stage{level}_b", 2), (f"mflow_conv_g{level}_b", 3)):
            for number in range(1, count + 1):
                file.conv(f"{group}.0.{number}_conv", channels, channels, 3, bias=True)
                file.conv(f"{group}.0.{number}_conv_relu_varout_dimred", channels, channels, 3)
        for number in range(1, 5):
            file.conv(f"mflow_conv_g{level}_pool.0.{number}_outvar_dimred", channels, channels, 3)
        if level > 1:
            file.conv(f"adapt_stage{level}_b2_joint_varout_dimred", channels, channels, 3)
            before = DECODER * 2 if level == 2 else DECODER
            file.conv(f"mflow_conv_g{level - 1}_b3_joint_varout_dimred", before, channels, 3)
    file.conv("clf_conv", DECODER, CLASSES, 3, bias=True)
    return file.tensors


def torchseg():
    file = File()
    sides = file.resnet("context_path.", "resnet18")
    for name, inputs, outputs, kernel in (
        ("spatial_path.conv_7x7", 3, WIDTH, 7),
        ("spatial_path.conv_3x3_1", WIDTH, WIDTH, 3),
        ("spatial_path.conv_3x3_2", WIDTH, WIDTH, 3),
        ("spatial_path.conv_1x1", WIDTH, DECODER, 1),
        ("global_context.1", sides[3], DECODER, 1),
        ("arms.0.conv_3x3", sides[3], DECODER, 3),
        ("arms.0.channel_attention.1", DECODER, DECODER, 1),
        ("arms.1.conv_3x3", sides[2], DECODER, 3),
        ("arms.1.channel_attention.1", DECODER, DECODER, 1),
        ("refines.0", DECODER, DECODER, 3),
        ("refines.1", DECODER, DECODER, 3),
        ("ffm.conv_1x1", DECODER * 2, DECODER * 2, 1),
        ("heads.0.conv_3x3", DECODER, DECODER * 2, 3),
        ("heads.1.conv_3x3", DECODER, DECODER * 2, 3),
        ("heads.2.conv_3x3", DECODER * 2, DECODER // 2, 3),
    ):
        file.unit(name, inputs, outputs, kernel)
    file.conv("ffm.channel_attention.1.conv", DECODER * 2, DECODER * 2, 1)
    file.conv("ffm.channel_attention.2.conv", DECODER * 2, DECODER * 2, 1)
    for number, inputs in ((0, DECODER * 2), (1, DECODER * 2), (2, DECODER // 2)):
        file.conv(f"heads.{number}.conv_1x1", inputs, CLASSES, 1, bias=True)
    return file.tensors


def coincheung(auxiliary=True):
    file = File()
    sides = file.resnet("cp.resnet.", "resnet18")
    for name, inputs, outputs, kernel in (
        ("sp.conv1", 3, WIDTH, 7),
        ("sp.conv2", WIDTH, WIDTH, 3),
        ("sp.conv3", WIDTH, WIDTH, 3),
        ("sp.conv_out", WIDTH, DECODER, 1),
        ("cp.arm16.conv", sides[2], DECODER, 3),
        ("cp.arm32.conv", sides[3], DECODER, 3),
        ("cp.conv_head32", DECODER, DECODER, 3),
        ("cp.conv_head16", DECODER, DECODER, 3),
        ("cp.conv_avg", sides[3], DECODER, 1),
        ("ffm.convblk", DECODER * 2, DECODER * 2, 1),
        ("conv_out.conv", DECODER * 2, DECODER * 2, 3),
    ):
        file.unit(name, inputs, outputs, kernel)
    for arm in ("cp.arm16", "cp.arm32"):
        file.conv(f"{arm}.conv_atten", DECODER, DECODER, 1)
        file.norm(f"{arm}.bn_atten", DECODER)
    file.conv("ffm.conv", DECODER * 2, DECODER * 2, 1)
    file.norm("ffm.bn", DECODER * 2)
    file.conv("conv_out.conv_out", DECODER * 2, CLASSES, 1, bias=True)
    for name in ("conv_out16", "conv_out32") if auxiliary else ():
        file.unit(f"{name}.conv", DECODER, DECODER // 2, 3)
        file.conv(f"{name}.conv_out", DECODER // 2, CLASSES, 1, bias=True)
    return file.tensors


def torchvision(backbone):
    file = File()
    file.resnet("", backbone)
    file.tensors["fc.weight"], file.tensors["fc.bias"] = torch.zeros(1000, 8), torch.zeros(1000)
    return file.tensors


def to_caffe(tensors, backbone):
    """The same tensors under Caffe's names, where norms are split into bn (statistics) and scale."""
    found = {}
    for name, tensor in tensors.items():
        if name.startswith("fc."):
            continue
        unit, value = name.rsplit(".", 1)
        place = re.fullmatch(r"layer(\d)\.(\d+)\.(conv|bn|downsample\.)(\d)", unit)
        if place is None:
            kind, tail = ("conv", "") if unit == "conv1" else ("bn", "_conv1")
        else:
            stage, block, number = int(place[1]), int(place[2]), int(place[4])
            is_norm = place[3] == "bn" or (place[3] == "downsample." and number == 1)
            kind = "bn" if is_norm else "conv"
            many = backbone == "resnet101" and stage in (2, 3) and block
            letter = f"b{block}" if many else "abcdef"[block]
            branch = "1" if place[3] == "downsample." else "2" + "abc"[number - 1]
            tail = f"{stage + 1}{letter}_branch{branch}"
        if kind == "conv":
            found["conv1.weight" if place is None else f"res{tail}.weight"] = tensor
        else:
            found[("scale" if value in ("weight", "bias") else "bn") + f"{tail}.{value}"] = tensor
    return found


def imported(tensors, network, layout="auto"):
    """Through conversion and the file of weights to a network."""
    found = convert(tensors, network, layout)
    assert found.missing == []
    assert found.left_over == []
    return found, load_model(dump_tensors(found.tensors, found.config, found.preprocessing)).network
