# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Controllers that others may write to, in chains and alone, seen through ROS alone."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from typing import Any

from control_msgs.msg import AdmittanceControllerState, MultiDOFCommand, MultiDOFStateStamped
from controller_manager_msgs.srv import ListControllers, ListHardwareInterfaces, SwitchController
import numpy as np
import pytest
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.time import Time
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool
from streaming_bench import ARM, beside, JOINTS, MANAGER, NAMESPACE, Streamed
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

statement = pytest.mark.statement

REFERENCES = [f'{joint}/position' for joint in JOINTS]


def switch(arm: Streamed, activate: Any = (), deactivate: Any = ()) -> Any:
    """Switch strictly; returns the answer."""
    return arm.client.call(f'{MANAGER}/switch_controller', SwitchController,
                           SwitchController.Request(
        activate_controllers=list(activate), deactivate_controllers=list(deactivate),
        strictness=2))


def listed(arm: Streamed) -> dict[str, Any]:
    """Return the controllers that the manager lists, by name."""
    answer = arm.client.call(f'{MANAGER}/list_controllers', ListControllers)
    return {one.name: one for one in answer.controller}


@pytest.fixture
def loop(arm: Streamed) -> Iterator[Streamed]:
    """Have the PID controller active by itself."""
    arm.use('loop')
    yield arm
    states = listed(arm)
    if states['chained_arm'].state == 'active':
        assert switch(arm, deactivate=['chained_arm']).ok
    arm.use(ARM)


@pytest.fixture
def chain(loop: Streamed) -> Streamed:
    """Have the trajectory controller before the PID controller active, too."""
    assert switch(loop, activate=['chained_arm']).ok
    return loop


@statement('CHN-1')
def test_trajectory_through_the_chain(chain: Streamed) -> None:
    """A trajectory moves the arm through the following controller."""
    goal = beside(0.2, 0.2)
    point = JointTrajectoryPoint(positions=goal.tolist())
    point.time_from_start.sec = 1
    message = JointTrajectory(joint_names=list(JOINTS), points=[point])
    with chain.publisher(
        JointTrajectory, f'{NAMESPACE}/chained_arm/joint_trajectory'
    ) as publisher:
        chain.stream_until(publisher, message, chain.has_moved(chain.positions, 1e-3), 'it moves')
        chain.until(lambda: np.abs(chain.positions - goal).max() < 5e-3, 'the arm is there')


@statement('CHN-1')
def test_what_is_listed(chain: Streamed) -> None:
    """The lists tell of references, chains and connections."""
    found = listed(chain)
    follower, preceding = found['loop'], found['chained_arm']
    assert (follower.is_chainable, follower.is_chained) == (True, True)
    assert (preceding.is_chainable, preceding.is_chained) == (False, False)
    assert list(follower.reference_interfaces) == REFERENCES
    (connection,) = preceding.chain_connections
    assert connection.name == 'loop'
    assert list(connection.reference_interfaces) == REFERENCES
    answer = chain.client.call(f'{MANAGER}/list_hardware_interfaces', ListHardwareInterfaces)
    shown = {one.name: one for one in answer.command_interfaces}
    assert all(shown[f'loop/{name}'].is_available and shown[f'loop/{name}'].is_claimed
               for name in REFERENCES)


@statement('CHN-1')
def test_refusals(arm: Streamed) -> None:
    """A preceding controller alone does not start; a follower that is used does not stop."""
    assert not switch(arm, activate=['chained_arm'], deactivate=[ARM]).ok
    arm.use('loop')
    assert switch(arm, activate=['chained_arm']).ok
    answer = switch(arm, deactivate=['loop'])
    assert not answer.ok
    assert 'chained_arm' in answer.message
    assert switch(arm, activate=[ARM], deactivate=['loop', 'chained_arm']).ok
    arm.active = ARM


@statement('CHN-1')
def test_own_topic_is_ignored(chain: Streamed) -> None:
    """While another controller writes the references, the topic moves nothing."""
    before, marker = chain.positions, len(chain.program.text)
    message = MultiDOFCommand(dof_names=list(JOINTS), values=beside(0.3).tolist())
    with chain.publisher(MultiDOFCommand, f'{NAMESPACE}/loop/reference') as publisher:
        chain.stream_until(
            publisher, message,
            lambda: 'another controller writes' in chain.program.text[marker:],
            'the reason is told')
    np.testing.assert_allclose(chain.positions, before, atol=1e-3)


