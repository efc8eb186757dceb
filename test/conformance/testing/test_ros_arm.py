# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the arm of mode ``process`` requests of the programs, which are action servers here."""

from collections import defaultdict
from pathlib import Path

from moveit_msgs.action import MoveGroup
from moveit_msgs.msg import MoveItErrorCodes
import pytest
from rclpy.action import ActionServer
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.node import SpinningNode
from armsim_ros.errors import ModelError
from armsim_ros.testing.program import private_domain
from armsim_ros.testing.robot_user import RobotUser
from armsim_ros.testing.ros_arm import RosArm
from armsim_ros.testing.stacks import built_cell

HAND = Path(__file__).parents[2] / 'support' / 'robots' / 'hand'


class Programs:
    """
    The endpoints of a simulation and of move_group, which note what is requested.

    :param domain: ROS domain id.
    """

    def __init__(self, domain):
        #: Action -> goals that have arrived.
        self.goals = defaultdict(list)
        self.code = MoveItErrorCodes.SUCCESS
        self._spinning = SpinningNode('programs', domain=domain)
        self._kept = []
        self._spinning.in_thread(self._make).result(10.0)

    def close(self):
        """Leave the graph."""
        self._spinning.close()

    def publish_states(self, namespace, joints):
        """Publish joint states of a robot at rest."""
        node = self._spinning.node

        def make():
            states = node.create_publisher(JointState, f'{namespace}/joint_states', 10)
            state = JointState(name=joints, position=[0.0] * len(joints))
            self._kept.append(node.create_timer(0.02, lambda: states.publish(state)))

        self._spinning.in_thread(make).result(10.0)

    def _make(self):
        node = self._spinning.node
        self._kept += [
            node.create_service(Trigger, '/simulation/sync', self._sync),
            ActionServer(node, MoveGroup, '/move_action', self._move)]

    def _sync(self, _, response):
        response.message = '0'
        return response

    def _move(self, handle):
        self.goals['move_action'].append(handle.request)
        result = MoveGroup.Result()
        result.error_code.val = self.code
        handle.succeed()
        return result


@pytest.fixture(scope='module')
def domain():
    """Lease a ROS domain."""
    with private_domain() as leased:
        yield leased


@pytest.fixture
def programs(domain):
    """Return the endpoints of programs."""
    served = Programs(domain)
    yield served
    served.close()


@pytest.fixture
def arm_of(domain, programs):
    """Return a function that gives the arm of a robot whose programs these endpoints are."""
    with ClientNode(domain, 'user') as client:
        def arm(robot):
            cell = built_cell(str(robot), None, {})
            namespace = cell.settings.namespace
            programs.publish_states(namespace, list(cell.model.active_joints))
            return RosArm(RobotUser(client, None, namespace), cell)

        yield arm


def test_joints_are_those_of_the_first_group(arm_of):
    """They are in the model's order, whichever group has the first named state."""
    assert arm_of(HAND).joints == ('carriage_x', 'carriage_z')


def test_a_named_state_is_that_of_the_group(arm_of, programs):
    """Groups may have states of the same name."""
    arm = arm_of('two_bots')
    arm.move_to('ready', group='right_arm')
    arm.move_to('ready')
    requests = [goal.request for goal in programs.goals['move_action']]
    assert [request.group_name for request in requests] == ['right_arm', 'left_arm']
    for request, side in zip(requests, ('right', 'left'), strict=True):
        moved = request.goal_constraints[0].joint_constraints
        assert [joint.joint_name for joint in moved] == [f'{side}_joint{i}' for i in range(1, 6)]


def test_a_state_of_another_group_is_refused(arm_of):
    """Nothing else is planned to instead."""
    arm = arm_of('panda')
    with pytest.raises(ModelError, match=r"'panda_arm' has no named state 'open'.*ready, extend"):
        arm.move_to('open')
