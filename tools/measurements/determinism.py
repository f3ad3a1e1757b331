"""Every task in 19 configurations, which have to give the same bits: determinism.csv.

Fails, and leaves the file as it was, if anything differs.
"""

import time

from measurements import common

OBS = ("state", "rgb", "objects")


def add_options(parser):
    pass


def run(options):
    start = time.monotonic()
    rows = {}
    for row in common.run_json([options.engram, "verify"]):
        own = rows.setdefault(row["id"], {"env_steps": 0, "different": 0})
        own["env_steps"] += row["env_steps"]
        own["different"] += row["different"]
        own[row["obs"]] = row["fingerprint"]
    seconds = time.monotonic() - start
    columns = ["env_steps", "different", *OBS]
    listed = [[name, *(own[column] for column in columns)] for name, own in rows.items()]
    common.write_csv("determinism.csv", ["id", *columns], listed)
    machine = common.run([options.engram, "doctor"]).rstrip()
    text = f"In {seconds:.0f} s, on this machine:"
    common.write_section("determinism", [text, "", "```", machine, "```"])
