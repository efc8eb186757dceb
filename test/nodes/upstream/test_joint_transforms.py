# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When transforms are due, of which joints, and where the links are."""

import math
from typing import Any

from geometry_msgs.msg import Transform
import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from tf2_msgs.msg import TFMessage

from armsim_ros.model.robot_model import Joint, JointType, Link, Mimic, RobotModel
from armsim_ros.model.transforms import (
    matrix_from_axis_angle,
    matrix_from_quat_xyzw,
    matrix_from_rpy,
    pose_from_parts,
)
from armsim_ros.nodes.upstream.robot_state_publisher import JointTransforms

AXIS = np.array([0.6, 0.0, 0.8])
ORIGIN = pose_from_parts([0.1, 0.2, 0.3], matrix_from_rpy([0.4, -0.5, 0.6]))


SECOND = 1_000_000_000


class Lines:
    """A log that keeps its lines."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def _keep(self, message: str) -> None:
        self.lines.append(message)

    info = warning = error = _keep


@pytest.fixture
def log() -> Lines:
    """Give a log."""
    return Lines()


@pytest.fixture
def transforms(log: Lines) -> JointTransforms:
    """Give a robot with one joint of each kind, and mimic joints in a chain."""
    joints = [
        Joint('turn', JointType.REVOLUTE, 'base', 'arm', ORIGIN, AXIS),
        Joint('slide', JointType.PRISMATIC, 'arm', 'hand', ORIGIN, AXIS),
        Joint('mount', JointType.FIXED, 'hand', 'tool', ORIGIN, AXIS),
        Joint('table', JointType.PLANAR, 'base', 'table', ORIGIN, AXIS),
        Joint('ball', JointType.FLOATING, 'base', 'ball', ORIGIN, AXIS),
        Joint('a_finger', JointType.PRISMATIC, 'hand', 'left', ORIGIN, AXIS,
              mimic=Mimic('slide', -2.0, 0.5)),
        Joint('b_tip', JointType.REVOLUTE, 'left', 'tip', ORIGIN, AXIS,
              mimic=Mimic('a_finger', 3.0)),
        Joint('aa_early', JointType.REVOLUTE, 'left', 'early', ORIGIN, AXIS,
              mimic=Mimic('b_tip')),
    ]
    links = ('base', *(joint.child for joint in joints))
    return JointTransforms(RobotModel(
        'robot', {name: Link(name) for name in links}, {joint.name: joint for joint in joints},
        'base'), log)


def read(message: bytes | None) -> TFMessage:
    """Return the message that is published."""
    assert message is not None
    return deserialize_message(message, TFMessage)


def shown(transforms: JointTransforms, values: dict[str, float], stamp_ns: int = 3 * SECOND,
          **words: Any) -> dict[str, Any]:
    """Return child frame -> transform of a joint state that is due, in the message's order."""
    message = read(transforms.message(
        list(values), list(values.values()), stamp_ns, 10 * SECOND,
        **{'frequency': 20.0, 'ignore_timestamp': True, **words}))
    return {stamped.child_frame_id: stamped for stamped in message.transforms}


def due(transforms: JointTransforms, names: str, stamp: float, now: float = 100.0,
        **words: Any) -> bool:
    """Return whether a joint state of joints with these names gives a message."""
    return transforms.message(
        names.split(), [0.0] * len(names.split()), round(stamp * SECOND), round(now * SECOND),
        **{'frequency': 20.0, **words}) is not None


def matrix(transform: Transform) -> np.ndarray:
    """Return a transform message as (4, 4)."""
    t, r = transform.translation, transform.rotation
    return pose_from_parts([t.x, t.y, t.z], matrix_from_quat_xyzw([r.x, r.y, r.z, r.w]))


