# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the arguments of Gazebo's and MoveIt's launch files are called here."""

from __future__ import annotations

from collections.abc import Mapping

_NO_WINDOW = 'the simulation has no window; watch it with RViz'
_RVIZ = 'start RViz yourself: rviz2, panel MotionPlanning'
_DEBUGGER = "to debug a program, start it alone: 'armsim move_group', 'armsim simulation'"
_OMPL = 'a key of ompl_planning.yaml'
_EXECUTION = 'a key of trajectory_execution.yaml'
_PLACE = 'placement: {xyz: [...], rpy: [...]} in simulation.yaml'
_SCENE = 'the planning scene is always published'
_ALL = 'all services and actions are always there'

#: Argument of a launch file or flag of a spawner -> what to use in its place.
REPLACED_ARGUMENTS: Mapping[str, str] = {
    'gui': _NO_WINDOW,
    'gazebo_gui': _NO_WINDOW,
    'headless': _NO_WINDOW,
    'verbose': 'messages are always complete',
    'recording': "record with 'ros2 bag record'",
    'debug': _DEBUGGER,
    'info': _DEBUGGER,
    'launch_prefix': _DEBUGGER,
    'command_args': _DEBUGGER,
    'world_name': 'world:=NAME|FILE',
    'model': 'robot:=NAME|DIR',
    'robot_name': 'robot:=NAME|DIR',
    'urdf_path': 'urdf:=FILE',
    'urdf_file': 'urdf:=FILE',
    'load_robot_description': 'the robot description is always published',
    'J': 'initial_positions:=JOINT=VALUE,...',
    'unpause': 'the physics runs from the start; paused:=true holds it',
    'R': _PLACE,
    'P': _PLACE,
    'Y': _PLACE,
    'roll': _PLACE,
    'pitch': _PLACE,
    'yaw': _PLACE,
    'ns': 'namespace:=NS',
    'tf_prefix': 'frames have the names of the URDF',
    'rviz': _RVIZ,
    'use_rviz': _RVIZ,
    'display': _RVIZ,
    'rviz_config': _RVIZ,
    'use_gui': 'joint states come from the simulation',
    'fake_execution': 'the simulated arm always executes',
    'allow_trajectory_execution': _EXECUTION,
    'moveit_manage_controllers': _EXECUTION,
    'moveit_controller_manager': _EXECUTION,
    'jiggle_fraction': _OMPL,
    'pipeline': 'the built-in pipeline plans for each',
    'max_safe_path_cost': 'planning with sensing is not part of ROS 2',
    'moveit_sensor_manager': 'sensors are those of sensors_3d.yaml',
    'publish_monitored_planning_scene': _SCENE,
    'capabilities': _ALL,
    'disable_capabilities': _ALL,
}

#: Arguments whose usual value asks for what happens anyhow -> that value.
HARMLESS_VALUES: Mapping[str, bool] = {
    'gui': False,
    'gazebo_gui': False,
    'headless': True,
    'debug': False,
    'info': False,
    'recording': False,
    'unpause': True,
    'rviz': False,
    'use_rviz': False,
    'display': False,
    'use_gui': False,
    'fake_execution': False,
    'publish_monitored_planning_scene': True,
    'load_robot_description': True,
}

#: Flags of Gazebo's spawn_model -> the argument in their place.
SPAWNER_FLAGS: Mapping[str, str] = {
    '-x': 'x:=METRES',
    '-y': 'y:=METRES',
    '-z': 'z:=METRES',
    '-J': REPLACED_ARGUMENTS['J'],
    '-R': _PLACE,
    '-P': _PLACE,
    '-Y': _PLACE,
    '-model': REPLACED_ARGUMENTS['model'],
    '-urdf': 'urdf:=FILE',
    '-file': 'urdf:=FILE',
    '-param': 'urdf:=FILE',
    '-unpause': REPLACED_ARGUMENTS['unpause'],
    '-robot_namespace': 'namespace:=NS',
}
