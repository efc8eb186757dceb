# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Answers of Franka's endpoints, without a middleware between client and arm.

As ``franka_param_service_server.cpp`` and ``franka_robot_state.cpp`` of franka_ros2.
"""

import math
from types import SimpleNamespace

from direct_nodes import Node, Nodes
import numpy as np
import pytest

from armsim_ros.control.arm_state import Cause
from armsim_ros.nodes.vendors.franka_services import ArmParameters, ParameterServices
from armsim_ros.nodes.vendors.franka_state_broadcaster import errors_of, robot_mode, StateTopics
from armsim_ros.stack import ArmSim

ARM, FLANGE = 'panda_arm_controller', 'panda_link8'
JOINTS = tuple(f'panda_joint{number}' for number in range(1, 8))


@pytest.fixture
def sim():
    """Return an arm of Franka whose controller is not active."""
    sim = ArmSim('panda', overrides={'simulation.hardware.vendor': 'franka'})
    assert sim.manager.switch([], [ARM]).ok
    sim.step(20)
    return sim


@pytest.fixture
def nodes(sim):
    """Return its endpoints."""
    nodes = Nodes(sim)
    nodes.parameters = ArmParameters()
    nodes.server = ParameterServices(nodes, JOINTS, nodes.parameters)
    return nodes


@pytest.fixture
def topics(nodes):
    """Return the topics of its state."""
    return StateTopics(nodes, SimpleNamespace(active=True), Node(), JOINTS, nodes.parameters)


def state(topics):
    """Return the message of now."""
    return topics._message(*topics._sample())


def behavior(torque, force):
    """Return the fields of a collision behaviour with these upper thresholds."""
    return {'lower_torque_thresholds_nominal': [0.5 * torque] * 7,
            'upper_torque_thresholds_nominal': [torque] * 7,
            'lower_force_thresholds_nominal': [0.5 * force] * 6,
            'upper_force_thresholds_nominal': [force] * 6}


def test_parameters_are_refused_while_a_controller_moves_the_arm(sim, nodes):
    """HW-D3: Each service answers with the controller's name; afterwards each succeeds."""
    requests = {
        'set_joint_stiffness': {'joint_stiffness': [3000.0] * 7},
        'set_cartesian_stiffness': {'cartesian_stiffness': [1000.0] * 6},
        'set_tcp_frame': {'transformation': np.eye(4).flatten()},
        'set_stiffness_frame': {'transformation': np.eye(4).flatten()},
        'set_force_torque_collision_behavior': behavior(20.0, 40.0),
        'set_full_collision_behavior': behavior(20.0, 40.0),
        'set_load': {'mass': 0.5},
    }
    assert list(nodes.services) == list(requests)
    sim.manager.switch([ARM], [])
    for name, request in requests.items():
        answer = nodes.call(name, **request)
        assert not answer.success
        assert ARM in answer.error
    sim.manager.switch([], [ARM])
    for name, request in requests.items():
        answer = nodes.call(name, **request)
        assert (answer.success, answer.error) == (True, ''), name


@pytest.mark.parametrize(('name', 'request_'), [
    ('set_joint_stiffness', {'joint_stiffness': [0.0] * 7}),
    ('set_cartesian_stiffness', {'cartesian_stiffness': [-1.0] * 6}),
    ('set_tcp_frame', {'transformation': [1.0] * 16}),
    ('set_force_torque_collision_behavior', behavior(0.0, 1.0)),
    ('set_load', {'mass': -1.0}),
    ('set_load', {'mass': math.nan}),
    ('set_load', {'mass': math.inf}),
    ('set_load', {'mass': 1.0, 'center_of_mass': [math.nan, 0.0, 0.0]}),
    ('set_load', {'mass': 1.0, 'load_inertia': [math.nan] * 9}),
])
def test_what_cannot_be_is_refused(nodes, name, request_):
    """HW-D3: The answer has the reason."""
    answer = nodes.call(name, **request_)
    assert not answer.success
    assert answer.error


