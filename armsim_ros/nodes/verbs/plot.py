# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``armsim plot``: a motion as a picture, from a file or as it happens."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
import csv
from dataclasses import dataclass, replace
from importlib.util import find_spec
import json
import math
from pathlib import Path
import struct
import time
from typing import Any

from control_msgs.msg import JointTrajectoryControllerState
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
import numpy as np
from numpy.typing import NDArray
from rcl_interfaces.srv import GetParameters
from rclpy.qos import QoSProfile, QoSReliabilityPolicy

from armsim_ros.clients.description import describe
from armsim_ros.clients.motion import seconds
from armsim_ros.clients.ros_client import RosClient
from armsim_ros.errors import ArmsimError, nearest
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.verbs.go import published_robot
from armsim_ros.nodes.verbs.terminal import call, parser, read, show, until

Array = NDArray[np.float64]

_COLUMNS = ['joint', 'time', 'desired', 'actual', 'error']
_STATIC = Path(__file__).resolve().parent.parent / 'web' / 'static'


@dataclass(frozen=True, eq=False)
class JointRecord:
    """
    What a controller reported of a joint.

    :param rows: (t, 4) time [s], desired, actual, error [rad or m].
    :param limits: of the position, those that there are.
    :param tolerance: of the error on the way, None for none.
    """

    name: str
    rows: Array
    limits: tuple[float, ...] = ()
    tolerance: float | None = None

    @property
    def violated(self) -> str:
        """In words when and how far the error left its tolerance; '' where it never did."""
        if self.tolerance is None:
            return ''
        outside = np.abs(self.rows[:, 3]) > self.tolerance
        if not outside.any():
            return ''
        worst = float(np.abs(self.rows[:, 3]).max())
        return (f'error {worst:.4g} is above the tolerance {self.tolerance:.4g}, first at '
                f'{self.rows[int(outside.argmax()), 0]:.2f} s')


def read_csv(file: Path) -> list[JointRecord]:
    """
    Read the file that the page's CSV button saves of an executed motion.

    :raises ArmsimError: it is not there, or something else.
    """
    found: dict[str, list[list[float]]] = {}
    try:
        with file.open(encoding='utf-8', newline='') as stream:
            table = csv.reader(stream)
            if next(table, None) != _COLUMNS:
                raise ArmsimError(f"{file}:1: this is not an executed motion; its first line must "
                                  f"be '{','.join(_COLUMNS)}'")
            for number, row in enumerate(table, 2):
                try:
                    values = [float(word) for word in row[1:]]
                    if len(values) != 4 or not all(map(math.isfinite, values)):
                        raise ValueError
                except ValueError:
                    raise ArmsimError(f'{file}:{number}: allowed: a name and four numbers') \
                        from None
                found.setdefault(row[0], []).append(values)
    except (OSError, UnicodeDecodeError) as error:
        raise ArmsimError(f"'{file}' cannot be read: {error}") from None
    return [JointRecord(name, np.array(rows)) for name, rows in found.items()]


def write_picture(records: Sequence[JointRecord], file: Path) -> None:
    """
    Write a PNG, or an HTML page that needs nothing else.

    :raises ArmsimError: there is nothing to draw, or the file has another ending.
    """
    if not records or any(len(record.rows) < 2 for record in records):
        raise ArmsimError('nothing was recorded: too few messages arrived')
    writers = {'.png': _write_png, '.html': _write_html}
    if file.suffix not in writers:
        raise ArmsimError(f"'{file}': allowed endings: {', '.join(writers)}")
    try:
        writers[file.suffix](records, file)
    except OSError as error:
        raise ArmsimError(f"'{file}' cannot be written: {error.strerror}") from None


def with_tolerances(records: Sequence[JointRecord], tolerances: Mapping[str, float],
                    limits: Mapping[str, tuple[float, ...]]) -> list[JointRecord]:
    """Return the records with what their errors and positions are held against."""
    return [JointRecord(record.name, record.rows, limits.get(record.name, ()),
                        tolerances.get(record.name))
            for record in records]


def _write_html(records: Sequence[JointRecord], file: Path) -> None:
    data: dict[str, Any] = {'joints': [{
        'name': record.name, 'violated': record.violated, 'limits': list(record.limits),
        'tolerance': record.tolerance,
        **{name: np.round(record.rows[:, index], 7).tolist()
           for index, name in enumerate(('times', 'desired', 'actual', 'error'))},
    } for record in records]}
    text = (_STATIC / 'plot.html').read_text(encoding='utf-8')
    curves = (_STATIC / 'curves.js').read_text(encoding='utf-8').replace('export ', '')
    # '<' written as JSON may write it, so that no name of a joint can end the element.
    embedded = json.dumps(data).replace('<', '\\u003c')
    file.write_text(text.replace('CURVES', curves).replace('DATA', embedded), encoding='utf-8')


def _write_png(records: Sequence[JointRecord], file: Path) -> None:
    if find_spec('matplotlib') is None:
        raise ArmsimError("PNG needs the Python package 'matplotlib': python3 -m pip install "
                          "'armsim_ros[web]'; HTML needs nothing: --to motion.html")
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 1.2 + 1.7 * len(records)), layout='constrained')
    rows = figure.subplots(len(records), 2, sharex=True, squeeze=False)
    for (left, right), record in zip(rows, records, strict=True):
        time, desired, actual, error = record.rows.T
        left.plot(time, desired, '--', color='0.5', label='desired')
        left.plot(time, actual, color='tab:blue', label='actual')
        low, high = left.get_ylim()
        for limit in record.limits:
            if low - (high - low) < limit < high + (high - low):
                left.axhline(limit, color='tab:red', linestyle=':')
        right.plot(time, error, color='tab:orange', label='error')
        left.set_ylabel(record.name)
        for axes in (left, right):
            axes.grid(alpha=0.3)
        if record.tolerance is not None:
            for sign in (1.0, -1.0):
                right.axhline(sign * record.tolerance, color='tab:red', linestyle=':')
            right.fill_between(time, 0, 1, where=np.abs(error) > record.tolerance, alpha=0.2,
                               color='tab:red', transform=right.get_xaxis_transform())
        if record.violated:
            right.set_title(record.violated, color='tab:red', fontsize=9)
    rows[0][0].legend(loc='best', fontsize=8)
    rows[0][1].legend(loc='best', fontsize=8)
    for axes in rows[-1]:
        axes.set_xlabel('time [s]')
    figure.savefig(file, dpi=110)


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
