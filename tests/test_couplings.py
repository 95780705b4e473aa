"""URDF+'s <coupling>: angle of the successor = ratio · angle of the predecessor."""

from __future__ import annotations

import numpy as np
import pytest
from looped import joint, link, robot

import pmjac_pin as pj

TRUE, FALSE = 'independent="true"', 'independent="false"'


def coupling(first="leg", second="rotor", ratio='<ratio value="-6"/>'):
    ends = f'<predecessor link="{first}"/><successor link="{second}"/>'
    return f'<coupling name="belt">{ends}{ratio}</coupling>'


def geared(element, leg=TRUE, rotor=FALSE, **kinds):
    """A hip that carries a leg and a rotor, each with a fixed link behind it, and a foot."""
    names = ("base", "hip", "leg", "rotor", "foot", "tip", "disc")
    kind = kinds.get("kind", "revolute")
    return robot(
        *(link(name) for name in names),
        joint("q_hip", "revolute", "base", "hip", attributes=kinds.get("hip", TRUE)),
        joint("q_leg", "revolute", "hip", "leg", (0, 1, 0), attributes=leg),
        joint("q_rotor", kind, "hip", "rotor", (0, 0.2, 0), attributes=rotor),
        joint("q_foot", "revolute", "leg", "foot", (0, 1, 0), attributes=TRUE),
        joint("tip_fixed", "fixed", "leg", "tip", (0, 0.5, 0)),
        joint("disc_fixed", "fixed", "rotor", "disc", (0, 0.1, 0)),
        element,
    )


@pytest.fixture
def load(tmp_path):
    def load(text, **options):
        path = tmp_path / "leg.urdf"
        path.write_text(text)
        return pj.load(path, **{"tool": "rotor", **options})

    return load


def test_the_successor_turns_ratio_times_as_far(load):
    mechanism = load(geared(coupling()))
    assert mechanism.spec.loops == (pj.JointLoop(joints=("q_leg", "q_rotor"), ratio=-6.0),)
    assert (mechanism.actuated, mechanism.passive) == (("q_hip", "q_leg", "q_foot"), ("q_rotor",))
    configuration = mechanism.close([0.1, 0.2, 0.3])
    assert configuration.passive == pytest.approx([-1.2])
    # The constraint of the reference implementation: (ratio, −1) on (predecessor, successor).
    motion = configuration.jacobian().motion_map
    columns = [
        mechanism.model.joints[mechanism.model.getJointId(n)].idx_v for n in ("q_leg", "q_rotor")
    ]
    np.testing.assert_allclose([-6.0, -1.0] @ motion[columns], 0.0, atol=1e-12)


def test_a_ratio_that_is_not_given_is_one(load):
    (gear,) = load(geared(coupling(ratio=""))).spec.loops
    assert gear.ratio == 1.0


def test_links_that_are_fixed_behind_joints_turn_with_them(load):
    assert load(geared(coupling("tip", "disc"))).spec.loops == load(geared(coupling())).spec.loops


def test_the_joint_that_is_not_independent_follows(load):
    mechanism = load(geared(coupling(), leg=FALSE, rotor=TRUE))
    (gear,) = mechanism.spec.loops
    assert (gear.joints, gear.ratio) == (("q_leg", "q_rotor"), -6.0)
    assert mechanism.actuated == ("q_hip", "q_rotor", "q_foot")
    assert mechanism.passive == ("q_leg",)


def test_the_joint_that_says_it_is_independent_leads_one_that_says_nothing(load):
    mechanism = load(geared(coupling(), leg="", rotor=TRUE, hip=""))
    (gear,) = mechanism.spec.loops
    assert (gear.joints, gear.ratio) == (("q_leg", "q_rotor"), -6.0)
    assert "q_rotor" in mechanism.actuated
    assert "q_leg" in mechanism.passive


def test_without_a_word_on_independence_the_successor_follows(load):
    mechanism = load(geared(coupling(), leg="", rotor="", hip="").replace(TRUE, ""))
    assert mechanism.actuated == ("q_hip", "q_leg", "q_foot")


def test_a_model_file_takes_it_along(tmp_path):
    (tmp_path / "leg.urdf").write_text(geared(coupling()).replace(TRUE, "").replace(FALSE, ""))
    (tmp_path / "leg.toml").write_text(
        'urdf = "leg.urdf"\nactuated = ["q_hip", "q_leg", "q_foot"]\ntool.frame = "rotor"\n'
        "[poses.home]\n"
    )
    mechanism = pj.load(tmp_path / "leg.toml")
    assert mechanism.spec.loops == (pj.JointLoop(joints=("q_leg", "q_rotor"), ratio=-6.0),)


BAD = {
    "a sum": (
        coupling("foot", "rotor"),
        "coupling 'belt': the angle of link 'foot' is the sum of 'q_leg', 'q_foot'; two joints are",
    ),
    "above": (coupling("hip", "leg"), "nothing turns link 'hip' against the other link"),
    "itself": (coupling("leg", "tip"), "nothing turns link 'leg' against the other link"),
    "no link": (coupling("legg"), "the predecessor link 'legg' does not exist; did you mean 'leg'"),
    "no end": ('<coupling name="belt"/>', "has no predecessor"),
    "no number": (
        coupling(ratio='<ratio value="6:1"/>'),
        "`value` is '6:1', not a finite",
    ),
    "no value": (coupling(ratio="<ratio/>"), "<ratio> has no `value`"),
    "misspelt": (coupling(ratio='<raito value="6"/>'), "unknown <raito>; did you mean 'ratio'"),
    "two": (coupling(ratio='<ratio value="6"/>' * 2), "has 2 <ratio>; give one"),
}


@pytest.mark.parametrize(("element", "message"), BAD.values(), ids=BAD)
def test_what_is_refused(load, element, message):
    with pytest.raises(pj.ModelFileError) as caught:
        load(geared(element))
    assert "leg.urdf: " in str(caught.value)
    assert message in str(caught.value)


def test_a_joint_of_several_freedoms_is_refused(load):
    text = geared(coupling(), kind="floating")
    with pytest.raises(pj.ModelFileError, match="joint 'q_rotor' has more than one degree of free"):
        load(text)


def test_a_link_in_a_loop_of_joints_has_no_angle(load):
    text = geared(coupling(), leg="").replace(
        "</robot>", joint("other", "revolute", "base", "leg") + "</robot>"
    )
    with pytest.raises(pj.ModelFileError, match="link 'leg' is in a loop of joints"):
        load(text)


def test_a_shaft_without_end_may_be_the_one_that_leads(load):
    """Its turns need no counting where the hinge's value tells its own: shaft = 6 hinge."""
    text = geared(coupling(), leg="", rotor=TRUE, hip="").replace("revolute", "continuous")
    mechanism = load(text)
    assert "q_rotor" in mechanism.actuated
    assert "q_leg" in mechanism.passive
    at = mechanism.close({name: 0.3 * (name == "q_rotor") for name in mechanism.actuated})
    assert at.joint_values["q_leg"] == pytest.approx(-0.05)
