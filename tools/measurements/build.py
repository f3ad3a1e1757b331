"""What a build costs: steps, processor time and wall time; writes nothing.

Cold: everything is compiled, without ccache. Second: nothing to do. Changed: a core file is newer.
"""

import os
import resource
import time

from measurements import common

CHANGED = "core/sim/simulator.cc"


def add_options(parser):
    parser.add_argument(
        "--folder",
        default=str(common.ROOT / "build" / "measured"),
        help="build folder, made if need be; default: build/measured",
    )
    parser.add_argument(
        "--target", default="engram_cli", help="what is built; default: engram_cli, as run.sh does"
    )
    parser.add_argument(
        "--warm", action="store_true", help="without the cold build: the folder has been built"
    )


def run(options):
    os.environ["CCACHE_DISABLE"] = "1"
    cmake = ["cmake", "-S", common.ROOT, "-B", options.folder, "-G", "Ninja"]
    build = ["cmake", "--build", options.folder, "--target", options.target]
    if not options.warm:
        measure("configure", [*cmake, "-DCMAKE_BUILD_TYPE=Release"])
        measure("cold", [*build, "--clean-first"])
    measure("second", build)
    (common.ROOT / CHANGED).touch()
    measure("changed", build)


def measure(name, command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.monotonic()
    output = common.run(command)
    wall = time.monotonic() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    steps = sum(" Building " in line or " Linking " in line for line in output.splitlines())
    times = f"{processor:>8.1f} s processor {wall:>8.1f} s wall"
    print(f"{name:<10} {steps:>4} steps {times}", flush=True)
