# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A world may have its own gravity, in every format."""

import numpy as np
import pytest

from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.sim.physics.mujoco_model import Ground
from armsim_ros.sim.world.resources import WorldResources
from armsim_ros.stack import ArmSim

MOON = (0.0, 0.0, -1.62)
SDF = """<sdf version="1.9"><world name="moon">{}
  <model name="ball"><pose>2 0 10 0 0 0</pose><link name="l"><collision name="c"><geometry>
    <sphere><radius>0.1</radius></sphere></geometry></collision></link></model>
</world></sdf>"""
MJCF = """<mujoco model="moon">{}<worldbody><body name="ball" pos="2 0 10"><freejoint/>
  <geom type="sphere" size="0.1"/></body></worldbody></mujoco>"""
YAML = """floor: false
{}
objects:
  ball: {{mass: 1.0, xyz: [2, 0, 10], parts: [{{shape: {{type: sphere, radius: 0.1}}}}]}}
"""
WORLDS = [('moon.sdf', SDF, '<gravity>0 0 -1.62</gravity>'),
          ('moon.xml', MJCF, '<option gravity="0 0 -1.62" timestep="0.01"/>'),
          ('moon.yaml', YAML, 'gravity: [0, 0, -1.62]')]


@pytest.mark.parametrize(('name', 'text', 'told'), WORLDS, ids=['sdf', 'mjcf', 'yaml'])
def test_things_fall_as_the_world_says(tmp_path, name, text, told):
    """The world's gravity wins over that of simulation.yaml; the arm stands still in it."""
    file = tmp_path / name
    file.write_text(text.format(told))
    sim = ArmSim('sunday', world=file)
    before = np.array(list(sim.joint_positions.values()))
    sim.run_until(1.0)
    assert sim.simulation.world.pose('ball')[2, 3] == pytest.approx(10.0 - 0.81, abs=0.01)
    after = np.array(list(sim.joint_positions.values()))
    np.testing.assert_allclose(after, before, atol=1e-4)


@pytest.mark.parametrize(('name', 'text', 'told'), WORLDS, ids=['sdf', 'mjcf', 'yaml'])
def test_a_world_that_does_not_say_leaves_it(tmp_path, name, text, told):
    """Then it is that of the settings."""
    (tmp_path / name).write_text(text.format(''))
    assert WorldResources([tmp_path]).world(str(tmp_path / name), '').gravity is None


def test_other_options_of_mjcf_are_not_used():
    """They are listed by name; gravity is not among them."""
    unused = WorldResources([]).world('', MJCF.format(WORLDS[1][2])).unused
    assert [line for line in unused if line.startswith('timestep of <option>')]
    assert not [line for line in unused if 'gravity' in line]


def test_another_world_brings_its_gravity_and_takes_it_away():
    """The drives hold the arm against what there is then."""
    sim = ArmSim('sunday', world='empty')
    world, simulation = sim.simulation.world, sim.simulation
    usual = SimulationSettings().gravity
    for ground, expected in ((Ground(gravity=MOON), MOON), (Ground(), usual)):
        world.commit(world.stage(ground=ground))
        sim.loop.restart('another world was loaded')
        assert tuple(simulation.mujoco_model.opt.gravity) == expected
        before = np.array(list(sim.joint_positions.values()))
        sim.run_until(sim.time + 0.5)
        after = np.array(list(sim.joint_positions.values()))
        np.testing.assert_allclose(after, before, atol=1e-4)