def test_movable_joints_turn_and_slide(transforms: JointTransforms) -> None:
    """The transform is the joint's origin times its motion, with the stamp of the message."""
    frames = shown(transforms, {'turn': 0.7, 'slide': 0.25}, 3 * SECOND + 4)
    turned = ORIGIN @ pose_from_parts([0, 0, 0], matrix_from_axis_angle(AXIS, 0.7))
    np.testing.assert_allclose(matrix(frames['arm'].transform), turned, atol=1e-12)
    slid = ORIGIN @ pose_from_parts(0.25 * AXIS, np.eye(3))
    np.testing.assert_allclose(matrix(frames['hand'].transform), slid, atol=1e-12)
    assert frames['arm'].header.frame_id == 'base'
    assert (frames['hand'].header.stamp.sec, frames['hand'].header.stamp.nanosec) == (3, 4)


def test_a_robot_at_rest_is_shown_at_every_time(transforms: JointTransforms) -> None:
    """Only the stamp changes while nothing moves; a motion that follows is shown."""
    found = [shown(transforms, {'turn': angle}, second * SECOND)['arm']
             for second, angle in enumerate((0.7, 0.7, 0.8))]
    assert [one.header.stamp.sec for one in found] == [0, 1, 2]
    first, second, third = (one.transform.rotation.w for one in found)
    assert first == second != third


def test_quaternions_have_length_one(transforms: JointTransforms) -> None:
    """A quaternion that is not normalized is refused by tf2."""
    for angle in np.linspace(-3 * math.pi, 3 * math.pi, 13):
        rotation = shown(transforms, {'turn': angle})['arm'].transform.rotation
        length = math.hypot(rotation.x, rotation.y, rotation.z, rotation.w)
        assert length == pytest.approx(1.0, abs=1e-12)


def test_only_named_joints_are_shown_in_the_order_of_their_names(
    transforms: JointTransforms
) -> None:
    """
    A message holds the joints of its joint state, sorted; unknown and fixed ones are left out.

    robot_state_publisher.cpp: callbackJointState, publishTransforms.
    """
    assert list(shown(transforms, {'turn': 0.1})) == ['arm']
    assert list(shown(transforms, {'turn': 0.1, 'mount': 1.0, 'lost': 1.0, 'ball': 1.0})) == [
        'arm']
    assert list(shown(transforms, {'turn': 0.1, 'a_finger': 0.2})) == ['left', 'tip', 'arm']
    assert shown(transforms, {'lost': 1.0}) == {}


def test_mimic_joints_follow_a_named_master(transforms: JointTransforms) -> None:
    """
    A mimic joint is shown where its master is named, or where one earlier in the alphabet is.

    robot_state_publisher.cpp: callbackJointState goes through its map of mimic joints once.
    """
    frames = shown(transforms, {'slide': 0.2})
    assert list(frames) == ['left', 'tip', 'hand']
    moved = ORIGIN @ pose_from_parts((-2.0 * 0.2 + 0.5) * AXIS, np.eye(3))
    np.testing.assert_allclose(matrix(frames['left'].transform), moved, atol=1e-12)
    turned = ORIGIN @ pose_from_parts(
        [0, 0, 0], matrix_from_axis_angle(AXIS, 3.0 * (-2.0 * 0.2 + 0.5)))
    np.testing.assert_allclose(matrix(frames['tip'].transform), turned, atol=1e-12)
    assert 'early' not in frames


def test_a_value_of_a_mimic_joint_itself_counts(transforms: JointTransforms) -> None:
    """
    What the joint state gives is not computed; of two values for one joint the first counts.

    robot_state_publisher.cpp: callbackJointState.
    """
    frames = shown(transforms, {'slide': 0.2, 'a_finger': 0.1})
    moved = ORIGIN @ pose_from_parts(0.1 * AXIS, np.eye(3))
    np.testing.assert_allclose(matrix(frames['left'].transform), moved, atol=1e-12)
    twice = read(transforms.message(['turn', 'turn'], [0.7, 0.1], 0, SECOND, frequency=20.0,
                                    ignore_timestamp=True))
    turned = ORIGIN @ pose_from_parts([0, 0, 0], matrix_from_axis_angle(AXIS, 0.7))
    np.testing.assert_allclose(matrix(twice.transforms[0].transform), turned, atol=1e-12)


