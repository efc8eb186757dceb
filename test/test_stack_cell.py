# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Two arms in one world, without ROS: physics, controllers, plans."""

import shutil

import numpy as np
import pytest

from armsim_ros import Box, pose_matrix, WorldObject
from armsim_ros.errors import ConfigError, ControllerError, PlanningError
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.resources import find_robot, PACKAGE, share_folder
from armsim_ros.sim.assembly import build_managers, build_simulation
from armsim_ros.sim.vacuum_control import VacuumControl
from armsim_ros.stack import ArmSim
from armsim_ros.trajectory import JointTrajectory

SIDES = ('left', 'right')
#: Both lean towards -y: the left one into the place where the right one stands upright.
LEANING = {'joint1': -1.5708, 'joint2': 1.0, 'joint3': 0.6, 'joint4': 0.0, 'joint5': 0.0}


@pytest.fixture
def both():
    """Return two of the same arm, half a metre apart, after a tenth of a second."""
    pair = ArmSim('two_bots')
    pair.step(100)
    return pair


def of(side, positions):
    """Return positions with the names of one arm."""
    return {f'{side}_{joint}': position for joint, position in positions.items()}


def test_both_hold_their_place(both):
    """Each under its own controllers, in one physics."""
    assert max(map(abs, both.joint_positions.values())) < 1e-4
    assert {name: list(manager.controllers) for name, manager in both.managers.items()} == {
        side: ['joint_state_controller', 'bot_joint_controller'] for side in SIDES}


def test_each_manager_knows_its_own_joints(both):
    """Interfaces and claims of one robot alone."""
    for side in SIDES:
        command, state = both.managers[side].list_hardware_interfaces()
        assert {one.name.partition('_')[0] for one in (*command, *state)} == {side}
        assert {one.name for one in command if one.is_claimed} == {
            f'{side}_joint{number}/position' for number in range(1, 6)}


def test_each_robot_has_its_own_suction_cup(tmp_path):
    """Each holds what is before it, and goes with its own link."""
    (tmp_path / 'robots.yaml').write_text(
        'robots:\n  left: {robot: sunday}\n  right: {robot: sunday, xyz: [0, -1, 0]}\n')
    pair = ArmSim(load_cell(str(tmp_path)))
    cups = pair.simulation.vacuum_grippers
    for side in SIDES:
        pose = pair.simulation.link_pose(f'{side}_link_6') @ pose_matrix((0.03, 0.0, 0.0))
        pair.add_object(WorldObject.of_shape(f'{side}_box', Box((0.04,) * 3), pose, mass=0.1))
        cup = VacuumControl(pair.loop, cups[f'{side}/vacuum_gripper'], lambda: None)
        cup.on()
        pair.run_until(lambda side=side: f'{side}_box' in pair.held)
    assert pair.held == {f'{side}_box': f'{side}_link_6' for side in SIDES}


def test_each_robot_shows_its_own_sensors(tmp_path):
    """dynamic_joint_states of one robot has its sensors, not those of the other."""
    arm = tmp_path / 'arm'
    shutil.copytree(find_robot('bot'), arm)
    shutil.copy(share_folder(PACKAGE) / 'urdf' / 'bot.urdf.xacro', arm)
    with (arm / 'simulation.yaml').open('a', encoding='utf-8') as file:
        file.write('sensors: {wrist: {type: force_torque, link: link5}}\n')
    (tmp_path / 'robots.yaml').write_text(
        'robots:\n  left: {robot: arm}\n  right: {robot: arm, xyz: [0, -1, 0]}\n')
    pair = ArmSim(load_cell(str(tmp_path)))
    pair.step(100)
    for side in SIDES:
        broadcaster = pair.managers[side].controllers['joint_state_controller']
        owners = {owner for owner, _, _ in broadcaster.read(0).dynamic}
        assert f'{side}_wrist' in owners
        assert {owner.partition('_')[0] for owner in owners} == {side}


def test_there_is_no_single_manager(both):
    """Who asks for it is told where they are."""
    with pytest.raises(ControllerError, match=r"managers\['left'\], managers\['right'\]"):
        _ = both.manager


