"""Convex meshes of a user's as props."""

from __future__ import annotations

import struct
from contextlib import closing
from typing import ClassVar

import numpy as np
import pytest

import engram
from engram import kit

# A wedge: a triangle of 4 cm by 4 cm, 6 cm long along y. Its base is z = 0.
TRIANGLE = [(-0.02, 0.0), (0.02, 0.0), (0.0, 0.04)]
WEDGE = np.array([(x, y, z) for x, z in TRIANGLE for y in (-0.03, 0.03)])
FACES = [(0, 2, 4), (1, 5, 3), (0, 1, 3), (0, 3, 2), (2, 3, 5), (2, 5, 4), (4, 5, 1), (4, 1, 0)]
BRICK = np.array([(x, y, z) for x in (-0.02, 0.02) for y in (-0.02, 0.02) for z in (-0.02, 0.02)])


class Meshes(engram.Task):
    """Meshes fall from 2 cm over the table; scripts push the first one or lift it."""

    PROPS: ClassVar[list[kit.Prop]] = []
    termination = "never"

    def build(self):
        self.all = self.add_props(self.PROPS)
        self.draw_real("turn", -3, 3, width=len(self.PROPS), unit="rad", text="about z")
        self.add_info("pos", np.float64, width=(len(self.PROPS), 3), privileged=True)
        self.add_info("quat", np.float64, width=(len(self.PROPS), 4), privileged=True)

    def reset(self):
        for i, prop in enumerate(self.PROPS):
            half = self.turn.reshape(self.n, -1)[:, i] / 2
            quat = np.stack([kit.cos(half), 0 * half, 0 * half, kit.sin(half)], axis=1)
            height = (prop.resting_height or 0) + 0.02
            self.place(self.all[i], (-0.1, 0.15 * i, height), quat, awake=True)

    def evaluate(self):
        self.pos[:] = self.prop_pos.reshape(self.pos.shape)
        self.quat[:] = self.prop_quat.reshape(self.quat.shape)

    def reward(self):
        return np.zeros(self.n)

    def oracle(self):  # lifts
        above = np.array([-0.1, 0, 0.02])
        grasps, lifts = self.elapsed >= 25, self.elapsed >= 32
        self.servo(self.descend(above, 0.15), gripper=kit.GRIPPER_OPEN)
        self.servo(above, gripper=-1, where=grasps)
        self.servo(np.add(above, [0, 0, 0.15]), gripper=-1, where=lifts)

    def sweep(self):  # pushes along y
        beside = np.array([-0.1, -0.1, 0.02])
        self.servo(self.descend(beside, 0.15))
        self.servo(np.add(beside, [0, 0.14, 0]), where=self.elapsed >= 30)


def made(*props, num_envs=4, **options):
    """A batch with these props."""
    cls = type("MeshesOf", (Meshes,), {"PROPS": list(props), "__module__": __name__})
    engram.register_task(cls, "Meshes-v0", 80, "Wait.", family="Meshes")
    options.setdefault("autoreset_mode", "DISABLED")
    options.setdefault("threads", 2)
    return closing(engram.make_vec("Meshes-v0", num_envs, privileged=True, **options))


def played(env, steps, policy="zero"):
    info = {}
    for _ in range(steps):
        *_, info = env.step(env.act(policy))
    props = len(env.description["props"])
    return {name: info[name].reshape(env.num_envs, props, -1) for name in ("pos", "quat")}


# --- files ---


def write_obj(path):
    lines = [f"v {x} {y} {z}" for x, y, z in WEDGE * 1000]
    lines += [f"f {a + 1}//1 {b + 1}//1 {c + 1}//1" for a, b, c in FACES]
    path.write_text("# wedge\no wedge\nvn 0 0 1\n" + "\n".join(lines) + "\n")


def write_binary_stl(path):
    content = b"solid in name only".ljust(80) + struct.pack("<I", len(FACES))
    for face in FACES:
        content += struct.pack("<12fH", 0, 0, 0, *np.ravel(WEDGE[list(face)] * 1000), 0)
    path.write_bytes(content)


def write_text_stl(path):
    facets = [
        "facet normal 0 0 0\n outer loop\n"
        + "".join("  vertex {} {} {}\n".format(*(WEDGE[i] * 1000)) for i in face)
        + " endloop\nendfacet\n"
        for face in FACES
    ]
    path.write_text("solid wedge\n" + "".join(facets) + "endsolid\n")


@pytest.mark.parametrize(
    ("name", "write"),
    [("w.obj", write_obj), ("w.stl", write_binary_stl), ("text.STL", write_text_stl)],
)
def test_files_have_the_points_of_their_mesh(tmp_path, name, write):
    write(tmp_path / name)
    mesh = kit.Mesh("wedge", tmp_path / name, scale=0.001)
    np.testing.assert_allclose(sorted(mesh.vertices), sorted(WEDGE.tolist()), atol=1e-7)
    assert mesh.resting_height == pytest.approx(0)
    assert "file" not in mesh.definition()


