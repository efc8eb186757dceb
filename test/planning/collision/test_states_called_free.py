# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Random states of the included robots among random objects, one of them attached.

Plain pairwise checks with contacts requested have the last word. ``--states N`` checks N states.
"""

import coal
import numpy as np
import pinocchio as pin
import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box, Cylinder, Sphere
from armsim_ros.model.loading import load_robot_model
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene

ROBOTS = ('sunday', 'ur5', 'panda', 'elfin', 'magician', 'bot')
FEW, OBJECTS, OF_A_SCENE = 300, 8, 1000


def cluttered(model, rng):
    """Return a scene with objects within reach, and one that a moving link carries."""
    scene = PlanningScene(model)
    for number in range(OBJECTS):
        shape = (Box(tuple(rng.uniform(0.02, 0.5, 3))),
                 Cylinder(rng.uniform(0.02, 0.1), rng.uniform(0.1, 0.6)),
                 Sphere(rng.uniform(0.03, 0.15)))[number % 3]
        pose = pose_matrix(rng.uniform(-0.9, 0.9, 3), rng.uniform(-3.0, 3.0, 3))
        scene.apply_object(CollisionObject(
            f'object_{number}', 0, scene.model_frame, pose=pose, shapes=(ObjectShape(shape),)))
    link = str(rng.choice(sorted(set().union(
        *(model.moved_links(group) for group in model.robot.semantic.groups)))))
    held = CollisionObject('held', 0, link, pose=pose_matrix((0.0, 0.0, 0.1)),
                           shapes=(ObjectShape(Box((0.05, 0.05, 0.2))),))
    scene.apply_attached(AttachedObject(link, held, (link,)))
    return scene


class Pairwise:
    """Every required pair of a checker's tables by itself, with contacts requested."""

    def __init__(self, model, tables):
        self._shapes, self._model = tables.shapes, model.model
        self._data = self._model.createData()
        self._geometry = pin.GeometryModel()
        for number, shape in enumerate(tables.shapes):
            self._geometry.addGeometryObject(pin.GeometryObject(
                str(number), shape.joint, pin.SE3(shape.pose), shape.exact))
        self._geometry.setCollisionPairs(tables.mask(None))
        self._found = pin.GeometryData(self._geometry)
        for number in range(len(self._geometry.collisionPairs)):
            request = coal.CollisionRequest()
            request.enable_contact = True
            self._found.collisionRequests[number] = request

    def touching(self, q):
        """Return the names of the bodies that touch."""
        pin.computeCollisions(self._model, self._data, self._geometry, self._found, q, False)
        return {
            frozenset((self._shapes[pair.first].body.name, self._shapes[pair.second].body.name))
            for number, pair in enumerate(self._geometry.collisionPairs)
            if self._found.collisionResults[number].isCollision()}


def pytest_generate_tests(metafunc):
    """Make a test of each robot and scene."""
    if 'scene_number' in metafunc.fixturenames:
        states = int(metafunc.config.getoption('states', None) or 0)
        scenes = max(1, -(-states // (OF_A_SCENE * len(ROBOTS))))
        metafunc.parametrize('scene_number', range(scenes))
        metafunc.parametrize('count', [OF_A_SCENE if states else FEW])


@pytest.mark.parametrize('robot', ROBOTS)
def test_what_is_called_free_touches_nothing(robot, scene_number, count):
    """A free state has no contacts, others have all that touch; so for many states at once."""
    model = KinematicModel(load_robot_model(load_robot_settings(robot)))
    rng = np.random.default_rng(scene_number)
    checker = CollisionChecker(cluttered(model, rng))
    low, high = np.maximum(model.lower, -np.pi), np.minimum(model.upper, np.pi)
    states = [model.apply_mimic(rng.uniform(low, high)) for _ in range(count)]
    free = []
    pairwise = [Pairwise(model, tables) for tables in checker._followed()]
    for q in states:
        touching = set().union(*(each.touching(q) for each in pairwise))
        found = {frozenset((each.body1, each.body2)) for each in checker.contacts(q)}
        assert touching <= found
        assert checker.in_collision(q) == bool(found)
        assert checker.in_collision(q, exact=False) or not found
        free.append(not found)
    assert not all(free)
    assert (~checker.near_pairs(np.array(states), None).motions).tolist() == free


def test_a_contact_is_found_where_the_distance_is_wrong_by_more_than_the_tolerance():
    """GJK finds 1.6 um between two cylinders that overlap by less than 0.1 um."""
    model = KinematicModel(load_robot_model(load_robot_settings('ur5')))
    q = np.array([
        -1.9813820951718957, 2.3528712939550216, 3.095449273050926,
        -2.631819010193574, 0.937112430870708, -1.8945388405296637])
    checker = CollisionChecker(PlanningScene(model))
    (table,) = checker._followed()
    pair = frozenset(('upper_arm_link', 'wrist_2_link'))
    assert pair in Pairwise(model, table).touching(q)
    assert pair in {frozenset((each.body1, each.body2)) for each in checker.contacts(q)}
