"""Output folders that are written atomically and never lead outside of the root.

Converters write to <root>/<part>/...: `root` is the user's choice, the parts come from engram and
from checked ids. Parts are real folders; links are refused, because they lead outside. A finished
folder lists its files, and only listed files are ever deleted with it.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import re
import secrets
import shutil
from collections.abc import Iterator
from pathlib import Path

from engram.datasets.checks import DatasetError, reading

LIST = ".engram_files.json"  # in each finished folder: the files that were written
_SUFFIX = ".engram-tmp"
_LARGEST_LIST = 64 << 20  # bytes


@contextlib.contextmanager
def new_folder(root: Path | str, *parts: str) -> Iterator[Path]:
    """A folder to fill; it replaces <root>/<parts> when the block ends without an error.

    Otherwise nothing is left behind. Raises DatasetError if <root>/<parts> has files that were not
    written here, if another process is writing there, or if it cannot be written.
    """
    made: list[Path] = []
    try:
        parent = _parents(Path(root), parts[:-1], made)
        target = parent / _plain_name(parts[-1])
        _require_own(target)
        with _temporary(parent, target.name) as path:
            yield path
            _write_list(path)
            _require_own(target)  # it may have changed meanwhile
            _put(path, target)
    except BaseException as error:
        for folder in reversed(made):
            with contextlib.suppress(OSError):
                folder.rmdir()  # unless there is something in it
        if isinstance(error, OSError):  # a full disk, for one, names no file
            path = Path(root).joinpath(*parts)
            reason = error.strerror or str(error)
            raise DatasetError(f"'{path}' cannot be written: {reason}") from error
        raise


def _parents(root: Path, names: tuple[str, ...], made: list[Path]) -> Path:
    """Makes <root>/<names>; adds new folders to `made`."""
    missing = [path for path in (root, *root.parents) if not path.exists()]
    for path in reversed(missing):
        path.mkdir(exist_ok=True)
        made.append(path)
    path = root
    for name in names:
        path = path / _plain_name(name)
        if path.is_symlink() or (path.exists() and not path.is_dir()):
            raise DatasetError(
                f"'{path}' is a link, or no folder; a folder needed, or nothing, or another --out"
            )
        if not path.exists():
            path.mkdir(exist_ok=True)
            made.append(path)
    return path


def _plain_name(name: str) -> str:
    if name in ("", ".", "..") or "/" in name or "\0" in name:
        raise DatasetError(f"name of a folder: {name!r} given; one without '/' needed")
    return name


# --- files of finished folders ---


def _files_in(folder: Path) -> Iterator[Path]:
    """All files and links below a folder; links are not followed."""
    for entry in os.scandir(folder):
        if entry.is_dir(follow_symlinks=False):
            yield from _files_in(Path(entry.path))
        else:
            yield Path(entry.path)


def _write_list(folder: Path) -> None:
    files = sorted(str(file.relative_to(folder)) for file in _files_in(folder))
    document = {"written_by": "engram.datasets", "files": files}
    (folder / LIST).write_text(json.dumps(document, indent=1) + "\n", "utf-8")


def _require_own(target: Path) -> None:
    """Refuses a path with anything but files that were written here."""
    if not os.path.lexists(target):
        return
    if target.is_symlink() or not target.is_dir():
        raise DatasetError(
            f"'{target}' is a link, or no folder; move it away, or use another --out"
        )
    listed = {LIST, *_listed(target)}
    for file in _files_in(target):
        if str(file.relative_to(target)) not in listed or file.is_symlink() or not file.is_file():
            raise DatasetError(
                f"'{file}' was not written by engram.datasets, whose files in '{target}' {LIST} "
                "lists; move the folder away, or use another --out"
            )


def _listed(target: Path) -> list[str]:
    path = target / LIST
    if not path.is_file() or path.is_symlink() or path.stat().st_size > _LARGEST_LIST:
        return []
    with reading(path):
        return [str(name) for name in json.loads(path.read_text("utf-8"))["files"]]


# --- unfinished folders ---


@contextlib.contextmanager
def _temporary(parent: Path, name: str) -> Iterator[Path]:
    """A new folder beside the target, locked until the end; removed if it is still there then."""
    with _locked(parent):  # processes make and remove temporary folders one at a time
        _remove_leftovers(parent, name)
        path = parent / _temporary_name(name)
        path.mkdir()
        lock = _lock(path)
    try:
        yield path
    finally:
        shutil.rmtree(path, ignore_errors=True)
        if lock is not None:
            os.close(lock)


def _temporary_name(name: str) -> str:
    return f"{name}.{os.getpid()}-{secrets.token_hex(4)}{_SUFFIX}"


def _remove_leftovers(parent: Path, name: str) -> None:
    """Removes folders of killed processes. Running processes hold a lock."""
    form = re.compile(re.escape(name) + r"\.([0-9]+)-[0-9a-f]{8}" + re.escape(_SUFFIX))
    for entry in sorted(os.scandir(parent), key=lambda entry: entry.name):
        found = form.fullmatch(entry.name)
        if not found or not entry.is_dir(follow_symlinks=False):
            continue
        lock = _lock(Path(entry.path))
        if lock is None:
            raise DatasetError(
                f"'{parent / name}' is being written by process {found[1]}; wait until it is done, "
                "or use another --out"
            )
        shutil.rmtree(entry.path, ignore_errors=True)
        os.close(lock)


def _put(path: Path, target: Path) -> None:
    """Moves the folder to the target; an old one is removed afterwards."""
    if not target.exists():
        path.rename(target)
        return
    old = target.parent / _temporary_name(target.name)
    target.rename(old)
    try:
        path.rename(target)
    except BaseException:
        old.rename(target)
        raise
    shutil.rmtree(old, ignore_errors=True)


def _lock(folder: Path) -> int | None:
    """A descriptor that locks a folder until it is closed; None if another process has the lock."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        return None
    except OSError:
        pass  # a file system without locks
    return descriptor


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[None]:
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        with contextlib.suppress(OSError):  # a file system without locks
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)
