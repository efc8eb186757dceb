# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 bag``: recordings as MCAP, as rosbag2 and Foxglove read them."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
import os
from pathlib import Path
import re
import sys
import time
from typing import Any

import yaml

from armsim_ros2.bag_selection import check_expressions, is_played, last_played
from armsim_ros2.errors import CliError, hint
from armsim_ros2.interfaces import definition_text, load
from armsim_ros2.parsing import argument, Arguments, exclusive, flag, hidden, positive_float, Verb
from armsim_ros2.qos import matched, offered, to_plain
from armsim_ros2.session import Session

_SECOND = 1_000_000_000


class _Recorder:
    """
    Writes what is published.

    :param options: the command line; which topics to record.
    :param stream: of the file.
    """

    def __init__(self, session: Session, options: Namespace, stream: Any) -> None:
        from mcap.writer import Writer

        self._session = session
        self._chosen = {session.absolute(name) for name in (*options.topics, *options.more_topics)}
        self._left_out = {session.absolute(name) for name in options.exclude_topics}
        self._options = options
        self._writer = Writer(stream)
        self._writer.start('ros2', 'armsim_ros2')
        self._schemas: dict[str, int] = {}
        self._known: set[str] = set()

    def subscribe(self) -> None:
        """Subscribe to topics that are published and not yet recorded."""
        from rclpy.qos import QoSProfile

        node = self._session.node
        for topic, types in self._session.names('topic', self._options.hidden).items():
            publishers = node.get_publishers_info_by_topic(topic)
            if topic in self._known or not publishers or not self._is_chosen(topic, types[0]):
                continue
            self._known.add(topic)
            try:
                kind = load(types[0], 'msg', "The message type '{}' is not installed")
                channel = self._add_channel(topic, types[0], publishers)
            except CliError as failure:
                print(f'{topic} is not recorded: {failure}', file=sys.stderr)
                continue
            node.create_subscription(kind, topic, self._write_to(channel),
                                     matched(QoSProfile(depth=100), publishers), raw=True)
            print(f"Subscribed to topic '{topic}'")

    def _is_chosen(self, topic: str, kind: str) -> bool:
        options = self._options
        if (topic in self._left_out or kind in options.exclude_topic_types
                or (options.exclude_regex and re.search(options.exclude_regex, topic))):
            return False
        return (options.all or topic in self._chosen or kind in options.topic_types
                or bool(options.regex and re.search(options.regex, topic)))

    def _add_channel(self, topic: str, kind: str, publishers: list[Any]) -> int:
        if kind not in self._schemas:
            text = definition_text(kind)
            self._schemas[kind] = self._writer.register_schema(kind, 'ros2msg', text.encode())
        profiles = [to_plain(info.qos_profile) for info in publishers]
        return self._writer.register_channel(topic, 'cdr', self._schemas[kind], {
            'offered_qos_profiles': yaml.safe_dump(profiles, sort_keys=False),
            'topic_type_hash': str(publishers[0].topic_type_hash)})

    def _write_to(self, channel: int) -> Any:
        clock = self._session.node.get_clock()

        def write(data: bytes) -> None:
            now = clock.now().nanoseconds
            if now:  # there is no simulated time yet
                self._writer.add_message(channel, now, data, now)

        return write

    def finish(self) -> None:
        """Write the index."""
        self._writer.finish()  # type: ignore[no-untyped-call] # mcap's


def _interval(text: str) -> int:
    """Return a number of milliseconds in which messages can be received, too."""
    return max(int(text), 1)


def _record(options: Namespace) -> None:
    if not (options.all or options.topics or options.more_topics or options.topic_types
            or options.regex):
        raise CliError('Invalid choice: Must specify topics, --all, --topic-types or --regex')
    check_expressions(options)
    folder = Path(options.output or time.strftime('rosbag2_%Y_%m_%d-%H_%M_%S'))
    if folder.exists():
        raise CliError(f"Output folder '{folder}' already exists.")
    folder.mkdir(parents=True)
    file = folder / f'{folder.name}_0.mcap'
    with Session(options) as session, open(file, 'wb') as stream:
        recorder = _Recorder(session, options, stream)
        try:
            print('Recording...')
            if options.no_discovery:
                session.settle()
                recorder.subscribe()
            while True:
                if not options.no_discovery:
                    recorder.subscribe()
                session.spin(limit=options.polling_interval / 1e3)
        except (KeyboardInterrupt, SystemExit):
            print('Recording stopped')
        finally:
            recorder.finish()
    with _opened(str(file)) as (reader, _):
        tree = {'rosbag2_bagfile_information': _metadata(reader, file)}
    (folder / 'metadata.yaml').write_text(yaml.safe_dump(tree, sort_keys=False))


