# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The whole stack without ROS."""

from pathlib import Path
from shutil import copytree
import subprocess
import sys

import numpy as np
import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.control.mailbox import GoalStatus
from armsim_ros.control.trajectory.tolerances import JointTolerance
from armsim_ros.errors import (
    ConfigError,
    ControllerError,
    ModelError,
    MoveItErrorCode,
    PlanningError,
    SimulationError,
)
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.assembly import servo_gains
from armsim_ros.stack import ArmSim
from armsim_ros.testing.stacks import built_cell
from armsim_ros.trajectory import JointTrajectory

ROOT = Path(__file__).parents[1]
JOINTS = tuple(f'joint_{i}' for i in range(1, 7))


@pytest.fixture
def sim(arm):
    """Return the stack of the test's arm: sunday at the feeding place, or the marker's."""
    return arm.sim


def through(*positions, smooth=True):
    """Return a trajectory of all joints through equal positions, a second apart."""
    rows = np.tile(np.array(positions)[:, None], 6)
    return JointTrajectory(
        JOINTS, 1.0 + np.arange(len(rows)), rows, np.zeros_like(rows) if smooth else None)


def test_starts_at_zero_and_moves_only_by_steps(sim):
    """Time begins at 0; a step is a millisecond; the arm holds its place."""
    assert sim.time == 0.0
    sim.step(10)
    assert sim.time == pytest.approx(0.01)
    np.testing.assert_allclose(list(sim.joint_positions.values()), 0.0, atol=1e-6)


def test_a_grippers_named_states_are_executed():
    """A gripper's controller gets the last point of the plan, as from move_group."""
    hand = ArmSim('panda')
    for state, position in (('open', 0.035), ('close', 0.0)):
        hand.execute(hand.plan(state, 'hand'))
        assert hand.joint_positions['panda_finger_joint1'] == pytest.approx(position, abs=0.005)


def test_plans_and_executes_a_named_state(sim):
    """After plan and execute the arm is at scan_food, within a milliradian."""
    sim.execute(sim.plan('scan_food'))
    wanted = sim.model.semantic.named_states['manipulator']['scan_food']
    for name, position in wanted.items():
        assert sim.joint_positions[name] == pytest.approx(position, abs=1e-3)


def test_plans_to_joint_positions_and_to_a_pose(sim):
    """Joint positions and the tip's pose are goals too."""
    sim.execute(sim.plan({'joint_1': 0.3, 'joint_2': 0.2}))
    assert sim.joint_positions['joint_1'] == pytest.approx(0.3, abs=1e-3)
    sim.execute(sim.plan('scan_food'))
    pose = sim.simulation.link_pose('link_6')
    pose[2, 3] -= 0.02
    sim.execute(sim.plan(pose))
    np.testing.assert_allclose(sim.simulation.link_pose('link_6')[:3, 3], pose[:3, 3], atol=2e-3)


def largest_error(sim, trajectory):
    """Run a trajectory; return the largest distance from the drives' reference [rad]."""
    (goal,) = sim.send_trajectory(trajectory)
    worst = 0.0
    while not goal.done:
        sim.step()
        error = sim.simulation.state.position - sim.simulation.reference_positions
        worst = max(worst, np.abs(error).max())
    return worst


def test_a_trajectory_is_followed_within_a_milliradian(sim):
    """Free motion: the measured joints are below 1 mrad from the controllers' reference."""
    assert largest_error(sim, through(0.0, 0.4, -0.1)) < 1e-3
    assert sim.joint_positions['joint_3'] == pytest.approx(-0.1, abs=1e-3)


def test_a_corner_in_velocity_costs_what_the_motors_effort_allows(sim):
    """Linear segments jump in velocity: the arm cuts the corner by 3 mrad and is there again."""
    assert largest_error(sim, through(0.0, 0.4, smooth=False)) < 3e-3
    assert sim.joint_positions['joint_3'] == pytest.approx(0.4, abs=1e-3)


@pytest.mark.armsim(**{'controller_manager.update_rate': 100})
def test_controllers_slower_than_the_physics_track_as_well(sim):
    """At an update rate of 100 Hz the drives interpolate: the end is met all the same."""
    sim.execute(sim.plan('scan_food'))
    wanted = sim.model.semantic.named_states['manipulator']['scan_food']
    for name, position in wanted.items():
        assert sim.joint_positions[name] == pytest.approx(position, abs=1e-3)


def test_the_gains_of_the_yaml_reach_the_drives():
    """The gains under a position controller are those of its joints' drives."""
    gains = servo_gains(load_robot_settings('sunday'))
    assert set(gains) == set(JOINTS)
    assert (gains['joint_1'].p, gains['joint_1'].d) == (1000.0, 0.1)
    assert gains['joint_1'].integral_bounds == (0.0, 0.0)


