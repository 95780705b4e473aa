"""A transmission as a plugin of ros2_control, compiled against the least of its interfaces."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from test_transmission import motors_by_hand
from transmission_machines import table_of

import pmjac_pin as pj
from pmjac_pin.adapters import ros2_control

OPTIONS = ("-std=c++17", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O1")
STUB = Path(__file__).parent / "ros2_control_stub"
pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler here")

# Reads ways and numbers, writes what became of them: positions, velocities, efforts.
PROGRAM = """#include "plugin.cpp"
#include <iostream>
using namespace t_transmission;
int refused(transmission_interface::TransmissionLoader & loader)
{
  int count = 0;
  hardware_interface::TransmissionInfo info{{{"a"}, {"b"}}, {{"c"}, {"d"}}};
  auto one = info, zero = info, joint = info;
  one.joints.pop_back();
  zero.actuators[0].mechanical_reduction = 0.0;
  joint.joints[1].mechanical_reduction = 2.0;
  for (const auto & wrong : {one, zero, joint}) {
    try {loader.load(wrong);} catch (const Exception &) {++count;}
  }
  double x = 0.0;
  auto good = loader.load(info);
  std::vector<JointHandle> j{{"a", "position", &x}, {"b", "position", &x}};
  std::vector<ActuatorHandle> m{{"c", "position", &x}, {"d", "position", &x}};
  std::vector<JointHandle> efforts{{"a", "effort", &x}, {"b", "effort", &x}};
  std::vector<JointHandle> half{j[0], j[1], {"a", "effort", &x}};
  auto both = j;
  both.insert(both.end(), efforts.begin(), efforts.end());
  good->configure(j, m);
  for (const auto & wrong : {efforts, half, both, {j[0]}}) {
    try {good->configure(wrong, m);} catch (const Exception &) {++count;}
  }
  return count;
}
int main()
{
  auto loader = exported_plugin();
  std::cout.precision(17);
  std::cout << refused(*loader) << std::endl;
  auto plugin = loader->load(
    {{{"pitch", 1.0, 0.2}, {"roll", 1.0, -0.1}}, {{"1", 3.0}, {"2", -2.0}}});
  double joints[3][2], motors[3][2];
  const char * kinds[] = {"position", "velocity", "effort"};
  std::vector<JointHandle> of_joints;
  std::vector<ActuatorHandle> of_motors;
  for (int kind = 2; kind >= 0; --kind) {
    for (int k = 0; k < 2; ++k) {
      of_joints.emplace_back(k ? "roll" : "pitch", kinds[kind], &joints[kind][k]);
      of_motors.emplace_back(k ? "2" : "1", kinds[kind], &motors[kind][k]);
    }
  }
  plugin->configure(of_joints, of_motors);
  double way;
  while (std::cin >> way) {
    const bool back = way != 0.0;
    auto & given = back ? motors : joints;
    auto & found = back ? joints : motors;
    for (auto & kind : given) {std::cin >> kind[0] >> kind[1];}
    back ? plugin->actuator_to_joint() : plugin->joint_to_actuator();
    std::cout << static_cast<Transmission &>(*plugin).status();
    for (auto & kind : found) {std::cout << ' ' << kind[0] << ' ' << kind[1];}
    std::cout << std::endl;
  }
}
"""
REDUCTION, OFFSET = np.array([3.0, -2.0]), np.array([0.2, -0.1])


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder, table = tmp_path_factory.mktemp("plugin"), table_of("humanoid_ankle")
    (folder / "t.h").write_text(table.c("t"))
    (folder / "plugin.cpp").write_text(ros2_control.source(table, "t.h", "t"))
    (folder / "main.cpp").write_text(PROGRAM)
    program = folder / "main"
    command = ["g++", *OPTIONS, f"-I{STUB}", str(folder / "main.cpp"), "-o", str(program)]
    subprocess.run(command, check=True)

    def at(rows):
        lines = "\n".join(" ".join(map(repr, map(float, row))) for row in rows)
        done = subprocess.run([program], input=lines, check=True, capture_output=True, text=True)
        count, *told = done.stdout.splitlines()
        return int(count), np.array([list(map(float, line.split())) for line in told])

    return at


def test_there_and_back_by_a_closed_formula(run, rng):
    """Offsets and reductions included; power is the same on both sides."""
    joints, rates = rng.uniform(-0.1, 0.1, (20, 2)), rng.uniform(-1, 1, (20, 2))
    efforts = rng.uniform(-9, 9, (20, 2))
    there = np.column_stack([np.zeros(20), joints + OFFSET, rates, efforts])
    refused, found = run([[0, *row[1:]] for row in there.tolist()])
    assert refused == 7
    status, position, velocity, effort = np.split(found, [1, 3, 5], axis=1)
    assert not status.any()
    by_hand = np.array([motors_by_hand(*x) for x in joints])
    np.testing.assert_allclose(position, by_hand * REDUCTION, atol=1e-12)
    step = 1e-6
    ahead = np.array([motors_by_hand(*x) for x in joints + step * rates])
    behind = np.array([motors_by_hand(*x) for x in joints - step * rates])
    moved = (ahead - behind) / (2 * step)
    np.testing.assert_allclose(velocity, moved * REDUCTION, atol=1e-7)
    power = (effort * velocity).sum(axis=1)
    np.testing.assert_allclose(power, (efforts * rates).sum(axis=1), atol=1e-10)
    _, again = run([[1, *row[1:]] for row in found.tolist()])
    assert not again[:, 0].any()
    np.testing.assert_allclose(again[:, 1:], there[:, 1:], atol=1e-11)


@pytest.mark.parametrize("back", [0, 1])
def test_what_is_no_pose_is_no_number(run, back):
    _, found = run([[back, 50.0, 50.0, 1.0, 1.0, 1.0, 1.0], [back, 0.2, -0.1, 0, 0, 0, 0]])
    assert found[0, 0] != 0
    assert np.isnan(found[0, 1:]).all()
    assert back or found[1, 0] == 0


def test_one_motor_and_one_joint(tmp_path):
    table = pj.transmission_table(pj.load("four_bar"), {"phi1": (2.2, 2.4)}, points=5)
    (tmp_path / "bar.h").write_text(table.c("bar"))
    (tmp_path / "bar.cpp").write_text(ros2_control.source(table, "bar.h", "bar"))
    command = ["g++", *OPTIONS, f"-I{STUB}", "-fsyntax-only", str(tmp_path / "bar.cpp")]
    subprocess.run(command, check=True)


def test_a_header_that_cannot_be_included():
    table = table_of("humanoid_ankle")
    for header in ("", 'a"b', "a\nb", 3):
        with pytest.raises(pj.ArgumentError, match="header is the name"):
            ros2_control.source(table, header)
    with pytest.raises(pj.ArgumentError, match="function's name"):
        ros2_control.source(table, "t.h", "a b")
