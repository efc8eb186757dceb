# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What ros2 bag play publishes of a recording, and with which profiles."""

import pytest
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy

from armsim_ros2.bag_selection import is_played, last_played
from armsim_ros2.commands.bag import VERBS
from armsim_ros2.parsing import Parser
from armsim_ros2.qos import offered, to_plain

RELIABLE = to_plain(QoSProfile(depth=1))
LATCHED = to_plain(QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL))
TOPICS = ('/clock', '/tf', '/tf_static', '/joint_states')


def parsed(verb, *words):
    """Return the options of a command line."""
    parser = Parser()
    for add in VERBS[verb].arguments:
        add(parser)
    return parser.parse_args(words)


def played(*words):
    """Return which topics are played."""
    options = parsed('play', 'bag', *words)
    return [topic for topic in TOPICS if is_played(topic, options, lambda name: name)]


@pytest.mark.parametrize(('words', 'topics'), [
    ([], TOPICS), (['--clock'], TOPICS[1:]), (['--clock', '100'], TOPICS[1:]),
    (['--clock', '--topics', '/clock', '/tf'], ('/tf',))])
def test_the_recorded_clock_is_left_out_where_a_clock_is_published(words, topics):
    """Re-enacts ros2bag/verb/play.py, main: two clocks would contradict each other."""
    assert played(*words) == list(topics)


@pytest.mark.parametrize(('words', 'topics'), [
    (['-e', '/tf'], ['/tf']), (['--regex', '/tf.*'], ['/tf', '/tf_static']),
    (['-e', '/tf', '--topics', '/clock'], ['/clock', '/tf']),
    (['-x', '.*tf.*', '--exclude-topics', '/clock'], ['/joint_states'])])
def test_topics_are_chosen_by_name_or_expression(words, topics):
    """Re-enacts mcap_storage.cpp, is_topic_selected_by_white_list_or_regex: the whole name."""
    assert played(*words) == topics


@pytest.mark.parametrize(('words', 'last'), [
    ([], None), (['--playback-duration', '2'], 3_000_000_000),
    (['--playback-until-sec', '2.5'], 2_500_000_000), (['--playback-until-nsec', '7'], 7),
    (['--playback-duration', '2', '--playback-until-sec', '9'], 9_000_000_000),
    (['--playback-duration', '0'], -1)])
def test_playing_ends_at_a_time_of_the_recording(words, last):
    """Re-enacts player.cpp, configure_play_until_timestamp: the later of both."""
    assert last_played(1_000_000_000, parsed('play', 'bag', *words)) == last


@pytest.mark.parametrize(('words', 'interval'), [([], 100), (['-p', '0'], 1), (['-p', '-5'], 1)])
def test_no_polling_interval_keeps_from_recording(words, interval):
    """Re-enacts recorder.cpp, topics_discovery: at 0 it looks all the time, and records."""
    assert parsed('record', '-a', *words).polling_interval == interval


def test_a_topic_is_published_with_the_profile_of_its_publishers():
    """Re-enacts rosbag2_storage/qos.cpp, adapt_offer_to_recorded_offers: with default history."""
    profile = offered('/tf_static', [LATCHED, {**LATCHED, 'depth': 5}])
    assert (profile.durability, profile.depth) == (QoSDurabilityPolicy.TRANSIENT_LOCAL, 10)


def test_a_topic_whose_publishers_differed_is_published_with_the_default(capsys):
    """Re-enacts rosbag2_storage/qos.cpp, adapt_offer_to_recorded_offers."""
    profile = offered('/tf', [LATCHED, RELIABLE])
    assert (profile.durability, profile.reliability, profile.depth) == (
        QoSDurabilityPolicy.VOLATILE, QoSReliabilityPolicy.RELIABLE, 10)
    assert 'Not all original publishers on topic /tf' in capsys.readouterr().err


@pytest.mark.parametrize('words', [
    ['play', 'bag', '--disable-keyboard-controls', '--read-ahead-queue-size', '10',
     '--wait-for-all-acked', '100', '-m', '/a:=/b'],
    ['record', '--all-topics', '--max-cache-size', '0', '--no-discovery', '-p', '50',
     '--exclude-regex', 'x', '--topic-types', 'a/msg/B', '--exclude-topic-types', 'a/msg/C'],
    ['info', 'bag', '-v']])
def test_options_of_rosbag2_are_understood(words):
    """As documented in docs/ros2_command.md."""
    assert parsed(*words)
