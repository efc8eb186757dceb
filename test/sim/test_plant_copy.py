# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The state that travels to the program that draws."""

import mujoco
import numpy as np
import pytest

from armsim_ros.config.world import WorldSettings
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.sim.camera import Snapshot, take_snapshot
from armsim_ros.sim.physics.compiler import model_to_bytes
from armsim_ros.sim.scene_renderer import PlantCopy
from armsim_ros.sim.simulation import Simulation

BALL = {'type': 'sphere', 'radius': 0.05}
WORLD = WorldSettings.model_validate({'objects': {
    'post': {'xyz': [2.0, 0.0, 0.5], 'parts': [{'shape': BALL}]},
    'ball': {'xyz': [1.0, 0.0, 0.7], 'mass': 0.2, 'parts': [{'shape': BALL}]},
}})


@pytest.fixture
def simulation(arm, settings):
    """Return an arm beside a fixed and a free object."""
    return Simulation(arm, settings, WORLD)


def test_a_copy_of_the_plant_shows_the_snapshot(simulation):
    """Joints, free objects, and fixed ones that somebody moved, are where they were taken."""
    plant = model_to_bytes(simulation.mujoco_model)
    simulation.world.set_pose('post', pose_matrix((0.1, 0.2, 0.3), (0.0, 0.0, 0.5)))
    simulation.world.set_pose('ball', pose_matrix((0.4, 0.1, 0.5)))
    simulation.set_positions({'elbow': 0.7})
    taken = take_snapshot(3, 17, simulation.mujoco_model, simulation.mujoco_data)
    arrived = Snapshot.from_bytes(taken.to_bytes())
    assert (arrived.camera, arrived.time_ns) == (3, 17)
    copy = PlantCopy(plant)
    copy.show(arrived)
    mujoco.mj_kinematics(simulation.mujoco_model, simulation.mujoco_data)
    np.testing.assert_array_equal(copy.data.xpos, simulation.mujoco_data.xpos)
    np.testing.assert_array_equal(copy.data.xquat, simulation.mujoco_data.xquat)