@contextmanager
def _opened(name: str) -> Iterator[tuple[Any, Path]]:
    """
    Open a recording.

    :param name: of its folder or file.
    :returns: the reader and the file.
    :raises CliError: there is none, or it is not MCAP.
    """
    from mcap.exceptions import McapError
    from mcap.reader import make_reader

    path = Path(name)
    files = sorted(path.glob('*.mcap')) if path.is_dir() else [path]
    if not path.exists():
        beside = [entry.name for entry in path.absolute().parent.glob('*')]
        raise CliError(f"Bag path '{name}' does not exist!{hint(path.name, beside)}")
    if len(files) != 1:
        raise CliError(f"'{name}' has {len(files)} .mcap files, not one; name one file of a bag "
                       'that was split, and convert other storages to mcap')
    with open(files[0], 'rb') as stream:
        try:
            reader = make_reader(stream)
            if reader.get_summary() is None:
                raise CliError(f"'{files[0]}' was not closed: it has no index")
            yield reader, files[0]
        except McapError as error:
            raise CliError(f"'{files[0]}' is not a readable MCAP file: {error}") from None


def _metadata(reader: Any, file: Path) -> dict[str, Any]:
    """Return the metadata of a bag as rosbag2 writes them."""
    summary = reader.get_summary()
    statistics = summary.statistics
    start = {'nanoseconds_since_epoch': statistics.message_start_time}
    duration = {'nanoseconds': statistics.message_end_time - statistics.message_start_time}
    return {
        'version': 9, 'storage_identifier': 'mcap', 'duration': duration, 'starting_time': start,
        'message_count': statistics.message_count,
        'topics_with_message_count': [{
            'topic_metadata': {
                'name': channel.topic, 'type': summary.schemas[channel.schema_id].name,
                'serialization_format': channel.message_encoding,
                'offered_qos_profiles': _profiles(channel),
                'type_description_hash': channel.metadata.get('topic_type_hash', '')},
            'message_count': statistics.channel_message_counts.get(channel.id, 0),
        } for channel in summary.channels.values()],
        'compression_format': '', 'compression_mode': '', 'relative_file_paths': [file.name],
        'files': [{'path': file.name, 'starting_time': dict(start), 'duration': dict(duration),
                   'message_count': statistics.message_count}],
        'custom_data': None, 'ros_distro': os.environ.get('ROS_DISTRO', 'jazzy'),
    }


def _profiles(channel: Any) -> list[dict[str, Any]]:
    return yaml.safe_load(channel.metadata.get('offered_qos_profiles', '')) or []


def _info(options: Namespace) -> None:
    with _opened(options.bag_path) as (reader, file):
        bag = _metadata(reader, file)
    topics = bag['topics_with_message_count']
    if options.topic_name:
        print(*(entry['topic_metadata']['name'] for entry in topics), sep='\n')
        return
    start = bag['starting_time']['nanoseconds_since_epoch']
    duration = bag['duration']['nanoseconds']
    rows = ('\n' + ' ' * 19).join(
        f'Topic: {data["name"]} | Type: {data["type"]} | Count: {entry["message_count"]} | '
        f'Serialization Format: {data["serialization_format"]}'
        for entry in topics for data in [entry['topic_metadata']])
    print(f'\nFiles:             {file.name}\nBag size:          {_size_text(file)}\n'
          f'Storage id:        mcap\nROS Distro:        {bag["ros_distro"]}\n'
          f'Duration:          {_seconds(duration)}s\n'
          f'Start:             {_moment(start)}\nEnd:               '
          f'{_moment(start + duration)}\nMessages:          {bag["message_count"]}\n'
          f'Topic information: {rows}\nService:           0\nService information: ')


def _size_text(file: Path) -> str:
    size, units = float(file.stat().st_size), ['B', 'KiB', 'MiB', 'GiB', 'TiB']
    while size >= 1024 and len(units) > 1:
        size /= 1024
        units.pop(0)
    return f'{size:.{0 if units[0] == "B" else 1}f} {units[0]}'


def _seconds(nanoseconds: int) -> str:
    return f'{nanoseconds // _SECOND}.{nanoseconds % _SECOND:09d}'


