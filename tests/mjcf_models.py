"""MJCF models for the tests, one for each thing that a reader can get wrong."""

from __future__ import annotations

GEOM = '<geom size=".1"/>'


def mjcf(bodies: str, equality: str = "", before: str = "", after: str = "") -> str:
    world = f"<worldbody>{bodies}</worldbody><equality>{equality}</equality>"
    return f"<mujoco>{before}{world}{after}</mujoco>"


def body(name: str, inside: str = "", attributes: str = "") -> str:
    return f'<body name="{name}" {attributes}>{inside}{GEOM}</body>'


def motor(*joints: str) -> str:
    return "<actuator>" + "".join(f'<motor joint="{joint}"/>' for joint in joints) + "</actuator>"


def four_bar(closing: str) -> str:
    coupler = body("coupler", '<joint name="p"/>', 'pos="1 0 0" euler="0 0 -40"')
    crank = body("crank", '<joint name="t"/>' + coupler, 'euler="0 0 60"')
    rocker = body("rocker", '<joint name="r"/>', 'pos="2.5 0 0" euler="0 0 80"')
    return mjcf(crank + rocker, closing, after=motor("t"))


FOUR_BAR = four_bar('<connect body1="coupler" body2="rocker" anchor="2 .1 0"/>')
WELDED_FOUR_BAR = mjcf(
    body(
        "crank",
        '<joint name="t" ref="10"/>'
        + body(
            "coupler",
            '<joint name="p" ref="-20"/>'
            + body("tip", '<joint name="s" pos=".5 0 0"/>', 'pos="1 0 0"'),
            'pos="1 0 0" euler="0 0 -40"',
        ),
        'euler="0 0 60"',
    )
    + body("rocker", '<joint name="r"/>', 'pos="2.5 0 0" euler="0 0 80"'),
    '<weld body1="tip" body2="rocker" anchor="1 2 0"/>',
    after=motor("t"),
)
SEVERAL_JOINTS = mjcf(
    body(
        "a",
        '<joint name="a1" axis="1 2 0" pos=".1 0 .2" ref="30"/>'
        '<joint name="a2" type="slide" axis="0 1 1" ref=".3" pos="4 5 6"/>'
        '<joint name="a3" axis="0 1 0" pos="0 .2 0" ref="-70"/>'
        + body("b", '<joint name="b1" type="ball" pos=".3 .1 0"/>', 'pos="0 1 .5" quat="1 2 3 4"'),
        'pos="1 2 3" axisangle="1 1 0 50"',
    )
    + body(
        "c",
        '<joint name="c1"/><joint name="c2" axis="1 0 0" pos=".1 .1 .1"/>'
        + body("d", '<joint name="d1" type="slide" ref="-1" axis="1 1 1"/>', 'pos=".3 0 0"'),
        'zaxis="1 1 1"',
    )
    + body("still", body("on_it", '<joint name="e1"/>'), 'pos="0 0 1" xyaxes="1 1 0 0 1 1"')
    + body("flies", "<freejoint/>", 'pos="0 1 1" euler="10 20 30"'),
    '<connect body1="b" body2="d" anchor=".1 .2 .3"/>'
    '<connect body1="flies" body2="a" anchor="0 0 0"/>'
    '<connect body1="world" body2="d" anchor="1 0 0"/>'
    '<connect body1="d" anchor="1 0 0"/>',
    after=motor("c1"),
)
TIP = '<site name="tip" type="capsule" size=".1" fromto="0 0 0 1 2 3"/>'
SITES = mjcf(
    '<site name="ground" pos="0 1 1" euler="0 0 45"/>'
    + body(
        "a",
        '<joint name="j1"/><site name="a" pos=".5 .1 0" quat="1 1 0 0"/>'
        + body("b", '<joint name="j2" axis="0 1 0"/>' + TIP),
        'pos="0 1 0"',
    )
    + body("c", '<joint name="j3" type="ball"/><site name="end" zaxis="1 0 1" pos="0 0 2"/>'),
    '<connect site1="tip" site2="end"/><weld site1="a" site2="ground"/>'
    '<weld site1="tip" site2="end"/>',
    after=motor("j1"),
)
WELDS = mjcf(
    body("a", '<joint name="f" type="free"/>', 'pos="0 1 0" euler="30 20 10"')
    + body(
        "b",
        '<joint name="j1" axis="0 1 1"/>'
        + body("c", '<joint name="j2" axis="1 0 0" ref="20"/>', 'pos="1 0 0" euler="0 40 0"'),
    ),
    '<weld body1="a" body2="c"/><weld body1="a" body2="b" anchor=".1 .2 .3"/>'
    '<weld body1="c" body2="a" relpose="1 2 3 1 1 0 0"/><weld body1="c"/>'
    '<weld body1="c" body2="a" relpose="1 2 3 2 0 1 0" anchor=".3 .2 .1"/>'
    '<weld body1="b" body2="a" relpose="1 2 3 0 0 0 0" anchor=".3 .2 .1"/>',
    after=motor("j1"),
)
# Offsets are in rad and m whatever the angles' unit; y − y₀ = a₀ + a₁ (x − x₀).
GEARS = mjcf(
    body(
        "a",
        '<joint name="x" ref="40"/>'
        + body("b", '<joint name="y" ref="-25" axis="1 0 0" pos="0 .1 0"/>', 'pos="1 0 0"'),
    )
    + body("c", '<joint name="s" type="slide" ref=".7"/>')
    + body("d", '<joint name="held" axis="0 1 0" ref="15"/><joint name="held2" type="slide"/>'),
    '<joint joint1="y" joint2="x" polycoef=".2 -1.5 0 0 0"/><joint joint1="s" joint2="x"/>'
    '<joint joint1="held" polycoef=".4"/><joint joint1="held2" joint2="x" polycoef=".1 0"/>',
    after=motor("x"),
)
_DEFAULTS = """
<compiler angle="radian" eulerseq="{eulerseq}" autolimits="true"/>
<default>
  <joint axis="0 1 0" ref=".1"/><site euler=".1 .2 .3"/><equality active="true"/>
  <default class="slides">
    <joint type="slide" range="-1 2"/>
    <default class="low"><joint pos="0 0 -1" type="hinge" limited="false"/></default>
    <default class="off"><equality active="false"/></default>
  </default>
</default>
<default><joint ref=".2"/><default class="late"><site quat="1 0 0 1"/></default></default>
"""
_CLASSES = (
    body(
        "a",
        '<joint name="j1"/>'
        + body("b", '<joint name="j2"/><site name="s1"/>', 'pos="0 0 1" euler=".3 .4 -.5"')
        + body("c", '<joint name="j3" class="low"/><site name="s2" quat="1 0 2 0"/>', 'pos="1 0 0"')
        + body(
            "d",
            '<joint name="j4" axis="1 0 1"/><site name="s3" class="late"/>',
            'childclass="main" euler="1 2 3"',
        ),
        'childclass="slides"',
    )
    + '<frame pos="1 0 0" euler="0 .5 0" childclass="low"><frame pos="0 1 0" axisangle="1 1 0 .7">'
    + body(
        "e",
        '<frame zaxis="1 2 3" pos=".1 .2 .3"><joint name="j5"/><site name="s4" pos="1 0 0"/>'
        + body("f", '<joint name="j6" class="main"/>', 'pos="0 0 .5"')
        + "</frame>",
    )
    + "</frame></frame>"
)


