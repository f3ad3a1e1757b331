"""``engram play``: choose a task, play it, watch others play it, in a browser on this machine.

``engram.play.app`` serves one page to one tab. What the page sends is checked in
``engram.play.messages``; ``engram.play.session`` answers it. Needs ``pip install "engram[play]"``.
"""
