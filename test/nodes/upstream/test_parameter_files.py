# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Which parameter files are of a controller, and what the spawner takes from them.

The behaviour is that of controller_manager_services.py
(get_params_files_with_controller_parameters, get_parameter_from_param_files) and of rcl's names.
"""

import pytest
import yaml

from armsim_ros.nodes.upstream.spawner_arguments import entries_of

BLOCK = {'ros__parameters': {'type': 'kind', 'fallback_controllers': ['b', 'c'], 'joints': ['x']}}


@pytest.fixture(name='file')
def _file(tmp_path):
    """Return a function that writes a parameter file and returns its path."""
    def write(content, name='file.yaml'):
        path = tmp_path / name
        path.write_text(yaml.safe_dump(content), encoding='utf-8')
        return str(path)
    return write


@pytest.mark.parametrize(('key', 'in_root', 'in_namespace'), [
    ('arm', True, False), ('/arm', True, False), ('/left/arm', False, True),
    ('/**/arm', True, True), ('/**/left/arm', False, True), ('/**', True, True),
    ('/right/arm', False, False), ('/**/other', False, False)])
def test_keys_of_a_controller(file, key, in_root, in_namespace):
    """A file counts if a key names the controller with its namespace, or a wildcard does."""
    path = file({key: BLOCK})
    for namespace, expected in (('/', in_root), ('/left', in_namespace)):
        entries = entries_of('arm', namespace, [path])
        assert entries.files == ((path,) if expected else ())
        assert entries.type == ('kind' if expected else '')
        assert entries.fallback_controllers == (('b', 'c') if expected else ())


def test_keys_below_a_wildcard(file):
    """Below /** the same names count."""
    for key in ('arm', '/left/arm', 'left/arm'):
        assert entries_of('arm', '/left', [file({'/**': {key: BLOCK}})]).type == 'kind'


def test_a_bare_name_in_a_namespace(file):
    """The name alone names no controller in a namespace; the remark explains what would."""
    entries = entries_of('arm', '/left', [file({'arm': BLOCK})])
    assert entries.files == ()
    assert '/left/arm, /**/arm' in entries.remarks[0]


def test_the_first_file_with_a_value_wins(file):
    """All files that name the controller are passed on; the first type counts, each file once."""
    first = file({'/**': {'ros__parameters': {'use_sim_time': True}}}, 'first.yaml')
    second = file({'arm': BLOCK}, 'second.yaml')
    third = file({'arm': {'ros__parameters': {'type': 'other'}}}, 'third.yaml')
    entries = entries_of('arm', '/', [first, second, third, second, file({'b': BLOCK})])
    assert entries.files == (first, second, third)
    assert entries.type == 'kind'


def test_a_file_of_ros_1(file):
    """In the layout of ROS 1 the name alone is enough."""
    assert entries_of('arm', '/left', [file({'left': {'arm': {'type': 'kind'}}})]).type == 'kind'
