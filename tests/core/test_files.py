"""Atomic files, shards, manifests, tables, indexes and URIs: nothing half-written, nothing outside its folder."""

import os
import tarfile
import time
from pathlib import Path

import pytest

from foggy_synscapes.datasets import index, lists, uris
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import replacing, write_bytes, write_text
from foggy_synscapes.io.hashing import sha256_bytes
from foggy_synscapes.io.shards import Shard, read_manifest, write_manifest, write_shard
from foggy_synscapes.io.stamps import CACHE, SETTLED_NS
from foggy_synscapes.io.tables import read_csv, write_csv

INDEX = Path("index/demo/all.csv")


def test_a_failed_write_leaves_the_old_content_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    write_text(path, "old")

    def write_and_fail() -> None:
        with replacing(path) as file:
            file.write(b"new")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        write_and_fail()
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.txt"]
    assert path.read_text() == "old"


def test_a_refused_write_is_an_error_that_names_the_file(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(FoggyError, match=r"file/below\.txt: cannot be written"):
        write_bytes(tmp_path / "file" / "below.txt", b"")


def test_a_shard_is_the_same_bytes_each_time_and_any_tar_program_reads_it(tmp_path: Path) -> None:
    members = [("a.png", b"1"), ("b.png", b"22")]
    manifest = write_shard(tmp_path / "x.tar", members)
    write_shard(tmp_path / "y.tar", iter(members))
    assert (tmp_path / "x.tar").read_bytes() == (tmp_path / "y.tar").read_bytes()
    with tarfile.open(tmp_path / "x.tar") as tar:
        assert [(entry.name, entry.mtime, entry.uid) for entry in tar] == [("a.png", 0, 0), ("b.png", 0, 0)]
    with Shard(tmp_path / "x.tar") as shard:
        assert shard.names() == ["a.png", "b.png"]
        assert shard.read("b.png") == b"22"
        with pytest.raises(FoggyError, match=r"no member c\.png"):
            shard.read("c.png")
    assert [(member.name, member.size) for member in manifest] == [("a.png", 1), ("b.png", 2)]


def test_a_manifest_comes_back_as_it_was(tmp_path: Path) -> None:
    members = write_shard(tmp_path / "x.tar", [("a.png", b"1")])
    write_manifest(tmp_path / "x.csv", members)
    assert read_manifest(tmp_path / "x.csv") == members


@pytest.mark.parametrize("name", ["../x.png", "/x.png", "a/../../x.png", "a\\x.png", ""])
def test_a_member_that_leaves_its_folder_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match="unsafe member name"):
        write_shard(tmp_path / "x.tar", [(name, b"")])
    write_csv(tmp_path / "x.csv", ("name", "size", "sha256"), [(name, 0, "")])
    with pytest.raises(FoggyError, match="unsafe member name"):
        read_manifest(tmp_path / "x.csv")


def test_members_out_of_order_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="sorted by name"):
        write_shard(tmp_path / "x.tar", [("b", b""), ("a", b"")])
    assert list(tmp_path.iterdir()) == []


def test_a_shard_that_is_cut_off_or_holds_links_is_refused(tmp_path: Path) -> None:
    write_shard(tmp_path / "x.tar", [("a.png", b"1" * 5000)])
    (tmp_path / "cut.tar").write_bytes((tmp_path / "x.tar").read_bytes()[:3000])
    with tarfile.open(tmp_path / "link.tar", "w") as tar:
        entry = tarfile.TarInfo("a.png")
        entry.type, entry.linkname = tarfile.SYMTYPE, "/etc/hostname"
        tar.addfile(entry)
    with pytest.raises(FoggyError, match=r"not a readable shard|cut off"):
        Shard(tmp_path / "cut.tar").read("a.png")
    with pytest.raises(FoggyError, match="plain files only"):
        Shard(tmp_path / "link.tar")
    with pytest.raises(FoggyError, match=r"none\.tar: missing"):
        Shard(tmp_path / "none.tar")


def test_a_table_that_lacks_a_column_or_a_cell_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("a,b\n1,2\n3\n")
    with pytest.raises(FoggyError, match="line 3: 1 cells, expected 2"):
        read_csv(path)
    with pytest.raises(FoggyError, match="column c missing; found a, b"):
        read_csv(path, ("c",))


