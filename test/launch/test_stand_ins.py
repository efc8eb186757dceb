# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Launch files of Gazebo's packages, which is not installed."""

import pytest

from armsim_ros.launch.main import main


@pytest.mark.parametrize(('package', 'file', 'process'), [
    ('gazebo_ros', 'gazebo', 'gazebo_ros/gzserver name=gzserver'),
    ('ros_gz_sim', 'gz_sim', '-/gz name=gazebo'),
    ('ros_gz_sim', 'ros_gz_sim', '-/gz name=gazebo'),
    ('ros_gz_sim', 'ros_gz_spawn_model', 'ros_gz_sim/create name=create'),
    ('ros_gz_bridge', 'ros_gz_bridge', 'ros_gz_bridge/parameter_bridge name=ros_gz_bridge'),
    ('ros_ign_gazebo', 'ign_gazebo', '-/ign name=gazebo'),
])
def test_launch_files_of_gazebo_are_there_under_their_names(
        package, file, process, entities, capsys):
    """Included or started by its name, a Python file of upstream starts the same processes."""
    included = entities(f"""
        IncludeLaunchDescription(PythonLaunchDescriptionSource(PathJoinSubstitution([
            FindPackageShare('{package}'), 'launch', '{file}.launch.py']))),
    """)
    assert included.status == 0
    assert included.plan[0].startswith(f'process: {process} ')
    assert main(['-n', package, f'{file}.launch.py']) == 0
    assert capsys.readouterr().out.splitlines() == included.plan


def test_the_launch_file_of_foxglove_bridge_passes_all_restrictions_on(capsys):
    """Re-enacts foxglove_bridge_launch.xml: each argument is a parameter of the node."""
    assert main(['-n', 'foxglove_bridge', 'foxglove_bridge_launch.xml',
                 'capabilities:=[connectionGraph]']) == 0
    names = capsys.readouterr().out.strip().rpartition('parameters=')[2].split(',')
    assert {'tls', 'topic_whitelist', 'param_whitelist', 'service_whitelist',
            'client_topic_whitelist', 'capabilities', 'include_hidden', 'asset_uri_allowlist',
            'ignore_unresponsive_param_nodes', 'use_sim_time'} <= set(names)
