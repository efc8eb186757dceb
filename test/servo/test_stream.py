# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Streams of twists, jogs and poses: where they lead, how fast, and what stops them."""

import numpy as np
import pytest
from servo_streams import jog, Streamer, twist

from armsim_ros.config.kinematics import JointLimitOverrides, JointLimitsSettings
from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.loading import load_robot_model
from armsim_ros.model.transforms import matrix_from_axis_angle, pose_from_parts, rotation_angle
from armsim_ros.servo.commands import InvalidCommandError, JointJog, PoseTarget, ServoStatus

SPEED = {'command_in_type': 'speed_units'}
ACCELERATION = 'online_signal_smoothing::AccelerationLimitedPlugin'


@pytest.fixture(scope='module')
def unlimited():
    """Return the kinematics of a robot whose first joint has no velocity limit."""
    limits = JointLimitsSettings(
        joint_limits={'joint_1': JointLimitOverrides(has_velocity_limits=False)})
    return KinematicModel(
        planning_robot(load_robot_model(load_robot_settings('sunday')), limits))


def test_straight_line(streamer):
    """A twist leads straight, at its speed, without turning the tip."""
    made = streamer(**SPEED)
    start = made.tip
    made.run(twist((0.0, 0.0, -0.1)), 1.5)
    way = made.tip[:3, 3] - start[:3, 3]
    assert way[2] == pytest.approx(-0.15, rel=0.1)
    assert np.abs(way[:2]).max() < 1e-4
    assert rotation_angle(start, made.tip) < 1e-3
    assert made.codes() <= {ServoStatus.NO_WARNING}


def test_pure_rotation_keeps_the_tip(streamer):
    """Turning about the tip does not move it."""
    made = streamer(**SPEED)
    start = made.tip
    made.run(twist(angular=(0.0, 0.0, 0.4), frame='link_6'), 2.0)
    made.run(None, 0.5)
    assert rotation_angle(start, made.tip) > 0.5
    assert np.linalg.norm(made.tip[:3, 3] - start[:3, 3]) < 1e-4


def test_about_the_frame(streamer):
    """Where asked for, a twist turns about the origin of its frame."""
    made = streamer(
        apply_twist_commands_about_ee_frame=False, check_collisions=False, **SPEED
    )
    centre = made.kinematics.link_pose(made.q, 'link_5')[:3, 3]
    radius = np.linalg.norm(made.tip[:3, 3] - centre)
    made.add_box('pivot', (0.01, 0.01, 0.01), centre)
    made.run(twist(angular=(0.0, 0.3, 0.0), frame='pivot'), 1.0)
    assert np.linalg.norm(made.tip[:3, 3] - centre) == pytest.approx(radius, abs=1e-3)


def test_zero_twist_holds(streamer):
    """A minute of nothing moves nothing."""
    made = streamer()
    made.run(twist(), 60.0)
    np.testing.assert_array_equal(made.positions[-1], made.positions[0])


def test_steps_keep_the_limits(streamer):
    """Sudden full commands change velocities no faster than the acceleration limit."""
    made = streamer()
    random = np.random.default_rng(3)
    for _ in range(40):
        made.run(jog(**{f'joint_{i}': random.uniform(-1, 1) for i in range(1, 7)}), 0.2)
    made.run(None, 1.0)
    step, change = made.steps()
    assert step.max() <= 0.5 * 0.01 + 1e-9
    assert change.max() <= 5.0 * 0.01 * 0.01 + 1e-9
    assert made.cycles[-1].at_rest


def test_speed_of_a_joint_scales_all(streamer):
    """A twist that asks too much of a joint goes slower, in the same direction."""
    made = streamer(scale={'linear': 0.0, 'rotational': 0.0}, **SPEED)
    made.run(twist((0.0, 0.0, 2.0)), 0.15)
    assert made.steps()[0].max() <= 3.14 * 0.01 + 1e-9


@pytest.mark.parametrize(('size', 'units'), [
    (50.0, 'unitless'), (1e3, 'unitless'), (1e300, 'unitless'), (1e300, 'speed_units')])
def test_a_large_twist_leads_in_its_direction(streamer, size, units):
    """
    The limits of the joints make it slower, and that is no reason to name free directions.

    Upstream: utils/command.cpp, jointDeltaFromTwist; servo.cpp, getNextJointState.
    """
    made = streamer(command_in_type=units)
    start = made.tip
    made.run(twist((0.0, size, 0.0)), 0.3)
    way = made.tip[:3, 3] - start[:3, 3]
    assert way[1] > 0.03
    assert way[1] / np.linalg.norm(way) > 0.999
    assert rotation_angle(start, made.tip) < 1e-3
    assert not any(cycle.findings for cycle in made.cycles)


