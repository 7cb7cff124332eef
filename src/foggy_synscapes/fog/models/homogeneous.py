"""Homogeneous fog, uniform airlight: F = t R + (1 - t) L, t = exp(-beta l). Source: paper, equations (1) and (2)."""

from foggy_synscapes.fog.models.model import FogModel
from foggy_synscapes.fog.optics import foggy_images, foggy_scan_lines, transmittance_images

FOG_MODEL = FogModel(
    text="homogeneous fog with uniform airlight (Koschmieder)",
    images=foggy_images,
    transmittances=transmittance_images,
    scan_lines=foggy_scan_lines,
)
