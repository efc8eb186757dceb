# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The table of a vendor is found by plugin, by name or by module."""

import pytest

from armsim_ros.errors import ConfigError
from armsim_ros.vendors import find_vendor

MODULE = """
from armsim_ros.vendors import Vendor

VENDOR = Vendor(name='mine', unlock_delay=2.0)
"""


@pytest.mark.parametrize(('plugin', 'name'), [
    ('ur_robot_driver/URPositionHardwareInterface', 'ur'),
    ('franka_hardware/FrankaHardwareInterface', 'franka'),
    ('kortex_driver/KortexMultiInterfaceHardware', 'kinova'),
])
def test_the_plugin_of_a_driver_has_a_vendor(plugin, name):
    """HW-A2: The hardware plugin of a vendor's driver gives the vendor's table."""
    assert find_vendor('', [plugin]).name == name
    assert find_vendor('none', [plugin]) is None


def test_mock_and_simulators_have_no_vendor():
    """HW-A2: Hardware that is mocked or simulated upstream has no vendor."""
    assert find_vendor('', ['mock_components/GenericSystem', 'gz_ros2_control/GazeboSimSystem'
                            ]) is None


def test_a_module_of_the_users_own_is_a_vendor(tmp_path, monkeypatch):
    """HW-A2: A module with a VENDOR is taken by its name."""
    (tmp_path / 'my_vendor.py').write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    assert find_vendor('my_vendor').unlock_delay == 2.0


def test_an_unknown_vendor_is_refused_with_the_known_ones():
    """HW-A2: The message names the vendors that there are."""
    with pytest.raises(ConfigError, match='ur, franka, kinova'):
        find_vendor('no_such_vendor')
