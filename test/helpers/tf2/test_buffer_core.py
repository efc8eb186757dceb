# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Times, trees and refusals of the buffer: facts of upstream's buffer_core.cpp and cache.cpp."""

import pytest
from rclpy.duration import Duration
from stamped_transforms import at, numbers, stamped
import tf2_py
from tf2_py import BufferCore
import yaml


@pytest.fixture
def buffer():
    """Return an empty buffer."""
    return BufferCore()


@pytest.fixture
def moving(buffer):
    """Return a buffer in which tool moves from x = 0 at 1 s to x = 2 m at 2 s."""
    buffer.set_transform(stamped('base', 'tool', 1.0), 'test')
    buffer.set_transform(stamped('base', 'tool', 2.0, (2, 0, 0)), 'test')
    return buffer


def test_between_samples_the_pose_is_interpolated(moving):
    """A quarter of the time is a quarter of the way."""
    found = moving.lookup_transform_core('base', 'tool', at(1.25))
    assert numbers(found) == ((0.5, 0, 0), (0, 0, 0, 1))
    assert (found.header.frame_id, found.child_frame_id) == ('base', 'tool')
    assert found.header.stamp == at(1.25).to_msg()


def test_the_message_is_one_that_the_constructor_makes(moving):
    """All fields are there and have the right types, so it can be sent and compared."""
    assert moving.lookup_transform_core('base', 'tool', at(2.0)) == (
        stamped('base', 'tool', 2.0, (2, 0, 0)))


def test_time_zero_is_the_latest_common_time(moving):
    """The stamp is the oldest of the newest samples; static frames do not count."""
    moving.set_transform(stamped('tool', 'camera', 1.0), 'test')
    moving.set_transform(stamped('tool', 'camera', 1.5), 'test')
    moving.set_transform_static(stamped('camera', 'lens', 0.3), 'test')
    moving.set_transform_static(stamped('world', 'base'), 'test')
    for pair in (('world', 'lens'), ('lens', 'world'), ('base', 'camera')):
        assert moving.lookup_transform_core(*pair, at(0)).header.stamp == at(1.5).to_msg()
        assert moving.get_latest_common_time(*pair) == at(1.5)
    found = moving.lookup_transform_core('world', 'lens', at(0))
    assert numbers(found)[0] == (1, 0, 0)
    assert moving.get_latest_common_time('camera', 'lens') == at(0)


def test_of_siblings_only_the_path_between_them_counts(moving):
    """A common parent that is itself delayed does not hold its children back."""
    moving.set_transform(stamped('tool', 'left', 3.0, (0, 1, 0)), 'test')
    moving.set_transform(stamped('tool', 'right', 2.5, (0, -1, 0)), 'test')
    moving.set_transform(stamped('tool', 'left', 2.5, (0, 1, 0)), 'test')
    found = moving.lookup_transform_core('left', 'right', at(0))
    assert found.header.stamp == at(2.5).to_msg()
    assert numbers(found)[0] == (0, -2, 0)


def test_a_static_frame_has_its_pose_at_every_time(buffer):
    """The answer bears the time that was asked for."""
    buffer.set_transform_static(stamped('base', 'camera', 5.0, (1, 2, 3)), 'test')
    for time in (0.001, 7e5):
        found = buffer.lookup_transform_core('base', 'camera', at(time))
        assert numbers(found)[0] == (1, 2, 3)
        assert found.header.stamp == at(time).to_msg()


def test_a_frame_is_where_it_is_whatever_is_known(buffer):
    """A look-up of a frame in itself needs no data."""
    found = buffer.lookup_transform_core('nobody', 'nobody', at(3.0))
    assert numbers(found) == ((0, 0, 0), (0, 0, 0, 1))
    assert found.header.stamp == at(3.0).to_msg()
    assert buffer.can_transform_core('nobody', 'nobody', at(3.0)) == (True, '')


def test_the_result_is_a_unit_quaternion_with_the_sign_of_a_matrix_conversion(buffer):
    """Signs as of Matrix3x3.h getRotation: w positive, beyond 120 degrees the largest part."""
    buffer.set_transform_static(stamped('a', 'b', rotation=(0.6, 0, 0, -0.8)), 'test')
    buffer.set_transform_static(stamped('a', 'c', rotation=(0.1, -0.99, 0.0, 0.1)), 'test')
    assert numbers(buffer.lookup_transform_core('a', 'b', at(0)))[1] == (
        pytest.approx((-0.6, 0, 0, 0.8)))
    length = (0.02 + 0.99 ** 2) ** 0.5
    assert numbers(buffer.lookup_transform_core('a', 'c', at(0)))[1] == (
        pytest.approx((-0.1 / length, 0.99 / length, 0, -0.1 / length)))


