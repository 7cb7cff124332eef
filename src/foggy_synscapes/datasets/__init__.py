"""The on-disk layouts of the datasets, one module each: a new one is a module that assigns DATASET."""

from foggy_synscapes.datasets.dataset import Dataset
from foggy_synscapes.registry import Registry

DATASETS: Registry[Dataset] = Registry("datasets", "DATASET", "dataset")


def test_sets() -> list[str]:
    """Names of the datasets that networks can be tested on, sorted."""
    return [name for name in DATASETS if DATASETS[name].test_pairs is not None]


def test_settings() -> list[str]:
    """Dotted keys of the params that decide which images the test sets consist of, beside their roots."""
    return sorted({key for name in test_sets() for key in DATASETS[name].settings})
