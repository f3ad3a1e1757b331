"""Pictures beside the original's: difference, tone, grain and outlines. Writes nothing.

Needs an interpreter with the package, Pillow and, in a folder, the original's pictures with their
index.json: of each, file, id, camera, step and the draws that pin its episode.
"""

import json
from pathlib import Path

from measurements.common import ROOT

BODIES = ["link0", "link1", "link2", "link3", "link4", "link5", "link6", "link7"]
BODIES += ["hand", "camera_link", "leftfinger", "rightfinger"]
WINDOW = 32  # pixels
BANDS = [0, 1.5 / 32, 3.1 / 32, 6.1 / 32, 0.51]  # 1 / wavelength: over 21, 21, 10 and 5 pixels


def add_options(parser):
    parser.add_argument("originals", type=Path, metavar="FOLDER", help="the original's pictures")


def draw(original, images={}):  # noqa: B006, of all steps and cameras of an episode
    """(128, 128, 3) and the body of each pixel; the arm held still, the gripper open."""
    import numpy as np

    import engram

    key = json.dumps([original[name] for name in ("id", "step", "pins")])
    if key not in images:
        options = {"obs_mode": "rgb+segmentation", "freeze_cue": False, "pins": original["pins"]}
        env = engram.make(original["id"], **options)
        observation, _ = env.reset(seed=0)
        action = np.zeros(env.action_space.shape, np.float32)
        action[-1] = 1
        for _ in range(original["step"]):
            observation = env.step(action)[0]
        names = env.batch.description["segmentation_names"]
        images[key] = observation["rgb"].copy(), observation["segmentation"].copy(), names
        env.close()
    rgb, bodies, names = images[key]
    camera = ("base_camera", "hand_camera").index(original["camera"])
    return rgb[..., 3 * camera : 3 * camera + 3].astype(float), bodies[..., camera], names


def is_wood(rgb):
    red, green, blue = rgb[..., 0], rgb[..., 1], rgb[..., 2]
    return (red - blue > 30) & (green > blue) & (green > 0.5 * red) & (green < 0.75 * red)


def is_robot(rgb):
    """Grey; the floor is blue beside it."""
    blue = rgb[..., 2] - rgb[..., 0]
    return (blue < 5.5) & (blue > -14)


def spectrum(rgb, wood):
    """Power of the grain, relative to brightness, by bands across (rows) and along (columns)."""
    import numpy as np

    window = np.outer(*2 * [np.hanning(WINDOW + 2)[1:-1]])
    window /= np.sqrt((window**2).mean())
    y, x = np.mgrid[:WINDOW, :WINDOW]
    plane = np.stack([np.ones(WINDOW**2), x.ravel(), y.ravel()], 1)
    frequency = np.abs(np.fft.fftfreq(WINDOW))
    bands = [(frequency >= a) & (frequency < b) for a, b in zip(BANDS, BANDS[1:], strict=False)]
    level, found = rgb.mean(-1), []
    for top in range(0, len(level) - WINDOW + 1, WINDOW // 2):
        for left in range(0, len(level) - WINDOW + 1, WINDOW // 2):
            part = np.s_[top : top + WINDOW, left : left + WINDOW]
            if wood[part].mean() < 0.995:
                continue
            smooth = plane @ np.linalg.lstsq(plane, level[part].ravel(), rcond=None)[0]
            grain = (level[part] / smooth.reshape(WINDOW, WINDOW) - 1) * window
            power = np.abs(np.fft.fft2(grain)) ** 2 / WINDOW**4
            found.append([[power[np.ix_(a, b)].sum() for b in bands] for a in bands])
    return found


def overlap(one, other):
    return (one & other).sum() / max((one | other).sum(), 1)


def compare(originals, folder):
    """Prints the figures of one camera's pictures."""
    import numpy as np
    from PIL import Image

    pairs = []
    for original in originals:
        theirs = np.asarray(Image.open(folder / original["file"]).convert("RGB")).astype(float)
        pairs.append((theirs, *draw(original)))
    woods = [is_wood(a) & is_wood(b) for a, b, _, _ in pairs]
    print(f"  mean difference of bytes {np.mean([abs(a - b).mean() for a, b, _, _ in pairs]):.2f}")
    on_wood = [abs(a - b)[wood].mean() for (a, b, _, _), wood in zip(pairs, woods, strict=True)]
    print(f"  the same, of the table's pixels {np.mean(on_wood):.2f}")
    off_wood = [
        abs(a - b)[is_robot(a) | np.isin(bodies, [names.index(n) for n in BODIES])].mean()
        for a, b, bodies, names in pairs
    ]
    print(f"  the same, of the robot's pixels {np.mean(off_wood):.2f}")
    outlines = [overlap(is_robot(a), is_robot(b)) for a, b, _, _ in pairs]
    print(f"  outline of the robot, intersection over union {np.mean(outlines):.3f}")
    for index, name in enumerate(("the original's", "engram's")):
        pixels = np.concatenate([p[index][wood] for p, wood in zip(pairs, woods, strict=True)])
        levels = np.percentile(pixels.mean(-1), [1, 5, 25, 50, 75, 95, 99])
        print(f"  {name} table: mean {pixels.mean(0).round(1)}, deviation {pixels.std(0).round(1)}")
        print(f"    percentiles 1, 5, 25, 50, 75, 95, 99: {levels.round(0)}")
        power = np.mean(
            [s for p, wood in zip(pairs, woods, strict=True) for s in spectrum(p[index], wood)], 0
        )
        print(f"    grain {np.sqrt(power.sum()):.4f}; deviation x 1000 by bands across, along:")
        for row in np.sqrt(power) * 1000:
            print("     ", " ".join(f"{value:6.1f}" for value in row))
    for body in BODIES:
        shown = [bodies == names.index(body) for _, _, bodies, names in pairs]
        if not any(mask.any() for mask in shown):
            continue
        colors = [
            np.concatenate([p[i][mask] for p, mask in zip(pairs, shown, strict=True)]).mean(0)
            for i in (0, 1)
        ]
        print(f"  {body}: the original's {colors[0].round(0)}, engram's {colors[1].round(0)}")


def count_links():
    """Prints how many pixels of the base camera show each body, as the test has it."""
    links = json.loads((ROOT / "tests" / "data" / "original_link_pixels.json").read_text())
    sums = {}
    for original in links:
        pins = {"robot_noise": original["robot_noise"]}
        start = {"id": "RememberColor9-VLA-v0", "camera": "base_camera", "step": 0, "pins": pins}
        _, bodies, names = draw(start)
        for body, pixels in original["pixels"].items():
            off, shown = sums.get(body, (0, 0))
            ours = int((bodies == names.index(body)).sum())
            sums[body] = off + abs(ours - pixels), shown + pixels
    for body, (off, shown) in sums.items():
        print(f"{body}: {off} pixels too many or too few of {shown}")


def run(options):
    index = json.loads((options.originals / "index.json").read_text())
    for camera in ("base_camera", "hand_camera"):
        originals = [entry for entry in index if entry["camera"] == camera]
        print(f"{camera}: {len(originals)} pictures")
        compare(originals, options.originals)
    count_links()
