"""Fog: optics, geometry and the atmospheric light. Arrays in, arrays out; knows no path."""
