# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What controllers reported, from their messages as they come or as they were recorded."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
import struct
from typing import Any

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
import numpy as np

from armsim_ros.errors import ArmsimError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.client.description import describe
from armsim_ros.nodes.client.motion import seconds
from armsim_ros.nodes.verbs.plot_picture import JointRecord, with_tolerances

_STATE = 'control_msgs/msg/JointTrajectoryControllerState'
_TEXT = 'std_msgs/msg/String'
_DESCRIPTION = 'robot_description'


def records_of(messages: Iterable[Any]) -> list[JointRecord]:
    """Return what messages of type JointTrajectoryControllerState contain for each joint."""
    rows: dict[str, list[tuple[float, float, float, float]]] = {}
    start: float | None = None
    for message in messages:
        now = seconds(message.header.stamp)
        start = now if start is None else start
        for name, *values in zip(
                message.joint_names, message.reference.positions, message.feedback.positions,
                message.error.positions, strict=False):
            rows.setdefault(name, []).append((now - start, *values))
    return [JointRecord(name, np.array(table)) for name, table in rows.items()]


def read_recording(file: Path) -> list[JointRecord]:
    """
    Read an MCAP file, or the first in a folder that ``ros2 bag record`` made.

    :raises ArmsimError: it is not there, is not a recording, or no trajectory controller is in it.
    """
    if file.is_dir():
        inside = sorted(file.glob('*.mcap'))
        if not inside:
            raise ArmsimError(f"'{file}' has no .mcap file in it; 'ros2 bag record -s mcap' "
                              'writes it')
        file = inside[0]
    states: list[Any] = []
    description = ''
    try:
        with file.open('rb') as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            for schema, channel, _, message in reader.iter_decoded_messages():
                if schema is not None and schema.name == _STATE:
                    states.append(message)
                elif (schema is not None and schema.name == _TEXT
                      and channel.topic.rpartition('/')[2] == _DESCRIPTION):
                    description = message.data
    except OSError as error:
        raise ArmsimError(f"'{file}' cannot be read: {error.strerror}") from None
    except (McapError, struct.error, ValueError, KeyError, EOFError) as error:
        raise ArmsimError(f"'{file}' is not a recording that can be read: {error}") from None
    if not states:
        raise ArmsimError(f"'{file}' has no messages of {_STATE}; record the controller's "
                          'controller_state')
    records = records_of(states)
    limits = position_limits(describe(description, ''), records) if description else {}
    return with_tolerances(records, {}, limits)


def position_limits(robot: RobotModel, records: Iterable[JointRecord]
                    ) -> dict[str, tuple[float, ...]]:
    """Return joint -> the ends of its range [rad or m], those that there are."""
    return {record.name: tuple(float(end) for end in (robot.joints[record.name].limits.lower,
                                                   robot.joints[record.name].limits.upper)
                            if np.isfinite(end))
            for record in records if record.name in robot.joints}