@pytest.mark.parametrize(('time', 'text'), [
    (2.5, 'into the future.  Requested time 2.500000 but the latest data is at time 2.000000'),
    (0.5, 'into the past.  Requested time 0.500000 but the earliest data is at time 1.000000'),
])
def test_outside_of_the_samples_is_an_extrapolation(moving, time, text):
    """The text has the times and the frames; can_transform has the same text."""
    for pair in (('base', 'tool'), ('tool', 'base')):
        with pytest.raises(tf2_py.ExtrapolationException) as caught:
            moving.lookup_transform_core(*pair, at(time))
        assert text in str(caught.value)
        assert f'from frame [{pair[1]}] to frame [{pair[0]}]' in str(caught.value)
        assert moving.can_transform_core(*pair, at(time)) == (False, str(caught.value))


def test_a_single_sample_is_known_at_its_time_only(buffer):
    """The text of the extrapolation says so."""
    buffer.set_transform(stamped('base', 'tool', 1.0), 'test')
    assert buffer.can_transform_core('base', 'tool', at(1.0))[0]
    with pytest.raises(tf2_py.ExtrapolationException, match=r'only time 1\.0+ is in the buffer'):
        buffer.lookup_transform_core('base', 'tool', at(1.1))


def test_data_that_the_path_does_not_need_may_be_missing(moving):
    """A parent's extrapolation does not prevent a look-up below it."""
    moving.set_transform_static(stamped('tool', 'left', 0.0, (0, 1, 0)), 'test')
    moving.set_transform_static(stamped('tool', 'right', 0.0, (0, -1, 0)), 'test')
    assert numbers(moving.lookup_transform_core('left', 'right', at(9.0)))[0] == (0, -2, 0)
    assert numbers(moving.lookup_transform_core('tool', 'right', at(9.0)))[0] == (0, -1, 0)


@pytest.mark.parametrize('time', [0.0, 1.5])
def test_frames_of_two_trees_are_not_connected(moving, time):
    """At time 0 and at any other."""
    moving.set_transform_static(stamped('table', 'cup'), 'test')
    with pytest.raises(tf2_py.ConnectivityException, match=(
            "between 'tool' and 'cup' because they are not part of the same tree")):
        moving.lookup_transform_core('tool', 'cup', at(time))
    assert not moving.can_transform_core('tool', 'cup', at(time))[0]


@pytest.mark.parametrize(('pair', 'kind', 'text'), [
    (('base', 'nope'), tf2_py.LookupException, '"nope" passed to lookupTransform argument '
     'source_frame does not exist'),
    (('nope', 'tool'), tf2_py.LookupException, '"nope" passed to lookupTransform argument '
     'target_frame does not exist'),
    (('base', ''), tf2_py.InvalidArgumentException, 'cannot be empty'),
    (('/base', 'tool'), tf2_py.InvalidArgumentException, "cannot start with a '/'"),
])
def test_names_that_are_no_frames(moving, pair, kind, text):
    """Unknown names and malformed names are different exceptions."""
    with pytest.raises(kind) as caught:
        moving.lookup_transform_core(*pair, at(0))
    assert text in str(caught.value)
    assert isinstance(caught.value, tf2_py.TransformException)
    assert not moving.can_transform_core(*pair, at(0))[0]


def test_the_fixed_frame_is_checked_too(moving):
    """lookup_transform_full validates three names."""
    with pytest.raises(tf2_py.LookupException, match='argument fixed_frame'):
        moving.lookup_transform_full_core('base', at(1.0), 'tool', at(1.0), 'nope')
    assert 'fixed_frame' in moving.can_transform_full_core(
        'base', at(1.0), 'tool', at(1.0), 'nope')[1]


@pytest.mark.parametrize('time', [0.0, 1.0])
def test_a_loop_is_reported(buffer, time):
    """Frames that are each other's parents have no root."""
    for parent, child in (('a', 'b'), ('b', 'c'), ('c', 'a')):
        buffer.set_transform(stamped(parent, child, 1.0), 'test')
    buffer.set_transform(stamped('x', 'y', 1.0), 'test')
    with pytest.raises(tf2_py.LookupException, match='contains a loop'):
        buffer.lookup_transform_core('y', 'a', at(time))