def mesh_of(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    return lambda: kit.Mesh("m", tmp_path / name)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.ply", b"ply", "ends in .obj or .stl"),
        ("a.obj", b"f 1 2 3\n", "has no vertices"),
        ("a.obj", b"v 1 2\n", "2 coordinates, 3 needed"),
        ("a.obj", b"v 1 2 x\n", "could not convert"),
        ("a.stl", b"\0" * 90, "no STL file"),
        ("a.stl", b"solid x\nendsolid", "has no vertices"),
        ("a.stl", b"solid x vertex 1 2", "a.stl: "),
        ("a.obj", b"v 1 2 3\n" * 9, "1 points given; 4 to 20000 allowed"),
    ],
)
def test_files_without_a_mesh_are_refused(tmp_path, name, content, message):
    with pytest.raises(engram.InvalidArgumentError, match=message):
        mesh_of(tmp_path, name, content)()


def test_other_mistakes_are_refused(tmp_path):
    with pytest.raises(engram.IoError, match=r"none\.stl: No such file"):
        kit.Mesh("m", tmp_path / "none.stl")
    for arguments, message in [
        ({}, "neither given"),
        ({"file": "a.obj", "vertices": BRICK}, "both given"),
        ({"vertices": BRICK[:, :2]}, r"shape \(8, 2\) given; \(n, 3\) needed"),
        ({"vertices": "brick"}, "numbers of shape"),
        ({"vertices": BRICK * np.nan}, "finite"),
        ({"vertices": BRICK, "scale": 0}, "more than 0"),
    ]:
        with pytest.raises(engram.InvalidArgumentError, match=message):
            kit.Mesh("m", **arguments)


@pytest.mark.parametrize(
    ("vertices", "message"),
    [
        (BRICK * [1, 1, 0], "prop 'm': 'vertices': its points are flat"),
        (BRICK * 1000, "'vertices' reach from -20 to 20, -2 to 2 m allowed"),
    ],
)
def test_meshes_without_a_solid_are_refused(vertices, message):
    with pytest.raises(engram.InvalidArgumentError, match=message):
        made(kit.Mesh("m", vertices=vertices))


# --- physics ---

WIDE = BRICK * [1, 2, 0.2]
TURNED = {"turn": [0.0]}


def test_a_mesh_of_a_cube_weighs_and_rests_as_a_cube():
    with made(kit.Cube("cube"), kit.Mesh("brick", vertices=BRICK)) as env:
        env.reset(seed=0)
        masses = [prop["mass"] for prop in env.description["props"]]
        assert masses[1] == pytest.approx(masses[0])
        height = played(env, 30)["pos"][:, :, 2]
        np.testing.assert_allclose(height, 0.02, atol=2e-4)


@pytest.mark.parametrize("vertices", [WEDGE, BRICK, WIDE], ids=["wedge", "brick", "plate"])
def test_meshes_come_to_rest_and_stay(vertices):
    with made(kit.Mesh("m", vertices=vertices)) as env:
        env.reset(seed=1)
        before = played(env, 30)
        after = played(env, 40)
        np.testing.assert_allclose(before["pos"][:, 0, 2], -vertices[:, 2].min(), atol=3e-4)
        np.testing.assert_allclose(after["pos"], before["pos"], atol=1e-4)
        np.testing.assert_allclose(after["quat"], before["quat"], atol=1e-3)


@pytest.mark.parametrize("vertices", [WEDGE, BRICK], ids=["wedge", "brick"])
def test_the_gripper_pushes_a_mesh(vertices):
    with made(kit.Mesh("m", vertices=vertices), pins=TURNED) as env:
        env.reset(seed=2)
        start = played(env, 28, "sweep")["pos"][:, 0]
        end = played(env, 40, "sweep")["pos"][:, 0]
        assert (np.abs(start[:, 1]) < 0.002).all()
        assert (end[:, 1] > 0.03).all()
        np.testing.assert_allclose(end[:, 2], -vertices[:, 2].min(), atol=2e-3)


def test_the_gripper_lifts_a_mesh_and_keeps_it():
    with made(kit.Mesh("m", vertices=BRICK), pins=TURNED) as env:
        env.reset(seed=3)
        lifted = played(env, 60, "oracle")
        kept = played(env, 18, "oracle")
        assert (lifted["pos"][:, 0, 2] > 0.12).all()
        np.testing.assert_allclose(kept["pos"][:, 0, 2], lifted["pos"][:, 0, 2], atol=5e-3)


