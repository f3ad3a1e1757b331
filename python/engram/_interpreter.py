"""Refuses subinterpreters, before the extension is loaded.

There the lock that its calls release and take again would be the main interpreter's: they would
never return. Loading it there would also break it in the main interpreter.
"""

import importlib


def _is_main() -> bool:
    for name in ("_interpreters", "_xxsubinterpreters"):  # from Python 3.13 on, and before
        try:
            interpreters = importlib.import_module(name)
        except ImportError:
            continue
        return bool(interpreters.get_current() == interpreters.get_main())
    return True  # a Python that has no others


if not _is_main():
    raise ImportError("engram works in the main interpreter only; this is a subinterpreter")