@pytest.mark.parametrize(('force', 'stops'), [(30.0, False), (90.0, True)])
def test_the_collision_behavior_decides_what_stops_the_arm(sim, nodes, topics, force, stops):
    """
    A push of the hand above the threshold of a joint is a reflex, one below is a contact.

    HW-D3, HW-B1.
    """
    assert nodes.call('set_force_torque_collision_behavior', **behavior(30.0, 100.0)).success
    sim.simulation.apply_wrench('panda_hand', (0, 0, -force))
    sim.run_until(sim.time + 1.0)
    assert sim.manager.arm.stopped == stops
    message = state(topics)
    assert any(message.collision_indicators.is_joint_collision) == stops
    assert message.current_errors.joint_reflex == stops
    assert message.robot_mode == (4 if stops else 1)
    if not stops:
        assert message.collision_indicators.is_joint_contact[3] == (
            abs(message.tau_ext_hat_filtered.effort[3]) > 15.0)


def test_the_wrench_is_what_pushes_the_arm(sim, topics):
    """
    HW-D2: 20 N along x, and none at all; with the pose of the tool in the arm's base.

    What the arm does to its environment is positive (robot_state.h of libfranka: O_F_ext_hat_K,
    tau_ext_hat_filtered).
    """
    assert np.abs(state(topics).tau_ext_hat_filtered.effort).max() < 0.05
    sim.simulation.apply_wrench('panda_hand', (20.0, 0, 0))
    sim.step(500)
    message = state(topics)
    force = message.o_f_ext_hat_k.wrench.force
    assert (force.x, force.y, force.z) == pytest.approx((-20.0, 0.0, 0.0), abs=0.5)
    # The push, above the shoulder, would turn it on; what its drive gives holds it back.
    assert message.tau_ext_hat_filtered.effort[1] == pytest.approx(-4.5, abs=0.2)
    own = message.k_f_ext_hat_k.wrench.force
    assert np.hypot(own.x, own.y) == pytest.approx(20.0, abs=0.7)
    pose = sim.simulation.link_pose('panda_hand_tcp')[:3, 3]
    found = message.o_t_ee.pose.position
    assert (found.x, found.y, found.z) == pytest.approx(pose, abs=1e-6)
    assert message.f_t_ee.pose.position.z == pytest.approx(0.1034)


def test_frames_of_clients_are_those_of_the_state(nodes, topics):
    """
    The tool is given in the frame of the hand, the wrench's frame in that of the tool.

    HW-D2, HW-D3.
    """
    frame = np.eye(4)
    frame[:3, 3] = 0.0, 0.0, 0.1
    before = state(topics)
    assert nodes.call('set_tcp_frame', transformation=frame.T.flatten()).success
    assert nodes.call('set_stiffness_frame', transformation=frame.T.flatten()).success
    after = state(topics)
    assert after.f_t_ee.pose.position.z - before.f_t_ee.pose.position.z == pytest.approx(0.1)
    assert after.ee_t_k.pose.position.z == pytest.approx(0.1)


def test_the_stiffness_of_joints_is_that_of_the_drives(sim, nodes):
    """HW-D3: Half the stiffness, twice the deflection."""
    found = []
    for stiffness in (2000.0, 1000.0):
        sim.simulation.apply_wrench('panda_hand', (0, 0, 0))
        assert nodes.call('set_joint_stiffness', joint_stiffness=[stiffness] * 7).success
        sim.step(500)
        before = sim.simulation.state.position[3]
        sim.simulation.apply_wrench('panda_hand', (0, 0, -20.0))
        sim.step(500)
        found.append(abs(sim.simulation.state.position[3] - before))
    assert found[1] / found[0] == pytest.approx(2.0, abs=0.1)


def test_the_wrench_is_of_the_origin_of_the_stiffness_frame(sim, nodes, topics):
    """HW-D2: A frame 0.5 m beside a force of 20 N sees its moment as well (O_F_ext_hat_K)."""
    sim.simulation.apply_wrench('panda_hand', (20.0, 0, 0))
    sim.step(500)
    before = state(topics).o_f_ext_hat_k.wrench
    tool = sim.simulation.link_pose('panda_hand_tcp')
    frame = np.eye(4)
    frame[:3, 3] = tool[:3, :3].T @ [0.0, 0.0, 0.5]
    assert nodes.call('set_stiffness_frame', transformation=frame.T.flatten()).success
    after = state(topics).o_f_ext_hat_k.wrench
    assert after.force.x == pytest.approx(before.force.x, abs=0.1)
    # The force of 20 N acts below the frame; the arm answers with its opposite.
    assert after.torque.y - before.torque.y == pytest.approx(20.0 * 0.5, abs=0.3)


