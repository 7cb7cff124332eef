"""Registries find entries by what modules declare, import them only when asked, and name what is wrong."""

import subprocess
import sys
from pathlib import Path

import pytest

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.registry import Registry, UnknownEntry, use_plugins
from foggy_synscapes.steps import REGISTRIES

THINGS = Registry("networks", "THING", "thing")


@pytest.mark.parametrize("name", REGISTRIES)
def test_every_entry_can_be_imported_and_has_a_text_or_title(name: str) -> None:
    registry = REGISTRIES[name]
    assert registry.names()
    for entry in registry:
        found = registry[entry]
        assert getattr(found, "text", None) or getattr(found, "title", None) or name == "stand_ins", entry


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(UnknownEntry, match=r"'resnet' is no network; there are bisenet, refinenet"):
        REGISTRIES["networks"]["resnet"]


def test_a_plugin_is_found_by_what_it_declares_and_imported_when_asked_for(plugins: Path) -> None:
    (plugins / "one.py").write_text("THING = 1\n")
    (plugins / "typed.py").write_text("THING: int = 2\n")
    (plugins / "helper.py").write_text("OTHER = 1\nprint(1 / 0)\n")
    (plugins / "broken.py").write_text("import nothing_of_this_name\nTHING = 3\n")
    assert THINGS.names() == ["broken", "one", "typed"]
    assert (THINGS["one"], THINGS["typed"]) == (1, 2)
    assert "helper" not in THINGS
    with pytest.raises(FoggyError, match=r"broken\.py: this plugin cannot be imported: ModuleNotFoundError: No module"):
        THINGS["broken"]


def test_two_entries_of_one_name_are_refused(plugins: Path) -> None:
    (plugins / "bisenet.py").write_text("NETWORK = 1\n")
    with pytest.raises(FoggyError, match=r"bisenet\.py: there is a network of this name already\. Rename the file\."):
        REGISTRIES["networks"].names()


def test_another_folder_takes_the_place_of_the_first(plugins: Path, tmp_path: Path) -> None:
    (plugins / "one.py").write_text("THING = 1\n")
    assert THINGS["one"] == 1
    (tmp_path / "others").mkdir()
    (tmp_path / "others/one.py").write_text("THING = 2\n")
    use_plugins(tmp_path / "others")
    assert THINGS["one"] == 2
    use_plugins(None)
    assert THINGS.names() == []


@pytest.mark.parametrize("name", ["My-Network.py", "2d.py"])
def test_a_plugin_whose_name_is_none_is_refused(plugins: Path, name: str) -> None:
    (plugins / name).write_text("THING = 1\n")
    use_plugins(None)
    with pytest.raises(FoggyError, match=r"a plugin's file is named like my_network\.py"):
        use_plugins(plugins)


def test_a_folder_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(FoggyError, match=r"plugins: .*nowhere is no folder"):
        use_plugins(tmp_path / "nowhere")


def test_listing_and_planning_need_no_torch() -> None:
    call = "import sys; from foggy_synscapes import steps; steps.steps(); sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", call], check=False).returncode == 0
