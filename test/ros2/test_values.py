# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Messages from YAML and back, as rosidl_runtime_py's set_message.py and convert.py."""

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovariance
import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import Byte, Float32MultiArray, UInt8MultiArray
from trajectory_msgs.msg import JointTrajectory

from armsim_ros2.errors import CliError
from armsim_ros2.values import field_of, fill, parse, predicate, Style, to_csv, to_plain, to_yaml


def test_nested_values_are_set():
    """Numbers are converted to the type of the field; nested messages and arrays are filled."""
    message = JointTrajectory()
    fill(message, parse('{header: {frame_id: base}, joint_names: [a, b], points: '
                        '[{positions: [1, 2.5], time_from_start: {sec: 3}}]}'))
    assert message.header.frame_id == 'base'
    assert message.joint_names == ['a', 'b']
    assert message.points[0].positions.tolist() == [1.0, 2.5]
    assert message.points[0].time_from_start.sec == 3


def test_fixed_arrays_and_bytes_are_set():
    """A numpy field takes a list of its length, a byte its number."""
    message = PoseWithCovariance()
    fill(message, {'covariance': [1] * 36})
    assert message.covariance.tolist() == [1.0] * 36
    status = DiagnosticStatus()
    fill(status, {'level': 2, 'values': [{'key': 'k', 'value': 'v'}]})
    assert (status.level, status.values[0].key) == (b'\x02', 'k')


def test_stamps_are_set_at_publication():
    """header: auto and stamp: now become setters, in nested messages and arrays, too."""
    message = PoseStamped()
    setters = fill(message, {'header': 'auto'}, stamps=True)
    for set_stamp in setters:
        set_stamp(Time(sec=7))
    assert message.header.stamp.sec == 7
    setters = fill(message, {'header': {'stamp': 'now', 'frame_id': 'x'}}, stamps=True)
    for set_stamp in setters:
        set_stamp(Time(sec=8))
    assert (message.header.stamp.sec, message.header.frame_id) == (8, 'x')


@pytest.mark.parametrize(('values', 'text'), [
    ({'nme': ['a']}, "'JointState' object has no attribute 'nme'; did you mean 'name'?"),
    ({'header': {'frame': 'a'}}, "has no attribute 'header.frame'"),
    ({'header': 3}, "Value '3' of header is expected to be a dictionary but is a int"),
    ({'name': 'a'}, "'name' cannot be 'a': a list is expected"),
    ({'position': ['x']}, "'position' cannot be ['x']"),
    ({'header': {'stamp': {'sec': 'x'}}}, "'header.stamp.sec' cannot be 'x'"),
    ({'header': {'stamp': {'sec': 1 << 40}}}, "'header.stamp.sec' cannot be"),
])
def test_what_does_not_fit_is_refused(values, text):
    """The message begins with upstream's words and names the field."""
    with pytest.raises(CliError, match=r'^Failed to populate field: ') as caught:
        fill(JointState(), values)
    assert text in str(caught.value)
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize('text', ['[1, 2]', 'data', '{a: ['])
def test_only_dictionaries_are_values(text):
    """Upstream's sentence, and one line for errors of YAML."""
    with pytest.raises(CliError, match='needs to be a dictionary in YAML format') as caught:
        parse(text)
    assert '\n' not in str(caught.value)


def test_yaml_keeps_the_order_of_the_fields():
    """The text that ros2 topic echo prints."""
    message = JointState(name=['a'], position=[1.0, 2.0])
    assert to_yaml(message) == (
        "header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: ''\nname:\n- a\n"
        'position:\n- 1.0\n- 2.0\nvelocity: []\neffort: []\n')
    assert to_yaml(message, flow=True).endswith(
        "  frame_id: ''\nname: [a]\nposition: [1.0, 2.0]\nvelocity: []\neffort: []\n")


def test_what_is_long_is_cut():
    """Arrays and texts end in dots after the limit (message_to_ordereddict)."""
    message = JointState(name=['abcdef', 'b', 'c'], position=[1.0, 2.0, 3.0])
    plain = to_plain(message, Style(most=2))
    assert plain['name'] == ['ab...', 'b', '...']
    assert plain['position'] == [1.0, 2.0, '...']
    assert to_plain(PoseWithCovariance(), Style(most=1))['covariance'] == [0.0, '...']


def test_arrays_and_texts_can_be_replaced():
    """--no-arr shows type and length, --no-str the length."""
    plain = to_plain(JointState(name=['a'], position=[1.0]), Style(no_arr=True, no_str=True))
    assert plain['name'] == '<sequence type: string, length: 1>'
    assert plain['position'] == '<sequence type: double, length: 1>'
    assert plain['header']['frame_id'] == '<string length: <0>>'
    no_arrays = Style(no_arr=True)
    assert to_plain(PoseWithCovariance(), no_arrays)['covariance'] == '<array type: double[36]>'
    trajectory = to_plain(JointTrajectory(), no_arrays)
    assert trajectory['points'] == (
        '<sequence type: trajectory_msgs/msg/JointTrajectoryPoint, length: 0>')


def test_csv_is_one_line():
    """The values in the order of the fields (message_to_csv)."""
    message = JointState(name=['a', 'b'], position=[1.0, 2.0])
    assert to_csv(message) == '0,0,,a,b,1.0,2.0,,'
    assert to_csv(message, Style(most=1)) == '0,0,,a,...,1.0,...,,'
    assert to_csv(message, Style(no_arr=True)).startswith(
        '0,0,,<sequence type: string, length: 2>,')


def test_bytes_and_small_numbers_are_scalars():
    """A byte is a character, an array of bytes a list of numbers."""
    assert to_plain(Byte(data=b'a')) == {'data': 'a'}
    assert to_plain(UInt8MultiArray(data=b'\x01\x02'))['data'] == [1, 2]
    assert to_plain(Float32MultiArray(data=[0.5]))['data'] == [0.5]


def test_a_field_is_read_by_its_path():
    """Names and indices; a wrong name is reported with the nearest."""
    message = JointState(name=['a', 'b'])
    assert field_of('name[1]')(message) == 'b'
    assert field_of('header.stamp.sec')(message) == 0
    with pytest.raises(CliError, match=r"Invalid field 'header.frame'.*did you mean 'frame_id'"):
        field_of('header.frame')(message)
    with pytest.raises(CliError, match=r"Invalid field 'name\[5\]'"):
        field_of('name[5]')(message)
    for text in ('', '.', 'a[', 'a b'):
        with pytest.raises(CliError, match='Invalid field value'):
            field_of(text)


def test_a_filter_is_a_python_expression():
    """It uses m; mistakes are reported in one line."""
    assert predicate('m.header.stamp.sec == 0')(JointState())
    with pytest.raises(CliError, match='Invalid filter'):
        predicate('m.')
    with pytest.raises(CliError, match=r"Invalid filter 'm.x'.*no attribute"):
        predicate('m.x')(JointState())
