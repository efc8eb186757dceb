# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the arm of mode ``process`` requests of the programs, which are action servers here."""

from collections import defaultdict
from pathlib import Path

from control_msgs.action import FollowJointTrajectory, GripperCommand
from moveit_msgs.action import MoveGroup
from moveit_msgs.msg import MoveItErrorCodes
import pytest
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.node import SpinningNode
from armsim_ros.errors import ControllerError, ModelError, PlanningError
from armsim_ros.nodes import qos
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
        self.code, self.planned = MoveItErrorCodes.SUCCESS, True
        #: Goals that are let go on until they are cancelled, and those that were.
        self.lasting, self.cancelled = set(), []
        self._tick = Future()
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
            node.create_timer(0.02, self._pass_time),
            node.create_service(Trigger, '/simulation/sync', self._sync),
            ActionServer(node, MoveGroup, '/move_action', self._move)]

    def serve(self, kind, name, refusal=''):
        """Serve the action of a controller."""
        node = self._spinning.node

        def answer(goal):
            if not refusal:
                return GoalResponse.ACCEPT
            reasons.publish(String(data=refusal))
            return GoalResponse.REJECT

        async def run(handle):
            self.goals[name].append(handle.request)
            while name in self.lasting and not handle.is_cancel_requested:
                await self._tick
            if handle.is_cancel_requested:
                self.cancelled.append(name)
                handle.canceled()
            else:
                handle.succeed()
            return kind.Result()

        def make():
            self._kept.append(ActionServer(
                node, kind, f'/{name}', run, goal_callback=answer,
                cancel_callback=lambda _: CancelResponse.ACCEPT))
            return node.create_publisher(
                String, f"/{name.partition('/')[0]}/rejected_goals", qos.EVENTS)

        reasons = self._spinning.in_thread(make).result(10.0)

    def _pass_time(self):
        tick, self._tick = self._tick, Future()
        tick.set_result(None)

    def _sync(self, _, response):
        response.message = '0'
        return response

    async def _move(self, handle):
        self.goals['move_action'].append(handle.request)
        while 'move_action' in self.lasting and not handle.is_cancel_requested:
            await self._tick
        result = MoveGroup.Result()
        if self.planned:
            result.planned_trajectory.joint_trajectory.points = [JointTrajectoryPoint()]
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
        def arm(robot, **options):
            cell = built_cell(str(robot), None, {})
            namespace = cell.settings.namespace
            programs.publish_states(namespace, list(cell.model.active_joints))
            return RosArm(RobotUser(client, None, namespace), cell, **options)

        yield arm


ARM, GRIPPER = 'panda_arm_controller/follow_joint_trajectory', 'panda_hand_controller/gripper_cmd'


@pytest.fixture
def panda_with(arm_of, programs):
    """Return a function that gives a panda whose gripper may refuse with a reason."""
    def panda(refusal=''):
        programs.serve(FollowJointTrajectory, ARM)
        programs.serve(GripperCommand, GRIPPER, refusal)
        return arm_of('panda')

    return panda


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


@pytest.mark.parametrize(('code', 'planned', 'error'), [
    (MoveItErrorCodes.TIMED_OUT, False, PlanningError),
    (MoveItErrorCodes.TIMED_OUT, True, ControllerError),
    (MoveItErrorCodes.CONTROL_FAILED, True, ControllerError)])
def test_a_plan_that_is_not_run_to_its_end_is_the_controllers_failure(
    arm_of, programs, code, planned, error
):
    """As in the test's own process; the same code may come from planner and controllers."""
    programs.code, programs.planned = code, planned
    arm = arm_of('panda')
    with pytest.raises(error):
        arm.move_to('ready')


def test_a_motion_is_waited_for_as_long_as_the_test_may_take(arm_of, programs):
    """The time limit of the marker holds for each motion."""
    programs.lasting.add('move_action')
    arm = arm_of('panda', time_limit=0.4)
    with pytest.raises(AssertionError, match=r'no result within 0\.4 s'):
        arm.move_to('ready')
    programs.lasting.clear()


def test_a_trajectory_goes_to_controllers_of_several_kinds(panda_with, programs):
    """A gripper gets its end; joints that follow others are left out, as by move_group."""
    arm = panda_with()
    arm.follow([(1.0, {'panda_joint1': 0.1, 'panda_finger_joint1': 0.03,
                       'panda_finger_joint2': 0.03})])
    (moved,), (closed,) = programs.goals[ARM], programs.goals[GRIPPER]
    assert moved.trajectory.joint_names == ['panda_joint1']
    assert closed.command.position == 0.03


def test_a_trajectory_is_run_by_all_controllers_or_by_none(panda_with, programs):
    """Where one refuses, the others have stopped, and its reason is told."""
    arm = panda_with('the fingers are hot')
    programs.lasting.add(ARM)
    with pytest.raises(ControllerError, match="'panda_hand_controller' refuses: the fingers are"):
        arm.follow([(1.0, {'panda_joint1': 0.1, 'panda_finger_joint1': 0.03})])
    assert programs.cancelled == [ARM]


def test_joints_without_a_controller_move_nothing(panda_with, programs):
    """A joint that the robot lacks is refused before anything is sent."""
    arm = panda_with()
    with pytest.raises(ControllerError, match="names joint 'elbow'"):
        arm.follow([(1.0, {'panda_joint1': 0.1, 'elbow': 0.1})])
    assert not programs.goals


def test_fingers_close_by_the_action_of_their_controller(panda_with, programs):
    """With the effort that is given, to the state of the SRDF."""
    arm = panda_with()
    arm.grasp(12.0)
    (closed,) = programs.goals[GRIPPER]
    assert (closed.command.position, closed.command.max_effort) == (
        arm.finger_state('close')['panda_finger_joint1'], 12.0)
