"""docs/gallery.md: every released policy has its film, which shows what the page says."""

from __future__ import annotations

import json
import re
import sys
from typing import Any

import pytest
from programs import RELEASED, ROOT, learners

import engram

image = pytest.importorskip("PIL.Image")

PAGE = ROOT / "docs" / "gallery.md"
MOST = 350_000  # bytes of a film
ALL = 3_000_000


sys.path.insert(0, str(ROOT / "tools"))
from pages import films  # noqa: E402

sys.path.pop(0)
FILMS = list(films.FILMS.values())
PLAYED = [film for film in FILMS if film.kind != "oracle"]


def results(film: Any) -> dict[str, Any]:
    return json.loads((film.agent.parent / "result.json").read_text())


def test_every_released_policy_has_its_film() -> None:
    released = {folder.name for folder in RELEASED.iterdir()}
    assert {film.id for film in FILMS if not film.kind} == released
    names = [name.removesuffix("-VLA-v0") for name in released]
    assert all((films.FOLDER / f"{name}.webp").is_file() for name in names)


def test_links_of_the_page_resolve_and_all_films_are_shown() -> None:
    text = PAGE.read_text()
    shown = re.findall(r"!\[[^]]+\]\(([^)]+)\)", text)
    assert sorted(shown) == sorted(f"pictures/films/{film.name}.webp" for film in FILMS)
    assert all((PAGE.parent / path).is_file() for path in shown)
    assert {path.name for path in films.FOLDER.iterdir()} == {film.file.name for film in FILMS}
    for path, anchor in re.findall(r"(?<!!)\[[^]]+\]\(([^)#]+)#?([^)]*)\)", text):
        page = (PAGE.parent / path).read_text()
        titles = re.findall(r"^#+ (.+)$", page, re.MULTILINE)
        assert not anchor or anchor in {title.lower().replace(" ", "-") for title in titles}


@pytest.mark.parametrize("film", [f for f in FILMS if not f.kind], ids=lambda film: film.name)
def test_the_page_has_the_rates_of_the_policy(film: Any) -> None:
    own, text = results(film), PAGE.read_text()
    rates = own["success_once"], own["wiped"]["success_once"]
    said = "Success in 200 episodes: {:.3f}; memory reset: {:.3f}.".format(*rates)
    assert f"`{film.id}`, seed {film.seed}. {said}" in text


def test_the_films_are_small() -> None:
    sizes = [film.file.stat().st_size for film in FILMS]
    assert max(sizes) < MOST
    assert sum(sizes) < ALL


@pytest.mark.parametrize("film", PLAYED, ids=lambda film: film.name)
def test_the_episode_is_as_the_page_says(film: Any) -> None:
    """Played again by the library; the film lasts as long (equal frames may be one)."""
    runner = learners.inference.load_runner(film.agent, film.kind == "wiped")
    given = {"obs": "rgb", "episodes": 1, "seed": film.seed, "threads": 1, "num_envs": 1}
    [task] = engram.evaluate(runner, film.id, **given)["tasks"]
    assert task["successes"] == [film.succeeds]
    with image.open(film.file) as shown:
        times = []
        for i in range(shown.n_frames):
            shown.seek(i)
            shown.load()
            times.append(shown.info["duration"])
    between = task["episode_lengths"][0] - 1
    assert sum(times) == films.FIRST + between * 1000 // films.RATE + films.LAST
    assert times[0] >= films.FIRST
    assert set(times[1:-1]) == {1000 // films.RATE}
    assert times[-1] >= films.LAST
