"""Value and derivative of all rows are Pinocchio's: over every number type, kind of loop and joint.

Where a number type has no roots, a tilt is Pinocchio's by cos(α/2), and a turn by sin(α)/α.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from flint import Ordering, fmpq_mpoly_ctx
from mechanisms import mostly_slow

import pmjac_pin as pj
from pmjac_pin.algebra.balls import Balls, precise, uppers
from pmjac_pin.algebra.boxes import Boxes
from pmjac_pin.algebra.floats import Floats
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.polynomials import Polynomials, symbols
from pmjac_pin.algebra.programs import Programs
from pmjac_pin.algebra.rooted_programs import RootedPrograms
from pmjac_pin.algebra.series import SeriesAlgebra
from pmjac_pin.algebra.terms import Recording, Term
from pmjac_pin.kinematics.loop_system import LoopSystem
from pmjac_pin.kinematics.loops import Loops, by_twists, riding
from pmjac_pin.kinematics.tree import Poses, Tree
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.joint_kind import JointMotion
from pmjac_pin.model.joint_kinds import JOINT_KINDS
from pmjac_pin.model.loop_spec import LOOP_KINDS

SLANTED = (0.6, 0.0, 0.8)
LOOPS = {
    "point": lambda pair: pj.PointLoop(frames=pair),
    "spherical": lambda pair: pj.SphericalLoop(frames=pair),
    "distance": lambda pair: pj.DistanceLoop(frames=pair, length=0.7),
    "frame": lambda pair: pj.FrameLoop(frames=pair),
    "revolute": lambda pair: pj.RevoluteLoop(frames=pair, axis=SLANTED),
    "prismatic": lambda pair: pj.PrismaticLoop(frames=pair, axis=(0, 1, 0)),
    "cylindrical": lambda pair: pj.CylindricalLoop(frames=pair, axis=(1, -2, 0.5)),
    "planar": lambda pair: pj.PlanarLoop(frames=pair),
    "universal": lambda pair: pj.UniversalLoop(frames=pair, axes=((1, 1, 0), (0, 0, 1))),
}
JOINTS = {
    "revolute": pin.JointModelRevoluteUnaligned(np.array(SLANTED)),
    "revolute x": pin.JointModelRX(),
    "continuous": pin.JointModelRUBY(),
    "prismatic": pin.JointModelPrismaticUnaligned(np.array(SLANTED)),
    "prismatic y": pin.JointModelPY(),
    "helical": pin.JointModelHelicalUnaligned(np.array(SLANTED), 0.3),
    "helical x": pin.JointModelHX(-0.2),
    "spherical": pin.JointModelSpherical(),
    "translation": pin.JointModelTranslation(),
    "planar": pin.JointModelPlanar(),
    "free": pin.JointModelFreeFlyer(),
}


def random_place(rng):
    return pin.SE3(pin.exp3(rng.normal(size=3)), rng.uniform(-1, 1, 3))


def machine(joint, rng):
    """Two chains on a body that turns: such a joint in the one, and one in the other."""
    model = pin.Model()

    def add(parent, name, joint, place):
        return model.addJoint(parent, joint, place, name)

    base = add(0, "base", pin.JointModelRZ(), random_place(rng))
    body = add(base, "turn", pin.JointModelRY(), pin.SE3(np.eye(3), np.array([0.3, 0, 0])))
    body = add(body, "first", joint, random_place(rng))
    one = add(body, "slide", pin.JointModelPX(), random_place(rng))
    body = add(base, "endless", pin.JointModelRUBX(), random_place(rng))
    two = add(body, "second", joint, pin.SE3.Identity())
    for name, joint in (("one", one), ("two", two), ("on base", base)):
        frame = pin.Frame(name, joint, random_place(rng), pin.FrameType.OP_FRAME)
        model.addFrame(frame, False)
    return model


def closed_frame(model, q):
    """Add a frame on the body of "two" that is where "one" is at q; return its name."""
    data, name = model.createData(), f"shut {model.nframes}"
    pin.framesForwardKinematics(model, data, q)
    two = find_frame(model, "two").joint
    place = data.oMi[two].actInv(data.oMf[model.getFrameId("one")])
    model.addFrame(pin.Frame(name, two, place, pin.FrameType.OP_FRAME), False)
    return name


def pinocchios(model, loop, q):
    """η, ∂η/∂v and the units, seen from the last body that carries both frames."""
    system, data = LoopSystem(model, [loop], {}), model.createData()
    scratch = system.create_data()
    pin.computeJointJacobians(model, data, q)
    residual, jacobian = system.evaluate(model, data, scratch, q)
    one, two = (find_frame(model, name) for name in loop.frames)
    base = Tree(model).base(one, two)
    turning = [
        pin.getJointJacobian(model, data, joint, pin.LOCAL_WORLD_ALIGNED)[3:]
        if joint
        else np.zeros((3, model.nv))
        for joint in (two.joint, base)
    ]
    second = data.oMi[two.joint].rotation @ two.placement.rotation
    for start in range(len(residual) - 2):
        if system.row_names[start].endswith(" x"):
            rows = slice(start, start + 3)
            in_base = data.oMi[base].rotation.T if base else np.eye(3)
            world = second @ residual[rows]
            rates = second @ jacobian[rows] - pin.skew(world) @ (turning[0] - turning[1])
            residual[rows], jacobian[rows] = in_base @ world, in_base @ rates
    return residual, jacobian, [name.split()[-2] for name in system.row_names]


def without_roots(residual, jacobian, words):
    """Tilts by cos(α/2), turns by sin(α)/α, and what the cosine of the angle is then."""
    residual, jacobian, cosine = residual.copy(), jacobian.copy(), None
    for word in ("tilt", "turn"):
        rows = [k for k, other in enumerate(words) if other == word]
        if not rows:
            continue
        eta, rates = residual[rows], jacobian[rows]
        size = np.linalg.norm(eta)
        along = eta @ rates
        if word == "tilt":
            half = np.sqrt(1.0 - size**2 / 4.0)
            residual[rows] = half * eta
            jacobian[rows] = half * rates - np.outer(eta, along) / (4.0 * half)
            cosine = 1.0 - size**2 / 2.0
        else:
            factor = np.sinc(size / np.pi)
            slope = (np.cos(size) - factor) / size**2 if size > 1e-3 else -1.0 / 3.0
            residual[rows] = factor * eta
            jacobian[rows] = factor * rates + slope * np.outer(eta, along)
            cosine = np.cos(size)
    return residual, jacobian, cosine


def motions(model, q):
    """The numbers by which each link moves at q, as floats."""
    floats = Floats()

    def motion(link):
        return link.kind.motion(floats, q[link.entries][:, None, None], link.edge.pitch)

    return motion


def as_numbers(motion, of):
    """The same motion in another number type."""

    def mapped(link):
        floats = motion(link)
        return JointMotion(tuple(map(of, floats.slides)), tuple(map(of, floats.turn)))

    return mapped


def middles(balls):
    return np.array([float(ball.mid()) for ball in balls.ravel()]).reshape(balls.shape)


def assembled(loops, blocks, nv, middle):
    """All rows, their derivatives and the cosine as arrays, each number by its `middle`."""
    residual, jacobian = np.zeros(loops.count), np.zeros((loops.count, nv))
    cosine = None
    for (rows, _), block in zip(loops.pairs[0].blocks, blocks, strict=True):
        residual[rows] = middle(block.rows.value)[:, 0, 0]
        if block.rows.columns:
            jacobian[rows, block.rows.columns] = middle(block.rows.rates)[:, :, 0]
        if block.cosine is not None:
            cosine = float(middle(block.cosine.value)[0, 0])
    return residual, jacobian, cosine


def by_floats(loops, model, q, rooted, way):
    poses = Poses(
        loops.tree, Floats(rooted), motions(model, q), range(model.nv) if way is riding else ()
    )
    return assembled(loops, way(loops.pairs[0], poses), model.nv, lambda x: x)


def by_complex_floats(loops, model, q):
    """On the real axis, by the entries that complex steps start from."""
    motion = as_numbers(motions(model, q), lambda x: x.astype(complex))
    poses = Poses(loops.tree, Floats(rooted=False), motion)
    blocks = by_twists(loops.pairs[0], poses)
    for block in blocks:
        assert (np.imag(block.rows.value) == 0.0).all()
    return assembled(loops, blocks, model.nv, np.real)


def by_boxes(loops, model, q, way):
    motion = as_numbers(motions(model, q), Intervals.exact)
    poses = Poses(loops.tree, Boxes(), motion, range(model.nv) if way is riding else ())
    blocks = way(loops.pairs[0], poses)
    for block in blocks:
        for part in (block.rows.value, block.rows.rates):
            assert part is None or part.width.max() < 1e-11
    return assembled(loops, blocks, model.nv, lambda x: x.middle)


def by_series(loops, model, q, way):
    algebra = SeriesAlgebra(2, 3)
    motion = as_numbers(motions(model, q), lambda x: algebra.boxes(Intervals.exact(x)))
    poses = Poses(loops.tree, algebra, motion, range(model.nv) if way is riding else ())
    blocks = way(loops.pairs[0], poses)
    return assembled(loops, blocks, model.nv, lambda x: x.value.middle)


def by_balls(loops, model, q, way):
    balls = Balls()
    with precise():
        motion = as_numbers(motions(model, q), lambda x: balls.constant(x[0, 0]))
        poses = Poses(loops.tree, balls, motion, range(model.nv) if way is riding else ())
        blocks = way(loops.pairs[0], poses)
        for block in blocks:
            assert uppers(block.rows.value - middles(block.rows.value)).max() < 1e-12
        return assembled(loops, blocks, model.nv, middles)


def by_polynomials(loops, model, q):
    """The numbers of one joint are variables, the others' are rational."""
    motion, rational, point = motions(model, q), Polynomials(), []
    first = model.getJointId("first")
    context = fmpq_mpoly_ctx.get([f"n{k}" for k in range(7)], Ordering.degrevlex)
    variables = context.gens()

    def mapped(link):
        floats = motion(link)
        exact = [rational.constant(x[0, 0]) for x in (*floats.slides, *floats.turn)]
        if link.edge.child == first:
            point.extend(float(x[0, 0]) for x in (*floats.slides, *floats.turn))
            exact = [symbols([variables[k]])[None] for k in range(len(exact))]
        return JointMotion(tuple(exact[: len(floats.slides)]), tuple(exact[len(floats.slides) :]))

    poses = Poses(loops.tree, rational, mapped, range(model.nv))
    blocks = riding(loops.pairs[0], poses)

    def at_point(array):
        values = np.empty(array.shape)
        at = [*point, *[0.0] * (7 - len(point))]
        values.ravel()[:] = [_evaluated(one, at) for one in array.ravel()]
        return values

    return assembled(loops, blocks, model.nv, at_point)


