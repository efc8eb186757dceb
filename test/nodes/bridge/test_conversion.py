# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Messages as JSON and CBOR, and back."""

from base64 import b64decode, b64encode, encodebytes
import itertools
import json
import math
import zlib

import cbor2
from control_msgs.action import FollowJointTrajectory
from geometry_msgs.msg import Point, PoseStamped
from hypothesis import given, settings, strategies
import numpy as np
import pytest
from rcl_interfaces.msg import ParameterValue
from rclpy.serialization import deserialize_message, serialize_message
from rosidl_parser.definition import BasicType, UnboundedWString
from sensor_msgs.msg import CameraInfo, Image, Imu, JointState, PointCloud2
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import Float32, Header, Int64, UInt8MultiArray
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import Marker, MeshFile

from armsim_ros.nodes.bridge import incoming
from armsim_ros.nodes.bridge.frames import to_png
from armsim_ros.nodes.bridge.incoming import ConversionError, serialized
from armsim_ros.nodes.bridge.outgoing import cbor_values, json_values, to_cbor, values_of
from armsim_ros.nodes.json_text import to_json


def now():
    """Return the time of these tests."""
    return 12, 34


def filled(cls, values):
    """Return a message with these values."""
    return deserialize_message(serialized(cls, values, now), cls)


def cbor_of(message):
    """Return what a client of CBOR reads."""
    return cbor2.loads(b''.join(
        to_cbor(cbor_values(type(message))(serialize_message(message)))))


@pytest.mark.parametrize('cls', [
    JointState, Image, CameraInfo, Imu, PointCloud2, JointTrajectory, ParameterValue,
    FollowJointTrajectory.Goal, FollowJointTrajectory.Impl.FeedbackMessage,
    FollowJointTrajectory.Impl.SendGoalService.Request])
def test_what_is_sent_can_be_sent_back(cls):
    """A message is the same after JSON and back."""
    message = cls()
    assert filled(cls, json.loads(to_json(values_of(message)))) == message


def test_json_has_the_forms_of_rosbridge():
    """NaN is null, bytes are base64, a byte list has integers, digits of an int64 are exact."""
    assert to_json(values_of(JointState(position=[1.0, math.nan, math.inf]))) == (
        '{"header":{"stamp":{"sec":0,"nanosec":0},"frame_id":""},"name":[],'
        '"position":[1.0,null,null],"velocity":[],"effort":[]}')
    for data in (b'', b'abc', bytes(range(256)) * 2000):
        assert json.loads(to_json(values_of(Image(data=data))))['data'] == b64encode(
            data).decode()
    value = ParameterValue(byte_array_value=[b'\x01', b'\xff'])
    assert values_of(value)['byte_array_value'] == [1, 255]
    assert to_json(values_of(Int64(data=2**63 - 1))) == '{"data":9223372036854775807}'


def test_cbor_has_typed_arrays_of_fixed_and_free_length():
    """Little-endian, with the tags of RFC 8746; bytes are bytes."""
    message = CameraInfo(k=np.arange(9.0), d=[0.5])
    values = cbor_of(message)
    assert (values['k'].tag, values['d'].tag) == (86, 86)
    assert np.frombuffer(values['k'].value, '<f8').tolist() == list(range(9))
    assert cbor_of(Image(data=b'abc'))['data'] == b'abc'


def test_long_parts_are_the_same_in_pieces():
    """In JSON, in CBOR, and back: bytes, numbers and messages, some of them not finite."""
    number = itertools.cycle([0.25, -1e300, math.nan])
    message = Marker(points=[Point(x=next(number), z=1.0) for _ in range(5000)],
                     mesh_file=MeshFile(data=bytes(range(256)) * 10_000))
    assert json.loads(to_json(values_of(message)))['mesh_file']['data'] == b64encode(
        message.mesh_file.data).decode()
    points = json.loads(to_json(values_of(message)))['points']
    assert cbor_of(message)['mesh_file']['data'] == bytes(message.mesh_file.data)
    assert [point['x'] for point in cbor_of(message)['points']] == pytest.approx(
        [point.x for point in message.points], nan_ok=True)
    found = filled(Marker, {'points': points}).points
    assert [point.x for point in found] == pytest.approx(
        [point.x for point in message.points], nan_ok=True)
    states = JointState(name=['a'] * 3000, position=np.arange(3000.0), velocity=[math.inf] * 3000)
    values = json.loads(to_json(values_of(states)))
    assert values['position'] == list(range(3000))
    assert (values['name'], values['velocity']) == (['a'] * 3000, [None] * 3000)
    assert np.frombuffer(cbor_of(states)['position'].value).tolist() == list(range(3000))


def test_bytes_of_a_machine_with_another_order_are_read():
    """The head says which order it is."""
    assert json_values(Int64)(b'\0\0\0\0' + (5).to_bytes(8, 'big')) == {'data': 5}


class Wide:
    """A class with a text of UTF-16, as the generator of ROS makes it; no package here has any."""

    SLOT_TYPES = (BasicType('uint8'), UnboundedWString(), BasicType('uint8'))

    def __init__(self):
        self._text = ''

    @classmethod
    def get_fields_and_field_types(cls):
        """Return the fields."""
        return {'before': 'uint8', 'text': 'wstring', 'after': 'uint8'}


