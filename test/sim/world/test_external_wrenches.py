# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Wrenches that act for a while, as those of mujoco_ros2_control.

external_wrench_plugin.cpp ``update``: axes and point are the body's, several add up, a duration of
zero is a single step, and the ramp ends at zero.
"""

import numpy as np
import pytest

from armsim_ros import ArmSim
from armsim_ros.errors import SimulationError
from armsim_ros.sim.external_loads import ExternalWrenches, Wrench
from armsim_ros.sim.world.entities import Entities, RobotEntity, UnknownEntityError

MS = 1_000_000


@pytest.fixture
def sim():
    """Give an arm at rest."""
    return ArmSim('sunday')


@pytest.fixture
def wrenches(sim):
    """Give what applies wrenches to it."""
    robot = RobotEntity('sunday', sim.model.root_link, tuple(sim.model.links))
    return ExternalWrenches(sim.loop, Entities(sim.simulation, [robot]))


def push(frame='link_6', force=(5.0, 0.0, 0.0), torque=(0.0, 0.0, 0.0), point=(0.0, 0.0, 0.0),
         duration=10, ramp=0):
    """Return a wrench; times in milliseconds."""
    return Wrench(frame, np.array(force), np.array(torque), np.array(point), duration * MS,
                  ramp * MS)


def applied(sim, link='link_6'):
    """Return what acts on a link in the physics (6,)."""
    return sim.simulation.mujoco_data.xfrc_applied[sim.simulation.link_body(link)].copy()


def test_axes_and_point_are_those_of_the_body(sim, wrenches):
    """The torque about the centre of mass has the lever of the force."""
    wrenches.apply([push(force=(5.0, 1.0, 0.0), torque=(0.0, 0.2, 0.0), point=(0.0, 0.0, 0.1))])
    pose = sim.simulation.link_pose('link_6')
    data, body = sim.simulation.mujoco_data, sim.simulation.link_body('link_6')
    force = pose[:3, :3] @ (5.0, 1.0, 0.0)
    lever = pose[:3, :3] @ (0.0, 0.0, 0.1) + pose[:3, 3] - data.xipos[body]
    torque = pose[:3, :3] @ (0.0, 0.2, 0.0) + np.cross(lever, force)
    assert applied(sim) == pytest.approx(np.concatenate((force, torque)))


@pytest.mark.parametrize(('duration', 'steps'), [(0, 1), (10, 10)])
def test_it_acts_for_its_duration(sim, wrenches, duration, steps):
    """Zero is a single step; the caller hears of the end."""
    ended = []
    wrenches.apply([push(duration=duration)], ended=lambda: ended.append(sim.loop.clock.steps))
    begin = sim.loop.clock.steps
    acting = []
    for _ in range(steps + 2):
        acting.append(bool(applied(sim).any()))
        sim.loop.advance()
    assert acting == [True] * steps + [False] * 2
    assert ended == [begin + steps]


def test_it_fades(sim, wrenches):
    """In the ramp it is as much as is left of it."""
    wrenches.apply([push(force=(0.0, 0.0, 8.0), duration=10, ramp=4)])
    sim.loop.advance(8)
    assert np.linalg.norm(applied(sim)[:3]) == pytest.approx(4.0)


def test_several_add_up_beside_what_others_apply(sim, wrenches):
    """A push of the library stays when they end."""
    sim.simulation.apply_wrench('link_6', force=(0.0, 0.0, 1.0))
    wrenches.apply([push(), push()])
    turn = sim.simulation.link_pose('link_6')[:3, :3]
    assert applied(sim)[:3] == pytest.approx(turn @ (10.0, 0.0, 0.0) + (0.0, 0.0, 1.0))
    sim.loop.advance(20)
    assert applied(sim)[:3] == pytest.approx((0.0, 0.0, 1.0))


def test_a_key_replaces(sim, wrenches):
    """The next message of a topic does not add up with the last."""
    for _ in range(3):
        wrenches.apply([push(force=(0.0, 3.0, 0.0))], key='topic')
    assert np.linalg.norm(applied(sim)[:3]) == pytest.approx(3.0)


def test_a_free_object_is_pushed(sim, wrenches):
    """By its name, also from sleep."""
    sim.loop.advance(500)
    cube = next(name for name, item in sim.simulation.world.objects.items()
                if item.mass is not None)
    before = sim.simulation.world.pose(cube)[:3, 3].copy()
    wrenches.apply([push(cube, force=(0.0, 8.0, 0.0), duration=200)])
    sim.loop.advance(300)
    assert sim.simulation.world.pose(cube)[1, 3] - before[1] > 0.01


def test_all_or_none(sim, wrenches):
    """A frame that is not known, or a fixed object, and nothing acts."""
    with pytest.raises(UnknownEntityError, match="no entity 'link_99'"):
        wrenches.apply([push(), push('link_99')])
    fixed = next(name for name, item in sim.simulation.world.objects.items() if item.mass is None)
    with pytest.raises(SimulationError, match='is fixed'):
        wrenches.apply([push(), push(fixed)])
    assert not applied(sim).any()


def test_a_reset_ends_them(sim, wrenches):
    """Nothing acts, and who waits hears of it."""
    ended = []
    wrenches.apply([push(duration=1000)], ended=lambda: ended.append(True))
    wrenches.clear()
    assert not applied(sim).any()
    assert ended == [True]
