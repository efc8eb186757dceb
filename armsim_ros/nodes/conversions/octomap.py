# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``octomap_msgs/msg/OctomapWithPose`` to a map, and back."""

from __future__ import annotations

from array import array

from octomap_msgs.msg import OctomapWithPose

from armsim_ros.errors import PlanningError
from armsim_ros.nodes.conversions.geometry import pose_from_message, pose_to_message
from armsim_ros.planning.scene.octomap import Octomap, OctomapUpdate, read_octomap, TREE

#: The id of a message that takes the map away.
CLEARED = 'cleared'


def octomap_from_message(message: OctomapWithPose, *, is_diff: bool) -> OctomapUpdate | None:
    """
    Return what a message does to the map of a scene, None where it changes nothing.

    Without data it takes the map away, as does another class of tree; in a diff a message without
    an id changes nothing.

    :raises PlanningError: FAILURE with the reason; of damaged data, with the byte's position.
    """
    tree = message.octomap
    if is_diff and not tree.id:
        return None
    if not tree.data:
        return OctomapUpdate()
    octomap = read_octomap(
        array('b', tree.data).tobytes(), tree=tree.id, binary=bool(tree.binary),
        resolution=float(tree.resolution), pose=pose_from_message(message.origin))
    return OctomapUpdate(octomap, message.header.frame_id)


def readable_octomap(
    message: OctomapWithPose, *, is_diff: bool
) -> tuple[OctomapUpdate | None, tuple[PlanningError, ...]]:
    """Return what a message does to the map, and why it could not be read."""
    try:
        return octomap_from_message(message, is_diff=is_diff), ()
    except PlanningError as error:
        # A tree of another class takes the place of the map, but cannot be used.
        other = message.octomap.id != TREE
        return OctomapUpdate() if other else None, (error,)


def octomap_to_message(octomap: Octomap | None, frame: str) -> OctomapWithPose:
    """
    Return a map in the full form; without data where there is none.

    :param frame: the model frame.
    """
    message = OctomapWithPose()
    message.header.frame_id = message.octomap.header.frame_id = frame
    if octomap is None:
        return message
    message.origin = pose_to_message(octomap.pose)
    message.octomap.id = TREE
    message.octomap.resolution = octomap.resolution
    message.octomap.binary = False
    message.octomap.data = array('b', octomap.full_data())
    return message
