# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The platform tag of the wheel follows the symbols that its libraries need."""

from importlib import metadata
import platform

from build_support import platform_tag
import pytest


@pytest.fixture
def libraries():
    """Return the installed libraries of the interface packages."""
    distribution = metadata.distribution('armsim-ros-interfaces')
    return [path.locate() for path in distribution.files if path.suffix == '.so']


def test_the_libraries_load_where_rclpy_does(libraries):
    """No symbol is newer than those of the rclpy wheels' platform."""
    assert libraries
    machine = platform.machine()
    # which no library with a newer symbol has
    assert platform_tag.platform_tag(libraries, machine) == f'manylinux_2_28_{machine}', [
        symbol for path in libraries for symbol in platform_tag.newer_symbols(path)]


def test_newer_symbols_are_named(libraries, monkeypatch):
    """A library that needs a newer glibc fits this machine alone."""
    monkeypatch.setitem(platform_tag.NEWEST, 'GLIBC', (2, 0))
    assert any(symbol.startswith('dlopen@GLIBC_2.')
               for symbol in platform_tag.newer_symbols(libraries[0]))
    assert platform_tag.platform_tag(libraries, 'x86_64') == 'linux_x86_64'


@pytest.mark.parametrize(('version', 'old'), [
    ('GLIBC_2.28', True), ('GLIBC_2.29', False), ('GLIBC_2.2.5', True), ('GLIBC_PRIVATE', False),
    ('GLIBCXX_3.4.25', True), ('GLIBCXX_3.4.26', False), ('ROS_9', True)])
def test_versions_are_compared_as_numbers(version, old):
    """The limits are those of glibc 2.28 and gcc 8."""
    assert platform_tag._is_old(version) == old
