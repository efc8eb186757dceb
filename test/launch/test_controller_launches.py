# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""controller_manager.launch_utils in launch files, by upstream's launch_utils.py."""

import pytest

from armsim_ros.launch.api import launches as utils
from armsim_ros.launch.api.context import LaunchContext
from armsim_ros.launch.api.ros_node import Node
from armsim_ros.launch.lookup import make_lookup
from armsim_ros.launch.mapping import Mapping
from armsim_ros.launch.names import importable


def spawner_words(description, **values):
    """Return the words of the spawner that a description starts, as a shell passes them."""
    context = LaunchContext()
    *arguments, node = description.entities
    for one in arguments:
        one.execute(context)
    context.launch_configurations.update(values)
    assert isinstance(node, Node)
    (start,) = Mapping(lambda *_: '').decide([(node, node.spec(context))])
    words = list(start.command)
    return words[words.index('spawner') + 1:words.index('--ros-args')], len(arguments)


def test_controllers_of_a_list():
    """The spawner gets names, manager and files; an empty last word is dropped by its shell."""
    words, arguments = spawner_words(utils.generate_controllers_spawner_launch_description(
        ['a', 'b'], ['x.yaml', None], ['--inactive']))
    assert words == ['a', 'b', '--controller-manager', 'controller_manager',
                     '--param-file', 'x.yaml', '--inactive']
    assert arguments == 2


def test_launch_arguments_of_the_spawner():
    """The manager's name and the end are launch arguments."""
    words, _ = spawner_words(utils.generate_load_controller_launch_description('a', 'x.yaml'),
                             controller_manager_name='/left/manager', unload_on_kill='true')
    assert words == ['a', '--controller-manager', '/left/manager', '--param-file', 'x.yaml',
                     '--unload-on-kill']


def test_controllers_of_a_dictionary():
    """Each controller has a file, a list of them, or none."""
    words, _ = spawner_words(utils.generate_controllers_spawner_launch_description_from_dict(
        {'a': 'x.yaml', 'b': ['y.yaml', 'z.yaml'], 'c': None}))
    assert words == ['a', 'b', 'c', '--controller-manager', 'controller_manager', '--param-file',
                     'x.yaml', '--param-file', 'y.yaml', '--param-file', 'z.yaml']


def test_controllers_with_options_of_their_own():
    """Every controller is a block of the spawner's words; there are no launch arguments."""
    words, arguments = spawner_words(utils.generate_spawner_launch_description(
        {'a': {'param_file': ['x.yaml', 'y.yaml'], 'load_only': True},
         'b': {'param_file': 'z.yaml', 'inactive': True, 'ros_args': '"-r p:=q"'},
         'c': {'inactive': False, 'param_file': None}},
        ['--activate-as-group']))
    assert words == ['--controller', 'a', '--param-file', 'x.yaml', '--param-file', 'y.yaml',
                     '--load-only', '--controller', 'b', '--param-file', 'z.yaml', '--inactive',
                     '--controller-ros-args', '-r p:=q', '--controller', 'c',
                     '--activate-as-group']
    assert arguments == 0


@pytest.mark.parametrize(('generate', 'info'), [
    (utils.generate_controllers_spawner_launch_description_from_dict, ['a']),
    (utils.generate_controllers_spawner_launch_description_from_dict, {'a': 1}),
    (utils.generate_spawner_launch_description, ['a']),
    (utils.generate_spawner_launch_description, {'a': {'param_file': 1}}),
    (utils.generate_spawner_launch_description, {'a': {'load_only': 'yes'}}),
    (utils.generate_spawner_launch_description, {'a': {'inactive': 1}}),
    (utils.generate_spawner_launch_description, {'a': {'ros_args': ['-r', 'p:=q']}})])
def test_wrong_kinds(generate, info):
    """A value of another kind is a ValueError."""
    with pytest.raises(ValueError, match=r'not a (str|bool|dict)'):
        generate(info)


def test_importable_in_launch_files():
    """A launch file imports the helpers under their own name."""
    with importable(make_lookup([], [])):
        import controller_manager.launch_utils as imported
        assert imported.generate_spawner_launch_description \
            is utils.generate_spawner_launch_description
