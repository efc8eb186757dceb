# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A Panda whose controller jumps to the end of a trajectory, and a script's MoveItPy beside it."""

from contextlib import closing, contextmanager, suppress
from pathlib import Path
import threading

from control_msgs.action import FollowJointTrajectory
import pytest
import rclpy
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
import yaml

from armsim_ros.config.robot_folder import find_files
from armsim_ros.model.description.xacro_text import read_description
from moveit.planning import MoveItPy

CONTROLLER = 'panda_arm_controller'
JOINTS = tuple(f'panda_joint{k}' for k in range(1, 8))


def pytest_configure(config):
    """Register the mark that names a statement."""
    config.addinivalue_line('markers', 'statement(*names): the statements that a test checks')


def pytest_addoption(parser):
    """Add what makes the test of a script's end longer."""
    parser.addoption('--endings', type=int, default=1, help='runs of a script for each way to end')


class Panda:
    """Joint states, and the action of a controller that obeys at once, or hangs."""

    def __init__(self):
        self.context = Context()
        rclpy.init(context=self.context, signal_handler_options=SignalHandlerOptions.NO)
        self.positions = dict.fromkeys(
            (*JOINTS, 'panda_finger_joint1', 'panda_finger_joint2'), 0.0)
        self.positions.update(panda_joint2=-0.785, panda_joint4=-2.356, panda_joint6=1.571)
        self.hangs, self.goals, self.cancelled = False, [], threading.Event()
        self.node = Node('fake_panda', context=self.context)
        group = ReentrantCallbackGroup()
        self.publisher = self.node.create_publisher(JointState, '/joint_states', 10)
        self.node.create_timer(0.02, self.publish, callback_group=group)
        self.server = ActionServer(
            self.node, FollowJointTrajectory, f'/{CONTROLLER}/follow_joint_trajectory',
            self.execute, callback_group=group,
            cancel_callback=lambda _: CancelResponse.ACCEPT)
        self.executor = MultiThreadedExecutor(2, context=self.context)
        self.executor.add_node(self.node)
        self.thread = threading.Thread(target=self.spin, daemon=True)
        self.thread.start()

    def spin(self):
        with suppress(ExternalShutdownException):
            self.executor.spin()

    def publish(self):
        message = JointState(name=list(self.positions), position=list(self.positions.values()))
        message.velocity = [0.0] * len(self.positions)
        message.header.stamp = self.node.get_clock().now().to_msg()
        self.publisher.publish(message)

    def execute(self, goal):
        trajectory = goal.request.trajectory
        self.goals.append(trajectory)
        if self.hangs:
            waiting = threading.Event()
            while not goal.is_cancel_requested and self.context.ok():
                waiting.wait(0.01)
            self.cancelled.set()
            goal.canceled()
            return FollowJointTrajectory.Result()
        self.positions.update(zip(
            trajectory.joint_names, trajectory.points[-1].positions, strict=True))
        goal.succeed()
        return FollowJointTrajectory.Result()

    def close(self):
        self.context.try_shutdown()
        self.thread.join(5.0)
        self.server.destroy()
        self.node.destroy_node()


def panda_parameters():
    """Return the parameters that a launch file would give the node of a script."""
    files = find_files('panda')
    kinematics, limits, controllers = (
        yaml.safe_load((files.folder / name).read_text())
        for name in ('kinematics.yaml', 'joint_limits.yaml', 'moveit_controllers.yaml'))
    return {
        'robot_description': read_description(files.urdf_file),
        'robot_description_semantic': files.srdf_file.read_text(),
        'robot_description_kinematics': kinematics,
        'robot_description_planning': limits,
        **controllers,
        'planning_pipelines': {'pipeline_names': [
            'ompl', 'pilz_industrial_motion_planner', 'chomp']},
        'chomp': {'planning_plugins': ['chomp_interface/CHOMPPlanner']},
        'ompl': {'planning_plugins': ['ompl_interface/OMPLPlanner'], 'planning_seed': 7},
        'plan_request_params': {'planning_attempts': 1, 'planning_pipeline': 'ompl'},
        'slow': {'plan_request_params': {
            'planning_pipeline': 'ompl', 'max_velocity_scaling_factor': 0.1,
            'planning_time': 2}},
        'lin': {'plan_request_params': {
            'planning_pipeline': 'pilz_industrial_motion_planner', 'planner_id': 'PTP'}},
        'other': {'plan_request_params': {'planning_pipeline': 'chomp'}},
        'planning_scene_monitor_options': {
            'name': 'monitor', 'wait_for_initial_state_timeout': 10.0},
    }


@pytest.fixture(scope='module')
def panda(shared_in_folder):
    """Run the robot; other folders' tests have the graph without it."""
    return shared_in_folder(lambda: closing(Panda()), Path(__file__).parent, 'panda')


@pytest.fixture(scope='session')
def parameters():
    """Return the parameters of the node."""
    return panda_parameters()


@contextmanager
def running_moveit(parameters):
    """Run a MoveItPy."""
    made = MoveItPy('moveit_py', config_dict=parameters)
    try:
        yield made
    finally:
        made.shutdown()


@pytest.fixture(scope='module')
def shared(panda, parameters, shared_in_folder):
    """Run a MoveItPy for all tests."""
    return shared_in_folder(lambda: running_moveit(parameters), Path(__file__).parent, 'moveit')


@pytest.fixture
def moveit(shared, panda):
    """Return a MoveItPy whose scene is empty, beside a robot that obeys."""
    panda.hangs = False
    panda.goals.clear()
    panda.cancelled.clear()
    yield shared
    panda.hangs = False
    with shared.get_planning_scene_monitor().read_write() as scene:
        scene.remove_all_collision_objects()


@pytest.fixture
def arm(moveit):
    """Return what plans for the arm."""
    return moveit.get_planning_component('panda_arm')


@pytest.fixture
def monitor(moveit):
    """Return what keeps the scene."""
    return moveit.get_planning_scene_monitor()
