"""``python -m engram`` is the engram command."""

from engram.command import main

main()
