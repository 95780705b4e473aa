"""How hard a gripper grips
========================

One motor closes two jaws: on either side a crank pushes, by a rod, an arm inwards, and a second arm
beside it keeps the jaw upright; the left crank is geared to the right one. The nearer crank and rod
are to a straight line, the harder the jaws press for the same torque: how hard, at which opening?
"""

# %%
# The machine is made in Pinocchio, one side as the other's mirror image: x outwards, z to the part.
# Angles count outwards on both sides.
import numpy as np
import pinocchio as pin
from scipy.optimize import brentq

import pmjac_pin as pj

CRANK, ROD, ARM, LEVER = 0.015, 0.0280, 0.040, 0.025  # m
MOTOR, PIVOT, APART, PAD = (0.055, 0.015), (0.030, 0.020), 0.012, 0.020  # m
model, loops = pin.Model(), []


def place(side, x, z):
    return pin.SE3(np.eye(3), np.array([side * x, 0.0, z]))


def hinge(name, parent, side, x, z):
    kind = pin.JointModelRevoluteUnaligned(np.array([0.0, side, 0.0]))
    return model.addJoint(parent, kind, place(side, x, z), name)


def frame(name, parent, side, x, z):
    model.addFrame(pin.Frame(name, parent, place(side, x, z), pin.FrameType.OP_FRAME))


for name, side in (("right", 1.0), ("left", -1.0)):
    crank = hinge(f"{name}_crank", 0, side, *MOTOR)
    rod = hinge(f"{name}_rod", crank, side, 0.0, CRANK)
    arm = hinge(f"{name}_arm", 0, side, *PIVOT)
    jaw = hinge(f"{name}_jaw", arm, side, 0.0, ARM)
    second = hinge(f"{name}_second_arm", 0, side, PIVOT[0] + APART, PIVOT[1])
    frame(f"{name}_rod_end", rod, side, 0.0, ROD)
    frame(f"{name}_lever", arm, side, 0.0, LEVER)
    frame(f"{name}_second_end", second, side, 0.0, ARM)
    frame(f"{name}_jaw_corner", jaw, side, APART, 0.0)
    frame(f"{name}_pad", jaw, side, -PAD, 0.02)
    for pair in (("rod_end", "lever"), ("second_end", "jaw_corner")):
        loops.append(pj.RevoluteLoop(frames=tuple(f"{name}_{end}" for end in pair), axis=(0, 1, 0)))
loops.append(pj.JointLoop(joints=("right_crank", "left_crank")))

# %%
# Of home only a guess is needed: the loops are closed from there, motors at rest if that can be.
guess = {"right_crank": 0.4, "right_rod": -1.6, "left_crank": 0.4, "left_rod": -1.6}
gripper = pj.Mechanism.from_pinocchio(
    model, loops, ["right_crank"], "right_pad", home=guess, name="gripper", tool_rows=["vx"]
)
print(gripper)

# %%
# The part pushes both pads outwards with 1 N each. What the motor holds then, turned round, is the
# grip for its torque. `reach` finds the crank for an opening.
TORQUE = 0.5  # N m
pushed = {"right_pad": [1.0, 0, 0, 0, 0, 0], "left_pad": [-1.0, 0, 0, 0, 0, 0]}
grips, cranks = [], []
print("opening   crank   grip of each jaw")
for opening in (0.040, 0.030, 0.020, 0.010, 0.005, 0.002, 0.0):
    reached = pj.reach(gripper, {"x": opening / 2})
    assert reached, reached.message
    (effort,) = reached.configuration.statics(pushed, frame="LOCAL_WORLD_ALIGNED").efforts
    cranks.append(float(reached.actuated[0]))
    grips.append(TORQUE / abs(effort))
    print(f"{1e3 * opening:4.0f} mm  {np.rad2deg(cranks[-1]):5.1f}°  {grips[-1]:6.1f} N")

# %%
# By hand: the crank's tip and the lever's end are a rod apart, which gives the arm for a crank; and
# what the motor does is what the two pads do, F = torque / (2 dx/dθ).


def pad(angle):
    """Return how far the pad is from the middle, from two triangles."""
    tip = np.array(MOTOR) + CRANK * np.array([np.sin(angle), np.cos(angle)])

    def gap(arm):
        return np.linalg.norm(PIVOT + LEVER * np.array([np.sin(arm), np.cos(arm)]) - tip) - ROD

    return PIVOT[0] + ARM * np.sin(brentq(gap, -0.6, 0.8, xtol=1e-15)) - PAD


for crank, grip in zip(cranks, grips, strict=True):
    slope = (pad(crank + 1e-5) - pad(crank - 1e-5)) / 2e-5
    assert abs(grip - TORQUE / (2 * slope)) < 1e-6 * grip

# %%
# Where crank and rod are in line the jaws stand still however the motor turns: the grip has no
# bound, and nobody can pull them open. `follow` finds it on the way as an event, a loss.
on = pj.follow(gripper, [[cranks[-1]], [cranks[-1] - 0.4]], start=reached.configuration)
(dead,) = on.events
assert dead.kind == "loss", dead
joints = dead.configuration.joint_values
beyond = np.rad2deg(cranks[-1] - joints["right_crank"])
assert abs(joints["right_rod"]) < 1e-8  # rad, against the crank
print(f"the dead centre is {beyond:.1f}° of the crank beyond closed")

# %%
# The gripper at its dead centre, where both jaws stand still.
figure = pj.plot(dead.configuration)
