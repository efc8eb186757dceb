# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What launch files use of other packages: MoveIt's, nav2's, ament's, yaml and xacro."""

import logging

import pytest

from armsim_ros.launch.main import main

HEAD = """
from launch import LaunchDescription
from launch_ros.actions import Node
from moveit_configs_utils import MoveItConfigsBuilder
from moveit_configs_utils import launches
from moveit_configs_utils.launch_utils import add_debuggable_node, DeclareBooleanLaunchArg


def generate_launch_description():
    config = MoveItConfigsBuilder('small')
"""


@pytest.fixture
def moveit(small_package, monkeypatch, capsys):
    """Return a function that runs a body with a builder of the small package dry."""
    monkeypatch.chdir(small_package.src)

    def run(*lines, words=()):
        body = ''.join(f'    {line}\n' for line in lines)
        path = small_package.write('launch/it.launch.py', HEAD.strip() + '\n' + body)
        capsys.readouterr()
        status = main(['-n', str(path), *words])
        out, err = capsys.readouterr()
        assert status == 0, out + err
        return out.splitlines()

    return run


def test_the_builder_collects_what_move_group_needs(moveit):
    """P36 MoveItConfigsBuilder: each part stands under its parameter's name."""
    (line,) = moveit(
        'config.robot_description(mappings={}).trajectory_execution('
        'file_path="config/moveit_controllers.yaml").planning_pipelines(pipelines=["ompl"])',
        'return LaunchDescription([Node(package="moveit_ros_move_group", executable="move_group",'
        ' parameters=[config.to_moveit_configs().to_dict()])])')
    names = line.partition('parameters=')[2].split(',')
    assert {'robot_description', 'robot_description_semantic', 'planning_pipelines', 'ompl',
            'moveit_simple_controller_manager', 'publish_planning_scene'} <= set(names)


@pytest.mark.parametrize(('name', 'expected'), [
    ('rsp', ['process: robot_state_publisher/robot_state_publisher']),
    ('move_group', ['process: moveit_ros_move_group/move_group']),
    ('moveit_rviz', ['unknown: rviz2/rviz2']),
    ('setup_assistant', ['unknown: moveit_setup_assistant/moveit_setup_assistant']),
    ('spawn_controllers', ['process: controller_manager/spawner'] * 2),
    ('static_virtual_joint_tfs', ['process: tf2_ros/static_transform_publisher']),
    ('warehouse_db', ['unknown: warehouse_ros_mongo/mongo_wrapper_ros.py']),
])
def test_the_launches_of_the_setup_assistant(moveit, small_package, name, expected):
    """P36 generate_*_launch: each starts what its file in a MoveIt package starts."""
    small_package.write('config/small.srdf', small_package.SRDF.replace(
        '<group ', '<virtual_joint name="v" type="fixed" parent_frame="world" child_link="base"/>'
        '<group ', 1))
    lines = moveit(f'return launches.generate_{name}_launch(config.to_moveit_configs())')
    assert [line.split(' ')[0] + ' ' + line.split(' ')[1] for line in lines] == expected


def test_a_problem_of_a_file_is_reported_once_a_launch(moveit, small_package):
    """Each included file of a demo reads the package again; its duplicate key is one line."""
    small_package.write('config/joint_limits.yaml',
                        'joint_limits:\n  shoulder: {max_velocity: 1.0, max_velocity: 2.0}\n')
    told = []
    handler = logging.Handler()
    handler.emit = lambda record: told.append(record.getMessage())
    logger = logging.getLogger('launch.moveit_configs_utils')
    logger.addHandler(handler)
    try:
        for launches in (1, 2):  # the next launch reports it again
            moveit('config.to_moveit_configs()',
                   'MoveItConfigsBuilder("small").to_moveit_configs()',
                   'return LaunchDescription()')
            assert sum('max_velocity' in text for text in told) == launches
    finally:
        logger.removeHandler(handler)