def test_an_unknown_state_is_refused_with_the_known_ones(sim):
    """A named state that the SRDF lacks is named with the nearest one."""
    with pytest.raises(ModelError, match=r"scan_fod.*did you mean 'scan_fo"):
        sim.plan('scan_fod')


def test_a_plan_that_cannot_be_has_a_reason(sim):
    """A goal out of reach raises PlanningError with a sentence; the stack goes on."""
    pose = np.eye(4)
    pose[:3, 3] = (5.0, 0.0, 0.0)
    with pytest.raises(PlanningError, match=r'\w'):
        sim.plan(pose, allowed_time=0.5)
    sim.step()


def test_a_trajectory_of_unknown_joints_is_refused(sim):
    """A trajectory for joints that no controller has says so; nothing moves."""
    with pytest.raises(ControllerError, match='elbow'):
        sim.send_trajectory(JointTrajectory(('elbow',), np.ones(1), np.zeros((1, 1))))


def test_a_start_that_does_not_fit_is_a_mistake_of_the_configuration():
    """An initial position of an unknown joint is refused as ConfigError with the known ones."""
    with pytest.raises(ConfigError, match='joint_1'):
        ArmSim('sunday', overrides={'simulation.initial_positions': {'joint_7': 0.1}})


def test_waiting_in_vain_ends(sim):
    """A condition that never holds ends with an error after its simulated time."""
    with pytest.raises(SimulationError, match=r'0\.05 s'):
        sim.run_until(lambda: False, timeout=0.05)
    sim.run_until(0.1)
    assert sim.time == pytest.approx(0.1)


def test_the_example_prints_the_same_digest_in_two_processes():
    """The same seed gives the same bytes in another process."""
    command = [sys.executable, str(ROOT / 'examples' / 'no_ros.py'), 'scan_food']
    runs = [
        subprocess.run(
            command, capture_output=True, text=True, check=True, cwd=ROOT,
            env={'PYTHONPATH': str(ROOT), 'PYTHONHASHSEED': seed, 'PATH': '/usr/bin:/bin'},
        ).stdout
        for seed in ('1', '2')
    ]
    assert 'digest' in runs[0]
    assert runs[0] == runs[1]


@pytest.mark.parametrize('rate', [1000, 100])
def test_many_steps_in_one_go_equal_single_ones(rate):
    """How the steps are asked for changes no bit: at rest, in motion, and at rest again."""
    digests, ends = [], []
    for count in (1, 7, 500):
        sim = ArmSim(built_cell('sunday', None, {'controller_manager.update_rate': rate}))
        sim.step(30)
        (goal,) = sim.send_trajectory(through(0.1, 0.3))
        goal.add_done_callback(lambda _, sim=sim: ends.append(sim.time))
        steps = 0
        while steps < 3500:
            sim.step(min(count, 3500 - steps))
            steps += count
        digests.append(sim.digest())
    assert digests[0] == digests[1] == digests[2]
    assert ends[0] == ends[1] == ends[2]


def test_a_robot_without_collision_geometry_is_planned_for(small_package):
    """Nothing of it can touch anything, and it still moves."""
    arm = ArmSim(str(small_package.folder))
    trajectory = arm.plan('bent')
    arm.execute(trajectory)
    assert arm.joint_positions['shoulder'] == pytest.approx(0.5, abs=0.01)


