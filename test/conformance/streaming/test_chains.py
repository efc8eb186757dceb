# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A trajectory controller before a PID controller, seen through ROS alone."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from control_msgs.msg import MultiDOFCommand, MultiDOFStateStamped
from controller_manager_msgs.srv import (
    ListControllers,
    ListHardwareInterfaces,
    SwitchController,
)
import numpy as np
import pytest
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
        strictness=2))  # fmt: skip


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
    publisher = chain.client.node.create_publisher(
        JointTrajectory, f'{NAMESPACE}/chained_arm/joint_trajectory', 10)
    chain.until(lambda: publisher.get_subscription_count() > 0, 'the topic is heard')
    point = JointTrajectoryPoint(positions=goal.tolist())
    point.time_from_start.sec = 1
    publisher.publish(JointTrajectory(joint_names=list(JOINTS), points=[point]))
    chain.until(lambda: np.abs(chain.positions - goal).max() < 5e-3, 'the arm is there')
    chain.client.in_executor(lambda: chain.client.node.destroy_publisher(publisher))


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
               for name in REFERENCES)  # fmt: skip


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
    publisher = chain.client.node.create_publisher(
        MultiDOFCommand, f'{NAMESPACE}/loop/reference', 10)
    chain.until(lambda: publisher.get_subscription_count() > 0, 'the topic is heard')
    message = MultiDOFCommand(dof_names=list(JOINTS), values=beside(0.3).tolist())
    chain.stream(publisher, message, 0.2, 0.05)
    chain.until(lambda: 'another controller writes' in chain.program.text[marker:],
                'the reason is told')  # fmt: skip
    np.testing.assert_allclose(chain.positions, before, atol=1e-3)
    chain.client.in_executor(lambda: chain.client.node.destroy_publisher(publisher))


@statement('CHN-2')
def test_pid_by_itself(loop: Streamed) -> None:
    """References come by topic, the state tells of them, feed-forward has its service."""
    states = loop.client.collect(f'{NAMESPACE}/loop/controller_state', MultiDOFStateStamped)
    publisher = loop.client.node.create_publisher(
        MultiDOFCommand, f'{NAMESPACE}/loop/reference', 10)
    loop.until(lambda: publisher.get_subscription_count() > 0, 'the topic is heard')
    goal = beside(0.2)
    loop.stream(publisher, MultiDOFCommand(dof_names=list(JOINTS), values=goal.tolist()), 0.1)
    loop.until(lambda: np.abs(loop.positions - goal).max() < 5e-3, 'the arm is there')
    message = states.wait_for(lambda one: abs(one.dof_states[0].reference - goal[0]) < 1e-9)
    assert [one.name for one in message.dof_states] == list(JOINTS)
    answer = loop.client.call(
        f'{NAMESPACE}/loop/set_feedforward_control', SetBool, SetBool.Request(data=False))
    assert answer.success
    loop.client.in_executor(lambda: loop.client.node.destroy_publisher(publisher))