def test_samples_older_than_the_cache_time_go(buffer):
    """Samples of the last ten seconds are kept, older new ones are ignored."""
    for time in range(1, 31):
        buffer.set_transform(stamped('base', 'tool', float(time)), 'test')
    buffer.set_transform(stamped('base', 'tool', 19.5), 'test')
    assert buffer.can_transform_core('base', 'tool', at(20.0))[0]
    assert not buffer.can_transform_core('base', 'tool', at(19.5))[0]


def test_the_cache_time_may_be_chosen():
    """In the constructor, as a Duration; a sample goes when the second newer sample comes."""
    buffer = BufferCore(Duration(seconds=2))
    for time in (1.0, 2.0, 3.0, 4.0, 5.0):
        buffer.set_transform(stamped('base', 'tool', time), 'test')
    assert 'earliest data is at time 2.000000' in buffer.can_transform_core(
        'base', 'tool', at(1.0))[1]


def test_many_samples_stay_within_the_cache_time(buffer):
    """The list is compacted and still holds exactly the last ten seconds."""
    for time in range(3000):
        buffer.set_transform(stamped('base', 'tool', 1.0 + time / 50, (time, 0, 0)), 'test')
    frame = yaml.safe_load(buffer.all_frames_as_yaml())['tool']
    assert frame['buffer_length'] == pytest.approx(10.02)
    assert numbers(buffer.lookup_transform_core('base', 'tool', at(60.01)))[0][0] == (
        pytest.approx(2950.5))


def test_samples_may_come_in_any_order(buffer):
    """An older sample is sorted in."""
    for time in (3.0, 1.0, 2.0, 2.0):
        buffer.set_transform(stamped('base', 'tool', time, (time * time, 0, 0)), 'test')
    assert numbers(buffer.lookup_transform_core('base', 'tool', at(2.5)))[0][0] == 6.5
    assert numbers(buffer.lookup_transform_core('base', 'tool', at(1.5)))[0][0] == 2.5


def test_a_new_parent_is_not_interpolated(buffer):
    """Between two samples with different parents the older holds (cache.cpp getData)."""
    buffer.set_transform(stamped('table', 'cup', 1.0, (1, 0, 0)), 'test')
    buffer.set_transform(stamped('tool', 'cup', 2.0, (5, 0, 0)), 'test')
    assert numbers(buffer.lookup_transform_core('table', 'cup', at(1.9)))[0] == (1, 0, 0)
    assert not buffer.can_transform_core('table', 'cup', at(2.0))[0]
    assert numbers(buffer.lookup_transform_core('tool', 'cup', at(2.0)))[0] == (5, 0, 0)


def test_a_frame_becomes_static_and_back(moving):
    """The kind of the newest sample counts, older ones are forgotten."""
    moving.set_transform_static(stamped('base', 'tool', 1.0, (7, 0, 0)), 'test')
    assert numbers(moving.lookup_transform_core('base', 'tool', at(1.5)))[0] == (7, 0, 0)
    moving.set_transform(stamped('base', 'tool', 3.0, (8, 0, 0)), 'test')
    assert not moving.can_transform_core('base', 'tool', at(1.5))[0]


def test_clear_keeps_names_and_static_frames(moving):
    """A look-up of a moving frame fails then, but not because its name is unknown."""
    moving.set_transform_static(stamped('base', 'camera', 0.0, (1, 0, 0)), 'test')
    moving.clear()
    assert moving._frameExists('tool')
    assert moving.can_transform_core('base', 'camera', at(0))[0]
    with pytest.raises(tf2_py.ConnectivityException):
        moving.lookup_transform_core('base', 'tool', at(0))
    with pytest.raises(tf2_py.ExtrapolationException, match='no data is in the buffer'):
        moving.lookup_transform_core('base', 'tool', at(1.5))


@pytest.mark.parametrize(('message', 'word'), [
    (stamped('base', 'base'), 'TF_SELF_TRANSFORM'),
    (stamped('base', ''), 'TF_NO_CHILD_FRAME_ID'),
    (stamped('', 'tool'), 'TF_NO_FRAME_ID'),
    (stamped('base', 'tool', translation=(float('nan'), 0, 0)), 'TF_NAN_INPUT'),
    (stamped('base', 'tool', rotation=(0, 0, 0, 0)), 'TF_DENORMALIZED_QUATERNION'),
    (stamped('base', 'tool', rotation=(0, 0, 0.2, 1)), 'TF_DENORMALIZED_QUATERNION'),
])
def test_transforms_that_cannot_be_used_are_ignored_and_reported(buffer, message, word, capfd):
    """The log has upstream's word for the reason."""
    buffer.set_transform(message, 'test')
    assert buffer._getFrameStrings() == []
    assert word in capfd.readouterr().err


