# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The manifest names what the package imports."""

import ast
from pathlib import Path
import re
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[2]
#: What belongs to ROS by its name.
ENDINGS = ('_msgs', '_srvs', '_interfaces')
OTHERS = {'rclpy', 'ament_index_python', 'xacro'}
#: A file without these has no import of them.
NAMES = re.compile('|'.join([*ENDINGS, *OTHERS]))
#: No release of Jazzy has them, so that rosdep has no keys for them.
UNRELEASED = {'franka_msgs', 'industrial_msgs'}


def is_ros(name):
    """Return whether a module is a package of ROS; launch is used only where it is installed."""
    return name.endswith(ENDINGS) or name in OTHERS


def imported():
    """Return the ROS packages that any file of the package imports."""
    found = set()
    for file in (ROOT / 'armsim_ros').rglob('*.py'):
        text = file.read_text()
        if not NAMES.search(text):
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Import):
                found.update(alias.name.partition('.')[0] for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module:
                found.add(node.module.partition('.')[0])
    return set(filter(is_ros, found))


def test_the_manifest_names_every_ros_package_that_is_imported_and_no_other():
    """package.xml depends on each imported ROS package that rosdep can install, and no other."""
    manifest = ElementTree.parse(ROOT / 'package.xml').getroot()
    declared = {element.text for element in manifest.iter('exec_depend')}
    assert set(filter(is_ros, declared)) == imported() - UNRELEASED
