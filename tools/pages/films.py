"""Records the films of docs/gallery.md again, or those that are named.

Needs engram, torch, PyAV and Pillow: build/python-env/bin/python.

Every film is one call of `engram record`, whose video becomes an animated WebP that pages show like
any picture. Its first and its last frame stay for longer. The same versions of the encoders write
the same bytes.
"""

import argparse
import json
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent.parent
FOLDER = ROOT / "docs" / "pictures" / "films"
RELEASED_FOLDER = ROOT / "python" / "learners" / "released"
VIEW = ("--camera", "all", "--size", "256", "--sensor-size", "128")
RATE = 20  # control steps per second
FIRST, LAST = 1000, 2000  # milliseconds of the first and the last frame
QUALITY = 50
# The benchmark's first episode in which a memory that has been reset guesses wrong.
SEED = 4242424242
GUESSED_RIGHT = {
    "FindImposterColor5": 1,
    "FindImposterShape3": 3,
}  # episodes before that
RELEASED = sorted(folder.name.removesuffix("-VLA-v0") for folder in RELEASED_FOLDER.iterdir())


class Film(NamedTuple):
    """An episode. kind: "" of a released policy, "wiped" with its memory reset, or "oracle"."""

    task: str  # without "-VLA-v0"
    kind: str = ""

    @property
    def id(self):
        return f"{self.task}-VLA-v0"

    @property
    def seed(self):
        return SEED + GUESSED_RIGHT.get(self.task, 0)

    @property
    def name(self):
        return f"{self.task}-{self.kind}" if self.kind else self.task

    @property
    def file(self):
        return FOLDER / f"{self.name}.webp"

    @property
    def agent(self):
        return RELEASED_FOLDER / self.id / "agent.pt"

    @property
    def succeeds(self):
        return self.kind != "wiped"

    def command(self, out):
        """Words of the command that records it."""
        words = [
            sys.executable,
            "-m",
            "engram",
            "record",
            self.id,
            "--seed",
            str(self.seed),
        ]
        if self.kind == "oracle":
            words += ["--policy", "oracle"]
        else:
            policy = [sys.executable, "-m", "engram_learners.serve", str(self.agent)]
            policy += ["--wiped"] if self.kind == "wiped" else []
            words += ["--obs", "rgb", "--policy-command", shlex.join(policy)]
        return [*words, *VIEW, "--fps", str(RATE), "--hold", "0,0", "--out", str(out), "--json"]


FILMS = {
    film.name: film
    for film in [
        *(Film(task) for task in RELEASED),
        *(Film(task, "wiped") for task in RELEASED if task != "InterceptMedium"),
        *(Film(task, "oracle") for task in ("RememberColor9",)),
    ]
}


def record(film, video):
    """Writes the video; returns how many frames it has."""
    done = subprocess.run(film.command(video), capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{film.name}: {done.stderr.strip()}")
    report = json.loads(done.stdout)
    if report["success_once"] != film.succeeds:
        sys.exit(f"{film.name}: success_once is {report['success_once']}")
    return report["frames"]


def animate(video, out):
    """Writes an animated WebP of the video's frames."""
    import av

    with av.open(str(video)) as source:
        frames = [frame.to_image() for frame in source.decode(video=0)]
    between = [1000 // RATE] * (len(frames) - 2)
    frames[0].save(
        out,
        save_all=True,
        append_images=frames[1:],
        duration=[FIRST, *between, LAST],
        loop=0,
        quality=QUALITY,
        method=4,
    )


def main(given, prog):
    parser = argparse.ArgumentParser(prog=prog, description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"default: {', '.join(FILMS)}")
    names = parser.parse_args(given).names
    unknown = [name for name in names if name not in FILMS]
    if unknown:
        parser.error(f"{', '.join(unknown)} given; allowed: {', '.join(FILMS)}")
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in names or FILMS:
        film = FILMS[name]
        with tempfile.TemporaryDirectory() as folder:
            video = Path(folder) / "film.mp4"
            frames = record(film, video)
            animate(video, film.file)
        print(f"{name}: {frames} frames, {film.file.stat().st_size} bytes", flush=True)
