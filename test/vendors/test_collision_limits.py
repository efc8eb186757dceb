# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What stops an arm of a vendor: no motion by itself, with or without a payload, and every blow.

Franka's limits are those of ``getDefaultCollisionBehaviorRequest``
(default_robot_behavior_utils.hpp of franka_example_controllers).
"""

import numpy as np
import pytest

from armsim_ros.control.mailbox import GoalStatus
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.external_loads import ExternalLoads
from armsim_ros.sim.vacuum_control import VacuumControl
from armsim_ros.stack import ArmSim
from armsim_ros.trajectory import JointTrajectory

CUP = {'link': 'panda_hand', 'xyz': [0.0, 0.0, 0.13], 'force': 2000.0, 'moment': 500.0}
#: So far from the ground and from its own column an arm moves freely [m].
CLEARANCE = 0.2


def joints_of(sim):
    """Return the joints of the arm, without fingers."""
    return tuple(name for name in sim.manager.hardware.joint_names if 'finger' not in name)


def positions(sim):
    """Return where the arm's joints are (n,)."""
    return np.array([sim.joint_positions[name] for name in joints_of(sim)])


def wide_goals(sim, count, seed):
    """Yield targets up to 2 rad away, on ways above the ground, and durations."""
    model = sim.scene.kinematic_model
    (robot,) = sim.cell.robots
    limits = [robot.model.joints[name].limits for name in joints_of(sim)]
    lower, upper = (np.array([getattr(limit, side) for limit in limits])
                    for side in ('lower', 'upper'))
    speed = np.array([limit.velocity for limit in limits])
    chance = np.random.default_rng(seed)

    def clear(way):
        for place in way:
            state = model.vector(sim.joint_positions | dict(zip(
                joints_of(sim), place, strict=True)))
            poses = [model.link_pose(state, joint.child) for joint in robot.model.joints.values()
                     if joint.name in joints_of(sim)[2:]]
            tip = poses[-1][:3, 3]
            if min(pose[2, 3] for pose in poses) < CLEARANCE or (
                    tip[2] < 0.6 and np.hypot(*tip[:2]) < 1.5 * CLEARANCE):
                return False
        return True

    while count:
        here = positions(sim)
        there = np.clip(here + chance.uniform(-2.0, 2.0, len(here)), 0.95 * lower, 0.95 * upper)
        if clear(here + share * (there - here) for share in np.linspace(0.0, 1.0, 20)):
            count -= 1
            # A cubic from rest to rest is at most 1.5 times as fast as its mean.
            fastest = 1.5 * np.max(np.abs(there - here) / speed)
            yield there, float(fastest / chance.uniform(0.5, 0.95))


def go(sim, target, duration):
    """Send a goal; return it."""
    (goal,) = sim.send_trajectory(JointTrajectory(
        joints_of(sim), np.array([duration]), target[None], np.zeros((1, len(target)))))
    return goal


def highest_load(sim, goal):
    """Return the greatest external torque of a joint until a goal is done, untouched [N*m]."""
    (robot,) = sim.cell.robots
    loads = ExternalLoads(sim.simulation, sim.manager.hardware.joint_names, robot)
    highest = 0.0
    while not goal.done:
        sim.step(2)
        if all('/cube' in ''.join(contact.bodies) for contact in sim.simulation.contacts):
            highest = max(highest, float(np.abs(loads.torques()).max()))
    return highest


def panda(**overrides):
    """Return an arm of Franka whose hand has a cup."""
    return ArmSim('panda', overrides={
        'simulation.hardware.vendor': 'franka', 'simulation.vacuum_grippers': {'cup': CUP},
        **overrides})


def with_load(mass):
    """Return an arm of Franka that carries a cube, which is set as its payload."""
    sim = panda()
    hand = sim.simulation.link_pose('panda_hand')
    middle = tuple((hand @ [0.0, 0.0, 0.165, 1.0])[:3])
    sim.add_object(WorldObject.of_shape(
        'cube', Box((0.06, 0.06, 0.06)), pose_matrix(middle), mass=mass))
    VacuumControl(sim.loop, sim.simulation.vacuum_grippers['cup'], lambda: None).on()
    sim.step(50)
    flange = sim.simulation.link_pose('panda_link8')
    centre = np.linalg.inv(flange) @ sim.simulation.world.pose('cube')
    sim.simulation.set_payload('panda_link8', mass, centre[:3, 3])
    sim.run_until(sim.time + 0.5)
    assert sim.simulation.vacuum_grippers['cup'].held == 'cube'
    return sim


@pytest.mark.parametrize(('robot', 'vendor'), [('panda', 'franka'), ('ur5', 'ur')])
def test_free_motion_is_no_load(robot, vendor):
    """
    At nearly the full speed of the joints nothing acts from outside, and nothing stops.

    HW-B1.
    """
    sim = ArmSim(robot, overrides={'simulation.hardware.vendor': vendor})
    assert sim.manager.stops.monitor is not None
    for target, duration in wide_goals(sim, 4, seed=1):
        goal = go(sim, target, duration)
        assert highest_load(sim, goal) < 1e-6
        assert goal.status is GoalStatus.SUCCEEDED, goal.result.message


