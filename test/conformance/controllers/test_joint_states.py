# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The joint state broadcaster, under the names of ROS 2 and of ROS 1."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
import math
from typing import Any

from control_msgs.msg import DynamicJointState
from controller_bench import Bench, nanoseconds, PERIOD, TrajectoryController
import pytest
from sensor_msgs.msg import JointState

from armsim_ros.clients.client_node import Collector
from armsim_ros.clients.controller_manager import ParameterClient

statement = pytest.mark.statement
upstream = pytest.mark.upstream
KIND = 'joint_state_broadcaster/JointStateBroadcaster'
KIND_OF_ROS_1 = 'joint_state_controller/JointStateController'
#: What the trajectory controllers of the fixture have and a broadcaster has not.
NONE = {'joints': None, 'command_interfaces': None, 'state_interfaces': None}
JOINTS = ['axis_1', 'axis_2', 'drive_1', 'drive_2', 'finger', 'twin', 'wheel_1', 'wheel_2']
Collect = Callable[..., Collector]


@pytest.fixture
def collect(bench: Bench) -> Iterator[Collect]:
    """Give a function that subscribes for the time of the test."""
    opened: list[Collector] = []

    def subscribe(topic: str, kind: type = JointState) -> Collector:
        opened.append(bench.client.collect(bench.name(topic), kind, 100))
        return opened[-1]

    yield subscribe
    for collector in opened:
        collector.close()


def steps(messages: list[Any]) -> set[int]:
    """Return the times between the stamps [ns]."""
    stamps = [nanoseconds(message.header.stamp) for message in messages]
    return {b - a for a, b in pairwise(stamps)}


@statement('M1', 'M3', 'M4', 'C18')
@upstream('JointStatePublishTest', 'ActivateEmptyTest',
          'ActivateTestWithoutJointsParameterWithRobotDescription')
def test_all_joints_in_all_arrays(bench: Bench, collect: Collect) -> None:
    """joint_states: each movable joint of the URDF once, by name, an entry of it in each array."""
    message = collect('joint_states').wait(1)[0]
    assert list(message.name) == JOINTS
    assert len(message.position) == len(message.velocity) == len(message.effort) == len(JOINTS)
    assert message.header.frame_id == 'base_link'


@statement('M1', 'M2')
@upstream('DynamicJointStatePublishTest')
def test_dynamic_joint_states(bench: Bench, collect: Collect) -> None:
    """dynamic_joint_states names each joint's interfaces and their values."""
    message = collect('dynamic_joint_states', DynamicJointState).wait(1)[0]
    assert sorted(message.joint_names) == JOINTS
    for values in message.interface_values:
        assert {'position', 'velocity'} <= set(values.interface_names)
        assert len(values.interface_names) == len(values.values)


@statement('M1', 'M2', 'M3', 'M4', 'C18')
@upstream('JointStatePublishTestLocalTopic', 'ExtraJointStatePublishTest',
          'ActivateDeactivateTestTwoJointsOneInterface')
def test_a_choice_of_joints_and_interfaces(bench: Bench, collect: Collect) -> None:
    """
    Local topics, joints in the order of the parameter, extra ones last, NaN for the rest.

    An extra joint that is there already is skipped, in both topics (init_joint_data).
    """
    bench.activate('chosen_broadcaster')
    dynamic = collect('chosen_broadcaster/dynamic_joint_states', DynamicJointState).wait(1)[0]
    assert sorted(dynamic.joint_names) == ['axis_1', 'axis_2', 'ghost']
    message = collect('chosen_broadcaster/joint_states').wait(1)[0]
    assert list(message.name) == ['axis_2', 'axis_1', 'ghost']
    assert all(math.isfinite(value) for value in message.position)
    assert math.isnan(message.velocity[0])
    assert math.isnan(message.effort[0])
    assert message.position[2] == 0.0
    assert message.header.frame_id == 'bench'


@statement('M2', 'C18')
@upstream('TestCustomInterfaceMapping')
def test_a_map_of_interfaces(bench: Bench, collect: Collect) -> None:
    """map_interface_to_joint_state publishes velocity as effort; dynamic states can be off."""
    bench.activate('mapped_broadcaster')
    message = collect('mapped_broadcaster/joint_states').wait(1)[0]
    assert all(math.isnan(value) for value in message.velocity)
    assert all(math.isfinite(value) for value in message.effort)
    topics = dict(bench.client.node.get_topic_names_and_types())
    assert bench.name('mapped_broadcaster/dynamic_joint_states') not in topics


