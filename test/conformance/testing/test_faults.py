# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Faults on purpose: joints, controllers, messages, services and clocks that fail."""

import time

import pytest
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from simulation_interfaces.srv import GetSimulatorFeatures

from armsim_ros.errors import ControllerError
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.testing import assert_rejected, ClockRelay, ServiceRelay, TopicRelay

CONTROLLER = 'arm_joint_controller'
AT_HOME = [(0.5, [0.0] * 6)]


@pytest.mark.armsim(faults={'joint_2': {'bias': 0.0}})
def test_a_joint_fails_from_a_moment_on(arm):
    """A joint can be blocked in the middle of a test, and be well again."""
    arm.follow([(0.5, [0.1] * 6)])
    arm.fault('joint_1', blocked=True)
    arm.follow([(0.5, [0.2] * 6)])
    assert arm.distance({'joint_1': 0.1})[1] == pytest.approx(0.0, abs=1e-3)
    arm.fault('joint_1')
    arm.follow([(0.5, [0.3] * 6)])
    assert arm.distance({'joint_1': 0.3})[1] == pytest.approx(0.0, abs=1e-3)


def test_an_arm_without_faults_says_how_to_get_them(arm):
    """Joints of an arm that was built without fault injection do not fail; the marker is named."""
    with pytest.raises(ControllerError, match=r'armsim\(faults='):
        arm.fault('joint_1', blocked=True)


def test_a_controller_refuses_in_process(arm):
    """Within the context a goal is refused, after it one is run."""
    with arm.refusing(CONTROLLER):
        assert_rejected(arm, AT_HOME)
    arm.follow(AT_HOME)
    with pytest.raises(ControllerError, match=r"no controller 'arm'.*arm_joint_controller"), \
            arm.refusing('arm'):
        pass


@pytest.mark.armsim(mode='process', faults={'joint_2': {'bias': 0.0}})
def test_joints_and_controllers_of_programs_fail(arm):
    """The same in mode process."""
    with arm.refusing(CONTROLLER):
        assert_rejected(arm, AT_HOME)
    arm.follow(AT_HOME)
    arm.fault('joint_1', bias=0.05)
    arm.follow([(0.5, [0.1] * 6)])
    assert arm.distance({'joint_1': 0.15})[1] == pytest.approx(0.0, abs=2e-3)
    arm.fault('joint_1')


@pytest.mark.armsim(mode='process', faults={'joint_2': {'bias': 0.0}})
def test_messages_are_dropped(arm, armsim_node):
    """A relay passes on what it does not drop, in order."""
    relay = TopicRelay(armsim_node, '/sunday/joint_states', '/lossy/joint_states', JointState,
                       drops=lambda number, _: number % 3 != 0)
    seen = armsim_node.collect('/lossy/joint_states', JointState).wait(10, 30.0)
    stamps = [ns_from_time(message.header.stamp) for message in seen]
    assert stamps == sorted(stamps)
    assert relay.dropped >= 2 * (relay.passed - 1) >= 18
    assert arm.name == 'sunday'


@pytest.mark.armsim(mode='process', faults={'joint_2': {'bias': 0.0}})
def test_a_clock_jumps(arm, armsim_node):
    """A relayed clock runs as the simulation's, and jumps when it is told to."""
    relay = ClockRelay(armsim_node)
    clock = armsim_node.collect('/jumping_clock', Clock)
    first = ns_from_time(clock.wait(1, 30.0)[-1].clock)
    relay.jump(-3600.0)
    clock.clear()
    back = clock.wait_for(lambda message: ns_from_time(message.clock) < first, 30.0)
    assert first - ns_from_time(back.clock) > 3000 * 10**9
    relay.jump(7200.0)
    clock.wait_for(lambda message: ns_from_time(message.clock) > first + 3000 * 10**9, 30.0)
    assert arm.name == 'sunday'


@pytest.mark.armsim(mode='process', faults={'joint_2': {'bias': 0.0}})
def test_a_service_is_late(arm, armsim_node):
    """A relayed service gives the stack's answer, not before its delay is over."""
    features = '/get_simulator_features', '/late/features', GetSimulatorFeatures
    call = arm.robot.client.call
    with ServiceRelay(armsim_node, *features, delay=1.0) as relay:
        direct = call(features[0], GetSimulatorFeatures, timeout=30.0)
        begun = time.monotonic()
        late = call(features[1], GetSimulatorFeatures, timeout=30.0)
        assert time.monotonic() - begun >= relay.delay
    assert late == direct