def test_parts_with_meshes_make_bodies_that_are_not_convex():
    beam = BRICK * [0.5, 2, 0.5]
    tee = kit.Parts(
        "tee",
        geoms=[
            kit.Geom("mesh", vertices=beam, color="red"),
            kit.Geom("mesh", vertices=beam[:, [1, 0, 2]] + [0.05, 0, 0], color="blue"),
        ],
    )
    with made(tee, num_envs=2) as env:
        env.reset(seed=0)
        height = played(env, 30)["pos"][:, 0, 2]
        np.testing.assert_allclose(height, 0.01, atol=2e-4)


# --- pictures and observations ---


def test_a_mesh_looks_like_the_box_it_is():
    pictures = []
    for prop in (
        kit.Box("thing", half_size=(0.02, 0.04, 0.03), body="visual", color="blue"),
        kit.Mesh("thing", vertices=BRICK * [1, 2, 1.5], body="visual", color="blue"),
    ):
        options = {"obs_mode": "rgb+depth+segmentation", "num_envs": 1, "pins": {"turn": [0.5]}}
        with made(prop, **options) as env:
            observation, _ = env.reset(seed=0)
            segment = env.description["segmentation_names"].index("thing")
            shown = observation["segmentation"] == segment
            assert shown.sum() > 100
            pictures.append({key: value.copy() for key, value in observation.items()})
    box, mesh = pictures
    # The mesh's numbers have single precision.
    for key, least in (("rgb", 12), ("depth", 2), ("segmentation", 0)):
        unlike = np.abs(box[key].astype(int) - mesh[key].astype(int)) > least
        assert unlike.mean() < 2e-3, key


def test_a_mesh_is_an_object_of_no_named_shape():
    with made(kit.Mesh("m", vertices=WEDGE, color="blue"), obs_mode="objects_dict") as env:
        env.reset(seed=0)
        for _ in range(25):
            observation, *_ = env.step(env.act("zero"))
        objects = {name: value[:, 0] for name, value in observation["objects"].items()}
        assert (objects["seen"] == 1).all()
        np.testing.assert_allclose(objects["size"], [[0.4, 0.6, 0.4]] * 4, atol=1e-5)  # of 5 cm
        assert (objects["shape"] == 0).all()
        assert (objects["color"].argmax(axis=1) == 2).all()


# --- as all tasks ---


def test_episodes_do_not_depend_on_batch_and_threads_and_snapshots_continue():
    props = [kit.Mesh("a", vertices=WEDGE), kit.Mesh("b", vertices=BRICK), kit.Cube("c")]
    found = []
    for num_envs, threads in ((6, 1), (6, 2), (2, 2)):
        with made(*props, num_envs=num_envs, threads=threads) as env:
            env.reset(seed=list(range(20, 20 + num_envs)))
            info = played(env, 40, "sweep")
            found.append(np.concatenate([info["pos"][:2].ravel(), info["quat"][:2].ravel()]))
            if num_envs == 6:
                state = env.save(3)
                expected = played(env, 20, "sweep")["pos"][3].copy()
                env.restore(state, 0)
                np.testing.assert_array_equal(played(env, 20, "sweep")["pos"][0], expected)
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])


TASK_FILE = """
import numpy as np, pathlib
import engram
from engram import kit

STONE = pathlib.Path(__file__).parent / "stone.obj"


class Stones(engram.Task):
    termination = "success"
    answer = "the stone that is touched"
    hidden = "target"

    def build(self):
        self.candidates = 2
        self.stones = self.add_props(
            kit.Mesh(f"stone_{c}", STONE, scale=0.001, color=c) for c in ("red", "blue"))
        self.draw_integer("target", 0, 1, text="the stone to touch")
        self.draw_places("spots", 2, (-0.2, -0.2), (0.05, 0.2), least_distance=0.12, text="spots")
        self.add_phases(("cue", 4), "act")

    def advance(self):
        self.place(self.stones[self.target], (0, 0), where=self.begins("cue"))
        self.place(self.stones, self.spots, where=self.begins("act"))

    def evaluate(self):
        acts = self.in_phase("act")
        self.answer_by_touch(self.pos_of(self.stones), self.target, 0.06, where=acts)

    def reward(self):
        return self.success * 1.0

    def oracle(self):
        self.go(self.target)

    def blind(self):
        self.go(self.guess(2))

    def go(self, key):
        self.rest()
        self.touch(self.pos_of(self.stones[key]) + (0, 0, 0.05), where=self.in_phase("act"))


engram.register_task(Stones, "Stones-v0", 40, "Touch the stone that was shown.")
"""


def test_a_task_with_meshes_passes_the_checks(tmp_path):
    write_obj(tmp_path / "stone.obj")
    (tmp_path / "stones.py").write_text(TASK_FILE)
    report = kit.check(str(tmp_path / "stones.py"), fast=True)
    assert report.ok, str(report)
