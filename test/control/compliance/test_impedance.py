# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The Cartesian controller against the physics: it holds, moves, yields and presses."""

import mujoco
import numpy as np
import pytest

from armsim_ros.config.controllers.compliance import (
    CartesianAdmittanceControllerParameters,
    CartesianControllerParameters,
    RepulsionSettings,
)
from armsim_ros.control.arm_dynamics import ArmDynamics
from armsim_ros.control.compliance.tip_forces import Gains, impedance_torques, JointBounds, Targets
from armsim_ros.model.transforms import rotation_angle

JOINTS = [f'panda_joint{number}' for number in range(1, 8)]


def test_activation_holds_where_the_arm_is(compliant):
    """Nothing moves by more than 2 mm: the drives hold the weight, the targets are the state."""
    arm = compliant()
    start, farthest = arm.place, 0.0
    for _ in range(50):
        arm.run(0.02)
        farthest = max(farthest, float(np.linalg.norm(arm.place - start)))
    assert farthest < 0.002
    assert arm.events == []


def test_a_target_is_reached(compliant):
    """A tenth of a metre away, the tip ends within 5 mm and 0.03 rad."""
    arm = compliant()
    start = arm.tip
    goal = arm.place + np.array((0.06, 0.06, -0.05))
    assert arm.aim(goal) == ''
    arm.run(3.0)
    assert np.linalg.norm(arm.place - goal) < 0.005
    assert rotation_angle(start[:3, :3], arm.tip[:3, :3]) < 0.03


@pytest.mark.parametrize('axis', [0, 2])
def test_it_yields_like_a_spring(compliant, axis):
    """Ten newtons on 400 N/m: 25 mm, to a tenth."""
    arm = compliant()
    arm.set(task__k_pos_x=400.0, task__k_pos_y=400.0, task__k_pos_z=400.0)
    arm.run(0.5)
    body, start, force = arm.plant.link_body('panda_hand_tcp'), arm.place, 10.0 * np.eye(3)[axis]
    data = arm.plant.mujoco_data
    data.xfrc_applied[body] = (*force, *np.cross(start - data.xipos[body], force))
    arm.run(2.0)
    way = arm.place - start
    assert way[axis] == pytest.approx(0.025, rel=0.1)
    assert np.linalg.norm(np.delete(way, axis)) < 0.0025


def test_it_presses_with_the_requested_force(compliant):
    """Five newtons downwards, without a spring along z: the floor bears five newtons."""
    arm = compliant()
    while arm.place[2] > 0.05:
        arm.aim((*arm.place[:2], max(0.04, arm.place[2] - 0.08)))
        arm.run(0.6)
    arm.set(task__k_pos_z=0.0)
    arm.controller.receive_wrench((0.0, 0.0, -5.0, 0.0, 0.0, 0.0))
    arm.run(2.5)
    model, data, force = arm.plant.mujoco_model, arm.plant.mujoco_data, np.empty(6)
    pressed = 0.0
    for contact in range(data.ncon):
        mujoco.mj_contactForce(model, data, contact, force)
        pressed += force[0]
    assert pressed == pytest.approx(5.0, rel=0.2)


@pytest.mark.parametrize('projector', ['kinematic', 'dynamic'])
def test_the_posture_changes_without_the_tip(compliant, projector):
    """Another posture, by the joints' names in any order, leaves the tip within 5 mm."""
    arm = compliant()
    arm.set(nullspace__projector_type=projector, nullspace__stiffness=5.0)
    start, state = arm.place, arm.plant.state
    before = state.position[:7].copy()
    names, goal = JOINTS[::-1], before + 0.3 * (np.eye(7)[0] - np.eye(7)[2])
    assert arm.controller.receive_joints(names, goal[::-1], ()) == ''
    arm.run(3.0)
    assert np.linalg.norm(arm.place - start) < 0.005
    assert state.position[0] - before[0] > 0.05


def test_joints_are_controlled_without_a_projector(compliant):
    """With all stiffness of the tip at 0 the posture is what the arm follows."""
    arm = compliant('joint_impedance_controller')
    goal = arm.plant.state.position[:7] + 0.3 * np.eye(7)[0] + 0.2 * np.eye(7)[3]
    arm.controller.receive_joints(JOINTS, goal, ())
    arm.run(3.0)
    np.testing.assert_allclose(arm.plant.state.position[:7], goal, atol=0.02)