def test_one_stops_and_the_other_goes_on(both):
    """A switch of one robot leaves the claims and commands of the other."""
    goals = both.send_trajectory(both.plan('ready', 'right_arm'))
    both.step(50)
    assert both.managers['left'].switch(deactivate=['bot_joint_controller']).ok
    both.run_until(lambda: all(goal.done for goal in goals))
    assert both.joint_positions['right_joint3'] == pytest.approx(1.4, abs=1e-3)
    assert both.joint_positions['left_joint3'] == pytest.approx(0.0, abs=1e-3)


def test_both_move_at_once(both):
    """Two trajectories at the same time, each to its own controller."""
    sent = [goal for side in SIDES
            for goal in both.send_trajectory(both.plan('ready', f'{side}_arm'))]
    both.run_until(lambda: all(goal.done for goal in sent))
    for side in SIDES:
        assert both.joint_positions[f'{side}_joint2'] == pytest.approx(-0.5, abs=1e-3)


def test_one_plan_moves_both(both):
    """A group over both arms; its trajectory is split over two controllers."""
    both.execute(both.plan('ready', 'both_arms'))
    for side in SIDES:
        assert both.joint_positions[f'{side}_joint4'] == pytest.approx(0.7, abs=1e-3)


def test_each_plan_knows_where_the_other_arm_is(both):
    """A goal is refused while the other arm stands in it, and free once it has moved."""
    with pytest.raises(PlanningError, match=r"'left_link\d' with 'right_link\d'"):
        both.plan(of('left', LEANING), 'left_arm')
    both.execute(both.plan(of('right', LEANING), 'right_arm'))
    both.execute(both.plan(of('left', LEANING), 'left_arm'))
    assert both.joint_positions['left_joint2'] == pytest.approx(1.0, abs=1e-3)


def test_arms_that_are_driven_into_each_other_touch(both):
    """What no planner allows, a controller does: the physics stops both."""
    both.send_trajectory(JointTrajectory(
        tuple(of('left', LEANING)), np.array([1.5, 3.0]),
        np.array([[-1.5708, 0.0, 0.0, 0.0, 0.0], [-1.5708, 1.0, 0.6, 0.0, 0.0]])))

    def arms_touch():
        return any({name.partition('/')[2].partition('_')[0] for name in contact.bodies}
                   == set(SIDES) for contact in both.simulation.contacts)

    both.run_until(arms_touch, timeout=4.0)
    both.run_until(both.time + 0.5)
    assert both.joint_positions['left_joint2'] < 0.95


def test_different_arms_keep_their_names():
    """No prefix where no name is in both: the groups and controllers of their own files."""
    pair = ArmSim('bot_and_elfin')
    pair.execute(pair.plan('ready', 'arm'))
    pair.execute(pair.plan('ready', 'elfin_arm'))
    ready = pair.model.semantic.named_states
    for name, position in (ready['arm']['ready'] | ready['elfin_arm']['ready']).items():
        assert pair.joint_positions[name] == pytest.approx(position, abs=1e-3)


def test_the_same_calls_give_the_same_run():
    """Seed and calls decide, not how many steps are done in one call; the digest shows it."""
    digests = set()
    for count in (1, 300, 300):
        pair = ArmSim('two_bots', seed=3)
        pair.send_trajectory(pair.plan('ready', 'both_arms'))
        for _ in range(300 // count):
            pair.step(count)
        digests.add(pair.digest())
    assert len(digests) == 1


def test_mistakes_of_all_controllers_at_once(monkeypatch):
    """A controller that cannot run on its robot is told with its place, for each robot."""
    cell = load_cell('two_bots')
    for robot in cell.robots:
        parameters = robot.settings.controller('bot_joint_controller').parameters
        monkeypatch.setitem(parameters.__dict__, 'joints', ('nobody',))
    with pytest.raises(ConfigError) as caught:
        build_managers(cell, build_simulation(cell.settings, cell.model))
    assert len(caught.value.problems) == 2
