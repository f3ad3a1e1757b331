"""Files that appear complete or not at all, in folders that no link leads out of."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import re
import secrets
from collections.abc import Iterator
from pathlib import Path

__all__ = [
    "InUseError",
    "UnsafeFolderError",
    "open_folder",
    "remove_leftovers",
    "replacing",
    "write_file",
]

_SUFFIX = ".engram-tmp"  # of temporary files, as the engram command names them
_TEMPORARY = re.compile(r".*\.[0-9a-f]+" + re.escape(_SUFFIX))


class InUseError(OSError):
    """Another process writes to the folder."""


class UnsafeFolderError(OSError):
    """A link, or no folder, is where a folder is needed."""


@contextlib.contextmanager
def open_folder(root: Path, *parts: str, lock: bool = False) -> Iterator[int]:
    """Makes and opens <root>/<parts>; the value is its descriptor.

    `root` is the caller's choice and may be a link; the parts must not. Files written through
    the descriptor stay in the folder, whatever takes its name meanwhile.

    Args:
        root: Folder that the caller names.
        *parts: Names below it.
        lock: True: keeps other processes that lock it out until the end.

    Raises:
        InUseError: Another process has locked it.
        UnsafeFolderError: A part is a link or no folder.
    """
    root.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(root, os.O_RDONLY | os.O_DIRECTORY)
    path = root
    for part in parts:
        path = path / part
        descriptor = _enter(descriptor, part, path)
    try:
        if lock:
            _lock(descriptor, path)
        yield descriptor
    finally:
        os.close(descriptor)


def _enter(parent: int, name: str, path: Path) -> int:
    """Opens the folder of that name in `parent`, made if need be; closes `parent`."""
    try:
        with contextlib.suppress(FileExistsError):
            os.mkdir(name, dir_fd=parent)
        return os.open(name, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW, dir_fd=parent)
    except OSError as error:
        if error.errno in (errno.ELOOP, errno.ENOTDIR):
            raise UnsafeFolderError(f"'{path}' is a link, or no folder; a folder needed") from None
        raise
    finally:
        os.close(parent)


def _lock(descriptor: int, path: Path) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise InUseError(f"another process writes to '{path}'") from None
    except OSError:
        pass  # a file system without locks


def write_file(folder: int, name: str, content: bytes) -> None:
    """Writes a file in an open folder; an old one, or a link, is replaced when it is complete."""
    temporary = f"{name}.{secrets.token_hex(8)}{_SUFFIX}"
    new = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW
    try:
        with open(os.open(temporary, new, 0o666, dir_fd=folder), "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, name, src_dir_fd=folder, dst_dir_fd=folder)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(temporary, dir_fd=folder)
        raise


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A path to write to; it becomes the file when the block ends, and replaces a link."""
    temporary = path.with_name(f"{path.name}.{secrets.token_hex(8)}{_SUFFIX}")
    try:
        yield temporary
        os.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise


def is_temporary(name: str) -> bool:
    """True for the names of temporary files."""
    return _TEMPORARY.fullmatch(name) is not None


def remove_leftovers(folder: int) -> None:
    """Removes temporary files of killed processes; for the holder of the folder's lock."""
    for name in os.listdir(folder):
        if is_temporary(name):
            with contextlib.suppress(OSError):
                os.unlink(name, dir_fd=folder)