def _evaluated(polynomial, point):
    if not hasattr(polynomial, "to_dict"):
        return float(polynomial)
    return sum(
        float(coefficient) * np.prod([x ** int(k) for x, k in zip(point, powers, strict=True)])
        for powers, coefficient in polynomial.to_dict().items()
    )


def by_programs(loops, model, q, programs, way):
    """Recorded over the entries of q, and then run term by term."""
    recording = Recording(model.nq)
    entries = programs.numbers(recording.inputs)

    def motion(link):
        return link.kind.motion(programs, entries[link.entries], link.edge.pitch)

    riders = range(model.nv) if way is riding else ()
    blocks = way(loops.pairs[0], Poses(loops.tree, programs, motion, riders))
    values = run(recording, q)

    def at_point(array):
        known = [values[x.index] if isinstance(x, Term) else x for x in array.ravel().tolist()]
        return np.array(known, dtype=float).reshape(array.shape)

    return assembled(loops, blocks, model.nv, at_point)


def run(recording, q):
    operations = {
        "input": lambda index: q[index],
        "+": lambda x, y: x + y,
        "-": lambda x, y: x - y,
        "*": lambda x, y: x * y,
        "neg": lambda x: -x,
        "/": lambda x, y: x / y,
        "sqrt": np.sqrt,
        "atan2": np.arctan2,
        "max": np.maximum,
        "copysign": np.copysign,
        "round": np.round,
        "sin": np.sin,
        "cos": np.cos,
    }
    values = []
    for term in recording.terms:
        operands = [values[x.index] if isinstance(x, Term) else x for x in term.operands]
        values.append(operations[term.operation](*operands))
    return values


