"""Fuzzing of data sets: damaged or invented ones, by number, and their invariants.

    python python/tests/fuzz_datasets.py [COUNT [FIRST]]

Case n is the same on every machine that has h5py, and on every one that lacks it. Whatever a data
set holds, `python -m engram.datasets` ends by itself and says what is wrong in one line that
terminals can show; it touches nothing outside its output folder, and leaves nothing there unless it
succeeds; what it accepts is sound.
"""

from __future__ import annotations

import collections
import contextlib
import faulthandler
import hashlib
import importlib.util
import io
import json
import os
import random
import shutil
import signal
import struct
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from sound_dataset import (
    EPISODES,
    ID,
    STEPS,
    arrays_of,
    fit_checksums,
    is_sound,
    metadata_text,
    sound_metadata,
    write_sound,
)

SECONDS = 20  # that one case may take
_LIBRARIES = ("pyarrow", "av", "pandas", "PIL", "google_crc32c", "google.protobuf")


def has_libraries() -> bool:
    """True if the converters can run here."""
    return all(importlib.util.find_spec(name) for name in _LIBRARIES)


def formats() -> list[str]:
    """Those that demonstrations can be converted to here."""
    return ["rlds", "lerobot"] + ["hdf5"] * (importlib.util.find_spec("h5py") is not None)


# --- damage ---


class Touch:
    """Unpickled, it makes a file."""

    def __init__(self, path: Path):
        self.path = path

    def __reduce__(self) -> Any:
        return os.mkdir, (str(self.path),)