def test_data_from_the_past_is_reported(buffer, capfd):
    """Samples older than the cache time are ignored."""
    buffer.set_transform(stamped('base', 'tool', 20.0), 'test')
    buffer.set_transform(stamped('base', 'tool', 9.9), 'test')
    assert 'TF_OLD_DATA' in capfd.readouterr().err


def test_slashes_before_names_are_dropped_on_the_way_in(buffer):
    """As upstream does for programs of ROS 1."""
    buffer.set_transform(stamped('/base', '/tool', 1.0), 'test')
    assert buffer._getFrameStrings() == ['tool', 'base']


def test_the_tree_as_text(moving):
    """Parent, publisher, rate and times of each frame."""
    moving.set_transform_static(stamped('tool', 'camera'), 'camera_driver')
    assert moving.all_frames_as_string() == (
        'Frame tool exists with parent base.\nFrame camera exists with parent tool.\n')
    assert yaml.safe_load(moving.all_frames_as_yaml()) == {
        'tool': {'parent': 'base', 'broadcaster': 'test', 'rate': 2.0,
                 'most_recent_transform': 2.0, 'oldest_transform': 1.0, 'buffer_length': 1.0},
        'camera': {'parent': 'tool', 'broadcaster': 'camera_driver', 'rate': 10000.0,
                   'most_recent_transform': 0.0, 'oldest_transform': 0.0, 'buffer_length': 0.0}}
    assert BufferCore().all_frames_as_yaml() == '[]'


def test_a_time_is_a_time(moving):
    """Times of rclpy and messages are taken, numbers are not."""
    assert moving.can_transform_core('base', 'tool', at(1.5).to_msg())[0]
    with pytest.raises(TypeError, match='time must have sec and nanosec, or nanoseconds'):
        moving.lookup_transform_core('base', 'tool', 1.5)


@pytest.mark.parametrize(('names', 'problem'), [
    (('world', 'tool'), 'Invalid frame ID "world" passed to canTransform argument target_frame - '
                        'frame does not exist'),
    (('base', 'world'), 'Invalid frame ID "world" passed to canTransform argument source_frame - '
                        'frame does not exist'),
    (('base', ''), 'Invalid frame ID "" passed to canTransform argument source_frame - '
                   'in tf2 frame_ids cannot be empty'),
    (('/base', 'tool'), 'Invalid frame ID "/base" passed to canTransform argument target_frame - '
                        "in tf2 frame_ids cannot start with a '/'")])
def test_can_transform_names_the_frame_that_is_missing(moving, names, problem):
    """tf2/src/buffer_core.cpp: fillOrWarnMessageForInvalidFrame, whose text tf2_echo logs."""
    assert moving.can_transform_core(*names, at(0)) == (False, problem)


def test_can_transform_full_names_the_fixed_frame(moving):
    """tf2/src/buffer_core.cpp: canTransform with a fixed frame."""
    assert moving.can_transform_full_core('base', at(0), 'tool', at(0), 'world') == (
        False, 'Invalid frame ID "world" passed to canTransform argument fixed_frame - '
               'frame does not exist')


@pytest.mark.parametrize(('source', 'target', 'chain'), [
    ('left', 'base', ['left', 'tool', 'base']),
    ('base', 'left', ['base', 'tool', 'left']),
    ('left', 'right', ['left', 'tool', 'right']),
    ('tool', 'tool', ['tool'])])
def test_the_chain_between_two_frames(moving, source, target, chain):
    """All frames from the source to the target, each once."""
    moving.set_transform_static(stamped('world', 'base'), 'test')
    moving.set_transform_static(stamped('tool', 'left'), 'test')
    moving.set_transform_static(stamped('tool', 'right'), 'test')
    assert moving._chain(target, at(0), source, at(0), target) == chain


def test_a_chain_over_a_fixed_frame(moving):
    """The path leads from the source to the fixed frame, and from there to the target."""
    moving.set_transform_static(stamped('world', 'base'), 'test')
    moving.set_transform_static(stamped('world', 'other'), 'test')
    assert moving._chain('other', at(2.0), 'tool', at(1.0), 'base') == [
        'tool', 'base', 'world', 'other']
