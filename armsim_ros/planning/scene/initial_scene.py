# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The planning scene as a program starts with it."""

from __future__ import annotations

from armsim_ros.arrays import Matrix
from armsim_ros.config.planning_parameters import PlanningParameters
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.world import WorldSettings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.robot_model import JointType, RobotModel
from armsim_ros.model.world_objects import (
    FLOOR,
    floor_object,
    world_in_root,
    world_objects,
    WorldObject,
)
from armsim_ros.planning.scene.objects import CollisionObject, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene


def initial_scene(
    model: KinematicModel, settings: RobotSettings, parameters: PlanningParameters, name: str = ''
) -> PlanningScene:
    """
    Return the scene of a robot's files.

    It is empty but for the robot. Where ``scene_from_world`` is ``fixed``, the fixed objects and
    the floor of the world's file are in it; they may touch the links that no joint moves, on which
    the robot stands.
    """
    scene = PlanningScene(
        model,
        name=name,
        link_padding=parameters.default_robot_padding,
        link_scale=parameters.default_robot_scale,
    )
    if parameters.scene_from_world == 'fixed':
        root = world_in_root(settings)
        standing = links_that_stand(model.robot)
        for thing in _fixed_objects(settings.world, root):
            scene.apply_object(thing)
            scene.set_acm(scene.acm.with_entry(thing.id, True, standing))
    return scene


def collision_object(thing: WorldObject, root: Matrix) -> CollisionObject:
    """
    Return an object of the simulated world as one to be added to a scene.

    :param root: (4, 4) pose of the world in the root link's frame.
    """
    shapes = tuple(ObjectShape(part.geometry, part.origin) for part in thing.parts)
    return CollisionObject(thing.name, pose=root @ thing.pose, shapes=shapes)


def _fixed_objects(world: WorldSettings, root: Matrix) -> list[CollisionObject]:
    """
    Return what of a world never moves.

    :param root: (4, 4) pose of the world in the root link's frame.
    """
    things = [
        collision_object(thing, root) for thing in world_objects(world) if thing.mass is None
    ]
    if world.floor and FLOOR not in world.objects:
        things.append(collision_object(floor_object(), root))
    return things


def links_that_stand(robot: RobotModel) -> tuple[str, ...]:
    """Return the links that no joint moves."""
    standing = [robot.root_link]
    for joint in robot.joints.values():
        if joint.type is JointType.FIXED and joint.parent in standing:
            standing.append(joint.child)
    return tuple(standing)
