# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Public robot descriptions from example-robot-data, where it is installed."""

from __future__ import annotations

from pathlib import Path
import sys

import pytest

_FOLDERS = {
    'ur5': 'example-robot-data/robots/ur_description/urdf/ur5_robot.urdf',
    'panda': 'example-robot-data/robots/panda_description/urdf/panda.urdf',
    'xarm7': 'example-robot-data/robots/xarm_description/urdf/xarm7.urdf',
    'so101': 'example-robot-data/robots/so_arm_description/urdf/so101.urdf',
}
_SRDFS = {
    'ur5': 'example-robot-data/robots/ur_description/srdf/ur5.srdf',
    'panda': 'example-robot-data/robots/panda_description/srdf/panda.srdf',
    'xarm7': 'example-robot-data/robots/xarm_description/srdf/xarm7.srdf',
}


def public_urdf(name: str) -> Path:
    """Return the URDF of a public robot; the test is skipped where its package is not there."""
    return _find(_FOLDERS[name])


def public_srdf(name: str) -> Path:
    """Return the SRDF that was published with a public robot; the test is skipped as above."""
    return _find(_SRDFS[name])


def _find(path: str) -> Path:
    for entry in sys.path:
        file = Path(entry, 'cmeel.prefix', 'share', path)
        if file.is_file():
            return file
    pytest.skip('needs the package example-robot-data: pip install example-robot-data')
