"""Loops of stereo completion and refinement, compiled by Numba; `depth` says what they are for and checks arrays."""