def times(collector: Any) -> Any:
    """Return the stamps of messages [s]."""
    return np.array([Time.from_msg(one.header.stamp).nanoseconds * 1e-9
                     for one in collector.messages])


@statement('CHN-2')
def test_pid_by_itself(loop: Streamed) -> None:
    """References come by topic, the state tells of them, feed-forward has its service."""
    goal = beside(0.2)
    command = MultiDOFCommand(dof_names=list(JOINTS), values=goal.tolist())
    topic = f'{NAMESPACE}/loop/controller_state'
    with (
        loop.publisher(MultiDOFCommand, f'{NAMESPACE}/loop/reference') as publisher,
        closing(loop.client.collect(topic, MultiDOFStateStamped)) as states,
        closing(loop.client.collect(f'{NAMESPACE}/joint_states', JointState)) as joints,
    ):
        loop.stream_until(
            publisher, command, lambda: np.abs(loop.positions - goal).max() < 5e-3,
            'the arm is there')
        message = states.wait_for(lambda one: abs(one.dof_states[0].reference - goal[0]) < 1e-9)
        joints.wait_for(lambda one: Time.from_msg(one.header.stamp)
                        >= Time.from_msg(states.messages[-1].header.stamp))
    assert [one.name for one in message.dof_states] == list(JOINTS)
    dofs = np.array([[(dof.feedback, dof.reference - dof.error) for dof in one.dof_states]
                     for one in states.messages])
    np.testing.assert_allclose(dofs[..., 0], dofs[..., 1], atol=1e-9)
    measured = [[dict(zip(one.name, one.position, strict=True))[name] for name in JOINTS]
                for one in joints.messages]
    at, seen = times(states), times(joints)
    gaps = np.diff(seen)[np.clip(np.searchsorted(seen, at) - 1, 0, len(seen) - 2)]
    dense = (gaps < 0.021) & (at >= seen[0]) & (at <= seen[-1])
    assert dense.sum() > 10
    for k, values in enumerate(np.transpose(measured)):
        between = np.interp(at, seen, values)
        np.testing.assert_allclose(dofs[dense, k, 0], between[dense], atol=8e-3)
    answer = loop.client.call(
        f'{NAMESPACE}/loop/set_feedforward_control', SetBool, SetBool.Request(data=False))
    assert answer.success


@pytest.fixture
def soft(arm: Streamed) -> Iterator[Streamed]:
    """Have the admittance controller active; it yields nowhere."""
    arm.use('soft')
    yield arm
    arm.use(ARM)


def yield_along(arm: Streamed, axes: list[bool]) -> None:
    """Choose the axes along which the admittance controller yields."""
    request = SetParameters.Request(
        parameters=[Parameter('admittance.selected_axes', value=axes).to_parameter_msg()])
    (result,) = arm.client.call(f'{NAMESPACE}/soft/set_parameters', SetParameters, request).results
    assert result.successful, result.reason


@statement('CHN-3')
def test_references_pass(soft: Streamed) -> None:
    """Where the arm yields to nothing, it goes where the references lead."""
    goal = beside(0.2, 0.1)
    point = JointTrajectoryPoint(positions=goal.tolist())
    with soft.publisher(JointTrajectoryPoint, f'{NAMESPACE}/soft/joint_references') as publisher:
        soft.stream_until(
            publisher, point, lambda: np.abs(soft.positions - goal).max() < 2e-3,
            'the arm is there')


@statement('CHN-3')
def test_yields_to_its_own_weight(soft: Streamed) -> None:
    """What hangs beyond the sensor pulls the arm down as far as the spring lets it."""
    # The newest alone: they are large, and come in every update.
    states = soft.client.collect(f'{NAMESPACE}/soft/status', AdmittanceControllerState, 1)
    weight = -states.wait(30)[-1].wrench_base.wrench.force.z
    before = soft.positions
    yield_along(soft, [False, False, True, False, False, False])
    try:
        message = states.wait_for(
            lambda one: abs(one.admittance_position.transform.translation.z + weight / 200.0)
            < 0.05 * weight / 200.0)
        assert message.joint_state.name == list(JOINTS)
        offset = np.array(message.joint_state.position)
        soft.until(lambda: np.abs(soft.positions - before - offset).max() < 5e-3,
                   'the arm has yielded')
    finally:
        states.close()
        yield_along(soft, [False] * 6)
