"""Servers for the tests of `engram play`."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from played import Server, serving


@pytest.fixture(scope="module")
def server(tmp_path_factory) -> Iterator[Server]:
    """One for all tests of a file; tabs come and go."""
    with serving(tmp_path_factory.mktemp("play") / "played") as running:
        yield running
