"""Scores of predictions against ground truth: confusion matrices, intersection over union, its means."""
