"""Foggy Synscapes: semantic understanding of foggy scenes with purely synthetic data, as a pipeline to run."""

__version__ = "0.1.0"
