# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 bag``: recordings that rosbag2 and Foxglove read."""

import signal

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
import pytest
import yaml

STRING = 'std_msgs/msg/String'
NOTE = '{data: written down}'


@pytest.fixture
def bag(ros2, start, tmp_path):
    """Record a message and the latched description; gives the folder."""
    folder = tmp_path / 'notes'
    recorder = start('bag', 'record', '/note', '-e', '^/robot_description$', '-o', str(folder))
    assert ros2('topic', 'pub', '--once', '--keep-alive', '1', '/note', STRING, NOTE).status == 0
    recorder.send_signal(signal.SIGINT)
    out, err = recorder.communicate(timeout=30)
    assert (recorder.returncode, err) == (0, '')
    assert "Subscribed to topic '/robot_description'" in out
    return folder


def test_a_recording_is_described_and_read(ros2, bag):
    """Info as rosbag2_py prints it; the file and metadata.yaml in the form of rosbag2 0.26."""
    lines = ros2('bag', 'info', str(bag)).lines
    assert lines[1] == 'Files:             notes_0.mcap'
    assert 'Storage id:        mcap' in lines
    assert 'Messages:          2' in lines
    assert any(line.endswith(f'Topic: /note | Type: {STRING} | Count: 1 | '
                             'Serialization Format: cdr') for line in lines)
    assert sorted(ros2('bag', 'info', '-t', str(bag)).lines) == ['/note', '/robot_description']
    values = yaml.safe_load((bag / 'metadata.yaml').read_text())['rosbag2_bagfile_information']
    assert (values['version'], values['message_count']) == (9, 2)
    (latched,) = (entry['topic_metadata'] for entry in values['topics_with_message_count']
                  if entry['topic_metadata']['name'] == '/robot_description')
    assert latched['offered_qos_profiles'][0]['durability'] == 'transient_local'
    assert latched['type_description_hash'].startswith('RIHS01_')
    with open(bag / 'notes_0.mcap', 'rb') as stream:
        texts = {channel.topic: message.data for _, channel, _, message in make_reader(
            stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages()}
    assert texts['/note'] == 'written down'
    assert texts['/robot_description'].rstrip().endswith('</robot>')


def test_a_recording_is_played(start, ros2, bag):
    """Messages are published with their types, at a rate, with or without a clock."""
    echo = start('topic', 'echo', '--once', '/note', STRING)
    player = start('bag', 'play', str(bag), '--loop', '--rate', '10', '--topics', '/note')
    assert echo.communicate(timeout=30)[0] == 'data: written down\n---\n'
    player.send_signal(signal.SIGINT)
    assert player.wait(30) == 2
    assert ros2('bag', 'play', str(bag), '--topics', '/note', '--clock', '100').status == 0


def test_what_cannot_be_played_is_named(ros2, tmp_path):
    """A missing recording, an empty folder, and a file of another kind."""
    assert ros2('bag', 'info', str(tmp_path / 'nope')).err.startswith('Bag path ')
    assert 'has 0 .mcap files' in ros2('bag', 'play', str(tmp_path)).err
    file = tmp_path / 'a.mcap'
    file.write_bytes(b'no recording, whatever its name is')
    assert 'is not a readable MCAP file' in ros2('bag', 'info', str(file)).err
    assert ros2('bag', 'record').err.startswith('Invalid choice: Must specify topics')
    assert 'already exists' in ros2('bag', 'record', '-a', '-o', str(tmp_path)).err
