# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Commands kept within limits, where enforce_command_limits is true.

The behaviour is that of joint_limits: joint_limits_helpers.cpp (compute_position_limits,
compute_velocity_limits, compute_effort_limits) and joint_soft_limiter.cpp.
"""

from dataclasses import replace
import math

import numpy as np
import pytest

from armsim_ros.control.manager.command_limits import CommandLimits
from armsim_ros.model.robot_model import (
    HardwareJoint,
    HardwareSystem,
    JointLimits,
    JointType,
    SoftLimits,
)

BROADCASTER = 'joint_state_broadcaster/JointStateBroadcaster'
FORWARD = 'forward_command_controller/ForwardCommandController'
PERIOD = 0.01


@pytest.fixture(name='limited')
def _limited(rig, robot):
    """Return a function that makes limited hardware: one joint of 1 rad, 2 rad/s, 5 N*m."""
    def make(soft=None, joint=None):
        hardware = rig().hardware
        model = robot({'a': JointType.REVOLUTE})
        own = JointLimits(-1.0, 1.0, velocity=2.0, effort=5.0)
        joints = {'a': replace(model.joints['a'], limits=own, soft_limits=soft)}
        systems = (HardwareSystem('h', 'system', 'p', (joint,)),) if joint is not None else ()
        return hardware, CommandLimits(hardware, replace(
            model, joints=joints, hardware=systems))
    return make


def enforced(hardware, limits, **commands):
    """Return what is left of the commands of joint a; the other joint has none."""
    for kind, value in commands.items():
        hardware.command.of(kind)[0] = value
    limits.enforce(PERIOD)
    return tuple(hardware.command.of(kind)[0] for kind in commands)


def place(hardware, position, velocity=0.0):
    """Put the joint somewhere."""
    hardware.state.position[0], hardware.state.velocity[0] = position, velocity


def test_a_position_moves_as_far_as_the_velocity_allows(limited):
    """A step is bounded by velocity x period, from the last command or what is measured."""
    hardware, limits = limited()
    place(hardware, 0.5)
    assert enforced(hardware, limits, position=9.0) == (pytest.approx(0.52),)
    assert enforced(hardware, limits, position=9.0) == (pytest.approx(0.54),)
    assert enforced(hardware, limits, position=0.53) == (pytest.approx(0.53),)
    for _ in range(50):
        enforced(hardware, limits, position=9.0)
    assert hardware.command.position[0] == 1.0
    assert np.isnan(hardware.command.position[1])


def test_what_comes_with_a_limited_command_is_dropped(limited):
    """A velocity that was to come with a position does not fit where that is limited."""
    hardware, limits = limited()
    hardware.feedforward.velocity[0] = 7.0
    enforced(hardware, limits, position=0.01)
    assert hardware.feedforward.velocity[0] == 7.0
    enforced(hardware, limits, position=0.5)
    assert np.isnan(hardware.feedforward.velocity[0])


def test_an_acceleration_limit_of_the_hardware(limited):
    """With an acceleration limit, the step grows with the measured velocity."""
    joint = HardwareJoint('a', bounds={'acceleration': (-10.0, 10.0)})
    hardware, limits = limited(joint=joint)
    assert enforced(hardware, limits, position=1.0) == (pytest.approx(0.1 * PERIOD),)
    assert enforced(hardware, limits, acceleration=30.0) == (10.0,)
    assert enforced(hardware, limits, velocity=1.0) == (pytest.approx(0.1),)


@pytest.mark.parametrize(('position', 'wanted', 'expected'), [
    (0.0, 3.0, 2.0), (0.0, -3.0, -2.0), (0.99, 2.0, 1.0), (-0.99, -2.0, -1.0),
    (1.001, 1.0, 0.0), (1.001, -1.0, -1.0), (1.1, -1.0, 0.0), (-1.1, 1.0, 0.0)])
def test_velocities(limited, position, wanted, expected):
    """A velocity ends at the position limits; far outside of them nothing moves."""
    hardware, limits = limited()
    place(hardware, position)
    assert enforced(hardware, limits, velocity=wanted) == (pytest.approx(expected),)


@pytest.mark.parametrize(('position', 'velocity', 'wanted', 'expected'), [
    (0.0, 0.0, 9.0, 5.0), (0.0, 0.0, -9.0, -5.0), (1.0, 0.0, 3.0, 0.0), (1.0, 0.0, -3.0, -3.0),
    (-1.0, 0.0, -3.0, 0.0), (0.0, 2.5, 3.0, 0.0), (0.0, -2.5, -3.0, 0.0)])
def test_efforts(limited, position, velocity, wanted, expected):
    """No effort pushes a joint beyond its position or velocity limits."""
    hardware, limits = limited()
    place(hardware, position, velocity)
    assert enforced(hardware, limits, effort=wanted) == (expected,)


def test_soft_limits_slow_down(limited):
    """Near a soft limit the velocity is k_position x distance; beyond it the joint creeps back."""
    hardware, limits = limited(soft=SoftLimits(-0.8, 0.8, 10.0, 4.0))
    place(hardware, 0.75)
    assert enforced(hardware, limits, velocity=2.0) == (pytest.approx(0.5),)
    assert enforced(hardware, limits, velocity=-2.0) == (-2.0,)
    place(hardware, 0.9)
    assert enforced(hardware, limits, velocity=2.0) == (pytest.approx(-math.radians(1.0)),)


def test_soft_limits_of_positions(limited):
    """A position command stays within the soft limits."""
    hardware, limits = limited(soft=SoftLimits(-0.8, 0.8, 100.0, 4.0))
    for _ in range(100):
        enforced(hardware, limits, position=0.95)
    assert hardware.command.position[0] == pytest.approx(0.8, abs=1e-6)


def test_soft_limits_of_efforts(limited):
    """An effort is k_velocity x distance to the velocity that is left."""
    hardware, limits = limited(soft=SoftLimits(-0.8, 0.8, 10.0, 4.0))
    place(hardware, 0.75)
    assert enforced(hardware, limits, effort=5.0) == (pytest.approx(2.0),)


@pytest.mark.parametrize(('soft', 'kind', 'command', 'expected'), [
    (SoftLimits(0.0, 0.0, 0.0, 4.0), 'position', 0.51, 0.51),
    (SoftLimits(0.0, 0.0, 100.0, 4.0), 'velocity', 1.0, 1.0),
    (SoftLimits(-0.8, 0.8, 0.0, 4.0), 'velocity', 1.0, 1.0),
])
def test_soft_limits_that_are_not_there(limited, soft, kind, command, expected):
    """
    Bounds that leave no range and a gain of 0 limit nothing.

    Upstream: joint_soft_limiter.hpp, has_soft_position_limits and has_soft_limits.
    """
    hardware, limits = limited(soft=soft)
    place(hardware, 0.5)
    assert enforced(hardware, limits, **{kind: command}) == (pytest.approx(expected),)


@pytest.mark.parametrize(('joint', 'position'), [
    (None, 0.95), (HardwareJoint('a', bounds={'position': (-0.8, 0.8)}), 0.75)])
def test_soft_bounds_end_at_the_hard_ones(limited, joint, position):
    """
    A soft bound beyond the limit of the joint is that limit.

    Upstream: component_parser.cpp, parse_control_resources_from_urdf.
    """
    hardware, limits = limited(soft=SoftLimits(-5.0, 5.0, 10.0, 4.0), joint=joint)
    place(hardware, position)
    assert enforced(hardware, limits, velocity=2.0) == (pytest.approx(0.5),)


@pytest.mark.parametrize(('soft', 'expected'), [
    (None, 0.2), (SoftLimits(-0.8, 0.8, 10.0, 4.0), 0.1)])
@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_a_soft_joint_is_not_commanded_far_ahead_of_its_motion(limited, soft, expected, sign):
    """
    The velocity of a joint with soft limits stays as near to the measured as it can change.

    Upstream: joint_soft_limiter.cpp, JointSoftLimiter::on_enforce.
    """
    joint = HardwareJoint('a', bounds={'acceleration': (-10.0, 10.0)})
    hardware, limits = limited(soft=soft, joint=joint)
    enforced(hardware, limits, velocity=sign)
    assert enforced(hardware, limits, velocity=sign) == (pytest.approx(sign * expected),)


def test_limits_that_are_switched_off(limited):
    """<limits enable="false"/> of the hardware leaves commands as they are."""
    hardware, limits = limited(joint=HardwareJoint('a', limited=False))
    wanted = {'position': 50.0, 'velocity': 60.0, 'acceleration': 70.0, 'effort': 80.0}
    assert enforced(hardware, limits, **wanted) == tuple(wanted.values())


@pytest.mark.parametrize(('kind', 'bounds', 'expected'), [
    ('velocity', (-0.5, 1.5), 0.5), ('velocity', (-9.0, 9.0), 2.0), ('effort', (-3.0, 4.0), 3.0)])
def test_the_smaller_bound_of_the_hardware_counts(limited, kind, bounds, expected):
    """Of min and max of <ros2_control> the smaller amount bounds both directions."""
    hardware, limits = limited(joint=HardwareJoint('a', bounds={kind: bounds}))
    assert enforced(hardware, limits, **{kind: 9.0}) == (expected,)
    assert enforced(hardware, limits, **{kind: -9.0}) == (-expected,)


def test_a_goal_beyond_the_limits(rig, trajectory):
    """The joint goes as far as the URDF allows."""
    r = rig(enforce_command_limits=True, velocity=20.0)
    r.arm().send_goal(trajectory((1.0, [12.0, 0.0])))
    r.run(1.5)
    assert r.hardware.command.position[0] == 10.0


def test_a_limited_goal_is_reached(rig, trajectory):
    """A controller that holds still is updated until its limited command has arrived."""
    r = rig(enforce_command_limits=True, velocity=1.0)
    arm = r.arm()
    arm.send_goal(trajectory((0.1, [0.5, 0.0])))
    r.run(0.3)
    assert r.hardware.state.position[0] < 0.4
    assert r.manager.plan(10, r.now_ns, 0.01, moving=False) == 0
    r.run(0.4)
    assert r.hardware.state.position[0] == pytest.approx(0.5)


def test_a_reset_leaves_no_command_of_the_old_place(rig, trajectory):
    """After a reset of the plant the joints stay where it put them."""
    r = rig(enforce_command_limits=True, velocity=1.0)
    r.arm().send_goal(trajectory((3.0, [2.0, -2.0])))
    r.run(4.0)
    r.manager.interrupt(r.now_ns, 'reset')
    place(r.hardware, 0.0)
    r.hardware.state.position[1] = 0.0
    r.manager.resume(r.now_ns)
    r.step()
    np.testing.assert_array_equal(r.hardware.command.position, 0.0)


def test_a_switch_limits_from_the_measured_states(rig):
    """
    A switch of command interfaces forgets the last commands, that of a broadcaster does not.

    resource_manager.cpp, ResourceManager::perform_command_mode_switch.
    """
    r = rig(enforce_command_limits=True)
    stream = r.load('stream', FORWARD, joints=['a'], interface_name='position')
    r.load('other', FORWARD, joints=['b'], interface_name='position')
    r.load('states', BROADCASTER)
    assert r.manager.switch(['stream']).ok
    r.hardware.frozen = True
    stream.receive([9.0])
    r.step(2)
    assert r.manager.switch(['states']).ok
    r.step()
    assert r.hardware.command.position[0] == pytest.approx(0.09)
    place(r.hardware, 1.0)
    assert r.manager.switch(['other']).ok
    r.step()
    assert r.hardware.command.position[0] == pytest.approx(1.03)
