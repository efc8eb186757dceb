# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What to do about what a launch lacks."""

import pytest

from armsim_ros.launch.failures import missing_module_text


@pytest.mark.parametrize(('module', 'distribution'), [
    ('cv2', 'opencv-python-headless'), ('yaml.constructor', 'PyYAML'), ('roslibpy', 'roslibpy')])
def test_a_missing_module_is_installed_by_the_name_of_its_distribution(module, distribution):
    """It may be another one."""
    assert f"pip install {distribution}'" in missing_module_text(module)
