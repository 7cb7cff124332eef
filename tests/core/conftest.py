"""What tests of the core share."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from foggy_synscapes.registry import use_plugins


@pytest.fixture
def plugins(tmp_path: Path) -> Iterator[Path]:
    """An empty folder of plugins, in use."""
    folder = tmp_path / "plugins"
    folder.mkdir()
    use_plugins(folder)
    yield folder
    use_plugins(None)