def test_the_wrench_is_zero_in_a_singularity(sim, topics):
    """HW-D2: Where the tool cannot move in some direction it cannot be told from the torques."""
    sim.simulation.set_positions(dict.fromkeys(JOINTS, 0.0) | {
        'panda_joint3': 1.57, 'panda_joint4': -1.57, 'panda_joint6': 3.14})
    sim.simulation.apply_wrench('panda_hand', (0, 20.0, 0))
    sim.step(2)
    message = state(topics)
    assert np.abs(message.tau_ext_hat_filtered.effort).max() > 1.0
    force = message.o_f_ext_hat_k.wrench.force
    assert (force.x, force.y, force.z) == (0.0, 0.0, 0.0)


def test_masses_are_those_of_end_effector_and_load(sim, nodes, topics):
    """
    HW-D2: In the axes of the flange, at the centre of mass.

    As ``combineCenterOfMass`` and ``combineInertiaTensor`` (load_calculations.cpp of libfranka).
    """
    hand = state(topics).inertia_ee
    links = [sim.simulation.mujoco_model.body(f'panda/{name}') for name in (
        'panda_leftfinger', 'panda_rightfinger')]
    assert hand.inertia.m > sum(float(link.mass[0]) for link in links)
    assert state(topics).inertia_total.inertia == hand.inertia
    inertia = np.diag([0.01, 0.02, 0.03])
    assert nodes.call('set_load', mass=2.0, center_of_mass=[0.0, 0.0, 0.2],
                      load_inertia=inertia.flatten()).success
    message = state(topics)
    load, total = message.inertia_load.inertia, message.inertia_total.inertia
    assert (load.m, load.com.z, load.iyy) == (2.0, 0.2, 0.02)
    assert total.m == pytest.approx(hand.inertia.m + 2.0)
    centre = (hand.inertia.m * hand.inertia.com.z + 2.0 * 0.2) / total.m
    assert total.com.z == pytest.approx(centre)
    reduced = hand.inertia.m * 2.0 / total.m
    way = 0.2 - hand.inertia.com.z, hand.inertia.com.y, hand.inertia.com.x
    assert total.ixx == pytest.approx(
        hand.inertia.ixx + 0.01 + reduced * (way[0]**2 + way[1]**2))


def test_a_collision_is_indicated_until_the_arm_has_recovered(sim, nodes, topics):
    """
    The indicator of a joint stays when the push is over (robot_state.h: joint_collision).

    HW-D2.
    """
    sim.simulation.apply_wrench('panda_hand', (0, 0, -100.0))
    sim.run_until(lambda: sim.manager.arm.stopped)
    sim.simulation.apply_wrench('panda_hand', (0, 0, 0))
    sim.step(500)
    message = state(topics)
    assert max(message.collision_indicators.is_joint_collision) == 1.0
    assert np.abs(message.tau_ext_hat_filtered.effort).max() < 1.0
    assert sim.manager.arm.clear_stop() == ''
    sim.step(20)
    assert max(state(topics).collision_indicators.is_joint_collision) == 0.0


@pytest.mark.parametrize(('cause', 'errors'), [
    (None, set()), (Cause('speed', 'x'), {'joint_velocity_violation'}),
    (Cause('position', 'x'), {'joint_position_limits_violation'}),
    (Cause('collision', 'external torque of x'), {'joint_reflex'}),
    (Cause('collision', 'contact of x'), {'cartesian_reflex'}),
    (Cause('injected'), {'joint_reflex'}), (Cause('power'), set())])
def test_causes_are_errors(cause, errors):
    """HW-D2: Each cause of a stop is its error of libfranka."""
    message = errors_of(cause)
    assert {name for name in message.get_fields_and_field_types() if getattr(message, name)} == (
        errors)


def test_the_mode_follows_the_arm(sim):
    """HW-D2: IDLE, MOVE, REFLEX, USER_STOPPED, and OTHER without power."""
    arm = sim.manager.arm
    assert [robot_mode(arm, moving=moving) for moving in (False, True)] == [1, 2]
    sim.protective_stop()
    assert robot_mode(arm, moving=True) == 4
    arm.emergency_stop()
    assert robot_mode(arm, moving=False) == 5
    arm.release_emergency_stop()
    assert robot_mode(arm, moving=False) == 5
    assert arm.clear_stop() == ''
    nodes = Nodes(sim)
    nodes.trigger(None, 'off', lambda: arm.power_to(type(arm.mode).POWER_OFF))
    nodes.call('off')
    assert robot_mode(arm, moving=False) == 0
