# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where the floor is when no world was chosen."""

import numpy as np
import pytest

from armsim_ros import ArmSim
from armsim_ros.errors import ConfigError
from armsim_ros.model.cell_loading import load_cell, survey_cell
from armsim_ros.model.geometry import (
    Box,
    Capsule,
    Cone,
    Cylinder,
    lowest_height,
    Mesh,
    Plane,
    Sphere,
)
from armsim_ros.model.transforms import pose_matrix

UP = np.array([0.0, 0.0, 1.0])
SOLID = ('<link name="{0}"><inertial><origin xyz="0 0 0.1"/><mass value="1"/>'
         '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>'
         '<collision><origin xyz="0 0 0.1"/><geometry><box size="0.04 0.04 0.2"/></geometry>'
         '</collision></link>')


@pytest.fixture
def package(small_package):
    """Return a package whose arm is 0.4 m long above its base at z = 0."""
    arm = small_package.ARM
    for name in ('upper', 'lower'):
        arm = arm.replace(small_package.LINK.format(name), SOLID.format(name))
    small_package.write('../description_folder/urdf/arm.urdf', small_package.XACRO.format(arm))
    small_package.ros2_control(
        *(f'<joint name="{name}"><command_interface name="position"/>'
          '<state_interface name="position"/><state_interface name="velocity"/></joint>'
          for name in ('shoulder', 'elbow')), plugin='mock_components/GenericSystem')
    return small_package


def reach_down(package):
    """Give the package a named state whose lower link ends below z = 0."""
    package.write('config/small.srdf', package.SRDF.replace(
        'value="0.5"', 'value="1.99"').replace('value="-0.5"', 'value="0.5"'))


def test_a_robot_above_the_floor_has_it_at_zero(package):
    """A robot that reaches below z = 0 in no stored pose keeps the usual floor, with no remark."""
    survey = survey_cell(str(package.folder))
    assert survey.cell.settings.world.floor_height == 0.0
    assert not [problem for problem in survey.problems if 'the floor is' in str(problem)]


def test_the_floor_is_below_the_named_states(package):
    """A named state that reaches below z = 0 lowers the floor, and a remark names the link."""
    reach_down(package)
    survey = survey_cell(str(package.folder))
    lowest = 0.2 + 0.2 * np.cos(1.99) + 0.2 * np.cos(2.49) - 0.02 * np.sin(2.49)
    assert lowest - 0.07 < survey.cell.settings.world.floor_height < lowest - 0.05
    remark, = [problem for problem in survey.problems if 'the floor is' in str(problem)]
    assert "link 'lower' reaches down to z = -0.05" in str(remark)
    assert "in the named state 'bent' of group 'arm'" in str(remark)


def test_a_hanging_robot_starts_free(package):
    """A robot that hangs below its mount starts without contact, plans, and arrives."""
    cell = load_cell(str(package.folder), overrides={
        'simulation.placement.xyz': [0, 0, 0.1], 'simulation.placement.rpy': [np.pi, 0, 0]})
    assert cell.settings.world.floor_height < -0.5
    sim = ArmSim(cell)
    sim.run_until(0.1)
    before = sim.joint_positions
    assert not [line for line in sim.simulation.warnings if 'overlap' in line]
    sim.execute(sim.plan('bent', 'arm'))
    assert abs(before['shoulder']) < 5e-3
    assert sim.joint_positions['shoulder'] == pytest.approx(0.5, abs=5e-3)


def test_a_chosen_world_keeps_its_floor(package):
    """The floor of a world file stays at its height, whatever the robot reaches."""
    reach_down(package)
    world = package.write('worlds/deep.yaml', 'floor: -0.01')
    assert load_cell(str(package.folder), world=world).settings.world.floor_height == -0.01


def test_floor_heights_are_finite(package):
    """A floor at an infinite height is refused."""
    world = package.write('worlds/none.yaml', 'floor: .inf')
    with pytest.raises(ConfigError, match='floor'):
        load_cell(str(package.folder), world=world)


@pytest.mark.parametrize('shape', [
    Box((0.1, 0.2, 0.3)), Sphere(0.1), Cylinder(0.1, 0.3), Cone(0.1, 0.3), Capsule(0.1, 0.3)],
    ids=lambda shape: type(shape).__name__)
def test_lowest_height(shape):
    """The lowest height of a turned shape is that of the lowest of many points on it."""
    rng = np.random.default_rng(3)
    points = surface(shape, rng)
    for _ in range(20):
        pose = pose_matrix(rng.uniform(-1, 1, 3), rng.uniform(-3, 3, 3))
        lowest = (points @ pose[2, :3] + pose[2, 3]).min()
        assert lowest - 2e-3 < lowest_height(shape, pose) <= lowest + 1e-9


def test_lowest_height_of_meshes_and_planes():
    """A mesh has that of its vertices; a plane has none."""
    mesh = Mesh(np.array([[0, 0, 0.3], [1, 0, 0], [0, 1, 0.2]]), np.array([[0, 1, 2]]))
    assert lowest_height(mesh, pose_matrix((0, 0, 1))) == pytest.approx(1.0)
    assert lowest_height(Plane(0, 0, 1, 0), np.eye(4)) == np.inf


def surface(shape, rng):
    """Return points (k, 3) [m] on a shape, dense around its rims."""
    if isinstance(shape, Box):
        return np.array(np.meshgrid(*[(-s / 2, s / 2) for s in shape.size])).reshape(3, -1).T
    directions = rng.normal(size=(20000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    if isinstance(shape, Sphere):
        return shape.radius * directions
    half = shape.length / 2
    if isinstance(shape, Capsule):
        ends = shape.radius * directions
        return np.vstack([ends + half * UP, ends - half * UP])
    angle = np.linspace(0, 2 * np.pi, 720)
    rim = np.column_stack([shape.radius * np.cos(angle), shape.radius * np.sin(angle), 0 * angle])
    top = [[0, 0, half]] if isinstance(shape, Cone) else rim + half * UP
    return np.vstack([rim - half * UP, top])
