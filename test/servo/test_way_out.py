# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The keys of armsim teleop from each named state of each robot: a motion, or a way out."""

from functools import cache
from pathlib import Path
import re

import numpy as np
import pytest
from servo_streams import jog, Streamer, twist

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.loading import load_robot_model
from armsim_ros.nodes.teleop.commands import MOVES
from armsim_ros.servo.assembly import arm_group
from armsim_ros.servo.commands import ServoStatus, weightiest

ROOT = Path(__file__).parents[2]
FAR = 0.02
#: How long a command lasts until its effect is read [s].
SHORT = 0.1
#: Every robot that is included; the cells consist of these.
ROBOTS = sorted(file.parent.name for file in (ROOT / 'config').glob('*/kinematics.yaml'))
AXES = {'x': (1, 0, 0), 'y': (0, 1, 0), 'z': (0, 0, 1)}


@cache
def robot(name):
    """Return kinematics, the group that servo moves, and servo's settings."""
    settings = load_robot_settings(name)
    kinematics = KinematicModel(planning_robot(load_robot_model(settings), settings.joint_limits))
    controllers = [each.joints for each in settings.controllers if hasattr(each, 'constraints')]
    return kinematics, arm_group(kinematics, controllers), settings.servo.moveit_servo


def made_in(name, state):
    """Return a stream that rests in a named state."""
    kinematics, group, parameters = robot(name)
    values = kinematics.robot.semantic.named_states[group][state]
    start = [values[kinematics.names[i]] for i in kinematics.group_indices(group)]
    return Streamer(kinematics, start, group, **parameters.model_dump())


def moved(made, direction, seconds, enough=np.inf):
    """
    Return how far the tip comes along a direction of its base, and the last status.

    :param enough: a way [m] with which it ends before its time.
    """
    base = made.kinematics.link_pose(made.q, made.stream.target.base)[:3, :3]
    before, command = made.tip[:3, 3], twist(direction, frame=made.stream.target.base)
    for _ in range(round(seconds / SHORT)):
        made.run(command, SHORT)
        way = float(base.T @ (made.tip[:3, 3] - before) @ direction)
        if way >= enough:
            break
    return way, weightiest(made.cycles[-1].findings)


def restart(made, place):
    """Bring the stream to rest in a place (m,) of the joints."""
    made.positions[:] = [place]
    made.stream.start(place)


def follow(made, free):
    """Follow what a status names as free, from where the arm is, and check that it is."""
    there = made.positions[-1]
    if free.startswith('turn'):
        _, joint, sense = free.split()
        before = made.stream.target.singularity(made.q)
        made.run(jog(**{joint.strip("'"): 1.0 if sense == 'up' else -1.0}), 0.8)
        assert np.abs(made.positions[-1] - there).max() > 0.2, free
        assert made.stream.target.singularity(made.q) < before, free
        return
    for sign, axis in re.findall('([-+])([xyz])', free):
        restart(made, there)
        direction = np.array(AXES[axis]) * (1 if sign == '+' else -1)
        assert moved(made, direction, 3.0, 1.01 * FAR)[0] > FAR, free


@pytest.mark.parametrize('name', ROBOTS)
def test_each_key_moves_the_tip_or_names_a_way_out(name):
    """A key moves the tip by 20 mm, or the status names what is free, and that is true."""
    kinematics, group, _ = robot(name)
    for state in kinematics.robot.semantic.named_states[group]:
        made = made_in(name, state)
        start = made.positions[0]
        for direction in MOVES.values():
            restart(made, start)
            way, finding = moved(made, np.array(direction), 2.0, FAR)
            if way < FAR:
                found = re.search(r"free: (turn '.*' \w+|[-+xyz, ]+ of )", finding.message)
                assert found, (state, finding.message)
                follow(made, found[1])


@pytest.mark.parametrize('name', ROBOTS)
def test_each_number_key_turns_its_joint_or_names_the_bound(name):
    """From each named state, both ways; the status has the bound and the side that is allowed."""
    kinematics, group, _ = robot(name)
    for state in kinematics.robot.semantic.named_states[group]:
        made = made_in(name, state)
        start = made.positions[0]
        for index, joint in enumerate(kinematics.robot.group(group).active_joints):
            for velocity in (1.0, -1.0):
                restart(made, start)
                for _ in range(round(0.8 / SHORT)):
                    made.run(jog(**{joint: velocity}), SHORT)
                    turned = velocity * (made.positions[-1] - start)[index]
                    if turned >= 0.1:
                        break
                else:
                    side = 'up' if velocity > 0 else 'down'
                    found = weightiest(made.cycles[-1].findings).message
                    assert re.search(rf"joint '{joint}' at .*, allowed {side} to ", found), (
                        state, found)


def test_the_default_robot_can_be_jogged_from_ready():
    """From `ready` each key moves the tip at once, without a warning on its first 50 mm."""
    made = made_in('sunday', 'ready')
    start = made.positions[0]
    for direction in MOVES.values():
        restart(made, start)
        way, finding = moved(made, np.array(direction), 0.8)
        assert way > 0.05
        assert finding.code is ServoStatus.NO_WARNING


def test_axes_are_not_free_where_translation_is_locked():
    """A turn that is blocked names a joint; scale.linear of 0 allows turns alone."""
    kinematics, _, _ = robot('sunday')
    made = Streamer(kinematics, scale={'linear': 0.0, 'rotational': 0.8, 'joint': 0.5})
    made.add_box('wall', (0.05, 2.0, 2.0), tuple(made.tip[:3, 3] + (0.12, 0.0, 0.0)))
    made.run(twist(angular=(1, 0, 0)), 4.0)
    told = [finding.message for cycle in made.cycles for finding in cycle.findings]
    assert any('free: turn' in message for message in told), set(told)


def test_a_twist_that_turns_back_forgets_what_was_free():
    """The text about a blocked direction ends with the first cycle that moves the tip."""
    made = made_in('sunday', 'scan_face2')
    _, finding = moved(made, np.array([-1, 0, 0]), 0.5)
    assert 'free: ' in finding.message
    _, finding = moved(made, np.array([1, 0, 0]), 0.2)
    assert 'free: ' not in finding.message


def test_directions_are_evaluated_one_per_cycle():
    """The first cycles of a blocked twist report the obstacle alone: none takes long."""
    made = made_in('sunday', 'home')
    made.run(twist((0, 0, -1)), 0.03)
    assert all('free' not in each.message for cycle in made.cycles for each in cycle.findings)
    made.run(twist((0, 0, -1)), 0.3)
    assert "free: turn 'joint_3'" in weightiest(made.cycles[-1].findings).message