def classes(eulerseq: str) -> str:
    equality = (
        '<connect class="off" body1="b" body2="e" anchor="0 0 0"/>'
        '<connect class="off" active="true" body1="b" body2="f" anchor="1 0 0"/>'
        '<connect active="false" body1="b" body2="f" anchor="1 0 0"/>'
        '<connect site1="s1" site2="s4"/>'
    )
    return mjcf(_CLASSES, equality, _DEFAULTS.format(eulerseq=eulerseq), motor("j1"))


# A rod between two sliders, with balls at both ends: it spins, which no motor feels.
BALL_ROD = mjcf(
    body(
        "left",
        '<joint name="l" type="slide" axis="0 1 0" ref=".2"/>'
        + body("rod", '<joint name="ball" type="ball"/>', 'pos="0 0 .5" euler="0 20 10"'),
    )
    + body(
        "right",
        '<joint name="r" type="slide" axis="1 1 0"/>'
        '<joint name="turn" axis="0 1 1" pos="0 .1 .3"/>',
        'pos="2 0 0"',
    )
    + body("hand", '<joint name="h" axis="0 1 0"/>', 'pos="1 1 0"'),
    '<connect body1="rod" body2="right" anchor="1.5 .2 .4"/>',
    after=motor("l", "turn"),
)

# Three legs, each closed onto a disc that MuJoCo sets down on its own inertia.
REPLICATED = mjcf(
    '<replicate count="3" euler="0 0 120" sep="-">'
    + body(
        "leg",
        '<joint name="hip" axis="0 1 0" ref="20"/><geom size=".1" pos="0 0 .3" mass="2"/>'
        + body("shin", '<joint name="knee" axis="0 1 0"/><site name="toe" pos="0 0 .6"/>'),
        'pos="1 0 0" euler="0 -30 0"',
    )
    + "</replicate>"
    + '<body name="disc" pos="0 0 1" euler="10 0 0"><freejoint name="floats" align="true"/>'
    '<geom type="box" size=".3 .2 .1" pos=".1 .2 .3" euler="30 0 20"/>'
    '<replicate count="3" euler="0 0 120"><site name="rim" pos=".4 0 0"/></replicate></body>',
    "".join(f'<connect site1="toe-{k}" site2="rim{k}"/>' for k in range(3))
    + '<weld body1="leg-0" body2="disc" active="false"/>'
    '<joint joint1="hip-1" joint2="hip-0" polycoef=".1 2"/>',
    after=motor("hip-0", "knee-2"),
)


MODELS = {
    "four-bar": FOUR_BAR,
    "welded four-bar": WELDED_FOUR_BAR,
    "several joints": SEVERAL_JOINTS,
    "sites": SITES,
    "welds": WELDS,
    "gears": GEARS,
    "ball rod": BALL_ROD,
    "replicated": REPLICATED,
    **{f"classes {order}": classes(order) for order in ("xyz", "zyx", "XYZ", "xZy", "YxX")},
}