def test_a_path_tolerance_ends_a_goal_at_its_tick_however_steps_are_asked_for():
    """A joint that is pushed away in the middle of a motion aborts the goal at the same tick."""
    ends = []
    for count in (1, 400):
        sim = ArmSim(built_cell('sunday', None, {}))
        sim.step(30)
        controller = sim.manager.controllers['arm_joint_controller']
        goal = controller.send_goal(
            through(0.1, 0.3), [JointTolerance('joint_2', position=0.001)]
        ).goal
        sim.step(700)
        sim.simulation.apply_wrench('link_3', force=(60.0, 0.0, 60.0))
        for _ in range(800 // count):
            sim.step(count)
        ends.append((goal.status, goal.result, sim.digest()))
    assert ends[0][0] is GoalStatus.ABORTED
    assert 'joint_2' in ends[0][1].message
    assert ends[0] == ends[1]


def test_gains_set_at_run_time_reach_the_drives(sim):
    """A joint with a tenth of its gain gives way ten times as far."""
    controller = sim.manager.controllers['arm_joint_controller']
    sim.simulation.apply_wrench('link_3', force=(30.0, 0.0, 0.0))
    sags = []
    for gain in (1000.0, 100.0):
        controller.set_parameters({'gains.joint_2.p': gain})
        sim.step(3000)
        sags.append(abs(sim.joint_positions['joint_2']))
    assert sags[1] == pytest.approx(10.0 * sags[0], rel=0.2)


def test_a_plan_takes_along_what_fingers_hold():
    """Held it is on the arm, for the planner, too; let go it is an obstacle where it is."""
    sim = ArmSim(ROOT / 'test' / 'support' / 'robots' / 'hand')
    sim.add_object(WorldObject.of_shape(
        'post', Box((0.03,) * 3), pose_matrix((0.0, 0.0, 1.12))))
    sim.add_object(WorldObject.of_shape(
        'cube', Box((0.05,) * 3), pose_matrix((0.0, 0.0, 1.16)), mass=0.3))
    for position, held in ((0.0, {'cube': 'palm'}), (0.04, {})):
        goal = sim.manager.controllers['fingers'].send_goal(position, 10.0).goal
        sim.run_until(lambda goal=goal: goal.done)
        assert sim.held == held
        sim.plan({'carriage_z': 0.01}, 'carriage')
        attached = sim.scene.attached
        assert {name: one.link_name for name, one in attached.items()} == held
        assert all(set(one.touch_links) == {'palm', 'left_finger', 'right_finger'}
                   for one in attached.values())


def test_joint_limits_bound_plans_and_not_the_drives(small_package):
    """
    A trajectory goes on to the end of the URDF's range; a plan neither ends nor starts there.

    moveit_ros/planning/robot_model_loader/src/robot_model_loader.cpp: configure.
    """
    small_package.write('config/joint_limits.yaml', (
        'joint_limits:\n  elbow: {min_position: -1.0, max_position: 1.0, '
        'has_velocity_limits: true, max_velocity: 0.5,\n'
        '    has_acceleration_limits: true, max_acceleration: 1.0}\n'
        '  shoulder: {has_acceleration_limits: true, max_acceleration: 1.0}\n'))
    sim = ArmSim(str(small_package.folder))
    assert sim.plan({'shoulder': 0.0, 'elbow': 0.9}, 'arm').duration > 0.9 / 0.5
    assert sim.plan({'elbow': 1.5}, 'arm').positions[-1, 1] == pytest.approx(1.0, abs=1e-3)
    sim.send_trajectory(JointTrajectory(
        ('shoulder', 'elbow'), np.array([1.5]), np.array([[0.0, 2.5]])))
    sim.run_until(2.5)
    assert sim.joint_positions['elbow'] == pytest.approx(2.0, abs=0.01)
    with pytest.raises(PlanningError) as refused:
        sim.plan({'shoulder': 0.0, 'elbow': 0.5}, 'arm')
    assert refused.value.code == MoveItErrorCode.START_STATE_INVALID


@pytest.mark.parametrize('allow_failure', [False, True])
def test_a_gripper_that_is_blocked(allow_failure, tmp_path):
    """An object between the fingers is a failure, unless allow_failure is set."""
    folder = copytree(ROOT / 'test' / 'support' / 'robots' / 'hand', tmp_path / 'hand')
    text = (folder / 'controllers.yaml').read_text()
    (folder / 'controllers.yaml').write_text(text.replace('stalling: true', 'stalling: false'))
    (folder / 'moveit_controllers.yaml').write_text(
        'moveit_simple_controller_manager:\n  controller_names: [hand/fingers]\n  hand/fingers: {'
        'type: GripperCommand, action_ns: gripper_cmd, joints: [finger_joint1], max_effort: 10, '
        f'allow_failure: {str(allow_failure).lower()}}}\n')
    sim = ArmSim(folder)
    sim.add_object(WorldObject.of_shape('post', Box((0.03,) * 3), pose_matrix((0.0, 0.0, 1.12))))
    sim.add_object(WorldObject.of_shape(
        'cube', Box((0.05,) * 3), pose_matrix((0.0, 0.0, 1.16)), mass=0.3))
    closing = JointTrajectory(('finger_joint1',), [0.0, 1.0], [[0.04], [0.0]])
    if allow_failure:
        sim.execute(closing)
    else:
        with pytest.raises(ControllerError, match="aborted: gripper 'fingers' stalled"):
            sim.execute(closing)
    assert sim.held == {'cube': 'palm'}


def test_a_refused_plan_is_reported_once(sim, capfd, caplog):
    """The exception has the reason; nothing is logged beside it."""
    with pytest.raises(PlanningError, match="did you mean 'joint_6'"):
        sim.plan({'joint_9': 1.0})
    assert capfd.readouterr().err == ''
    assert caplog.text == ''