def test_a_demo_is_made_of_the_packages_own_files(moveit, small_package):
    """P36 generate_demo_launch: descriptions, move_group, the control node, then spawners."""
    for name in ('rsp', 'move_group', 'moveit_rviz', 'warehouse_db', 'spawn_controllers'):
        small_package.write(f'launch/{name}.launch.py', HEAD.strip()
                            + f'\n    return launches.generate_{name}_launch('
                            'config.to_moveit_configs())\n')
    lines = moveit('return launches.generate_demo_launch(config.to_moveit_configs())',
                   words=['use_rviz:=false'])
    assert [line.split(' ')[1].partition('/')[2] for line in lines] == [
        'robot_state_publisher', 'move_group', 'ros2_control_node', 'spawner', 'spawner']


def test_a_debuggable_node_and_its_argument(moveit):
    """P36 add_debuggable_node, DeclareBooleanLaunchArg: one node, in a debugger where asked."""
    lines = moveit(
        'made = LaunchDescription([DeclareBooleanLaunchArg("debug", default_value=False)])',
        'add_debuggable_node(made, package="tf2_ros", executable="static_transform_publisher", '
        'name="it")',
        'return made')
    assert lines == ['process: tf2_ros/static_transform_publisher name=it ns=/ parameters=']


def test_parameters_collected_from_files(dry, workspace):
    """P36 launch_param_builder: YAML, texts, xacro and single values make one dictionary."""
    (workspace / 'config/a.yaml').write_text('speed: 1.5\n')
    (workspace / 'config/b.txt').write_text('text')
    (workspace / 'config/c.xacro').write_text('<robot name="r"/>')
    said = dry("""
        from launch import LaunchDescription
        from launch.actions import LogInfo
        from launch_param_builder import ParameterBuilder, load_yaml

        def generate_launch_description():
            made = (ParameterBuilder('mine').yaml('config/a.yaml', 'block')
                    .file_parameter('text', 'config/b.txt').xacro_parameter('x', 'config/c.xacro')
                    .parameter('one', 1).to_dict())
            return LaunchDescription([LogInfo(msg=f"{made['block']} {made['text']} {made['one']} "
                                              f"{'<robot' in made['x']}")])
    """)
    assert "{'speed': 1.5} text 1 True" in said.errors


def test_parameter_files_that_are_rewritten(entities, workspace):
    """P36 RewrittenYaml, ReplaceString: the file that a node gets has other values."""
    (workspace / 'config/p.yaml').write_text('arm:\n  ros__parameters: {rate: 1, name: <who>}\n')
    said = entities("""
        OpaqueFunction(function=lambda context: [LogInfo(msg=Path(RewrittenYaml(
            ReplaceString(source, {'<who>': 'anna'}), {'rate': '5'}, root_key='left',
            convert_types=True).perform(context)).read_text())]),
    """, before="""
import os
from pathlib import Path
from ament_index_python.packages import get_package_share_directory, get_package_share_path
from nav2_common.launch import ReplaceString, RewrittenYaml

source = os.path.join(get_package_share_directory('mine'), 'config', 'p.yaml')
assert get_package_share_path('mine') / 'config' / 'p.yaml' == Path(source)
""")
    for line in ('left:', 'rate: 5', 'name: anna'):
        assert line in said.errors


def test_xacro_as_a_module(dry, workspace):
    """P36 xacro, yaml: a file may process its robot by itself."""
    (workspace / 'config/r.xacro').write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="n" '
        'default="a"/><link name="$(arg n)"/></robot>')
    said = dry("""
        import os, xacro, yaml
        from ament_index_python.packages import get_package_share_directory
        from launch import LaunchDescription
        from launch.actions import LogInfo

        def generate_launch_description():
            file = os.path.join(get_package_share_directory('mine'), 'config', 'r.xacro')
            text = xacro.process_file(file, mappings=yaml.safe_load('{n: b}')).toxml()
            return LaunchDescription([LogInfo(msg=text)])
    """)
    assert '<link name="b"/>' in said.errors
