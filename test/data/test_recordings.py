# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Data sets from recordings of topics."""

import json

from mcap.writer import Writer as McapWriter
from mcap_ros2.writer import Writer
import numpy as np
from pyarrow import parquet
import pytest

from armsim_ros.cli.main import main
from armsim_ros.data.recordings import convert
from armsim_ros.data.topic_map import topic_map, TopicMap
from armsim_ros.data.video import decoded
from armsim_ros.errors import ArmsimError, ConfigError

_HEADER = ('=' * 80 + '\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n'
           + '=' * 80 + '\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n')
KINDS = {
    'sensor_msgs/msg/JointState': 'std_msgs/Header header\nstring[] name\nfloat64[] position\n'
                                  f'float64[] velocity\nfloat64[] effort\n{_HEADER}',
    'std_msgs/msg/Float64MultiArray': 'float64[] data\n',
    'std_msgs/msg/Bool': 'bool data\n', 'std_msgs/msg/String': 'string data\n',
    'sensor_msgs/msg/Image': 'std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding'
                             f'\nuint8 is_bigendian\nuint32 step\nuint8[] data\n{_HEADER}',
}
MAP = {
    'fps': 10, 'task': 'Do it.', 'robot_type': 'bot', 'episode': {'topic': '/run'},
    'features': {
        'observation.state': {'topic': '/joint_states', 'names': ['b', 'a']},
        'action': {'topic': '/commands'}, 'observation.images.front': {'topic': '/image'},
    }}


def header(t):
    """Return a header of a time [s]."""
    return {'stamp': {'sec': int(t), 'nanosec': round((t % 1) * 1e9)}, 'frame_id': ''}


def joint_state(t):
    """Return joints that are at t and -t."""
    return {'header': header(t), 'name': ['a', 'b'], 'position': [t, -t], 'velocity': [],
            'effort': []}


def image(t):
    """Return a picture that is brighter the later it is."""
    return {'header': header(t), 'height': 16, 'width': 16, 'encoding': 'bgr8', 'is_bigendian': 0,
            'step': 48, 'data': bytes([0, 0, round(10 * t)] * 256)}


def record(path, messages):
    """Write (topic, type, arrival [s], message) to an MCAP file."""
    with path.open('wb') as stream:
        writer, schemas = Writer(stream), {}
        for topic, kind, arrival, message in sorted(messages, key=lambda item: item[2]):
            if kind not in schemas:
                schemas[kind] = writer.register_msgdef(kind, KINDS[kind])
            writer.write_message(topic=topic, schema=schemas[kind], message=message,
                                 log_time=round(arrival * 1e9),
                                 publish_time=round(arrival * 1e9))
        writer.finish()


def two_runs(skip=()):
    """Return messages of ten seconds in which the robot runs from 1 to 3 and from 6 to 8 s."""
    messages = [('/run', 'std_msgs/msg/Bool', t, {'data': value})
                for t, value in ((1.0, True), (3.0, False), (6.0, True), (8.0, False))]
    for k in range(1000):
        t = k / 100
        if not any(low < t < high for low, high in skip):
            messages.append(('/joint_states', 'sensor_msgs/msg/JointState', t, joint_state(t)))
        if k % 5 == 0:
            messages.append(('/commands', 'std_msgs/msg/Float64MultiArray', t,
                             {'data': [2 * t, 0.0, 1.0]}))
            messages.append(('/image', 'sensor_msgs/msg/Image', t, image(t)))
    return messages


def converted(tmp_path, messages, mapping=MAP, **words):
    """Return the data set of messages."""
    record(tmp_path / 'run.mcap', messages)
    return convert([tmp_path / 'run.mcap'], tmp_path / 'set', TopicMap.model_validate(mapping),
                   **words)


