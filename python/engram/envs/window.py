"""A window that shows images, as Gymnasium's own environments open one."""

from __future__ import annotations

from typing import Any

import numpy as np

from engram.errors import UnavailableError


class Window:
    """Open from its construction to ``close``.

    Args:
        title: Of the window.
        size: Width and height in pixels.
        rate: Images per second: ``show`` waits until it is time for the next one.

    Raises:
        UnavailableError: There is no pygame, or no display.
    """

    def __init__(self, title: str, size: tuple[int, int], rate: int) -> None:
        try:
            import pygame
        except ImportError:
            raise UnavailableError(
                "render_mode: 'human' given, which needs pygame: pip install pygame; "
                "'rgb_array' needs nothing"
            ) from None
        self._pygame: Any = pygame
        self._rate = rate
        try:
            pygame.display.init()
            self._surface: Any = pygame.display.set_mode(size)
        except pygame.error as error:
            raise UnavailableError(
                f"render_mode: 'human' given, but no window can be opened here ({error}); "
                "'rgb_array' needs none"
            ) from None
        pygame.display.set_caption(title)
        self._clock = pygame.time.Clock()

    def show(self, image: np.ndarray) -> None:
        """Shows uint8 (height, width, 3), row 0 on top."""
        surface = self._pygame.surfarray.make_surface(image.swapaxes(0, 1))
        self._surface.blit(surface, (0, 0))
        self._pygame.event.pump()
        self._pygame.display.flip()
        self._clock.tick(self._rate)

    def close(self) -> None:
        """Closes it; a second time is allowed."""
        if self._surface is not None:
            self._surface = None
            self._pygame.display.quit()
