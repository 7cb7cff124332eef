"""Depth from stereo as Foggy Cityscapes has it, and transmittance refined by the image: arrays in, arrays out.

Sources: Sakaridis, Dai and Van Gool, Semantic Foggy Scene Understanding with Synthetic Data, IJCV 2018 (completion,
guided filter); Sakaridis, Dai, Hecker and Van Gool, Model Adaptation with Synthetic and Real Data for Semantic Dense
Foggy Scene Understanding, ECCV 2018 (dual-reference cross-bilateral filter).
"""