@pytest.mark.parametrize(('command', 'scale'), [
    (twist((1.7e308, 1.7e308, 0.0)), {'linear': 10.0}),
    (jog(joint_1=1e308), {'joint': 10.0}),
    (PoseTarget('base_link', pose_from_parts((1e308, 0.0, 0.0), np.eye(3))), {'linear': 0.0}),
], ids=['twist', 'jog', 'pose'])
def test_a_command_beyond_all_numbers_is_refused(streamer, command, scale):
    """What asks for joint velocities that are no numbers ends no program, and moves nothing."""
    made = streamer(scale=scale)
    with pytest.raises(InvalidCommandError, match='not finite'):
        made.run(command, 0.01)
    made.run(None, 0.1)
    np.testing.assert_array_equal(made.positions[-1], made.positions[0])


def test_override_of_the_velocity(streamer):
    """
    The factor multiplies what is commanded; it is not a share of the limits, which may be lower.

    Upstream: utils/common.cpp, jointLimitVelocityScalingFactor.
    """
    made = streamer(override_velocity_scaling_factor=0.05, check_collisions=False)
    made.run(jog(joint_1=1.0, joint_6=-0.5), 0.5)
    assert made.steps()[0][[0, 5]] == pytest.approx(0.05 * 0.5 * 0.01 * np.array([1.0, 0.5]))
    fast = streamer(override_velocity_scaling_factor=0.5, check_collisions=False, **SPEED)
    fast.run(jog(joint_6=100.0), 1.0)
    assert fast.steps()[0].max() == pytest.approx(3.14 * 0.01, rel=1e-3)
    off = streamer(override_velocity_scaling_factor=0.009, check_collisions=False)
    off.run(jog(joint_1=1.0), 0.5)
    assert off.steps()[0].max() == pytest.approx(0.5 * 0.01)


def test_scales_of_joints(streamer):
    """
    The scale of joints counts without units alone, and values beyond 1 are not cut.

    Upstream: utils/command.cpp, jointDeltaFromJointJog.
    """
    made = streamer(check_collisions=False)
    made.run(jog(joint_6=3.0), 1.0)
    assert made.steps()[0].max() == pytest.approx(3.0 * 0.5 * 0.01)
    units = streamer(check_collisions=False, scale={'joint': 0.1}, **SPEED)
    units.run(jog(joint_6=1.0), 1.0)
    assert units.steps()[0].max() == pytest.approx(0.01)


def test_scales_of_the_tip(streamer):
    """
    Twists without units are not cut; with units their norms are, by a scale above 0.

    Upstream: utils/command.cpp, jointDeltaFromTwist.
    """
    def speed(value, **parameters):
        made = streamer(check_collisions=False, **parameters)
        made.run(twist((0.0, 0.0, -value)), 0.4)
        before = made.tip[2, 3]
        made.run(twist((0.0, 0.0, -value)), 0.01)
        return (before - made.tip[2, 3]) / 0.01

    assert speed(2.0, scale={'linear': 0.05}) == pytest.approx(0.1, rel=0.02)
    assert speed(0.2, scale={'linear': 0.05}, **SPEED) == pytest.approx(0.05, rel=0.02)
    assert speed(2.0, scale={'linear': -0.05}) == pytest.approx(-0.1, rel=0.02)
    for unbounded in (0.0, -0.05):
        assert speed(0.1, scale={'linear': unbounded}, **SPEED) == pytest.approx(0.1, rel=0.02)


def test_jogs_without_names_and_with_one_twice(streamer):
    """
    The first is valid and holds; of the second the last value counts.

    Upstream: utils/command.cpp, jointDeltaFromJointJog.
    """
    made = streamer(check_collisions=False)
    made.run(jog(), 0.1)
    assert made.codes() <= {ServoStatus.NO_WARNING}
    np.testing.assert_array_equal(made.positions[-1], made.positions[0])
    made.run(JointJog(('joint_1', 'joint_1'), np.array([1.0, -1.0])), 0.3)
    assert made.positions[-1][0] < made.positions[0][0]


def test_parameters_change_while_it_moves(streamer):
    """
    A stream of other parameters goes on where the one before was, without a step.

    Upstream: servo.cpp, getNextJointState and updateParams.
    """
    made, other = streamer(check_collisions=False), streamer(
        check_collisions=False, scale={'joint': 0.2})
    made.run(jog(joint_1=1.0), 0.5)
    before = made.stream
    made.stream, made.parameters = other.stream, other.parameters
    made.stream.take_over(before)
    made.run(jog(joint_1=1.0), 0.5)
    assert made.steps()[1].max() <= 5.0 * 0.01 * 0.01 + 1e-9
    assert made.positions[-1][0] - made.positions[-2][0] == pytest.approx(0.2 * 0.01)


