# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The same package through bringup and through its own launch file is the same robot."""

from textwrap import dedent

from controller_manager_msgs.srv import (
    ListControllers,
    ListHardwareComponents,
    ListHardwareInterfaces,
)
import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from armsim_ros.clients.controller_manager import ParameterClient
from armsim_ros.testing.program import private_domain, start_program
from armsim_ros.testing.robot_user import user_of

LAUNCH = """
from launch import LaunchDescription
from launch_ros.actions import Node
from moveit_configs_utils import MoveItConfigsBuilder
from moveit_configs_utils.launches import generate_move_group_launch
from moveit_configs_utils.launches import generate_spawn_controllers_launch


def generate_launch_description():
    configs = MoveItConfigsBuilder('small').to_moveit_configs()
    return LaunchDescription([
        Node(package='robot_state_publisher', executable='robot_state_publisher',
             parameters=[configs.robot_description]),
        Node(package='controller_manager', executable='ros2_control_node', parameters=[
            str(configs.package_path / 'config/ros2_controllers.yaml')],
            remappings=[('~/robot_description', '/robot_description')]),
        *generate_move_group_launch(configs).entities,
        *generate_spawn_controllers_launch(configs).entities])
"""
#: Plans keep to less than what the URDF allows, which is 2 rad.
LIMITS = """
joint_limits:
  elbow: {has_position_limits: true, min_position: -1.0, max_position: 1.0,
          has_velocity_limits: true, max_velocity: 0.5,
          has_acceleration_limits: true, max_acceleration: 1.0}
  shoulder: {has_acceleration_limits: true, max_acceleration: 1.0}
"""
NODES = ('arm_controller', 'joint_state_broadcaster', 'controller_manager', 'move_group',
         'robot_state_publisher')
LISTS = {'list_controllers': ListControllers, 'list_hardware_components': ListHardwareComponents,
         'list_hardware_interfaces': ListHardwareInterfaces}
JOINTS = ['shoulder', 'elbow']


@pytest.fixture
def seen(small_package, monkeypatch):
    """Return a function that starts a program, and returns what a client sees of the robot."""
    small_package.write('launch/robot.launch.py', dedent(LAUNCH))
    small_package.write('config/joint_limits.yaml', LIMITS)
    small_package.write(
        'config/ros2_controllers.yaml', small_package.ROS2.replace('rate: 500', 'rate: 100'))
    monkeypatch.chdir(small_package.src)

    def picture(*words, ready):
        with (
            private_domain() as domain,
            start_program(words[0], domain, *words[1:]) as program,
            user_of(program, domain, '') as user,
        ):
            program.wait_for_line(ready, 60.0)
            client = user.client
            found = {
                'joints': list(client.collect('/joint_states', JointState).wait(1)[0].name),
                'description': client.latched('/robot_description', String).data,
                **{name: client.call(f'/controller_manager/{name}', kind)
                   for name, kind in LISTS.items()},
            }
            found['list_controllers'].controller.sort(key=lambda one: one.name)
            parameters = {node: ParameterClient(client, f'/{node}') for node in NODES}
            found.update((node, {name: one.get(name) for name in one.names()})
                         for node, one in parameters.items())
            plan = user.move_group.plan
            points = plan(
                'arm', {'shoulder': 0.0, 'elbow': 1.5}).planned_trajectory.joint_trajectory.points
            last = points[-1].time_from_start
            found['planned'] = [round(value, 2) for value in (
                *points[-1].positions, last.sec + last.nanosec * 1e-9)]
            outcome = user.send('arm_controller', JOINTS, [(2.0, [0.0, 2.5])])
            found['beyond'] = (outcome.status, outcome.error_code)
            user.wait_until_still()
            found['end'] = {name: round(value, 2) for name, value in user.positions().items()}
            found['start'] = plan('arm', {'shoulder': 0.1, 'elbow': 0.5}).error_code.val
            found['topics'] = sorted(client.node.get_topic_names_and_types())
            return found

    return picture


def test_one_robot(seen, small_package):
    """
    Joints, controllers, hardware, topics, parameters, ranges, answers and plans are equal.

    The drives reach the end of the URDF's range, where no plan may start or end.
    """
    own = seen('bringup', f'robot:={small_package.folder}', ready='You can start planning')
    launched = seen('launch', 'small_moveit_config', 'robot.launch.py',
                    ready=r'\[spawner-\d+\] .*active: arm_controller')
    assert own['move_group']['pilz_industrial_motion_planner.planning_plugins'] == [
        'pilz_industrial_motion_planner/CommandPlanner']
    for node in NODES:
        common = own[node].keys() & launched[node].keys() - {'use_sim_time'}
        assert {name: own[node][name] for name in common} == {
            name: launched[node][name] for name in common}
        assert common >= {'arm_controller': {'joints'}, 'move_group': {
            'robot_description_planning.joint_limits.elbow.max_velocity'}}.get(node, set())
        del own[node], launched[node]
    assert own == launched
    assert own['end']['elbow'] == pytest.approx(2.0, abs=0.01)
    assert own['planned'][1] == pytest.approx(1.0, abs=0.01)
    assert own['start'] != 1