NUMBERS = {
    "floats, twists": lambda *case: by_floats(*case, True, by_twists),
    "floats, riding": lambda *case: by_floats(*case, True, riding),
    "floats without roots, twists": lambda *case: by_floats(*case, False, by_twists),
    "floats without roots, riding": lambda *case: by_floats(*case, False, riding),
    "complex floats, twists": by_complex_floats,
    "boxes, twists": lambda *case: by_boxes(*case, by_twists),
    "boxes, riding": lambda *case: by_boxes(*case, riding),
    "series, twists": lambda *case: by_series(*case, by_twists),
    "series, riding": lambda *case: by_series(*case, riding),
    "balls, twists": lambda *case: by_balls(*case, by_twists),
    "balls, riding": lambda *case: by_balls(*case, riding),
    "polynomials, riding": by_polynomials,
    "programs, twists": lambda *case: by_programs(*case, Programs(), by_twists),
    "programs, riding": lambda *case: by_programs(*case, Programs(), riding),
    "rooted programs, twists": lambda *case: by_programs(*case, RootedPrograms(), by_twists),
    "rooted programs, riding": lambda *case: by_programs(*case, RootedPrograms(), riding),
}


WITH_ROOTS = (
    "floats, twists",
    "floats, riding",
    "rooted programs, twists",
    "rooted programs, riding",
)