@pytest.mark.parametrize('period', [0.01, 0.034])
def test_the_arm_brakes_at_its_limit_behind_the_acceleration_filter(streamer, period):
    """
    After the last command it goes no farther than v^2 / 2a, whatever update_period is.

    Upstream: servo.cpp, smoothHalt; acceleration_filter.cpp, doSmoothing.
    """
    made = streamer(
        start=(-2.5, 0.3, 1.5, 0.5, 1.0, 0.0), check_collisions=False, publish_period=period,
        max_expected_latency=0.2, update_period=0.01, smoothing_filter_plugin_name=ACCELERATION,
        **SPEED)
    made.run(jog(joint_1=2.0), 1.0)
    released = made.positions[-1][0]
    made.run(None, 0.5)
    assert made.cycles[-1].at_rest
    assert made.positions[-1][0] - released <= 2.0**2 / (2.0 * 5.0)
    assert bool(made.warnings) == (period != 0.01)


def test_a_joint_without_a_velocity_limit_is_as_fast_as_commanded(unlimited):
    """
    No limit of its own is made up for it.

    Upstream: utils/common.cpp, jointLimitVelocityScalingFactor.
    """
    made = Streamer(unlimited, start=(-2.5, 0.3, 1.5, 0.5, 1.0, 0.0), check_collisions=False,
                    **SPEED)
    made.run(jog(joint_1=4.0), 1.0)
    assert made.steps()[0][0] == pytest.approx(4.0 * 0.01)


def test_jog_moves_only_what_it_names(streamer):
    """The other joints stay."""
    made = streamer()
    made.run(jog(joint_2=0.5, joint_6=-1.0), 1.0)
    moved = made.positions[-1] - made.positions[0]
    assert np.flatnonzero(np.abs(moved) > 1e-9).tolist() == [1, 5]


def test_joint_bound(streamer):
    """A joint stops before its margin, is named, and comes back at once."""
    made = streamer(start=(2.4, 0.4569, 0.4905, 0.9504, 1.57, 0.0))
    made.run(jog(joint_1=1.0), 2.0)
    finding = made.cycles[-1].findings[0]
    assert finding.code is ServoStatus.JOINT_BOUND
    assert "'joint_1'" in finding.message
    assert made.positions[-1][0] == pytest.approx(2.79 - 0.1, abs=0.01)
    assert np.max([p[0] for p in made.positions]) < 2.79 - 0.1 + 0.01
    made.run(jog(joint_1=-1.0), 0.3)
    assert made.positions[-1][0] < 2.62


@pytest.mark.parametrize('after', ['silence', 'turn'])
def test_a_slow_joint_brakes_before_its_bound_beside_a_fast_one(streamer, after):
    """What another joint still has to do leaves a joint no less able to stop in time."""
    made = streamer(start=(2.55, 0.4569, 0.4905, 0.9504, 1.57, 0.0), check_collisions=False,
                    scale={'joint': 3.0}, halt_all_joints_in_joint_mode=False)
    made.run(jog(joint_1=0.25, joint_6=-1.0), 0.35)
    made.run(None if after == 'silence' else jog(joint_1=0.25, joint_6=1.0), 1.0)
    assert np.max([p[0] for p in made.positions]) < 2.79 - 0.1 + 0.005
    assert made.steps()[1][0] <= 5.0 * 0.01 * 0.01 + 1e-9


@pytest.mark.parametrize('all_halt', [True, False])
def test_others_at_a_bound(streamer, all_halt):
    """A joint at its bound stops the others too, unless the parameter says no."""
    made = streamer(start=(2.7, 0.4569, 0.4905, 0.9504, 1.57, 0.0),
                    halt_all_joints_in_joint_mode=all_halt)
    made.run(jog(joint_1=1.0, joint_6=1.0), 0.5)
    moved = abs(made.positions[-1][5] - made.positions[0][5])
    assert (moved < 1e-3) == all_halt


def test_pose_is_reached_and_held(streamer):
    """The tip goes to a pose without going past it, and says that it is there."""
    made = streamer()
    start = made.tip
    goal = pose_from_parts(
        start[:3, 3] + (0.03, -0.04, 0.05),
        start[:3, :3] @ matrix_from_axis_angle((0.0, 0.0, 1.0), 0.4),
    )
    base = np.linalg.inv(made.kinematics.link_pose(made.q, 'base_link'))
    command = PoseTarget('base_link', base @ goal)
    way = goal[:3, 3] - start[:3, 3]
    farthest = 0.0
    for _ in range(400):
        made.run(command, 0.01)
        along = (made.tip[:3, 3] - start[:3, 3]) @ way / np.linalg.norm(way)
        farthest = max(farthest, along)
    assert farthest < np.linalg.norm(way) + 0.002
    assert np.linalg.norm(made.tip[:3, 3] - goal[:3, 3]) < 0.0015
    assert rotation_angle(made.tip, goal) < 0.011
    assert made.cycles[-1].findings[0].message == 'No warnings: pose reached'


