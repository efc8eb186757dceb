# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The planning scene as a program starts with it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsim_ros.config.planning_parameters import PlanningParameters
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.world import WorldSettings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box, Mesh
from armsim_ros.model.robot_model import JointType, RobotModel
from armsim_ros.model.transforms import inverse_pose, pose_matrix
from armsim_ros.model.world_objects import world_objects
from armsim_ros.planning.scene import PlanningScene
from armsim_ros.planning.scene_update import CollisionObjectUpdate

Matrix = NDArray[np.float64]

FLOOR = 'floor'
FLOOR_EDGE, FLOOR_DEPTH = 10.0, 0.1
"""Size of the floor [m]; no arm reaches beyond."""


def initial_scene(
    model: KinematicModel, settings: RobotSettings, parameters: PlanningParameters, name: str = ''
) -> PlanningScene:
    """
    Return the scene of a robot's files.

    It is empty but for the robot. With ``scene_from_world`` the fixed objects and the floor of the
    simulated world are in it; they may touch the links that no joint moves, on which the robot
    stands.
    """
    scene = PlanningScene(
        model,
        name=name,
        link_padding=parameters.default_robot_padding,
        link_scale=parameters.default_robot_scale,
    )
    if parameters.scene_from_world:
        placement = settings.simulation.placement
        root = inverse_pose(pose_matrix(placement.xyz, placement.rpy))
        standing = _links_that_stand(model.robot)
        for thing in _fixed_objects(settings.world, root):
            scene.apply_object(thing)
            scene.set_acm(scene.acm.with_entry(thing.id, True, standing))
    return scene


def _fixed_objects(world: WorldSettings, root: Matrix) -> list[CollisionObjectUpdate]:
    """
    Return what of a world never moves.

    :param root: (4, 4) pose of the world in the root link's frame.
    """
    things = []
    for thing in world_objects(world):
        if thing.mass is not None:
            continue
        solid = [part for part in thing.parts if not isinstance(part.geometry, Mesh)]
        meshes = [part for part in thing.parts if isinstance(part.geometry, Mesh)]
        things.append(CollisionObjectUpdate(
            thing.name,
            pose=root @ thing.pose,
            primitives=tuple(part.geometry for part in solid),
            primitive_poses=tuple(part.origin for part in solid),
            meshes=tuple(part.geometry for part in meshes if isinstance(part.geometry, Mesh)),
            mesh_poses=tuple(part.origin for part in meshes),
        ))
    if world.floor and FLOOR not in world.objects:
        things.append(CollisionObjectUpdate(
            FLOOR,
            pose=root @ pose_matrix((0.0, 0.0, -0.5 * FLOOR_DEPTH)),
            primitives=(Box((FLOOR_EDGE, FLOOR_EDGE, FLOOR_DEPTH)),),
        ))
    return things


def _links_that_stand(robot: RobotModel) -> tuple[str, ...]:
    """Return the links that no joint moves."""
    standing = [robot.root_link]
    for joint in robot.joints.values():
        if joint.type is JointType.FIXED and joint.parent in standing:
            standing.append(joint.child)
    return tuple(standing)
