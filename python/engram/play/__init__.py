"""``engram play``: choose a task, play it, watch policies play it, in a browser on this machine.

``engram.play.app`` serves one page to one tab. ``engram.play.messages`` checks the messages of the
page, ``engram.play.session`` answers them. Needs aiohttp and Pillow.
"""