def test_singularity(streamer):
    """An outstretched arm slows down, halts, and leaves the singularity on its own way."""
    made = streamer(start=(0.0, 0.5, 0.9, 0.9, 1.2, 0.0), check_collisions=False, **SPEED)
    made.run(twist((0.0, 0.0, 0.2)), 4.0)
    assert ServoStatus.DECELERATE_FOR_APPROACHING_SINGULARITY in made.codes()
    assert ServoStatus.HALT_FOR_SINGULARITY in made.codes() or made.cycles[-1].findings
    there = made.tip[2, 3]
    made.run(twist((0.0, 0.0, -0.2)), 2.0)
    assert made.tip[2, 3] < there - 0.05


def test_leaving_a_singularity(streamer):
    """
    Between the thresholds motion away is slowed down less than motion towards, and is reported.

    Upstream: test_utils.cpp, LeavingSingularityScaling.
    """
    made = streamer(start=(0.0, 0.5, 0.9, 0.9, 1.2, 0.0), check_collisions=False, **SPEED)
    while ServoStatus.DECELERATE_FOR_APPROACHING_SINGULARITY not in made.codes():
        made.run(twist((0.0, 0.0, 0.1)), 0.05)
    made.run(twist((0.0, 0.0, 0.1)), 0.1)
    made.cycles.clear()
    made.run(twist((0.0, 0.0, -0.1)), 0.02)
    assert made.codes() == {ServoStatus.DECELERATE_FOR_LEAVING_SINGULARITY}


def test_obstacle(streamer):
    """The arm comes to rest before a wall, names it, and goes away from it at full speed."""
    made = streamer(**SPEED)
    tip = made.tip[:3, 3]
    made.add_box('wall', (0.5, 0.02, 0.5), (tip[0], tip[1] + 0.17, tip[2]))
    made.run(twist((0.0, 0.2, 0.0), frame='world'), 3.0)
    finding = made.cycles[-1].findings[0]
    assert finding.code in (ServoStatus.HALT_FOR_COLLISION, ServoStatus.DECELERATE_FOR_COLLISION)
    assert "'wall'" in finding.message
    assert not any(made.checker.in_collision(
        made.kinematics.insert(made.q, 'manipulator', p)) for p in made.positions)
    assert made.tip[1, 3] > tip[1] + 0.03
    before = made.tip[1, 3]
    made.run(twist((0.0, -0.2, 0.0), frame='world'), 0.5)
    assert made.tip[1, 3] < before - 0.05


def test_random_jogs_among_boxes(streamer):
    """No jog among obstacles ends in a contact or past a limit."""
    made = streamer()
    random = np.random.default_rng(11)
    made.add_box('left', (0.1, 0.1, 0.4), (0.3, 0.3, 1.4))
    made.add_box('right', (0.1, 0.1, 0.4), (0.3, -0.4, 1.4))
    made.add_box('table', (1.5, 1.5, 0.03), (0.0, 0.0, 1.0))
    made.scene.set_acm(made.scene.acm.with_entry('table', True, ('base_link',)))
    for _ in range(60):
        linear, angular = random.uniform(-1, 1, 3), random.uniform(-1, 1, 3)
        made.run(twist(linear, angular), 0.3)
        made.run(jog(**{f'joint_{i}': random.uniform(-1, 1) for i in range(1, 7)}), 0.3)
    touching = [p for p in made.positions[::3] if made.checker.in_collision(
        made.kinematics.insert(made.q, 'manipulator', p))]
    assert not touching
    assert (np.array(made.positions) <= made.kinematics.upper[:6]).all()
    assert (np.array(made.positions) >= made.kinematics.lower[:6]).all()


@pytest.mark.parametrize(
    ('command', 'words'),
    [
        (twist((0.1, 0, 0), frame=''), 'frame_id is empty'),
        (twist((0.1, 0, 0), frame='nowhere'), "frame 'nowhere'"),
        (jog(joint_9=1.0), "'joint_9'"),
    ],
)
def test_senseless_commands(streamer, command, words):
    """They are refused with the field's name, and nothing moves."""
    made = streamer()
    with pytest.raises(InvalidCommandError, match=words):
        made.run(command, 0.01)
    made.run(None, 0.1)
    np.testing.assert_array_equal(made.positions[-1], made.positions[0])
