"""Files under their partial names: created exclusively, locked, named together."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from vdoor.errors import VdoorError
from vdoor.files import partial_name, refuse_existing
from vdoor.partial import Partial, together, write_whole


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_the_second_writer_is_refused_and_the_first_one_finishes(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    first = Partial(path)
    with pytest.raises(VdoorError, match="another run is writing it"):
        write_whole(path, b"second")
    first.fill(b"first")
    first.give_name()
    assert path.read_bytes() == b"first"
    assert names(tmp_path) == ["a.txt"]


def test_what_a_killed_run_left_is_replaced_by_force_only(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    partial_name(path).write_bytes(b"left")
    with pytest.raises(VdoorError, match="already exists, --force overwrites it"):
        Partial(path, force=False)
    assert partial_name(path).read_bytes() == b"left"
    write_whole(path, b"new")
    assert names(tmp_path) == ["a.txt"]
    partial_name(path).touch()  # nothing is lost with an empty one
    refuse_existing([tmp_path / "b.txt"], force=False)
    partial_name(tmp_path / "b.txt").touch()
    refuse_existing([tmp_path / "b.txt"], force=False)


def test_a_link_under_a_partial_name_is_refused(tmp_path: Path) -> None:
    for target in (tmp_path / "outside.txt", tmp_path / "nowhere"):
        (tmp_path / "outside.txt").write_bytes(b"mine")
        path = tmp_path / "a.txt"
        partial_name(path).symlink_to(target)
        with pytest.raises(VdoorError, match="link"):
            write_whole(path, b"theirs")
        with pytest.raises(VdoorError, match="link"):
            refuse_existing([path], force=True)
        assert (tmp_path / "outside.txt").read_bytes() == b"mine"
        assert not (tmp_path / "nowhere").exists()
        partial_name(path).unlink()


def test_without_force_nothing_is_replaced_that_came_meanwhile(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    partial = Partial(path, force=False)
    path.write_bytes(b"came meanwhile")
    with pytest.raises(VdoorError, match="already exists"):
        partial.give_name()
    partial.remove()
    assert path.read_bytes() == b"came meanwhile"
    assert names(tmp_path) == ["a.txt"]


def test_files_get_their_names_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a").write_bytes(b"old")
    filled = Partial.fill

    def full(self: Partial, content: bytes) -> None:
        if self.path.name == "b":
            raise VdoorError(f"output: cannot be written ({os.strerror(errno.ENOSPC)}): {self.path}")
        filled(self, content)

    def write() -> None:
        with together() as staged:
            staged.make_folder(tmp_path / "new")
            for name in ("a", "new/c", "b"):
                staged.add(tmp_path / name, b"new")

    with monkeypatch.context() as patch:
        patch.setattr(Partial, "fill", full)
        with pytest.raises(VdoorError, match="No space left"):
            write()
    assert (tmp_path / "a").read_bytes() == b"old"
    assert names(tmp_path) == ["a"]
    write()
    assert [(tmp_path / name).read_bytes() for name in ("a", "b", "new/c")] == [b"new"] * 3


def test_a_file_whose_place_was_taken_is_not_renamed(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    partial = Partial(path)
    partial.name.unlink()
    partial.name.write_bytes(b"another's")
    with pytest.raises(VdoorError, match="something else has its place"):
        partial.give_name()
    partial.remove()
    assert partial_name(path).read_bytes() == b"another's"