class Case:
    """One case: folders `in`, `out` and `outside`, and the arguments of the command."""

    def __init__(self, place: Path, number: int, template: Path):
        self.random = random.Random(number)
        self.place = place
        self.root = place / "in"
        self.outside = place / "outside"
        shutil.copytree(template, self.root)
        (self.outside / "deep").mkdir(parents=True)
        (self.outside / "keep").write_text("what others own")
        self.folder = self.root / "data_npz" / ID
        self.out = self.random.choice([self.root, self.root, place / "out"])
        kinds = [*formats(), "replay"] if has_libraries() else ["read"]
        self.kind = self.random.choice(kinds)
        self.options: list[str] = []
        self.placed = False
        self.format = self.random.choice(["npz", *formats()])
        if self.kind == "replay":
            self.options = ["--format", self.format]
        elif self.kind == "lerobot":
            self.options = self.random.choice([["--images"]] * 5 + [["--codec", "mpeg4"]])
        if self.kind in formats() and self.out != self.root:
            self.options += ["--out", str(self.out)]
        damages = [self.metadata_field, self.metadata_bytes, self.array, self.file_bytes]
        damages += [self.archive, self.places] if self.kind != "replay" else [self.stored] * 4
        damages += [self.arguments] if self.kind != "read" else []
        for damage in self.random.choices(damages, k=self.random.choice([1, 1, 1, 2])):
            damage()

    def name(self) -> str:
        """An id that is none."""
        return self.random.choice(
            [
                "../../outside", "../outside", str(self.outside), "..", ".", "", "/", "a/b-v0",
                f"{ID}/..", f"{ID}\0", f"{ID}\n", f"\x1b[2J{ID}", "x" * 5000, "outside", "\ud800",
                "../../outside/deep/x-v0", f"{ID} ", "é-v0", "C:\\x-v0", "x-v0/../../../outside",
            ]
        )  # fmt: skip

    def value(self) -> Any:
        """Anything that JSON can hold, and more."""
        return self.random.choice(
            [
                None, True, False, 0, -1, 1, 3, 2**31, 2**63, 10**30, 1e12, 1e308, 0.5, [None] * 2,
                float("nan"), float("inf"), "", "2", [], [1], [[]], [0, 1, 2], {}, {"a": 1},
                self.name(),
                [STEPS, 0], [STEPS, -STEPS], [STEPS, 2**40], ["3", "3"], [True, True], [0.0, 1.0],
                "\x1b]0;x\x07", "x" * 100_000, list(range(1000)),
            ]
        )  # fmt: skip

    # Each of these damages one thing.

    def metadata_field(self) -> None:
        metadata = sound_metadata()
        key = self.random.choice([*metadata, "env_id", "env_id", "num_episodes", "engram"])
        if self.random.random() < 0.1:
            del metadata[key]
        elif key == "engram" and self.random.random() < 0.7:
            metadata[key][self.random.choice(["renderer", "rules"])] = self.value()
        else:
            metadata[key] = self.name() if key == "env_id" else self.value()
        path = self.folder / "metadata.json"
        if path.is_file():
            path.write_text(metadata_text(metadata))

    def metadata_bytes(self) -> None:
        path = self.folder / "metadata.json"
        good = metadata_text(sound_metadata()).encode()
        made = self.random.choice(
            [
                b"", b"[" * 100_000, b"null", b"[]", b"3", b'"x"', b"\xff\xfe", b"\0" * 100, b"{",
                b'{"env_id": ' + b"9" * 5000 + b"}", good[: self.random.randrange(len(good))],
                good + good, good.replace(b"2", b"-2"), good.replace(b"3", b"3e400"),
                good.replace(b"[", b"[[").replace(b"]", b"]]"), self.flipped(good),
            ]
        )  # fmt: skip
        if path.is_dir():
            path.rmdir()
        path.unlink(missing_ok=True)
        if self.random.random() < 0.05:
            os.mkfifo(path)
        elif self.random.random() < 0.05:
            path.mkdir()
        else:
            path.write_bytes(made)

    def flipped(self, data: bytes) -> bytes:
        changed = bytearray(data)
        for _ in range(self.random.choice([1, 1, 2, 8])):
            if changed:
                changed[self.random.randrange(len(changed))] = self.random.randrange(256)
        return bytes(changed)

    def one_file(self) -> Path:
        return self.folder / f"train_data_{self.random.randrange(EPISODES)}.npz"

    def array(self) -> None:
        path = self.one_file()
        arrays: dict[str, Any] = arrays_of(int(path.stem[-1]))
        name = self.random.choice([*arrays, "action", "proprio", "episode_length"])
        good = arrays[name]
        dtypes = [
            np.float64,
            np.int8,
            np.int64,
            np.uint8,
            np.bool_,
            np.complex64,
            ">f4",
            "S5",
            "U5",
        ]
        shapes = [(), (0,), (1,), (STEPS, 6), (6, STEPS), (STEPS, 8), (STEPS + 1, 7), (STEPS, 7, 1)]
        numbers = [np.nan, np.inf, -np.inf, 1e30, -5.0, 1.0001, 0.0]
        change = self.random.randrange(7)
        if change == 0:
            del arrays[name]
        elif change == 1:
            with contextlib.suppress(ValueError):
                arrays[name] = good.astype(self.random.choice(dtypes))
        elif change == 2:
            arrays[name] = np.zeros(self.random.choice(shapes), good.dtype)
        elif change == 3 and good.dtype.kind == "f":
            arrays[name].flat[self.random.randrange(good.size)] = self.random.choice(numbers)
        elif change == 4:
            arrays[name] = np.array(Touch(self.outside / "deep" / "ran"), object)
        elif change == 5:
            texts = ["", "x" * 20_000, "\x1b[2Jx", "a\nb", "\ud800", "a\0b", "é"]
            arrays["language_instruction"] = np.array(self.random.choice(texts))
        else:
            arrays[name] = np.asfortranarray(np.full(good.shape, 2, good.dtype))
        np.savez_compressed(path, **arrays)

    def file_bytes(self) -> None:
        path = self.one_file()
        good = path.read_bytes() or b"x"
        cut = self.random.randrange(len(good))
        path.write_bytes(
            self.random.choice([self.flipped(good), good[:cut], good[cut:], b"", good * 2])
        )

    def archive(self) -> None:
        path = self.one_file()
        name = self.random.choice([*arrays_of(0)])
        shape = self.random.choice(
            ["(10000000000,)", "(3, 7)", "(-1,)", "()", "(3.0,)", "(1,)*9**9"]
        )
        header = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}".encode()
        version = self.random.choice([(1, 0), (2, 0), (3, 0), (9, 9)])
        size = struct.pack("<H" if version == (1, 0) else "<I", len(header))
        lie = b"\x93NUMPY" + bytes(version) + size + header
        methods = [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA]
        with zipfile.ZipFile(path, "w", self.random.choice(methods)) as file:
            for key, value in arrays_of(int(path.stem[-1])).items():
                content = io.BytesIO()
                np.save(content, value)
                data = content.getvalue()
                if key == name:
                    bomb = data[:128] + bytes(30_000_000)
                    data = self.random.choice([lie, bomb, data[:130], self.flipped(data), b""])
                file.writestr(f"{key}.npy", data)
            file.writestr("../../../outside/deep/slipped.npy", b"x")

    def places(self) -> None:
        """Files at the output paths."""
        parts = [f"data_{self.kind}", ID, *["1.0.0"] * (self.kind == "rlds")]
        parts = parts[: self.random.randint(1, 3)]
        path = self.out.joinpath(*parts)
        if self.placed:
            return
        self.placed = True
        shutil.rmtree(path, ignore_errors=True)
        path.parent.mkdir(parents=True, exist_ok=True)
        kind = self.random.randrange(7)
        if kind == 0:
            path.symlink_to(self.outside)
        elif kind == 1:
            path.write_text("a file")
        elif kind == 2:
            path.mkdir()
            (path / "thesis.txt").write_text("the only copy")
        elif kind == 3:
            path.symlink_to(self.place / "nowhere")
        elif kind == 4:
            path.mkdir()
            (path / ".engram_files.json").write_text(
                json.dumps({"files": ["link", "../../outside"]})
            )
            (path / "link").symlink_to(self.outside)
        elif kind == 5:
            leftover = path.parent / f"{path.name}.{self.random.randrange(99999)}.engram-tmp"
            leftover.symlink_to(self.outside)
        else:
            leftover = path.parent / f"{path.name}.77-00000000.engram-tmp"
            leftover.symlink_to(self.outside)

    def stored(self) -> None:
        """Other formats for replay."""
        files = [
            path
            for path in sorted((self.root / f"data_{self.format}").rglob("*"))
            if path.is_file() and path.suffix not in (".json", ".npz")
        ]
        if not files:
            self.array()
            return
        path = self.random.choice(files)
        data = path.read_bytes() or b"x"
        if "tfrecord" in path.name and self.random.random() < 0.8:
            self.record(path, data)
        else:
            cut = self.random.randrange(len(data))
            path.write_bytes(self.random.choice([self.flipped(data), data[:cut], b""]))
        if self.random.random() < 0.9:
            with contextlib.suppress(ValueError):  # engram.json is damaged
                fit_checksums(self.root / f"data_{self.format}")

    def record(self, path: Path, data: bytes) -> None:
        """A record whose checksums are right."""
        from engram.datasets import tf_example

        if len(data) < 100:
            return
        size = min(len(data), struct.unpack("<Q", data[:8])[0])
        body = data[12 : 12 + size]
        try:
            fields = tf_example.parse_example(body)
        except Exception:  # damaged already
            return
        name = self.random.choice([*fields])
        made: list[Any] = [[b"x"], [1.0], [7], fields[name][:-1] or [0], fields[name] * 2]
        made += [[float("nan")] * 21, [b"\xff"], [-1], [2**63 - 1], [2.0] * 21]
        fields[name] = self.random.choice(made)
        body = self.random.choice([self.flipped(body), tf_example.serialize_example(fields)])
        with open(path, "wb") as file:
            tf_example.write_record(file, body)
            file.write(data[16 + size :])

    def arguments(self) -> None:
        number = self.random.choice(["0", "-1", "1e3", "nan", "", "9" * 30, "10", "60000", "x"])
        names = {"lerobot": ["--fps", "--codec"], "replay": ["--episodes"]}
        name = self.random.choice([*names.get(self.kind, ["--jobs"]), "ID", "--out"])
        if name == "ID":
            self.options.insert(0, self.name().replace("\0", "0").replace("\ud800", "x"))
        elif name == "--codec":
            codecs = ["", "x", "gif", "rawvideo", "aac", "mjpeg", "h264;", "png"]
            self.options = ["--codec", self.random.choice(codecs)]
        elif name == "--out":
            self.options += ["--out", ""]
        else:
            self.options += [f"{name}={number}"]