def test_frames_have_the_latest_values(tmp_path):
    """Two episodes of two seconds; joints by name, commands, pictures, each not from later."""
    data = converted(tmp_path, two_runs())
    assert (data.episodes, data.frames) == (2, 42)
    rows = parquet.read_table(tmp_path / 'set/data', partitioning=None).to_pylist()
    for row in rows:
        t = (1.0, 6.0)[row['episode_index']] + row['frame_index'] / 10
        np.testing.assert_allclose(row['observation.state'], [-t, t], atol=1e-6)
        np.testing.assert_allclose(row['action'], [2 * t, 0.0, 1.0], atol=1e-6)
    info = json.loads((tmp_path / 'set/meta/info.json').read_text())
    assert info['features']['observation.state']['names'] == ['b', 'a']
    video = tmp_path / 'set/videos/observation.images.front/chunk-000/file-001.mp4'
    pictures = decoded(video.read_bytes())
    assert len(pictures) == 21
    assert pictures[-1][..., 0].mean() == pytest.approx(80, abs=4)
    assert pictures[-1][..., 2].mean() < 10


def test_silence_separates_episodes_without_a_topic(tmp_path):
    """Where nothing comes for longer than the gap, another episode begins."""
    mapping = {'fps': 10, 'task': 'Do it.', 'features': {
        'observation.state': {'topic': '/joint_states', 'names': ['a']}}}
    quiet = [item for item in two_runs() if item[0] == '/joint_states' and not 4 < item[2] < 6]
    assert converted(tmp_path, quiet, mapping).episodes == 2


def test_a_gap_is_named_with_its_times(tmp_path):
    """More than three frames without joints are refused, and kept on request."""
    messages = two_runs(skip=[(2.0, 2.5)])
    with pytest.raises(ArmsimError, match=r"'/joint_states' is silent from 2.0.* to at least 2.4"):
        converted(tmp_path, messages)
    assert converted(tmp_path, messages, allow_gaps=True).episodes == 2


def test_stamps_that_run_back_are_named(tmp_path):
    """Both times are in the message."""
    messages = [*two_runs(), ('/joint_states', 'sensor_msgs/msg/JointState', 5.001,
                              joint_state(4.0))]
    with pytest.raises(ArmsimError, match=r'run back from 5.0+ s to 4.0+ s'):
        converted(tmp_path, messages)


def test_what_does_not_fit_is_named(tmp_path):
    """A missing topic and a missing joint, with what there is."""
    wrong = {**MAP, 'features': {'action': {'topic': '/comands'}}}
    with pytest.raises(ConfigError, match=r"no topic '/comands'.*did you mean '/commands'"):
        converted(tmp_path, two_runs(), wrong)
    wrong = {**MAP, 'features': {'action': {'topic': '/joint_states', 'names': ['c']}}}
    with pytest.raises(ArmsimError, match="no joint 'c'; it has a, b"):
        converted(tmp_path, two_runs(), wrong)


def test_the_program_reads_a_map_file(tmp_path, capsys):
    """It prints what it wrote; an error of the map names its key."""
    record(tmp_path / 'run.mcap', two_runs())
    (tmp_path / 'map.yaml').write_text(json.dumps(MAP))
    arguments = ['dataset', str(tmp_path / 'run.mcap'), str(tmp_path / 'set'), '--map']
    assert main([*arguments, str(tmp_path / 'map.yaml')]) == 0
    assert capsys.readouterr().out == '2 episodes, 42 frames\n'
    (tmp_path / 'wrong.yaml').write_text('fps: 0\nfeatures: {action: {topik: /x}}\n')
    with pytest.raises(ConfigError, match=r'fps: .*greater than or equal to 1'):
        topic_map(tmp_path / 'wrong.yaml')
    assert main([*arguments, str(tmp_path / 'wrong.yaml')]) == 2


def test_a_topic_without_a_message_is_named(tmp_path):
    """A topic that was recorded, and on which nothing came."""
    with (tmp_path / 'run.mcap').open('wb') as stream:
        writer = McapWriter(stream)
        writer.start('ros2')
        kind = 'std_msgs/msg/Float64MultiArray'
        schema = writer.register_schema(kind, 'ros2msg', KINDS[kind].encode())
        writer.register_channel('/commands', 'cdr', schema)
        writer.finish()
    mapping = {'fps': 10, 'task': 'Do it.', 'features': {'action': {'topic': '/commands'}}}
    with pytest.raises(ConfigError, match="has no message of '/commands'"):
        convert([tmp_path / 'run.mcap'], tmp_path / 'set', TopicMap.model_validate(mapping))