def cases(model, kind, rng):
    """A loop of the kind and a pose: off closure, with a frame on the common body, on closure."""
    q = pin.integrate(model, pin.neutral(model), rng.normal(size=model.nv))
    yield LOOPS[kind](("one", "two")), q
    yield LOOPS[kind](("on base", "one")), q
    shut = closed_frame(model, q)
    yield LOOPS[kind]((shut, "one")), q


def check(model, tree, loop, q, exact):
    """Compare all number types with Pinocchio."""
    # Near half a turn Pinocchio's own derivative of the logarithm loses digits.
    near = np.pi - np.linalg.norm(exact[0][[word == "turn" for word in exact[2]]])
    bound = 1e-11 / min(near, 1.0) ** 2
    loops = Loops(model, tree, [loop], {})
    for number, evaluated in NUMBERS.items():
        expected = (*exact[:2], None) if number in WITH_ROOTS else without_roots(*exact)
        residual, jacobian, cosine = evaluated(loops, model, q)
        np.testing.assert_allclose(residual, expected[0], atol=1e-12, err_msg=number)
        np.testing.assert_allclose(jacobian, expected[1], atol=bound, err_msg=number)
        assert (cosine is None) == (expected[2] is None), number
        assert cosine is None or cosine == pytest.approx(expected[2], abs=1e-12), number


# Each kind of joint and each kind of loop three times or more.
EVERY = [(kind, joint) for kind in LOOPS for joint in JOINTS]
SOME = [
    (kind, joint)
    for k, kind in enumerate(LOOPS)
    for n, joint in enumerate(JOINTS)
    if (k + n) % 3 == 0
]


@pytest.mark.parametrize(("kind", "joint"), mostly_slow(EVERY, SOME))
def test_value_and_derivative_are_pinocchios(kind, joint, rng):
    model = machine(JOINTS[joint], rng)
    for loop, q in cases(model, kind, rng):
        check(model, Tree(model), loop, q, pinocchios(model, loop, q))


def test_every_kind_of_loop_is_tried():
    """A gear has no frames: test_many_loops.py, test_recorded.py, test_certificate_rows.py."""
    assert set(LOOPS) == set(LOOP_KINDS) - {"joint"}


def test_every_kind_of_joint_is_tried():
    tried = {name.split()[0] for name in JOINTS}
    known = {name for name, kind in JOINT_KINDS.items() if kind.nv and not kind.in_turn}
    assert tried >= known