def test_a_prefix_precedes_both_frames(transforms: JointTransforms) -> None:
    """
    It is put before the names without a separator, and read at each message.

    robot_state_publisher.cpp: publishTransforms, publishFixedTransforms.
    """
    found = shown(transforms, {'turn': 0.1}, prefix='left/')['left/arm']
    assert found.header.frame_id == 'left/base'
    assert list(shown(transforms, {'turn': 0.1}, prefix='b_')) == ['b_arm']
    fixed = transforms.static('left/', 0)
    assert [(one.header.frame_id, one.child_frame_id) for one in fixed] == [
        ('left/hand', 'left/tool'), ('left/base', 'left/table')]


def test_joints_that_never_move_are_static(transforms: JointTransforms) -> None:
    """
    Fixed and planar joints have the node's time; a floating joint appears nowhere.

    robot_state_publisher.cpp: addChildren, publishFixedTransforms.
    """
    tool, table = transforms.static('', 5 * SECOND)
    assert (tool.child_frame_id, tool.header.stamp.sec) == ('tool', 5)
    assert table.child_frame_id == 'table'
    np.testing.assert_allclose(matrix(tool.transform), ORIGIN, atol=1e-12)


def test_messages_come_at_most_at_the_frequency(transforms: JointTransforms) -> None:
    """
    A joint state is due the period after the last one, in whole milliseconds.

    robot_state_publisher.cpp: callbackJointState. 1000 / 30 is taken as 33 ms.
    """
    assert due(transforms, 'turn slide', 10.0)
    assert not due(transforms, 'turn slide', 10.049)
    assert due(transforms, 'turn slide', 10.05)
    assert not due(transforms, 'turn', 10.082, frequency=30.0)
    assert due(transforms, 'turn', 10.083, frequency=30.0)
    assert due(transforms, 'turn', 10.083, frequency=0.0)


def test_the_joint_that_waits_longest_decides(transforms: JointTransforms) -> None:
    """
    A joint that was never published counts as stamp 0, so a partial message is not held back.

    robot_state_publisher.cpp: callbackJointState.
    """
    assert due(transforms, 'turn', 10.0)
    assert due(transforms, 'slide', 10.001)
    assert due(transforms, 'turn lost', 10.002)
    assert not due(transforms, 'turn slide', 10.003)


def test_a_stamp_of_zero_is_never_due(transforms: JointTransforms) -> None:
    """
    Only ignore_timestamp lets it through, and every message.

    robot_state_publisher.cpp: callbackJointState.
    """
    assert not due(transforms, 'turn', 0.0)
    assert due(transforms, 'turn', 0.0, ignore_timestamp=True)
    assert due(transforms, 'turn', 0.0, ignore_timestamp=True)


def test_stamps_ahead_of_the_clock(transforms: JointTransforms) -> None:
    """
    A stamp that was published and is in the future does not hold the next ones back.

    robot_state_publisher.cpp: callbackJointState begins with the node's time.
    """
    assert due(transforms, 'turn', 50.0, now=20.0)
    assert due(transforms, 'turn', 20.1, now=20.0)


def test_a_clock_that_runs_backwards_clears_the_memory(
    transforms: JointTransforms, log: Lines
) -> None:
    """
    It is logged once, and publishing goes on.

    robot_state_publisher.cpp: callbackJointState.
    """
    assert due(transforms, 'turn', 50.0, now=50.0)
    assert due(transforms, 'turn', 1.0, now=1.0)
    assert not due(transforms, 'turn', 1.01, now=1.01)
    assert log.lines == ['time moved backwards: joint transforms are published again']


def test_names_and_positions_of_different_number(transforms: JointTransforms, log: Lines) -> None:
    """
    Such a message is dropped and logged.

    robot_state_publisher.cpp: callbackJointState.
    """
    for names, positions in ((['turn'], []), (['turn'], [1.0, 2.0]), ([], [1.0])):
        assert transforms.message(names, positions, SECOND, SECOND, frequency=20.0,
                                  ignore_timestamp=True) is None
    assert log.lines == ["ignored a JointState without positions, of joint 'turn' and others",
                         'ignored a JointState with 1 names and 2 positions',
                         'ignored a JointState with 0 names and 1 positions']
    assert transforms.message([], [], SECOND, SECOND, frequency=20.0) is None