@pytest.fixture
def dataset(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    root = tmp_path / "data"
    for name in ("b.png", "a/c.png"):
        write_bytes(root / name, name.encode())
    return root


def test_an_index_lists_sizes_and_hashes_sorted_by_path(dataset: Path) -> None:
    index.write_index(INDEX, dataset, ["b.png", "a/c.png"])
    assert index.read_index(INDEX) == {"a/c.png": sha256_bytes(b"a/c.png"), "b.png": sha256_bytes(b"b.png")}
    assert INDEX.read_text().splitlines()[1].startswith("a/c.png,7,")


def test_other_bytes_of_equal_size_and_time_are_seen(dataset: Path) -> None:
    index.write_index(INDEX, dataset, ["b.png", "a/c.png"])
    content, times = dataset / "a/c.png", (dataset / "a/c.png").stat()
    content.write_bytes(b"A/C.png")
    os.utime(content, ns=(times.st_atime_ns, times.st_mtime_ns))
    index.write_index(INDEX, dataset, ["b.png", "a/c.png"])
    assert index.read_index(INDEX) == {"a/c.png": sha256_bytes(b"A/C.png"), "b.png": sha256_bytes(b"b.png")}


def test_a_file_with_the_stamp_of_the_last_time_is_not_read_again(dataset: Path) -> None:
    time.sleep(2 * SETTLED_NS / 1e9)  # a stamp of just now could be that of two contents
    index.write_index(INDEX, dataset, ["b.png"])
    (cache,) = CACHE.rglob("*.json")
    known = sha256_bytes(b"b.png")
    cache.write_text(cache.read_text().replace(known, known[::-1]))
    index.write_index(INDEX, dataset, ["b.png"])
    assert index.read_index(INDEX) == {"b.png": known[::-1]}


def test_a_file_has_changed_if_its_content_has_and_not_if_only_its_time_has(dataset: Path) -> None:
    index.write_index(INDEX, dataset, ["b.png", "a/c.png"])
    os.utime(dataset / "b.png", (1, 1))
    assert index.changed_since_listed(INDEX, dataset) == []
    write_bytes(dataset / "b.png", b"B.png")
    (dataset / "a/c.png").unlink()
    assert index.changed_since_listed(INDEX, dataset) == ["a/c.png", "b.png"]


def test_a_missing_file_or_one_outside_the_root_cannot_be_listed(dataset: Path, tmp_path: Path) -> None:
    with pytest.raises(FoggyError, match=r"none\.png: missing"):
        index.write_index(INDEX, dataset, ["none.png"])
    (tmp_path / "secret").write_text("x")
    (dataset / "link.png").symlink_to(tmp_path / "secret")
    for path in ("link.png", "../secret"):
        with pytest.raises(FoggyError, match="leads out of the dataset's folder"):
            index.write_index(INDEX, dataset, [path])


def test_a_uri_gives_the_listed_bytes_and_no_others(dataset: Path, tmp_path: Path) -> None:
    write_shard(tmp_path / "results/fog/beta_0.005/0000.tar", [("00001_beta_0.005.png", b"fog")])
    reader = uris.Reader({"cityscapes": dataset}, "results/fog")
    fog = uris.of_fog("0.005", "0000", "00001_beta_0.005.png")
    assert reader.read(fog, sha256_bytes(b"fog")) == b"fog"
    assert reader.read("cityscapes:b.png", sha256_bytes(b"b.png")) == b"b.png"
    with pytest.raises(FoggyError, match="its content changed since it was listed"):
        reader.read("cityscapes:b.png", sha256_bytes(b"before"))
    for uri in ("cityscapes:../x", "cityscapes:/etc/hostname", "b.png", "fog:../x.tar#a", "fog:x.tar#../a"):
        with pytest.raises(FoggyError, match="not the name of an image"):
            reader.read(uri, "")
    with pytest.raises(FoggyError, match="no dataset 'kitti'"):
        reader.read("kitti:b.png", "")


def test_a_list_file_must_be_as_indexed_and_name_each_file_once(dataset: Path) -> None:
    write_text(dataset / "list.txt", "a/c.png\nb.png\n")
    index.write_index(INDEX, dataset, ["list.txt"])
    listed = index.read_index(INDEX)
    assert lists.read_list(dataset, "list.txt", listed) == ["a/c.png", "b.png"]
    write_text(dataset / "list.txt", "a/c.png\n")
    with pytest.raises(FoggyError, match="changed since it was listed"):
        lists.read_list(dataset, "list.txt", listed)
    for text, message in (
        ("b.png\nb.png\n", "stands there twice"),
        ("../b.png\n", "leads out"),
        ("\n", "names no file"),
    ):
        write_text(dataset / "list.txt", text)
        with pytest.raises(FoggyError, match=message):
            lists.read_list(dataset, "list.txt")


def test_images_are_paired_with_the_labels_of_their_own_frame() -> None:
    images, labels = (
        ["x/a_leftImg8bit.png", "x/b_leftImg8bit.png"],
        ["y/a_gtFine_labelIds.png", "y/b_gtFine_labelIds.png"],
    )
    assert lists.paired(images, labels, "demo") == list(zip(images, labels, strict=True))
    with pytest.raises(
        FoggyError, match=r"line 1 of its lists names x/a_leftImg8bit\.png, but labels of another frame"
    ):
        lists.paired(images, labels[::-1], "demo")
    with pytest.raises(FoggyError, match="2 images but 1 label maps"):
        lists.paired(images, labels[:1], "demo")


def test_a_file_has_the_permissions_of_any_new_one_and_no_thread_sees_another_mask(tmp_path: Path, monkeypatch) -> None:
    asked: list[int] = []
    before = os.umask(0o027)
    try:
        with monkeypatch.context() as patch:
            patch.setattr(os, "umask", lambda mask: asked.append(mask) or 0o027)
            write_bytes(tmp_path / "file", b"content")
    finally:
        os.umask(before)
    assert (tmp_path / "file").stat().st_mode & 0o777 == 0o640
    assert asked == []
