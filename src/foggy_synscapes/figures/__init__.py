"""Figures from arrays and scores: no path is known here."""
