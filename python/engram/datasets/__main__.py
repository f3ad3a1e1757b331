"""The command `python -m engram.datasets`."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import importlib
import json
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn

from engram import load_tasks
from engram._distribution import install_command
from engram.datasets import additions, checks, collected, lerobot_options
from engram.datasets.checks import DatasetError
from engram.datasets.episodes import find_metadata
from engram.datasets.spaces import ANGLES
from engram.datasets.work import ahead

_FORMATS = ("rlds", "lerobot", "hdf5")  # that demonstrations are converted to
_LEROBOT_OPTIONS = dataclasses.fields(lerobot_options.Options)


def main(arguments: list[str] | None = None) -> int:
    options = _parser().parse_args(arguments)
    interruption = _Interruption()
    try:
        with interruption:
            for file in getattr(options, "tasks", ()):
                load_tasks(file)
            results = options.run_all(options)
    except KeyboardInterrupt:
        return 130
    except (DatasetError, OSError) as error:
        if interruption.noted:
            return 130
        print(f"engram.datasets: {DatasetError(str(error))}", file=sys.stderr)
        return 1
    except UnicodeEncodeError as error:  # of a file's name, in a C locale without UTF-8 mode
        print(
            f"engram.datasets: {checks.short(error.object)} given, which the locale's encoding "
            "cannot hold; a UTF-8 locale, or PYTHONUTF8=1, needed",
            file=sys.stderr,
        )
        return 1
    except ModuleNotFoundError as error:
        extra = "hdf5" if error.name == "h5py" else "datasets"
        print(
            f"engram.datasets: {error}; `{install_command(extra)}` brings it",
            file=sys.stderr,
        )
        return 1
    if options.json:
        print(json.dumps(results, indent=2))
    return 0 if all(result.get("equal", True) for result in results) else 1


def run() -> NoReturn:
    """The whole command."""
    sys.exit(main())


class _Interruption:
    """Notes a Ctrl-C, and takes signals that end the process for one.

    Python loses a KeyboardInterrupt that comes while it deletes an object, and prints it; the
    stream that the Ctrl-C ends as well then looks as if it had failed.
    """

    def __init__(self) -> None:
        self.noted = False
        self._before: dict[int, Any] = {}
        self._print_lost = sys.unraisablehook

    def __enter__(self) -> _Interruption:
        if threading.current_thread() is not threading.main_thread():
            return self
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            self._print_lost = sys.unraisablehook
            sys.unraisablehook = self._lost
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1):
            before = signal.getsignal(number)
            if before in (signal.default_int_handler, signal.SIG_DFL):
                self._before[number] = before
                signal.signal(number, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)
        if self._before.get(signal.SIGINT) is signal.default_int_handler:
            sys.unraisablehook = self._print_lost

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.noted = True
        signal.default_int_handler(number, frame)

    def _lost(self, lost: sys.UnraisableHookArgs) -> None:
        if not issubclass(lost.exc_type, KeyboardInterrupt):
            self._print_lost(lost)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m engram.datasets",
        description="Converts the demonstrations of `engram collect`, or replays them.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def add(name, words, run):
        command = commands.add_parser(name, help=words, description=words)
        command.add_argument(
            "folder", type=_folder, metavar="FOLDER", help="what holds data_npz/<id>"
        )
        command.add_argument(
            "ids", nargs="*", metavar="ID", help="tasks; default: all that are there"
        )
        command.add_argument(
            "--json", action="store_true", help="one JSON document on standard output"
        )
        command.set_defaults(run=run, run_all=_run_folders)
        return command

    rlds = add("rlds", "Writes OUT/data_rlds/<id>/1.0.0, for tensorflow_datasets", _convert("rlds"))
    lerobot = add("lerobot", "Writes OUT/data_lerobot/<id>, a LeRobotDataset", _convert("lerobot"))
    hdf5 = add("hdf5", "Writes OUT/data_hdf5/<id>, as robomimic reads it", _convert("hdf5"))
    for command in (rlds, lerobot, hdf5):
        command.add_argument("--out", type=_folder, help="default: FOLDER")
        _add_additions(command)
    _add_jobs(rlds)
    _add_jobs(hdf5)
    _add_lerobot_options(lerobot)

    words = "Writes OUT/data_<format>/<id> while `engram collect` plays, without NPZ between"
    collect = commands.add_parser("collect", help=words, description=words)
    collect.add_argument("--format", choices=_FORMATS, required=True)
    collect.add_argument("ids", nargs="+", metavar="ID")
    collect.add_argument("--out", type=_folder, required=True)
    collect.add_argument("--json", action="store_true")
    collected.add_arguments(collect)
    _add_additions(collect)
    _add_lerobot_options(collect)
    collect.set_defaults(run_all=_collect)

    replay = add(
        "replay", "Plays stored actions in fresh environments and compares what they show", _replay
    )
    _add_jobs(replay)
    replay.add_argument(
        "--tasks",
        action="append",
        default=[],
        metavar="FILE",
        help="file of tasks of your own that the demonstrations are of (repeatable)",
    )
    replay.add_argument("--format", choices=("npz", *_FORMATS), default="npz")
    replay.add_argument(
        "--episodes",
        type=_whole(1, checks.MAX_EPISODES),
        help="only the first N of each task",
    )
    return parser


def _add_jobs(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--jobs",
        type=_whole(0, checks.MAX_JOBS),
        default=0,
        help="threads; 0: one per core (default)",
    )


def _add_additions(command: argparse.ArgumentParser) -> None:
    for name in additions.MAPS:
        command.add_argument(
            f"--{name}", action="store_true", help=f"also the {name} of `engram collect --{name}`"
        )
    for name in additions.ROWS:
        command.add_argument(
            f"--{name}", action="store_true", help=f"also the rows of `engram collect --{name}`"
        )
    command.add_argument(
        "--labels",
        action="store_true",
        help="also subtasks, plan, memory and the other labels of `engram collect --labels`, "
        "which are privileged: targets, not inputs",
    )


def _add_lerobot_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--version",
        choices=lerobot_options.VERSIONS,
        default="3.0",
        help="of the format: 3.0 (default), or 2.1 for lerobot 0.3, openpi and GR00T",
    )
    command.add_argument(
        "--fps",
        type=_whole(1, checks.MAX_FPS),
        default=lerobot_options.FPS,
        help=f"frames per second of time stamps, default {lerobot_options.FPS}: real time",
    )
    frames = command.add_mutually_exclusive_group()
    frames.add_argument(
        "--frames",
        choices=lerobot_options.FRAMES,
        default="videos",
        help="videos (default), images (PNG, lossless), or auto: images where a few episodes "
        "take up no more of them",
    )
    frames.add_argument(
        "--images", action="store_const", const="images", dest="frames", help="--frames images"
    )
    command.add_argument(
        "--codec",
        help=f"encoder of videos; default: {lerobot_options.ENCODER}",
    )
    command.add_argument(
        "--angles",
        choices=ANGLES,
        default=ANGLES[0],
        help="of the TCP in observation.state: continuous (default), or with the benchmark's jumps "
        "between -pi and pi",
    )
    command.add_argument(
        "--modality",
        choices=lerobot_options.MODALITIES,
        help="gr00t: meta/modality.json and an annotation column, with --version 2.1",
    )


def _folder(text: str) -> Path:
    if not text:
        raise argparse.ArgumentTypeError("'' given; the name of a folder needed")
    return Path(text)


def _whole(low: int, high: int):
    """A converter of whole numbers from low to high."""

    def convert(text: str) -> int:
        try:
            return checks.whole_number("value", int(text), low, high)
        except (ValueError, DatasetError):
            raise argparse.ArgumentTypeError(
                f"{text!r} given; a whole number from {low} to {high} needed"
            ) from None

    return convert


def _run_folders(options) -> list[dict]:
    format = getattr(options, "format", "npz")  # of what is replayed
    folders = find_metadata(options.folder, format, options.ids)
    return [options.run(folder, options) for folder in folders]


def _format_options(name: str, given) -> dict[str, Any]:
    """The options of a format among those that are given."""
    if name == "lerobot":
        return {field.name: getattr(given, field.name) for field in _LEROBOT_OPTIONS}
    return {addition: getattr(given, addition) for addition in additions.ADDITIONS}


def _collect(given) -> list[dict]:
    """Tasks that are there already, from the same collection, are left as they are.

    The next task's stream begins while one is written, so that neither waits for the other.
    """
    writer = _module(given.format)
    options = _format_options(given.format, given)
    results = []
    with contextlib.ExitStack() as streams:

        def begun() -> Iterator[tuple[collected.CollectedEpisodes, bool]]:
            for env_id in dict.fromkeys(given.ids):
                episodes = collected.collect(given, env_id)
                is_there = writer.is_written(episodes, given.out, **options)
                yield episodes if is_there else streams.enter_context(episodes), is_there

        with ahead(begun()) as coming:
            for episodes, is_there in coming:
                if is_there:
                    print(f"{episodes.env_id}: there already", file=sys.stderr)
                    continue
                with _Progress(episodes) as progress:
                    path = writer.convert(episodes, given.out, progress=progress, **options)
                episodes.close()
                results.append(_result(episodes, path, given.format))
    return results


def _convert(name: str) -> Callable[..., dict]:
    """The command that converts to a format."""

    def convert(folder, given) -> dict:
        options = _format_options(name, given)
        if name != "lerobot":
            options["jobs"] = given.jobs
        with _Progress(folder) as progress:
            path = _module(name).convert(
                folder, given.out or given.folder, progress=progress, **options
            )
        return _result(folder, path, name)

    return convert


def _module(name: str) -> Any:
    """What writes a format; it imports libraries."""
    return importlib.import_module(f"engram.datasets.{name}")


def _replay(folder, options) -> dict:
    from engram.datasets import replay

    with _Progress(folder) as progress:
        return replay.compare(
            folder, options.folder, options.format, options.episodes, progress, options.jobs
        )


def _result(folder, path: Path, name: str) -> dict:
    return {
        "env_id": folder.env_id,
        "out": str(path),
        "format": name,
        "episodes": len(folder),
        "steps": sum(folder.metadata["episode_lengths"]),
    }


class _Progress:
    """One line on standard error: a count while it runs, where it is a terminal, and the time."""

    def __init__(self, folder):
        self.name = folder.env_id
        self.start = time.monotonic()
        self.next = self.start + 2
        self.done = 0

    def __enter__(self):
        return self

    def __call__(self, done: int, total: int) -> None:
        self.done = done
        now = time.monotonic()
        if sys.stderr.isatty() and now >= self.next:
            self.next = now + 0.2
            print(
                f"\r\033[K{self.name}: {done} of {total} episodes",
                end="",
                file=sys.stderr,
                flush=True,
            )

    def __exit__(self, kind, *_) -> None:
        if sys.stderr.isatty():
            print("\r\033[K", end="", file=sys.stderr)
        if kind is None:
            seconds = time.monotonic() - self.start
            print(f"{self.name}: {self.done} episodes in {seconds:.1f} s", file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
