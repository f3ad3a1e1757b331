"""render_mode="human"."""

from __future__ import annotations

import sys

import gymnasium
import numpy as np
import pytest
from conftest import TASK

import engram


@pytest.fixture
def pygame(monkeypatch):
    """The module pygame, with a dummy display."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    return pytest.importorskip("pygame")


def shown(pygame) -> np.ndarray:
    """Contents of the window, (height, width, 3)."""
    return pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1)


@pytest.mark.parametrize("maker", [engram.make, gymnasium.make])
def test_a_window_shows_every_step(pygame, maker):
    env = maker(f"engram/{TASK}", render_mode="human", render_size=(96, 64))
    plain = engram.make(TASK, render_mode="rgb_array", render_size=(96, 64))
    env.reset(seed=0)
    plain.reset(seed=0)
    np.testing.assert_array_equal(shown(pygame), plain.render())
    for _ in range(3):
        action = plain.act("random")
        env.step(action)
        plain.step(action)
        np.testing.assert_array_equal(shown(pygame), plain.render())
    assert env.render() is None
    assert TASK in pygame.display.get_caption()[0]
    env.close()
    env.close()
    assert not pygame.display.get_init()
    plain.close()


def test_without_a_display_there_is_an_error(pygame, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "nothing")
    with pytest.raises(engram.UnavailableError, match="no window can be opened here"):
        engram.make(TASK, render_mode="human")


def test_without_pygame_there_is_an_error(monkeypatch):
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(engram.UnavailableError, match="pip install pygame"):
        engram.make(TASK, render_mode="human")


@pytest.mark.parametrize("mode", ["ansi", "rgb_array_list", 3, ["human"]])
def test_other_modes_are_refused(mode):
    with pytest.raises(engram.InvalidArgumentError, match="allowed: human, rgb_array, None"):
        engram.make(TASK, render_mode=mode)


def test_gymnasium_collects_pictures():
    env = gymnasium.make(f"engram/{TASK}", render_mode="rgb_array_list", render_size=16)
    env.reset(seed=0)
    env.step(env.unwrapped.act("zero"))
    assert [picture.shape for picture in env.render()] == [(16, 16, 3)] * 2
    env.close()