@pytest.mark.parametrize(('kind', 'damping', 'expected'), [
    (CartesianControllerParameters, 0.0, 10.0),
    (CartesianControllerParameters, 3.0, 3.0),
    (CartesianAdmittanceControllerParameters, 0.0, 0.0),
    (CartesianAdmittanceControllerParameters, -1.0, 10.0),
])
def test_damping_of_the_posture(kind, damping, expected):
    """Re-enacts cartesian_controller.cpp, setStiffnessAndDamping: 0 is critical damping there."""
    parameters = kind(joints=('a', 'b'), end_effector_frame='tip', nullspace={
        'stiffness': 25.0, 'damping': damping})
    np.testing.assert_allclose(Gains.of(parameters).posture_damping, [expected] * 2)


def test_operational_space(compliant):
    """Gains scaled by the tip's inertia reach a target, too."""
    arm = compliant()
    arm.set(use_operational_space=True, use_local_jacobian=True, use_coriolis_compensation=True,
            operational_space_regularization=0.001)
    goal = arm.place + np.array((0.05, 0.05, 0.0))
    arm.aim(goal)
    arm.run(3.0)
    assert np.linalg.norm(arm.place - goal) < 0.01


def test_it_holds_without_targets_after_the_timeout(compliant):
    """A wrench that nobody renews ends; the arm stays where it is then."""
    arm = compliant(command_timeout=0.2)
    arm.controller.receive_wrench((0.0, 0.0, 15.0, 0.0, 0.0, 0.0))
    arm.run(1.0)
    place = arm.place
    arm.run(1.0)
    assert np.linalg.norm(arm.place - place) < 0.002


def test_the_admittance_yields_to_what_is_measured(compliant):
    """Five newtons in the sensor's axes, on 200 N/m: 25 mm along the base's x."""
    arm = compliant('cartesian_admittance_controller')
    start, turn = arm.place, arm.plant.link_pose('panda_hand')[:3, :3]
    assert arm.controller.receive_measured((*(turn.T @ (5.0, 0.0, 0.0)), 0.0, 0.0, 0.0)) == ''
    arm.run(2.0)
    np.testing.assert_allclose(arm.place - start, (0.025, 0.0, 0.0), atol=0.0025)


def test_a_variable_stiffness_of_the_admittance(compliant):
    """Four hundred newtons per metre instead of two hundred halve the way."""
    arm = compliant('cartesian_admittance_controller')
    turn, start = arm.plant.link_pose('panda_hand')[:3, :3], arm.place
    arm.controller.receive_yielding_stiffness((400.0, 400.0, 400.0, 10.0, 10.0, 10.0))
    arm.controller.receive_measured((*(turn.T @ (5.0, 0.0, 0.0)), 0.0, 0.0, 0.0))
    arm.run(2.0)
    assert arm.place[0] - start[0] == pytest.approx(0.0125, rel=0.1)


@pytest.mark.parametrize(('position', 'torque'), [
    (0.85, 0.0), (0.95, -2.5), (1.3, -5.0), (-0.95, 2.5), (-1.3, 5.0)])
def test_a_bound_pushes_back_no_harder_than_requested(compliant, position, torque):
    """The torque grows over the safe range, is constant beyond a bound, and 0 without bounds."""
    arm = compliant()
    dynamics = ArmDynamics(arm.sim.cell.robots[0].model, JOINTS, 'panda_hand_tcp', 'panda_link0')
    positions = np.full(7, position)
    dynamics.move(positions, np.zeros(7))
    bounds = JointBounds(np.full(7, -1.0), np.full(7, 1.0), np.arange(7) < 6)
    parameters = arm.controller.parameters
    targets = Targets(dynamics.pose, positions, np.zeros(7), np.zeros(6))
    torques = [
        impedance_torques(each, Gains.of(each), targets, dynamics, bounds, positions, np.zeros(7))
        for each in (parameters, parameters.model_copy(update={
            'joint_limit_repulsion': RepulsionSettings(enabled=False)}))]
    expected = np.append(np.full(6, torque), 0.0)
    np.testing.assert_allclose(torques[0] - torques[1], expected, atol=1e-9)


def test_a_slide_is_as_inert_as_what_it_carries(panda):
    """Rotor inertia is not included: the inertia of a finger is its mass."""
    model = panda.robots[0].model
    finger = ArmDynamics(model, ['panda_finger_joint1'], 'panda_leftfinger', 'panda_hand')
    mass = model.links['panda_leftfinger'].inertial.mass
    np.testing.assert_allclose(finger.inertia(), [[mass]], rtol=1e-6)
