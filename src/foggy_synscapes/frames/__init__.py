"""Fog on files: finds frames, renders them, keeps what an interrupted run finished. Knows no formula."""
