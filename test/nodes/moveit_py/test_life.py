# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How a MoveItPy begins and ends."""

from pathlib import Path
import subprocess
import sys
import tempfile

import pytest
import rclpy
from std_msgs.msg import String

from armsim_ros.cli.arguments import UsageError
from armsim_ros.clients.ros_client import RosClient
from armsim_ros.moveit_py import description
from armsim_ros.moveit_py.description import node_arguments
from armsim_ros.nodes import qos
from moveit.planning import MoveItPy
from moveit.utils import create_params_file_from_dict


def pytest_generate_tests(metafunc):
    """Have each way to end as often as ``--endings`` has it."""
    if 'way' in metafunc.fixturenames:
        runs = metafunc.config.getoption('endings', None) or 1
        metafunc.parametrize(('way', 'run'), [
            (way, run) for way in ('plain', 'shutdown', 'error', 'plan', 'execute')
            for run in range(runs)])


@pytest.mark.statement('A5', 'A6', 'B1', 'C8')
def test_a_script_ends_cleanly(way, run, panda, parameters, tmp_path, monkeypatch):
    """With its own status, and without a word of the interpreter or the middleware."""
    panda.hangs = way == 'execute'
    panda.cancelled.clear()
    monkeypatch.setattr(tempfile, 'tempdir', str(tmp_path))
    file = create_params_file_from_dict(parameters, 'moveit_py')
    done = subprocess.run(
        [sys.executable, Path(__file__).with_name('script.py'), way,
         '--ros-args', '--params-file', file],
        capture_output=True, text=True, timeout=60)
    panda.hangs = False
    text = [line for line in done.stderr.splitlines() if not line.startswith('[')]
    if way == 'error':
        assert done.returncode == 1
        assert (text[0].split()[0], text[-1]) == ('Traceback', 'ZeroDivisionError')
        assert len(text) == 4, done.stderr
        return
    assert (done.returncode, text) == (0, []), done.stderr
    assert done.stdout.endswith('the end\n')
    if way in ('plan', 'execute'):
        assert float(done.stdout.split()[2]) < 0.5
    if way == 'execute':
        assert panda.cancelled.wait(1.0)


@pytest.mark.statement('A5', 'B3')
def test_shutdown_leaves_the_scripts_rclpy_alone(panda, parameters):
    """Its context goes on; what was shut down reports that it was."""
    rclpy.init()
    try:
        with_own_node = MoveItPy('short_lived', config_dict=parameters)
        arm = with_own_node.get_planning_component('panda_arm')
        with_own_node.shutdown()
        with_own_node.shutdown()
        assert rclpy.ok()
        with pytest.raises(RuntimeError, match="'short_lived' has been shut down"):
            arm.get_start_state()
    finally:
        rclpy.shutdown()


@pytest.mark.statement('B1')
def test_a_missing_description(monkeypatch):
    """The error names what is missing and where it was searched for."""
    monkeypatch.setattr(description, 'DESCRIPTION_TIMEOUT', 0.1)
    with pytest.raises(RuntimeError, match=r'no robot_description and no .*config_dict'):
        MoveItPy('nothing', config_dict={'a': 1})


@pytest.mark.statement('B1', 'B2')
def test_descriptions_come_from_topics(panda, parameters):
    """Where parameters have none, and from the namespace of the node, like all of its topics."""
    with RosClient('describes') as client:
        for name in ('robot_description', 'robot_description_semantic'):
            publisher = client.node.create_publisher(String, f'/left/{name}', qos.LATCHED)
            publisher.publish(String(data=parameters[name]))
        rest = {name: value for name, value in parameters.items()
                if not name.startswith('robot_description')}
        rest.update(sensors=['cloud'], cloud={
            'sensor_plugin': 'occupancy_map_monitor/PointCloudOctomapUpdater',
            'point_cloud_topic': '/points'})
        made = MoveItPy('by_topic', 'left', config_dict=rest,
                        remappings={'joint_states': '/joint_states'},
                        provide_planning_service=False)
        assert made.get_robot_model().name == 'panda'
        node = made._cpp.node
        assert node.get_namespace() == '/left'
        followed = {each.topic_name for each in node.subscriptions}
        assert {'/points', *(f'/left/{name}' for name in (
            'planning_scene', 'planning_scene_world', 'collision_object',
            'attached_collision_object'))} < followed
        assert '/left/get_planning_scene' not in {each.srv_name for each in node.services}
        made.shutdown()


@pytest.mark.statement('B1')
def test_no_complete_state_in_time(panda, parameters):
    """The error names the topics and the joints."""
    options = {'wait_for_initial_state_timeout': 0.2}
    with pytest.raises(RuntimeError, match=r'/right/joint_states.*panda_joint1'):
        MoveItPy('too_early', config_dict={
            **parameters, 'planning_scene_monitor_options': options},
            remappings=dict.fromkeys(('joint_states', '/joint_states'), '/right/joint_states'))


@pytest.mark.statement('B1')
def test_parameters_of_files(tmp_path):
    """The node's own block wins over a wildcard, a later file over an earlier, a dict over all."""
    first, second = tmp_path / 'first.yaml', tmp_path / 'second.yaml'
    first.write_text('/**: {ros__parameters: {a: 1, b: 1, c: 1, d: {e: 1}}}\n'
                     '/left/arm: {ros__parameters: {b: 2}}\n/other: {ros__parameters: {a: 9}}\n')
    second.write_text('/**: {ros__parameters: {b: 3, c: 3}}\n')
    found = node_arguments('arm', 'left', [str(first), str(second)], {'d': {'e': 5}}, {'x': 'y'})
    assert found.values == {'a': 1, 'b': 2, 'c': 3, 'd.e': 5}
    assert (found.namespace, found.remappings) == ('/left', ['x:=y'])
    with pytest.raises(UsageError, match='absent'):
        node_arguments('arm', '', [str(tmp_path / 'absent.yaml')], None, None)


@pytest.mark.statement('B1')
def test_a_description_by_another_name():
    """planning_scene_monitor_options name the parameter; the others begin with its name."""
    found = node_arguments('arm', '', [], {
        'planning_scene_monitor_options': {'robot_description': 'arm_description'},
        'arm_description': 'urdf', 'arm_description_semantic': 'srdf',
        'arm_description_kinematics': {'all': {'kinematics_solver': 'k'}}}, None)
    assert found.values['robot_description'] == 'urdf'
    assert found.values['robot_description_semantic'] == 'srdf'
    assert found.values['robot_description_kinematics.all.kinematics_solver'] == 'k'
