# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 param`` and ``ros2 control``, beyond what upstream.yaml has."""

import yaml

NODE = '/sunday/arm_joint_controller'
MANAGER = ('-c', '/sunday/controller_manager')


def test_parameters_are_listed_in_order(ros2):
    """With their types, too (ros2param/verb/list.py)."""
    names = ros2('param', 'list', '/move_group').lines
    assert names == sorted(names)
    typed = ros2('param', 'list', '/move_group', '--param-type').lines
    assert [line.partition(' (type: ')[0] for line in typed] == names


def test_a_missing_parameter_is_hinted_at(ros2):
    """On standard error; the status is upstream's 0 or 1."""
    assert "did you mean 'use_sim_time'?" in ros2('param', 'get', '/move_group', 'use_sim_tim').err


def test_a_dump_is_a_parameter_file(ros2):
    """The text of dump is YAML for --params-file and load (ros2param/verb/dump.py)."""
    values = yaml.safe_load(ros2('param', 'dump', NODE).out)[NODE]['ros__parameters']
    assert values['joints'][0] == 'joint_1'


def test_the_only_manager_is_taken(ros2):
    """Without -c, with a line on standard error."""
    done = ros2('control', 'list_controllers')
    assert (done.status, done.err) == (
        0, 'using the controller manager /sunday/controller_manager\n')


def test_a_missing_controller_is_hinted_at(ros2):
    """The most similar one that is loaded."""
    done = ros2('control', 'set_controller_state', 'arm_joint_controler', 'active', *MANAGER)
    assert (done.status, done.err) == (1, 'controller arm_joint_controler does not seem to be '
                                          "loaded; did you mean 'arm_joint_controller'?\n")
