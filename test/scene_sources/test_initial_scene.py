# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What planning knows from the start."""

import numpy as np
import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.stack import ArmSim

IN_THE_TABLE = {
    'joint_1': 1.606, 'joint_2': -0.939, 'joint_3': -1.898, 'joint_4': 0.166, 'joint_5': 1.757,
    'joint_6': -0.475,
}
KNOWING = {'planning_parameters.scene_from_world': True}


@pytest.fixture
def world(tmp_path):
    """Write a world with a post of two parts that never moves, and a ball that does."""
    file = tmp_path / 'world.yaml'
    file.write_text("""
floor: true
objects:
  post:
    xyz: [0.5, 0.1, 0.2]
    parts:
      - {shape: {type: box, size: [0.1, 0.1, 0.4]}}
      - xyz: [0, 0, 0.3]
        shape: {type: prism, length: 0.1, corners: [[0, 0], [0.1, 0], [0, 0.1]]}
  ball:
    xyz: [0.6, -0.3, 0.05]
    mass: 0.1
    parts: [{shape: {type: sphere, radius: 0.05}}]
""")
    return file


def test_it_is_empty_unless_asked_for(arm):
    """As in the stack that it replaces: who plans around the world has to describe it."""
    assert dict(arm.sim.scene.objects) == {}


def test_what_never_moves_is_in_it(world):
    """Fixed objects with all their parts, and the floor; nothing that can be pushed."""
    objects = ArmSim('bot', world=world, overrides=KNOWING).scene.objects
    assert set(objects) == {'post', 'floor'}
    np.testing.assert_allclose(objects['post'].pose[:3, 3], [0.5, 0.1, 0.2])


def test_poses_are_seen_from_where_the_robot_stands(world):
    """A robot that stands elsewhere sees the same object at another place."""
    placed = {**KNOWING, 'simulation.placement': {'xyz': [0.0, -0.4, 0.0], 'rpy': [0, 0, 1.5708]}}
    post = ArmSim('bot', world=world, overrides=placed).scene.objects['post']
    np.testing.assert_allclose(post.pose[:3, 3], [0.5, -0.5, 0.2], atol=1e-4)


def test_the_world_of_a_virtual_joint_is_the_simulations(small_package):
    """Where a fixed virtual joint ties the robot to the world, that frame is where it stands."""
    tie = '<virtual_joint name="v" type="fixed" parent_frame="world" child_link="base"/>'
    srdf = small_package.SRDF.replace('</robot>', f'{tie}</robot>')
    small_package.write('config/small.srdf', srdf)
    placed = {'simulation.placement': {'xyz': [0.0, 0.0, 0.14], 'rpy': [0, 0, 0]}}
    scene = ArmSim(str(small_package.folder), overrides=placed).scene
    assert scene.model_frame == 'base'
    np.testing.assert_allclose(scene.frame_pose('world')[:3, 3], [0.0, 0.0, -0.14], atol=1e-9)


@pytest.mark.armsim(overrides=KNOWING)
def test_no_plan_goes_where_the_world_is(arm):
    """The default arm with its table: a state in the table is refused, the others are not."""
    with pytest.raises(PlanningError, match="'table'"):
        arm.move_to(IN_THE_TABLE)
    for state in ('scan_food', 'home'):
        arm.move_to(state)
