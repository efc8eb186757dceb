# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``armsim plot``: a motion as a picture, from a file or as it happens."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
import time
from typing import Any

from control_msgs.msg import JointTrajectoryControllerState
from rcl_interfaces.srv import GetParameters
from rclpy.qos import QoSProfile, QoSReliabilityPolicy

from armsim_ros.clients.ros_client import RosClient
from armsim_ros.errors import ArmsimError, nearest
from armsim_ros.nodes.verbs.go import published_robot
from armsim_ros.nodes.verbs.plot_picture import (
    JointRecord,
    position_limits,
    read_csv,
    read_recording,
    records_of,
    with_tolerances,
    write_picture,
)
from armsim_ros.nodes.verbs.terminal import call, parser, read, show, until

#: A joint that is quicker than this moves [rad/s or m/s].
_MOVES = 1e-3
#: A motion that has ended is recorded so much longer [s].
_AFTER = 0.5
_LOOK = 0.05


def main(argv: Sequence[str] | None = None) -> int:
    """
    Draw.

    :returns: 0, or 1 where a tolerance was violated.
    :raises ArmsimError: there is no such file or topic, or nothing moved.
    """
    words = parser('plot', 'draw desired, actual, error and tolerance of each joint')
    words.add_argument('source', metavar='FILE|TOPIC', help='a recording (MCAP), a CSV file that '
                       'the page saved, or the controller_state of a trajectory controller')
    words.add_argument('--to', type=Path, default=Path('motion.png'), metavar='FILE',
                       help='out.png or out.html (default: motion.png)')
    words.add_argument('--seconds', type=float, default=0.0, metavar='SECONDS',
                       help='record so long (default: until the next motion has ended)')
    words.add_argument('--tolerance', type=float, default=0.0, metavar='VALUE', help='of the '
                       "error [rad or m], in place of the controller's own")
    asked, ros = read(words, argv)
    file = Path(asked.source)
    if file.suffix == '.mcap' or file.is_dir():
        records = read_recording(file)
    elif file.is_file() or file.suffix:
        records = read_csv(file)
    else:
        topic = asked.source if asked.source.startswith('/') else f'/{asked.source}'
        with RosClient('armsim_plot', ros) as client:
            records = _listen(client, topic, asked.seconds, asked.timeout)
            records = with_tolerances(records, *_bounds(client, topic, records, asked.timeout))
    if asked.tolerance > 0.0:
        records = [replace(record, tolerance=asked.tolerance) for record in records]
    write_picture(records, asked.to)
    violated = {record.name: record.violated for record in records if record.violated}
    show({'file': str(asked.to), 'violated': violated}, asked.json,
         '\n'.join([str(asked.to), *(f'{name}: {text}' for name, text in violated.items())]))
    return 1 if violated else 0


def _listen(client: RosClient, topic: str, duration: float, patience: float) -> list[JointRecord]:
    """Return what comes, for so long, or from the start of a motion to its end."""
    polled = client.poll(JointTrajectoryControllerState, topic, _profile(client, topic, patience))
    messages: list[Any] = []
    begun, moved = time.monotonic(), 0.0
    while True:
        news = polled.take()
        for message in news:
            if any(abs(speed) > _MOVES for speed in message.feedback.velocities):
                moved = time.monotonic()
        messages += news
        now = time.monotonic()
        if duration:
            if now - begun > duration:
                break
        elif moved and now - moved > _AFTER:
            break
        elif not moved:
            messages = messages[-10:]
        time.sleep(_LOOK)
    return records_of(messages)


def _profile(client: RosClient, topic: str, patience: float) -> QoSProfile:
    """
    Return the profile of a subscription that every publisher of a topic matches.

    :raises ArmsimError: the topic does not appear in time, or has another type.
    """
    try:
        publishers = until(lambda: client.node.get_publishers_info_by_topic(topic) or None,
                           patience, f'topic {topic}')
    except ArmsimError as error:
        hint = nearest(topic, [name for name, _ in client.node.get_topic_names_and_types()])
        raise ArmsimError(f'{error} {hint}'.strip()) from None
    kind = JointTrajectoryControllerState.__name__
    if any(info.topic_type != f'control_msgs/msg/{kind}' for info in publishers):
        raise ArmsimError(f"the type of '{topic}' is {publishers[0].topic_type}, not {kind}")
    reliable = all(info.qos_profile.reliability == QoSReliabilityPolicy.RELIABLE
                   for info in publishers)
    return QoSProfile(depth=100, reliability=(
        QoSReliabilityPolicy.RELIABLE if reliable else QoSReliabilityPolicy.BEST_EFFORT))


def _bounds(client: RosClient, topic: str, records: Sequence[JointRecord], patience: float
            ) -> tuple[dict[str, float], dict[str, tuple[float, ...]]]:
    """Return tolerances and position limits, as far as controller and description publish them."""
    node = topic.rpartition('/')[0]
    names = [f'constraints.{record.name}.trajectory' for record in records]
    tolerances: dict[str, float] = {}
    limits: dict[str, tuple[float, ...]] = {}
    try:
        values = call(client, GetParameters, f'{node}/get_parameters',
                      GetParameters.Request(names=names), patience).values
        for record, value in zip(records, values, strict=False):
            if value.double_value > 0.0:
                tolerances[record.name] = value.double_value
        limits = position_limits(published_robot(client, patience), records)
    except ArmsimError:
        return tolerances, limits  # drawn without what is not published
    return tolerances, limits
