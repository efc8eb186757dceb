# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where the named frames of a scene are: links, objects, subframes, fixed frames."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.scene.content import SceneContent, SceneDraft

SceneParts = SceneContent | SceneDraft

#: Transforms from a frame to the robot, one in the other; more are a circle.
LONGEST_CHAIN = 100


def link_of_frame(
    kinematics: KinematicModel, content: SceneParts, frame: str
) -> tuple[str, Matrix]:
    """
    Return the link that a frame is fixed to, and its pose (4, 4) on that link.

    Links come first, then attached objects, then the world, then further frames; a subframe is
    ``object/subframe``. What stands in the world is fixed to the root link; so is a further
    frame, at the place where it is in the content's robot state.

    :param frame: '' is the model frame; a leading slash is dropped.
    :raises PlanningError: FRAME_TRANSFORM_FAILURE for an unknown frame.
    """
    found = _own_frame(kinematics, content, _name(frame))
    if found is None:
        return kinematics.robot.root_link, frame_pose(kinematics, content, frame)
    return found


def frame_pose(
    kinematics: KinematicModel, content: SceneParts, frame: str, q: Vector | None = None
) -> Matrix:
    """
    Return the pose (4, 4) of a frame in the model frame.

    :param q: (n,) robot state; None for the content's. What moves with a link is where the link
        is in that state.
    :raises PlanningError: FRAME_TRANSFORM_FAILURE for an unknown frame.
    """
    name, offset = _name(frame), np.eye(4)
    for _ in range(LONGEST_CHAIN):
        found = _own_frame(kinematics, content, name)
        if found is not None:
            link, pose = found
            offset = pose @ offset
            if link == kinematics.robot.root_link:
                return offset
            return kinematics.link_pose(content.q if q is None else q, link) @ offset
        edge = content.frames.get(name)
        if edge is None:
            raise _unknown(kinematics, content, frame, name)
        name, offset = _name(edge.parent), edge.pose @ offset
    raise PlanningError(
        MoveItErrorCode.FRAME_TRANSFORM_FAILURE,
        f"frame '{frame}': its chain of transforms leads to no link of the robot, it goes in a "
        f"circle at '{name}'",
        'planning scene',
    )


def _own_frame(
    kinematics: KinematicModel, content: SceneParts, name: str
) -> tuple[str, Matrix] | None:
    """Return link and pose of a frame of robot or objects, None for any other."""
    robot = kinematics.robot
    if kinematics.has_link(name):
        return name, np.eye(4)
    if not name or name == robot.model_frame:
        return robot.root_link, np.eye(4)
    attached = content.attached.get(name)
    if attached is not None:
        return attached.link_name, attached.object.pose
    for owner, subframe in _splits(name):
        attached = content.attached.get(owner)
        if attached is not None and subframe in attached.object.subframes:
            body = attached.object
            return attached.link_name, body.pose @ body.subframes[subframe]
    item = content.objects.get(name)
    if item is not None:
        return robot.root_link, item.pose
    for owner, subframe in _splits(name):
        item = content.objects.get(owner)
        if item is not None and subframe in item.subframes:
            return robot.root_link, item.pose @ item.subframes[subframe]
    return None


def _splits(name: str) -> Iterator[tuple[str, str]]:
    """Yield the parts before and after each slash of ``object/subframe``."""
    at = name.find('/')
    while at >= 0:
        yield name[:at], name[at + 1 :]
        at = name.find('/', at + 1)


def _name(frame: str) -> str:
    return frame[1:] if frame.startswith('/') else frame


def _unknown(
    kinematics: KinematicModel, content: SceneParts, frame: str, name: str
) -> PlanningError:
    joined = f"; its chain of transforms ends at '{name}'" if name != _name(frame) else ''
    return PlanningError(
        MoveItErrorCode.FRAME_TRANSFORM_FAILURE,
        f"frame '{frame}' is no link, object, subframe or known fixed frame{joined}; "
        f"the model frame is '{kinematics.robot.model_frame}' "
        f'{nearest(name, known_frames(kinematics, content))}'.rstrip(),
        'planning scene',
    )


def known_frames(kinematics: KinematicModel, content: SceneParts) -> tuple[str, ...]:
    """Return the names of all frames."""
    bodies = [*content.objects.values(), *(item.object for item in content.attached.values())]
    subframes = [f'{body.id}/{name}' for body in bodies for name in body.subframes]
    return (
        *kinematics.robot.links,
        *(body.id for body in bodies),
        *subframes,
        *content.frames,
    )