def test_a_wstring_has_four_bytes_for_each_unit(monkeypatch):
    """As rosidl_typesupport_fastrtps_c (cdr_serialize of U16String) has it."""
    monkeypatch.setattr(incoming, 'values_of', lambda _: {'before': 0, 'text': '', 'after': 0})
    values = {'before': 1, 'text': 'aé\U0001f600', 'after': 2}
    raw = serialized(Wide, values, now)
    assert raw == (b'\0\1\0\0\1\0\0\0\4\0\0\0a\0\0\0\xe9\0\0\0\x3d\xd8\0\0\0\xde\0\0\2')
    assert json_values(Wide)(raw) == values


@given(strategies.lists(strategies.one_of(
    strategies.integers(-2**53, 2**53), strategies.floats(), strategies.none(),
    strategies.sampled_from(['NaN', 'Infinity', '-Infinity']))))
@settings(max_examples=50)
def test_floats_take_integers_null_and_words(numbers):
    """All that stands for a number in JSON becomes that number."""
    words = {None: math.nan, 'NaN': math.nan, 'Infinity': math.inf, '-Infinity': -math.inf}
    expected = [float(words.get(number, number)) if number is None or isinstance(number, str)
                else float(number) for number in numbers]
    found = filled(JointState, {'position': numbers}).position
    assert np.array_equal(found, expected, equal_nan=True)


@pytest.mark.parametrize(('cls', 'values', 'text'), [
    (JointTrajectory, {'points': [{}, {}, {'positions': ['a']}]},
     'points[2].positions[0]: expected a number, got "a"; JointTrajectoryPoint has positions'),
    (JointTrajectory, {'joint_name': []},
     "joint_name: no such field; did you mean 'joint_names'?; JointTrajectory has header"),
    (JointTrajectory, {'points': {}}, 'points: expected a list, got an object'),
    (JointTrajectory, [1, 2, 3, 4], '4 values, but JointTrajectory has'),
    (JointTrajectory, 'x', 'expected an object, got "x"'),
    (Image, {'height': -1}, 'height: expected 0 to 4294967295 (uint32), got -1'),
    (Image, {'height': 1.5}, 'height: expected an integer, got 1.5'),
    (Image, {'height': True}, 'height: expected an integer, got true'),
    (Image, {'height': 10**400}, 'got a number of 1329 bits'),
    (Image, {'data': '?'}, 'data: expected base64 or a list of numbers'),
    (Image, {'data': [1, 256]}, 'data[1]: expected 0 to 255 (uint8), got 256'),
    (Image, {'data': [True]}, 'data[0]: expected an integer, got true'),
    (Image, {'encoding': '\ud800'}, 'encoding: half of a surrogate pair'),
    (CameraInfo, {'k': [1, 2]}, 'k: expected 9 values, got 2'),
    (Float32, {'data': 1e39}, 'data: too large for float'),
    (Float32, {'data': 10**400}, 'data: too large for float'),
    (SolidPrimitive, {'dimensions': [1, 2, 3, 4]}, 'dimensions: expected at most 3 values, got 4'),
])
def test_what_does_not_fit_is_refused_with_its_path(cls, values, text):
    """The text names the path, what was expected, and the fields there are."""
    with pytest.raises(ConversionError) as refusal:
        filled(cls, values)
    assert text in str(refusal.value)


def test_bytes_are_base64_or_a_list():
    """Both give the same message."""
    for data in ('AQI=', [1, 2]):
        assert filled(UInt8MultiArray, {'data': data}).data.tolist() == [1, 2]


@pytest.mark.parametrize('encode', [b64encode, encodebytes])
def test_base64_may_have_lines(encode):
    """As MIME prescribes and Android writes it; rosbridge_suite ignores them, too."""
    content = bytes(range(200))
    assert filled(UInt8MultiArray, {'data': encode(content).decode()}).data.tobytes() == content


def test_a_header_without_a_stamp_gets_the_time_and_others_keep_theirs():
    """No header: zero, so that trajectories start at once; ``seq`` of ROS 1 is ignored."""
    stamps = [
        ({}, (0, 0)), ({'header': {}}, (12, 34)), ({'header': {'seq': 1}}, (12, 34)),
        ({'header': {'stamp': None, 'frame_id': None}}, (12, 34)),
        ({'header': {'stamp': 'now'}}, (12, 34)),
        ({'header': {'stamp': {'sec': 0}}}, (0, 0)),
        ({'header': {'stamp': {'secs': 5, 'nsecs': 6}}}, (5, 6))]
    for values, expected in stamps:
        stamp = filled(PoseStamped, values).header.stamp
        assert (stamp.sec, stamp.nanosec) == expected, values
    assert filled(Header, {'stamp': {'sec': 1, 'nanosec': 2}}).stamp.nanosec == 2


def test_a_png_holds_the_text():
    """Its RGB bytes are the text, padded with newlines."""
    text = '{"op":"publish","msg":"ä"}' * 100
    data = b64decode(to_png(text))
    assert data.startswith(b'\x89PNG\r\n\x1a\n')
    width, height = (int.from_bytes(data[at:at + 4], 'big') for at in (16, 20))
    start = data.index(b'IDAT') + 4
    size = int.from_bytes(data[start - 8:start - 4], 'big')
    lines = zlib.decompress(data[start:start + size])
    stride = 1 + 3 * width
    rows = [lines[at + 1:at + stride] for at in range(0, len(lines), stride)]
    assert len(rows) == height
    assert b''.join(rows).decode().rstrip('\n') == text
