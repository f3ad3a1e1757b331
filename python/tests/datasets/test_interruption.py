"""Ctrl-C in the commands of data sets."""

from __future__ import annotations

import signal
import sys
import weakref

from engram.datasets.__main__ import _Interruption


class Deleted:
    pass


def test_a_ctrl_c_that_python_loses_is_noted_and_not_printed(capsys, monkeypatch):
    monkeypatch.setattr(sys, "unraisablehook", sys.__unraisablehook__)  # not pytest's
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with _Interruption() as interruption:
            watched = Deleted()
            reference = weakref.ref(watched, lambda _: signal.raise_signal(signal.SIGINT))
            del watched
    finally:
        signal.signal(signal.SIGINT, before)
    assert reference() is None
    assert interruption.noted
    assert capsys.readouterr().err == ""