def void(_: Any) -> None:
    """Discards values of expressions."""


# --- what must hold ---


def tree(place: Path) -> dict[str, Any]:
    """Everything below a folder; links are not followed."""
    found: dict[str, Any] = {}
    for entry in sorted(place.rglob("*")):
        name = str(entry.relative_to(place))
        if entry.is_symlink():
            found[name] = os.readlink(entry)
        elif entry.is_file():
            found[name] = hashlib.sha256(entry.read_bytes()).hexdigest()
        else:
            found[name] = "folder" if entry.is_dir() else "special"
    return found


def read_all(root: Path) -> int:
    """The command without its libraries: everything before the conversion."""
    from engram.datasets import DatasetError, find_folders

    try:
        for folder in find_folders(root):
            for _ in folder:
                pass
    except DatasetError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


def run(case: Case) -> tuple[int, str]:
    """The exit code and what was said."""
    from engram.datasets.__main__ import main

    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
        try:
            if case.kind == "read":
                return read_all(case.root), said.getvalue()
            code = main([case.kind, str(case.root), *case.options])
        except SystemExit as ended:
            code = int(ended.code or 0)
    return code, said.getvalue()


def problems(place: Path, number: int, template: Path) -> tuple[str, list[str]]:
    """Plays a case; returns what came of it, and what does not hold."""

    def too_late(*_: Any) -> None:
        raise TimeoutError(f"more than {SECONDS} s")

    signal.signal(signal.SIGALRM, too_late)
    case = Case(place, number, template)
    before = tree(place)
    signal.alarm(SECONDS)
    faulthandler.dump_traceback_later(2 * SECONDS, exit=True)  # if it is stuck in a library
    try:
        code, said = run(case)
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        return "raised", [f"raised {type(error).__name__}: {str(error)[:200]}"]
    finally:
        signal.alarm(0)
        faulthandler.cancel_dump_traceback_later()
    found = []
    after = tree(place)
    changed = [name for name in {*before, *after} if before.get(name) != after.get(name)]
    lines = said.splitlines()
    if not all(line.isprintable() for line in lines):
        found.append("control characters")
    refused = code != 0 and not (case.kind == "replay" and lines and " episodes in " in lines[-1])
    if refused and code == 1 and len(lines) != 1:
        found.append(f"{len(lines)} lines")
    if code != 0 or case.kind in ("replay", "read"):
        if changed:
            found.append(f"refused or read only, but changed {sorted(changed)[:3]}")
    else:
        allowed = str((case.out / f"data_{case.kind}").relative_to(place))
        beyond = [path for path in changed if path != "out" and not path.startswith(allowed)]
        if beyond:
            found.append(f"changed beyond its output: {sorted(beyond)[:3]}")
        lost = [path for path in before if path not in after and "engram" not in path]
        if any(path.endswith("thesis.txt") for path in lost):
            found.append(f"deleted {lost}")
        try:
            sound = is_sound(case.folder)
        except Exception as error:
            sound = False
            found.append(f"unreadable: {error}")
        if not sound:
            found.append("accepted what is not sound")
    return "refused" if refused else "accepted", found


def play(first: int, count: int, report: Any = None) -> tuple[collections.Counter, list[str]]:
    """Plays cases; returns how many were refused and accepted, and what does not hold."""
    memory = Path("/dev/shm")
    base = Path(tempfile.mkdtemp(dir=memory if memory.is_dir() else None))
    counts: collections.Counter = collections.Counter()
    findings: list[str] = []
    try:
        template = base / "template"
        write_sound(template)
        if has_libraries():
            from engram.datasets.__main__ import main

            with contextlib.redirect_stderr(io.StringIO()):
                for format in formats():
                    options = ["--images"] if format == "lerobot" else ["--jobs", "1"]
                    assert main([format, str(template), *options]) == 0
        for number in range(first, first + count):
            place = base / "case"
            place.mkdir()
            outcome, found = problems(place, number, template)
            counts[outcome] += 1
            findings += [f"case {number}: {text}" for text in found]
            shutil.rmtree(place)
            if report:
                report(number, findings)
    finally:
        shutil.rmtree(base, ignore_errors=True)
    return counts, findings


def main() -> int:
    """The command."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    counts, findings = play(first, count)
    print(*findings, sep="\n")
    print(f"data sets: {count} cases, {dict(counts)}, {len(findings)} findings")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