def _moment(nanoseconds: int) -> str:
    day = datetime.fromtimestamp(nanoseconds // _SECOND)
    return (f'{day:%b %e %Y %H:%M:%S}.{nanoseconds % _SECOND:09d} ({_seconds(nanoseconds)})')


def _play(options: Namespace) -> None:
    from rclpy.duration import Duration

    check_expressions(options)
    options.ros_args = [word for rule in options.remap for word in ('--remap', rule)]
    with _opened(options.bag_path) as (reader, _), Session(options) as session:
        summary = reader.get_summary()
        publishers = {}
        for channel in summary.channels.values():
            if not is_played(channel.topic, options, session.absolute):
                continue
            try:
                kind = load(summary.schemas[channel.schema_id].name, 'msg')
            except CliError as failure:
                print(f'{channel.topic} is not played: {failure}', file=sys.stderr)
                continue
            publishers[channel.id] = session.node.create_publisher(
                kind, channel.topic, offered(channel.topic, _profiles(channel)))
        session.settle()
        first: int = summary.statistics.message_start_time + round(options.start_offset * _SECOND)
        while True:
            _play_once(session, reader, publishers, first, options)
            if not options.loop:
                break
        limit = Duration(seconds=options.wait_for_all_acked / 1e3 or -1)
        for publisher in publishers.values():
            publisher.wait_for_all_acked(limit)


def _play_once(session: Session, reader: Any, publishers: dict[int, Any], first: int,
               options: Namespace) -> None:
    """
    Publish the messages once.

    :param publishers: by the number of the recorded channel.
    :param first: time of the recording to begin with [ns].
    """
    session.spin(limit=options.delay)
    start = time.monotonic()

    def reached() -> int:
        """Return the time of the recording that is reached [ns]."""
        return first + int((time.monotonic() - start) * options.rate * _SECOND)

    timer = None
    if options.clock:
        clock_type = load('rosgraph_msgs/Clock', 'msg')
        clock = session.node.create_publisher(clock_type, '/clock', 10)

        def publish_clock() -> None:
            message = clock_type()
            message.clock.sec, message.clock.nanosec = divmod(reached(), _SECOND)
            clock.publish(message)

        timer = session.node.create_timer(1 / options.clock, publish_clock)
    last = last_played(first, options)
    for _, channel, message in reader.iter_messages():
        if last is not None and message.log_time > last:
            break
        if channel.id in publishers and message.log_time >= first:
            wait = (message.log_time - reached()) / options.rate / _SECOND
            session.spin(limit=wait)
            publishers[channel.id].publish(message.data)
    if timer is not None:
        session.node.destroy_timer(timer)
        session.node.destroy_publisher(clock)


_bag = argument('bag_path', help='folder or .mcap file of the recording')
_keyboard = flag('--disable-keyboard-controls', about='no effect: there are none')
_storage = argument('-s', '--storage', choices=['mcap'], default='mcap', help='the only one')


def _excluding(*short: str) -> tuple[Arguments, Arguments]:
    """Return the options that leave topics out."""
    return (argument('--exclude-topics', nargs='+', default=[], metavar='TOPIC',
                     help='leave these topics out'),
            argument(*short, '--exclude-regex', default='',
                     help='leave topics out that match this expression'))


VERBS = {
    'info': Verb('print the topics and the duration of a recording', _info, [
        _bag, _storage, exclusive(
            flag('-t', '--topic-name', about='print only the names of topics'),
            flag('-v', '--verbose', about='no effect: services are not recorded'))]),
    'play': Verb('publish the messages of a recording', _play, [
        _bag, _storage,
        argument('-r', '--rate', type=positive_float, default=1.0,
                 help='times as fast as recorded (default: %(default)s)'),
        argument('--topics', nargs='+', default=[], metavar='TOPIC', help='only these topics'),
        argument('-e', '--regex', default='', help='only topics that match this expression'),
        *_excluding('-x'),
        argument('-m', '--remap', nargs='+', default=[], metavar='OLD:=NEW',
                 help='publish under other names'),
        flag('-l', '--loop', about='begin again at the end'),
        argument('--clock', type=positive_float, nargs='?', const=40.0, metavar='HZ',
                 help='publish the time of the recording on /clock (40 times per second)'),
        argument('-d', '--delay', type=positive_float, default=0.0, metavar='S',
                 help='time to wait before each start'),
        argument('--start-offset', type=float, default=0.0, metavar='S',
                 help='skip so much of the recording'),
        argument('--playback-duration', type=float, default=-1.0, metavar='S',
                 help='play only so much of the recording'),
        exclusive(
            argument('--playback-until-sec', type=float, default=-1.0, metavar='S',
                     help='play until this time of the recording'),
            argument('--playback-until-nsec', type=int, default=-1, metavar='NS',
                     help='the same in nanoseconds')),
        argument('--wait-for-all-acked', type=int, default=0, metavar='MS',
                 help='how long to wait at the end for subscribers; 0: no limit'),
        argument('--read-ahead-queue-size', type=int, metavar='N', help='no effect'),
        _keyboard, flag('--disable-loan-message', about='no effect')]),
    'record': Verb('record topics until Ctrl-C', _record, [
        argument('topics', nargs='*', metavar='topic', help='topics to record'),
        argument('--topics', dest='more_topics', nargs='+', default=[], metavar='TOPIC',
                 help='topics to record'),
        flag('-a', '--all', '--all-topics', dest='all', about='record all topics'),
        argument('--topic-types', nargs='+', default=[], metavar='TYPE',
                 help='record topics of these types'),
        argument('-e', '--regex', default='', help='record topics that contain this expression'),
        *_excluding(),
        argument('--exclude-topic-types', nargs='+', default=[], metavar='TYPE',
                 help='leave topics of these types out'),
        flag('--no-discovery', about='record only topics that are there at the start'),
        argument('-p', '--polling-interval', type=_interval, default=100, metavar='MS',
                 help='how often new topics are looked for (default: %(default)s)'),
        argument('--max-cache-size', type=int, metavar='BYTES', help='no effect'), _keyboard,
        argument('-o', '--output', metavar='FOLDER', help='a new folder for the recording'),
        _storage, flag('--use-sim-time', about='use the time of /clock'), hidden('topic')]),
}
