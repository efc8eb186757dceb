# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A robot that stands in the world of an SDF or MJCF file from the start."""

import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.errors import SimulationError
from armsim_ros.stack import ArmSim

SDF = """<sdf version="1.9"><world name="room">
  <light name="sun" type="directional"/>
  <model name="table"><static>true</static><pose>1 0 0.2 0 0 0</pose><link name="top">
    <collision name="c"><geometry><box><size>0.4 0.4 0.4</size></box></geometry></collision>
  </link></model>
  <model name="cube"><pose>1 0 0.6 0 0 0</pose><link name="body">
    <inertial><mass>0.2</mass></inertial>
    <collision name="c"><geometry><box><size>0.1 0.1 0.1</size></box></geometry></collision>
  </link></model>
</world></sdf>"""
MJCF = """<mujoco model="room"><worldbody>
  <geom name="table" type="box" size="0.2 0.2 0.2" pos="1 0 0.2"/>
  <body name="cube" pos="1 0 0.6"><freejoint/><geom type="box" size="0.05 0.05 0.05"/></body>
</worldbody></mujoco>"""


@pytest.fixture(params=[('room.sdf', SDF), ('room.world', SDF), ('room.xml', MJCF)],
                ids=['sdf', 'world', 'mjcf'])
def file(request, tmp_path):
    """Return the file of a world with a cube above a table."""
    name, text = request.param
    path = tmp_path / name
    path.write_text(text)
    return path


def test_things_stand_where_the_file_has_them(file):
    """The cube falls on the table and lies there."""
    sim = ArmSim('sunday', world=file)
    sim.run_until(1.0)
    assert sim.simulation.world.pose('cube')[2, 3] == pytest.approx(0.45, abs=1e-3)


def test_what_is_not_used_is_said(tmp_path):
    """A light has no effect, and one warning says so."""
    file = tmp_path / 'room.sdf'
    file.write_text(SDF)
    warnings = ArmSim('sunday', world=file).simulation.warnings
    assert [line for line in warnings if 'light' in line and 'not used of the world' in line]


def test_a_mass_without_inertia_is_said(tmp_path):
    """What SDF makes of it is no one's intention: one warning has file, line and remedy."""
    file = tmp_path / 'room.sdf'
    file.write_text('<sdf version="1.9">\n<world name="room">\n<model name="m"><link name="l">\n'
                    '<inertial><mass>0.1</mass></inertial>\n'
                    '<collision name="c"><geometry><sphere><radius>0.1</radius></sphere>'
                    '</geometry></collision></link></model></world></sdf>')
    (line,) = [one for one in ArmSim('sunday', world=file).simulation.warnings if 'mass' in one]
    assert 'room.sdf:4' in line
    assert 'give its own' in line


def test_a_broken_world_is_a_mistake_with_its_place(tmp_path):
    """File and line are named."""
    file = tmp_path / 'room.sdf'
    file.write_text('<sdf version="1.9">\n<world name="room">\n<model>\n</world></sdf>')
    with pytest.raises(SimulationError, match=r'room\.sdf:4'):
        ArmSim('sunday', world=file)


def test_a_planner_that_reads_the_file_itself_is_warned(file):
    """``fixed`` reads worlds in YAML only; the remark names what reads any."""
    overrides = {'planning_parameters.scene_from_world': 'fixed'}
    remarks = load_robot_settings('sunday', world=file, overrides=overrides).remarks
    assert [one for one in remarks if "'live' publishes any to planning" in one.what]
