"""Random machines of several kinds, closed at home by how they are built."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import pmjac_pin as pj

KINDS = ("loop of seven", "crank and rod", "hexaglide", "planar loop", "geared loop")


def random_machine(seed):
    """Return one of KINDS, by the seed."""
    rng = np.random.default_rng([seed, 71])
    return _BUILDERS[KINDS[seed % len(KINDS)]](rng)


class Tree:
    """A tree under construction, with the world pose of each joint at home."""

    def __init__(self):
        self.model = pin.Model()
        self.poses = {0: pin.SE3.Identity()}

    def joint(self, parent, name, pose, kind="revolute"):
        """Add a joint along z of this world pose; return its index."""
        kinds = {"revolute": pin.JointModelRZ, "prismatic": pin.JointModelPZ}
        kinds["free"] = pin.JointModelFreeFlyer
        joint = kinds[kind]()
        no = np.full(joint.nv, 1e9)
        wide = np.full(joint.nq, 1e9)
        place = self.poses[parent].actInv(pose)
        index = self.model.addJoint(parent, joint, place, name, no, no, -wide, wide)
        self.poses[index] = pose
        return index

    def frame(self, body, name, pose):
        """Add a frame of this world pose."""
        place = self.poses[body].actInv(pose)
        self.model.addFrame(pin.Frame(name, body, place, pin.FrameType.OP_FRAME), False)


def random_pose(rng, reach=1.0):
    return pin.SE3(pin.exp3(rng.normal(size=3)), rng.uniform(-reach, reach, 3))


def at(point):
    return pin.SE3(np.eye(3), np.asarray(point, dtype=float))


def loop_of_seven(rng):
    """A general single loop of seven joints: mobility 1."""
    tree, body = Tree(), 0
    slides = rng.integers(1, 7, size=2)
    for k in range(7):
        kind = "prismatic" if k in slides else "revolute"
        body = tree.joint(body, f"j{k}", random_pose(rng), kind)
        if k == 3:
            tree.frame(body, "tool", random_pose(rng))
    tree.frame(body, "end", at([0, 0, 0]))
    tree.frame(0, "base", at([0, 0, 0]))
    loop = pj.FrameLoop(frames=("end", "base"))
    return pj.Mechanism.from_pinocchio(tree.model, [loop], ["j0"], "tool", name="seven")


def crank_and_rod(rng):
    """Two hinges anywhere and a rod between them: mobility 1."""
    tree = Tree()
    ends = []
    for name in ("crank", "rocker"):
        body = tree.joint(0, name, random_pose(rng))
        end = tree.poses[body].act(rng.uniform(-1, 1, 3))
        tree.frame(body, f"{name}_end", at(end))
        ends.append(end)
    length = float(np.linalg.norm(ends[0] - ends[1]))
    loop = pj.DistanceLoop(frames=("crank_end", "rocker_end"), length=length)
    return pj.Mechanism.from_pinocchio(tree.model, [loop], ["crank"], "rocker_end", name="rod")


def hexaglide(rng):
    """Six sliders on the ground hold a platform by six rods: mobility 6."""
    tree = Tree()
    sliders = [tree.joint(0, f"s{k}", random_pose(rng), "prismatic") for k in range(6)]
    plate = tree.joint(0, "plate", random_pose(rng), "free")
    loops = []
    for k, slider in enumerate(sliders):
        point = tree.poses[plate].act(rng.uniform(-0.7, 0.7, 3))
        tree.frame(slider, f"a{k}", tree.poses[slider])
        tree.frame(plate, f"b{k}", at(point))
        length = float(np.linalg.norm(point - tree.poses[slider].translation))
        loops.append(pj.DistanceLoop(frames=(f"a{k}", f"b{k}"), length=length))
    tree.frame(plate, "tool", tree.poses[plate] * random_pose(rng, 0.2))
    motors = [f"s{k}" for k in range(6)]
    return pj.Mechanism.from_pinocchio(tree.model, loops, motors, "tool", name="hexaglide")


def planar_loop(rng, geared=False):
    """A four-bar of random lengths in a random plane; its motor geared to the crank or on it."""
    tree, plane = Tree(), random_pose(rng)
    corners = np.hstack([rng.uniform(-1, 1, (4, 2)), np.zeros((4, 1))])
    hinges = [plane * at(corner) for corner in corners]
    crank = tree.joint(0, "crank", hinges[0])
    coupler = tree.joint(crank, "coupler", hinges[1])
    rocker = tree.joint(0, "rocker", hinges[3])
    tree.frame(coupler, "one", hinges[2])
    tree.frame(rocker, "other", hinges[2])
    tree.frame(coupler, "tool", plane * at([*rng.uniform(-1, 1, 2), 0.3]))
    loops, motors = [pj.PointLoop(frames=("one", "other"))], ["crank"]
    if geared:
        tree.joint(0, "motor", random_pose(rng))
        loops.append(pj.JointLoop(joints=("motor", "crank"), ratio=10.0 ** rng.uniform(-5, 5)))
        motors = ["motor"]
    return pj.Mechanism.from_pinocchio(tree.model, loops, motors, "tool", name="planar")


_BUILDERS = {
    "loop of seven": loop_of_seven,
    "crank and rod": crank_and_rod,
    "hexaglide": hexaglide,
    "planar loop": planar_loop,
    "geared loop": lambda rng: planar_loop(rng, geared=True),
}


def planar_four_bar(coupler, rocker, ends, motors, **options):
    """Hinges a at the origin, b between crank and coupler, c on the ground; the ends of b and c."""
    tree = Tree()
    a = tree.joint(0, "a", at([0, 0, 0]))
    b = tree.joint(a, "b", at([*coupler, 0]))
    c = tree.joint(0, "c", at([*rocker, 0]))
    for joint, frame, end in zip((b, c), ("bt", "ct"), ends, strict=True):
        tree.frame(joint, frame, at([*end, 0]))
    loops = [pj.PointLoop(frames=("bt", "ct"))]
    return pj.Mechanism.from_pinocchio(tree.model, loops, motors, "bt", **options)
