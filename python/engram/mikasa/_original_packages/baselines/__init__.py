"""Stands in for the package in processes that ``python -m engram.mikasa`` has started."""

import engram.mikasa.alias  # noqa: F401 (puts engram's module in this one's place)
