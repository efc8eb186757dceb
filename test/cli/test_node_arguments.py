# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A node's parameters from ``--ros-args``."""

import pytest
import yaml

from armsim_ros.cli.arguments import UsageError
from armsim_ros.cli.node_arguments import read_node_arguments


@pytest.fixture
def rate(tmp_path):
    """Return a function that gives the rate of a node for files with (key, rate) each."""
    def read(*files, name='arm', namespace='/'):
        words = ['--ros-args', '-r', f'__ns:={namespace}']
        for number, (key, value) in enumerate(files):
            path = tmp_path / f'{number}.yaml'
            path.write_text(yaml.safe_dump({key: {'ros__parameters': {'rate': value}}}))
            words += ['--params-file', str(path)]
        return read_node_arguments(words, name).values.get('rate')
    return read


@pytest.mark.parametrize(('files', 'expected'), [
    ([('arm', 1), ('/**', 2)], 2), ([('/**', 1), ('arm', 2)], 2),
    ([('arm', 1), ('arm', 2)], 2), ([('arm', 1), ('/arm', 2)], 2),
    ([('/**', 1), ('arm', 2), ('/**', 3)], 2), ([('arm', 1), ('/**', 2), ('arm', 3)], 2)])
def test_the_key_that_comes_first_is_overridden(rate, files, expected):
    """rclcpp/parameter_map.cpp, parameter_map_from: keys in the order of their first use."""
    assert rate(*files) == expected


@pytest.mark.parametrize(('key', 'fits'), [
    ('/left/arm', True), ('left/arm', True), ('/**/arm', True), ('/left/**', True),
    ('/**', True), ('/*/arm', True), ('/right/arm', False), ('/right/**', False), ('/*', False),
    ('other', False)])
def test_keys_of_a_node(rate, key, fits):
    """rclcpp/parameter_map.cpp, parameter_map_from: ``*`` is a name, ``**`` any number of them."""
    assert (rate((key, 1), namespace='/left') == 1) is fits


def test_a_file_that_is_not_utf8_is_named(tmp_path):
    """With its place, not with a traceback."""
    file = tmp_path / 'arm.yaml'
    file.write_text('# M\xfcller', encoding='latin-1')
    with pytest.raises(UsageError, match=f"parameter file '{file}' is not YAML: .*0xfc"):
        read_node_arguments(['--params-file', str(file)], 'arm')
