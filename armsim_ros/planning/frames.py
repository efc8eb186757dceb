# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where the named frames of a scene are: links, objects, subframes, fixed frames."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import nearest, PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.error_codes import MoveItErrorCode
from armsim_ros.planning.scene_content import SceneContent
from armsim_ros.planning.world_object import CollisionObject

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


def link_of_frame(
    kinematics: KinematicModel, content: SceneContent, frame: str
) -> tuple[str, Matrix]:
    """
    Return the link that a frame is fixed to, and its pose (4, 4) on that link.

    Links come first, then attached objects, then the world, then further frames; a subframe is
    ``object/subframe``. What stands in the world is fixed to the root link.

    :param frame: '' is the model frame; a leading slash is dropped.
    :raises PlanningError: FRAME_TRANSFORM_FAILURE for an unknown frame.
    """
    name = frame[1:] if frame.startswith('/') else frame
    robot = kinematics.robot
    if kinematics.has_link(name):
        return name, np.eye(4)
    if not name or name == robot.model_frame:
        return robot.root_link, np.eye(4)
    attached = content.attached.get(name)
    if attached is not None:
        return attached.link_name, attached.object.pose
    carried = {id_: item.object for id_, item in content.attached.items()}
    found = _subframe(carried, name)
    if found is not None:
        return content.attached[found[0]].link_name, found[1]
    if name in content.objects:
        return robot.root_link, content.objects[name].pose
    found = _subframe(content.objects, name)
    if found is not None:
        return robot.root_link, found[1]
    if name in content.frames:
        return robot.root_link, content.frames[name]
    raise PlanningError(
        MoveItErrorCode.FRAME_TRANSFORM_FAILURE,
        f"frame '{frame}' is no link, object, subframe or known fixed frame; "
        f"the model frame is '{robot.model_frame}' "
        f'{nearest(name, known_frames(kinematics, content))}'.rstrip(),
        'planning scene',
    )


def frame_pose(
    kinematics: KinematicModel, content: SceneContent, frame: str, q: Vector | None = None
) -> Matrix:
    """
    Return the pose (4, 4) of a frame in the model frame.

    :param q: (n,) robot state; None for the content's.
    :raises PlanningError: FRAME_TRANSFORM_FAILURE for an unknown frame.
    """
    link, offset = link_of_frame(kinematics, content, frame)
    if link == kinematics.robot.root_link:
        return offset.copy()
    return kinematics.link_pose(content.q if q is None else q, link) @ offset


def known_frames(kinematics: KinematicModel, content: SceneContent) -> tuple[str, ...]:
    """Return the names of all frames."""
    bodies = [*content.objects.values(), *(item.object for item in content.attached.values())]
    subframes = [f'{body.id}/{name}' for body in bodies for name in body.subframes]
    return (
        *kinematics.robot.links,
        *(body.id for body in bodies),
        *subframes,
        *content.frames,
    )


def _subframe(
    objects: Mapping[str, CollisionObject], name: str
) -> tuple[str, Matrix] | None:
    """Return (object id, pose with the object's) of an ``object/subframe``."""
    at = name.find('/')
    while at >= 0:
        body = objects.get(name[:at])
        if body is not None and name[at + 1 :] in body.subframes:
            return body.id, body.pose @ body.subframes[name[at + 1 :]]
        at = name.find('/', at + 1)
    return None