def test_a_payload_that_is_set_is_no_load():
    """HW-B1, HW-C7: 3 kg in fast motion: what is left of them is far from what stops the arm."""
    sim = with_load(3.0)
    for target, duration in wide_goals(sim, 4, seed=1):
        goal = go(sim, target, duration)
        assert highest_load(sim, goal) < 2.0
        assert goal.status is GoalStatus.SUCCEEDED, goal.result.message


def test_a_payload_that_is_not_set_is_a_load():
    """HW-C7: 3 kg that are carried, or that are set and not carried, act on the joints."""
    sim = with_load(3.0)
    (robot,) = sim.cell.robots
    loads = ExternalLoads(sim.simulation, sim.manager.hardware.joint_names, robot)
    assert np.abs(loads.torques()).max() < 0.1
    sim.simulation.set_payload('panda_link8', 0.0, (0.0, 0.0, 0.0))
    sim.run_until(sim.time + 0.5)
    weighed = loads.torques()
    assert np.abs(weighed).max() > 10.0
    sim.simulation.vacuum_grippers['cup'].switch_off()
    sim.simulation.set_payload('panda_link8', 3.0, (0.0, 0.0, 0.16))
    sim.run_until(sim.time + 0.5)
    np.testing.assert_allclose(loads.torques(), -weighed, atol=0.5)


@pytest.mark.parametrize(('robot', 'vendor'), [('panda', 'franka'), ('ur5', 'ur')])
def test_a_blow_stops_the_arm(robot, vendor):
    """HW-B1: A block in the way of the hand ends the goal with a collision."""
    sim = ArmSim(robot, overrides={'simulation.hardware.vendor': vendor})
    model, here = sim.scene.kinematic_model, positions(sim)
    there = here + np.array([1.2, *np.zeros(len(here) - 1)])
    halfway = dict(zip(joints_of(sim), 0.5 * (here + there), strict=True))
    (robot,) = sim.cell.robots
    last = [joint.child for joint in robot.model.joints.values()
            if joint.name == joints_of(sim)[-1]]
    tip = model.link_pose(model.vector(sim.joint_positions | halfway), last[0])[:3, 3]
    sim.add_object(WorldObject.of_shape('block', Box((0.1, 0.1, 0.1)), pose_matrix(tuple(tip))))
    goal = go(sim, there, 1.5)
    sim.run_until(lambda: goal.done)
    assert goal.result.message.startswith('protective stop: collision: ')


@pytest.mark.parametrize(('milliseconds', 'stops'), [(8, False), (16, True)])
def test_a_torque_stops_the_arm_once_it_lasts(milliseconds, stops):
    """HW-B1: A push of less than 10 ms does not, a longer one does."""
    sim = panda()
    sim.step(20)
    sim.simulation.apply_wrench('panda_hand', (0.0, 0.0, -150.0))
    sim.step(milliseconds)
    sim.simulation.apply_wrench('panda_hand')
    sim.step(20)
    assert sim.manager.arm.stopped == stops


@pytest.mark.parametrize(('settings', 'watched'), [
    ({'watch': 'never'}, False), ({'vendor': 'none'}, False), ({'vendor': 'kinova'}, False),
    ({'vendor': 'none', 'watch': 'always'}, True),
    ({'vendor': 'none', 'collision.force': 80.0}, True)])
def test_an_arm_is_watched_where_it_has_limits(settings, watched):
    """HW-B1, HW-A5: Those of its vendor or its own, unless the settings have it otherwise."""
    sim = panda(**{f'simulation.hardware.{key}': value for key, value in settings.items()})
    assert (sim.manager.stops.monitor is not None) == watched


def test_the_limits_are_those_of_the_vendor():
    """
    Franka has one for each joint, Universal Robots a share; a limit of one's own is for all.

    HW-B1.
    """
    torques = panda().manager.stops.monitor.torques
    assert torques[:7].tolist() == [35.0, 35.0, 32.0, 30.0, 29.0, 27.0, 24.0]
    sim = ArmSim('ur5', overrides={'simulation.hardware.vendor': 'ur'})
    assert sim.manager.stops.monitor.torques.tolist() == [75.0, 75.0, 75.0, 14.0, 14.0, 14.0]
    assert sim.manager.stops.monitor.force == 150.0
    own = panda(**{'simulation.hardware.collision.torque': 12.0}).manager.stops.monitor
    assert set(own.torques.tolist()) == {12.0}
    assert own.force == 40.0


def test_freedrive_gives_way_to_what_would_stop_the_arm():
    """
    A hand that guides the arm does not stop it; once freedrive ends, the same push does.

    HW-C7.
    """
    sim = panda(**{'simulation.hardware.collision.torque': 5.0})
    sim.manager.arm.set_freedrive(True)
    sim.step(20)
    sim.simulation.apply_wrench('panda_hand', (0.0, 0.0, -20.0))
    sim.step(40)
    assert not sim.manager.arm.stopped
    sim.manager.arm.set_freedrive(False)
    sim.step(40)
    assert sim.manager.arm.cause.text.startswith('external torque')
