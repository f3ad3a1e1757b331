"""Imports of the original's packages, served by engram: programs need no change.

    import engram.mikasa.alias  # before the program's own imports

    import mikasa_robo_suite.vla.memory_envs
    from mikasa_robo_suite.vla.utils.apply_wrappers import apply_mikasa_vla_wrappers

``mikasa_robo_suite``, ``baselines`` and ``mani_skill`` then have those of the original's modules
and names that engram.mikasa has; others are refused with a sentence. For a program that cannot be
edited, ``python -m engram.mikasa PROGRAM`` does the same. Installed packages of these names are not
hidden unless that is asked for (``install``). ``uninstall`` takes the names back.
"""

from __future__ import annotations

from engram.mikasa._alias_modules import install, uninstall

__all__ = ["install", "uninstall"]

install()
