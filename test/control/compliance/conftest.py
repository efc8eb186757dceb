# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A Panda with the controllers of crisp_controllers under the names that crisp-python expects."""

from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml

from armsim_ros.model.cell_loading import load_cell
from armsim_ros.model.transforms import quat_xyzw_from_matrix
from armsim_ros.stack import ArmSim

TIP = 'panda_hand_tcp'
FILE = Path(__file__).parents[3] / 'examples' / 'crisp_panda.yaml'


def load_example(manager, name, **more):
    """Load a controller of the example into a manager, with more parameters."""
    parameters = {**yaml.safe_load(FILE.read_text())[name]['ros__parameters'], **more}
    kind = parameters.pop('type')
    controller = manager.load(SimpleNamespace(name=name, type=kind, parameters=parameters))
    manager.configure(name)
    return controller


class Compliant:
    """The arm with a compliant controller active, stepped without ROS."""

    def __init__(self, cell, name, more):
        self.sim = ArmSim(cell)
        self.manager = self.sim.managers['panda']
        self.plant = self.sim.simulation
        self.controller = load_example(self.manager, name, **more)
        self.events = []
        result = self.manager.switch(activate=[name], deactivate=['panda_arm_controller'])
        assert result.ok, result.message

    @property
    def tip(self):
        """Where the tip is (4, 4)."""
        return self.plant.link_pose(TIP)

    @property
    def place(self):
        """Where the tip is (3,)."""
        return self.tip[:3, 3].copy()

    def set(self, **parameters):
        self.controller.set_parameters(
            {name.replace('__', '.'): value for name, value in parameters.items()})

    def aim(self, place):
        """Send a target without turning."""
        return self.controller.receive_pose('', place, quat_xyzw_from_matrix(self.tip[:3, :3]))

    def run(self, seconds):
        for _ in range(round(seconds * 500)):
            self.sim.step()
        self.events += [event.text for event in self.manager.poll_events()
                        if event.source == self.controller.name and event.level == 'warning']


@pytest.fixture(scope='package', name='panda')
def _panda():
    return load_cell('panda')


@pytest.fixture
def load():
    """Return the function that loads a controller of the example."""
    return load_example


@pytest.fixture
def compliant(panda):
    """Return a function that makes the arm with a controller active, and its parameters."""
    return lambda name='cartesian_impedance_controller', **more: Compliant(panda, name, more)
