# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Two coupled fingers: with what force they hold, what they hold, and what they lose."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shaking import shaking

from armsim_ros.model.cell_loading import load_cell
from armsim_ros.model.geometry import Box
from armsim_ros.model.grippers import grippers_in
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.finger_contacts import FingerContacts
from armsim_ros.stack import ArmSim

HAND = Path(__file__).parents[1] / 'support' / 'robots' / 'hand'
KINDS = ('fingers', 'parallel_fingers', 'effort_fingers')
FINGERS = ('left_finger', 'right_finger')


@pytest.fixture(scope='module')
def cell():
    """Return the files of the hand, read once."""
    return load_cell(str(HAND))


class Hand:
    """Fingers around a cube of 0.3 kg and 50 mm that stands on a post."""

    def __init__(self, cell, friction=0.8):
        self.sim = ArmSim(cell)
        self.world = self.sim.simulation.world
        cube = WorldObject.of_shape('cube', Box((0.05,) * 3), pose_matrix((0, 0, 1.16)), mass=0.3)
        self.world.add(replace(cube, friction=friction))
        self.world.add(WorldObject.of_shape(
            'post', Box((0.03,) * 3), pose_matrix((0, 0, 1.12))))
        self.gripper, = grippers_in(cell)
        self.looks = FingerContacts(self.sim.simulation, [self.gripper])

    def close(self, force, kind='fingers', position=0.0):
        """Close the fingers by a controller, and return the goal when it has ended."""
        if kind != 'fingers':
            assert self.sim.manager.switch([kind], ['fingers']).ok
            self.sim.step(20)
        controller = self.sim.manager.controllers[kind]
        words = ([position], [], [force]) if kind.startswith('parallel') else (position, force)
        goal = controller.send_goal(*words).goal
        self.sim.run_until(lambda: goal.done, timeout=5.0)
        return goal

    def force(self):
        """Return what a finger presses with [N]: the mean, as the post takes up a difference."""
        return 0.5 * sum(one.force for one in self.looks.contacts(self.gripper))

    def cube_in_palm(self):
        """Return where the cube is, seen from the palm (3,) [m]."""
        return self.world.pose('cube')[:3, 3] - self.sim.simulation.link_pose('palm')[:3, 3]

    def slip(self, seconds):
        """Let go of the post, shake, and return the farthest that the cube slipped [m]."""
        self.world.remove('post')
        start, farthest = self.cube_in_palm(), 0.0
        goals = self.sim.send_trajectory(shaking(seconds))
        while not all(goal.done for goal in goals) and farthest < 0.05:
            self.sim.step(50)
            farthest = max(farthest, float(np.linalg.norm(self.cube_in_palm() - start)))
        return farthest


def test_a_cube_is_held_through_a_minute_of_shaking(cell):
    """0.3 kg by 10 N and friction 0.8, through an acceleration of 1 g for 60 s: 2 mm at most."""
    hand = Hand(cell)
    hand.close(10.0)
    assert hand.slip(60.0) < 2e-3


@pytest.mark.parametrize(('force', 'friction'), [(3.0, 0.8), (10.0, 0.0)])
def test_too_weak_or_too_slippery_is_dropped(cell, force, friction):
    """3 N carry 4.8 N of the 5.9 N that are needed; without friction nothing is carried."""
    hand = Hand(cell, friction)
    hand.close(force)
    assert hand.slip(10.0) >= 0.05


@pytest.mark.parametrize('kind', KINDS)
@pytest.mark.parametrize('position', [0.0, 0.023])
def test_each_finger_presses_with_the_goals_effort(cell, kind, position):
    """The force is max_effort, whether the goal is far behind the surface or 2 mm."""
    hand = Hand(cell)
    controller = hand.sim.manager.controllers[kind]
    goal = hand.close(10.0, kind, position)
    assert goal.status.name == 'SUCCEEDED'
    near = 0.025 - position < controller.parameters.goal_tolerance
    assert (goal.result.stalled, goal.result.reached_goal) == (not near, near)
    hand.sim.step(300)
    # The PID of the effort kind makes 8 N of 2 mm.
    wanted = 8.0 if kind == 'effort_fingers' and near else 10.0
    assert hand.force() == pytest.approx(wanted, rel=0.05)
    hand.sim.step(5000)
    assert hand.force() == pytest.approx(wanted, rel=0.05)


def test_a_goal_without_an_effort_is_bounded_by_the_joint(cell):
    """The URDF's 40 N; a later goal of 5 N presses less."""
    hand = Hand(cell)
    hand.close(0.0)
    hand.sim.step(300)
    assert hand.force() > 18.0
    hand.close(5.0)
    hand.sim.step(300)
    assert hand.force() == pytest.approx(5.0, rel=0.05)


def test_what_two_fingers_press_is_held_after_a_while(cell):
    """From opposite sides for 0.2 s; what is let go is not held any more."""
    hand = Hand(cell)
    hand.sim.step(100)
    assert hand.looks.held() == {}
    hand.close(10.0)
    begin = hand.sim.time
    while not (held := hand.looks.held()):
        hand.sim.step(20)
    assert hand.sim.time - begin == pytest.approx(0.2, abs=0.02)
    assert held['cube'].palm == 'palm'
    assert set(held['cube'].links) == {'palm', *FINGERS}
    hand.close(10.0, position=0.04)
    assert set(hand.looks.held()) == {'cube'}
    hand.sim.step(200)
    assert hand.looks.held() == {}


def test_one_finger_holds_nothing(cell):
    """A touch from one side, and from above, is none."""
    hand = Hand(cell)
    hand.world.set_pose('cube', pose_matrix((0, 0.0705, 1.16)))
    hand.world.set_pose('post', pose_matrix((0, 0.0705, 1.12)))
    hand.sim.step(1)
    assert {one.link for one in hand.looks.contacts(hand.gripper)} <= {'left_finger'}
    hand.world.set_pose('cube', pose_matrix((0, 0, 1.265)))
    hand.sim.step(500)
    assert {one.link for one in hand.looks.contacts(hand.gripper)} == {'palm'}
    assert hand.looks.held() == {}
