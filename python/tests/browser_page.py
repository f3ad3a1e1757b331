"""The page of `engram play` in a real browser: fixtures and helpers of its tests."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from play_server import Server

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
PICTURES = os.environ.get("ENGRAM_PLAY_PICTURES")  # a folder for screenshots
SECONDS = 60  # limit for every wait


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api")
    if CHROMIUM is None:
        pytest.skip("chromium is not installed")
    with playwright.sync_playwright() as starter:
        sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
        running = starter.chromium.launch(executable_path=CHROMIUM, args=sandbox)
        yield running
        running.close()


@pytest.fixture
def opened(browser, server: Server) -> Iterator[Callable[..., Any]]:
    """Opens the page; console messages and requests to other origins fail the test."""
    wrong: list[str] = []
    contexts = []

    def open_page(**context: Any) -> Any:
        script = context.pop("script", None)
        contexts.append(
            browser.new_context(**{"viewport": {"width": 1280, "height": 900}, **context})
        )
        if script:
            contexts[-1].add_init_script(script)
        page = contexts[-1].new_page()
        page.set_default_timeout(SECONDS * 1000)
        page.on("console", lambda message: wrong.append(message.text))
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("request", lambda request: _check_address(request.url, server, wrong))
        page.goto(server.link)
        page.wait_for_selector("body[data-ready]")
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert wrong == []


def _check_address(url: str, server: Server, wrong: list[str]) -> None:
    if not url.startswith((server.link, "blob:", "data:")):
        wrong.append(f"asked for {url}")


def until(page: Any, condition: str) -> None:
    """Waits until an expression is true. Playwright's own function needs a forbidden eval."""
    end = time.monotonic() + SECONDS
    while not page.evaluate(condition):
        assert time.monotonic() < end, condition
        time.sleep(0.02)


def screenshot(page: Any, name: str) -> None:
    if PICTURES:
        page.screenshot(path=f"{PICTURES}/{name}.png", full_page=True)
