# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which values of the hardware are read for a controller."""

import numpy as np
import pytest


@pytest.fixture
def hardware(hardware_class):
    """Return joints with a sensor, and a count of how often its values were computed."""

    class Measuring(hardware_class):
        computed = 0

        @property
        def other_states(self):
            self.computed += 1
            return {'wrist/force.x': 3.0, 'a/temperature': 40.0}

    made = Measuring()
    made.state.position[:] = [0.1, 0.2]
    made.state.velocity[:] = [1.0, 2.0]
    return made


def test_reading_joints_leaves_sensors_alone(hardware):
    """The values of sensors are computed only for an interface that is not a joint's motion."""
    np.testing.assert_array_equal(
        hardware.read_states(['b/position', '', 'a/velocity']), [0.2, np.nan, 1.0])
    assert hardware.computed == 0


def test_sensors_are_computed_once_per_reading(hardware):
    """All values of a reading belong together."""
    values = hardware.read_states(['wrist/force.x', 'a/position', 'a/temperature'])
    assert values.tolist() == [3.0, 0.1, 40.0]
    assert hardware.computed == 1


def test_an_interface_that_is_not_there_raises(hardware):
    """Whatever kind it would be."""
    for interface in ('wrist/force.y', 'c/position'):
        with pytest.raises(KeyError, match=interface):
            hardware.read_states([interface])