@statement('M2')
@pytest.mark.parametrize(
    ('name', 'default'),
    [('use_local_topics', False), ('use_urdf_to_filter', True), ('frame_id', 'base_link'),
     ('publish_dynamic_joint_states', True), ('joints', []), ('interfaces', []),
     ('extra_joints', []), ('map_interface_to_joint_state.position', 'position')],
)
def test_defaults(bench: Bench, name: str, default: Any) -> None:
    """The parameters have Jazzy's defaults and are fixed."""
    parameters = ParameterClient(bench.client, bench.name('joint_state_broadcaster'))
    assert (parameters.get(name) or default) == default
    assert parameters.describe(name).read_only


@statement('M5')
@upstream('ActivateTestTwoJointTwoInterfacesAllMissing',
          'ActivateTestTwoJointTwoInterfacesOneMissing')
@pytest.mark.parametrize(
    'choice',
    [{'joints': ['axis_1'], 'interfaces': ['temperature']},
     {'joints': ['nobody'], 'interfaces': ['position'], 'use_urdf_to_filter': False}],
    ids=['interface', 'joint'],
)
def test_what_is_missing_fails_activation(
    bench: Bench, load: Callable[..., bool], choice: dict[str, Any]
) -> None:
    """An interface that is asked for and missing: it never becomes active."""
    ok = load('seeker', KIND, **{**NONE, **choice}) and bench.manager.configure('seeker')
    assert not (ok and bench.manager.switch(activate=['seeker']).ok)


@statement('M6', 'M7', 'A16', 'U3')
@pytest.mark.parametrize('kind', [KIND, KIND_OF_ROS_1])
def test_a_publish_rate(
    bench: Bench, load: Callable[..., bool], collect: Collect, kind: str
) -> None:
    """publish_rate 50 spaces the messages by 20 ms of simulated time, under either name."""
    name = 'rated_ros_1' if kind == KIND_OF_ROS_1 else 'rated'
    assert load(name, kind, **NONE, publish_rate=50, use_local_topics=True)
    assert bench.manager.configure(name)
    bench.activate(name)
    # A message may be lost on a busy machine: then the step is a multiple.
    found = steps(collect(f'{name}/joint_states').wait(12)[2:])
    assert min(found) == 20_000_000
    assert all(step % 20_000_000 == 0 for step in found)
    bench.activate()


@statement('A15', 'M2')
def test_every_update_publishes_by_default(bench: Bench, collect: Collect) -> None:
    """Without a publish_rate each update of the controller publishes."""
    found = steps(collect('joint_states').wait(30)[5:])
    assert min(found) == round(PERIOD * 1e9)


@statement('M6')
def test_extra_joints_of_ros_1(
    bench: Bench, load: Callable[..., bool], collect: Collect
) -> None:
    """extra_joints as blocks of name, position, velocity, effort."""
    extra = [{'name': 'ghost', 'position': 0.1, 'velocity': 0.2, 'effort': 0.3}]
    assert load(
        'haunted', KIND_OF_ROS_1, **NONE, publish_rate=50, extra_joints=extra,
        use_local_topics=True,
    )
    assert bench.manager.configure('haunted')
    bench.activate('haunted')
    message = collect('haunted/joint_states').wait(1)[0]
    ghost = list(message.name).index('ghost')
    assert (message.position[ghost], message.velocity[ghost], message.effort[ghost]) == (
        0.1, 0.2, 0.3
    )
    bench.activate()


@statement('G7', 'M4')
def test_mimic_joints_are_published(bench: Bench, collect: Collect) -> None:
    """A joint that follows another appears, at multiplier * position + offset."""
    bench.activate()
    message = collect('joint_states').wait(3)[-1]
    position = dict(zip(message.name, message.position, strict=True))
    assert position['twin'] == pytest.approx(2.0 * position['finger'] + 0.01, abs=2e-3)


@statement('O5')
def test_positions_are_not_wrapped(bench: Bench, collect: Collect) -> None:
    """A continuous joint that turns on is published beyond pi, without a jump."""
    wheels: TrajectoryController = bench.use('wheels', home=False)
    start = wheels.newest().reference.positions
    topic = collect('joint_states')
    # At the start of a trajectory the short way is taken: two halves.
    wheels.go([start[0] + 2.0, start[1]], 0.3)
    wheels.go([start[0] + 4.0, start[1]], 0.3)

    def turned(message: JointState) -> float:
        return dict(zip(message.name, message.position, strict=True))['wheel_1'] - start[0]

    topic.wait_for(lambda m: abs(turned(m) - 4.0) < 0.05)
    ways = [turned(message) for message in topic.messages]
    assert max(abs(b - a) for a, b in pairwise(ways)) < 1.5
