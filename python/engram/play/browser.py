"""Opens the page in a browser.

Command lines can be read by all users of a machine, so the browser's must not contain the address.
It opens a file that only its user can read, which leads to the address.
"""

from __future__ import annotations

import html
import os
import shutil
import tempfile
import threading
import webbrowser
from pathlib import Path

_NAME = "engram_play.html"
_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>engram play</title>
<meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0; url={link}"></head>
<body><a href="{link}">engram play</a></body></html>
"""


class Browser:
    """A file that leads to the page, as long as it is needed."""

    def __init__(self) -> None:
        self._folder: str | None = None

    def open(self, link: str) -> None:
        """Opens the link. A file that cannot be written is an OSError."""
        self._folder = tempfile.mkdtemp(prefix="engram-play-")  # for this user alone
        file = Path(self._folder) / _NAME
        descriptor = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
        with os.fdopen(descriptor, "w") as out:
            out.write(_PAGE.format(link=html.escape(link)))
        # Some browsers return only when they are closed.
        threading.Thread(target=webbrowser.open, args=(file.as_uri(),), daemon=True).start()

    def close(self) -> None:
        """Removes the file; the page is open, or will not be opened any more."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None
