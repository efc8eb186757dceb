# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What only a camera sees is avoided by the next plan, in time that only steps move."""

import math

import numpy as np
import pytest

from armsim_ros import ArmSim
from armsim_ros.errors import SimulationError
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.planning.budget import CountingClock
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.request import Constraints, MotionPlanRequest
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject, ObjectShape

UNSEEN = {'planning_parameters.scene_from_world': 'false'}
CRATE = Box((0.12, 0.12, 0.3))
#: In the way of the Panda's turn, before the camera.
PLACE = pose_matrix((0.45, 0.0, 0.45))


@pytest.fixture(scope='module')
def panda():
    """Return a Panda between two cameras; planning knows nothing of the world."""
    usual = {'link': 'panda_link0', 'width': 320, 'height': 240}
    return ArmSim('panda', overrides={**UNSEEN, 'simulation.cameras': {
        'eye': {**usual, 'xyz': [2.0, 0.0, 0.9], 'rpy': [0.0, 0.25, math.pi]},
        'back': {**usual, 'xyz': [-1.0, 0.0, 1.4], 'rpy': [0.0, 0.55, 0.0]}}})


@pytest.fixture(autouse=True)
def forgotten(request):
    """Empty the map and the world after each test."""
    yield
    if 'panda' in request.fixturenames:
        sim = request.getfixturevalue('panda')
        sim.scene.set_octomap(None)
        sim.scene.clear()
        if 'crate' in sim.simulation.world.objects:
            sim.simulation.world.remove('crate')


def put(sim, pose=PLACE):
    """Put a crate into the world, of which planning knows nothing."""
    sim.simulation.world.add(WorldObject.of_shape('crate', CRATE, pose))
    sim.step()


def turn(sim):
    """Return a motion past the place of the crate."""
    joints = {f'panda_joint{k}': value for k, value in enumerate(
        (0.9, 0.35, 0.0, -1.9, 0.0, 2.25, 0.785), 1)}
    start = {**joints, 'panda_joint1': -0.9}
    sim.scene.set_positions(start)
    return start, joints


def path(sim):
    """Return the states of a plan from one side of the crate to the other."""
    start, goal = turn(sim)
    response = sim.planner.plan(MotionPlanRequest(
        group_name='panda_arm', goal_constraints=(Constraints.of_joints(goal),),
        allowed_planning_time=20.0, seed=1), sim.scene.snapshot(), clock=CountingClock())
    assert response.success, response.message
    model = sim.scene.kinematic_model
    names, points = response.trajectory.joint_names, response.trajectory.positions
    return [model.vector(dict(zip(names, row, strict=True)), model.vector(start))
            for row in points]


def touched(sim, states, pose=PLACE):
    """Return whether a state touches the crate itself, deeper than a tenth of the map's cells."""
    scene = sim.scene.snapshot()
    scene.set_octomap(None)
    scene.apply_object(CollisionObject('crate', pose=pose, shapes=(ObjectShape(CRATE),)))
    checker = CollisionChecker(scene)
    return any(contact.depth > 0.005 for q in states for contact in checker.contacts(q))


def near(octomap, pose=PLACE):
    """Return how many occupied cells are within the crate, a cell wider."""
    if octomap is None:
        return 0
    local = octomap.boxes[0] - pose[:3, 3]
    return int((np.abs(local) <= 0.5 * np.array(CRATE.size) + 0.05).all(axis=1).sum())


def test_what_only_the_camera_sees_is_avoided(panda):
    """Unseen the plan goes through it, seen from both sides around it; gone, its cells go."""
    put(panda)
    assert touched(panda, path(panda))
    panda.look('eye')
    panda.look('back')
    assert near(panda.scene.octomap) > 20
    states = path(panda)
    assert not touched(panda, states)
    panda.simulation.world.remove('crate')
    panda.step()
    for _ in range(4):
        panda.look('eye')
        panda.look('back')
    assert near(panda.scene.octomap) == 0


def test_arm_never_blocks_itself(panda):
    """It is left out where it is seen, in motion as well as at rest."""
    for angle in (-0.8, 0.0, 0.8):
        panda.execute(panda.plan({'panda_joint1': angle, 'panda_joint4': -2.0}, velocity=0.5))
        panda.look('eye')
        panda.scene.set_positions(panda.joint_positions)
        assert not CollisionChecker(panda.scene).in_collision(panda.scene.q)


def test_cells_of_an_object_go_when_it_is_known(panda):
    """Added or attached, it does not block the arm that is to grasp it."""
    put(panda)
    panda.look('eye')
    assert near(panda.scene.octomap) > 20
    panda.scene.apply_object(
        CollisionObject('crate', pose=PLACE, shapes=(ObjectShape(CRATE),)))
    assert near(panda.scene.octomap) == 0
    panda.look('eye')
    assert near(panda.scene.octomap) == 0
    panda.scene.apply_attached(AttachedObject('panda_hand', CollisionObject('crate')))
    panda.look('eye')
    assert near(panda.scene.octomap) == 0


def test_shipped_cell_sees_its_table(tmp_path):
    """The camera on the wrist of sunday adds the cells that it sees, equal in equal runs."""
    maps = []
    for _ in range(2):
        sim = ArmSim('sunday', overrides=UNSEEN)
        sim.look('camera')
        maps.append(sim.scene.octomap.full_data())
        assert not CollisionChecker(sim.scene).in_collision(sim.scene.q)
    assert maps[0] == maps[1]
    known = ArmSim('sunday')
    known.look('camera')
    before = len(sim.scene.octomap.boxes[0])
    assert known.scene.octomap is None or len(known.scene.octomap.boxes[0]) < before


def test_unknown_camera_is_named(panda):
    """The sentence has the cameras that there are."""
    with pytest.raises(SimulationError, match=r"no camera 'ey'; did you mean 'eye'"):
        panda.look('ey')
