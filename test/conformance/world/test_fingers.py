# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Two fingers around a cube, as a program drives them by the gripper's action."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

from action_msgs.msg import GoalStatus
from control_msgs.action import GripperCommand
from faster import FASTER
from moveit_msgs.msg import ContactInformation
import pytest
from scene_user import Planner
from sensor_msgs.msg import JointState
from shaking import shaking
from simulation_interfaces.msg import EntityState
from world_user import OK, pose, WorldUser

from armsim_ros.clients.action_client import PatientActionClient
from armsim_ros.clients.trajectory import SUCCEEDED, TrajectoryClient
from armsim_ros.nodes.conversions.trajectory import trajectory_to_message
from armsim_ros.testing.robot_user import running_robot

statement = pytest.mark.statement

HAND = Path(__file__).parents[2] / 'support' / 'robots' / 'hand'
POST = 'armsim://box?size=0.03,0.03,0.03'
CUBE = 'armsim://box?size=0.05,0.05,0.05&mass=0.3'
OPEN, CLOSED = 0.04, 0.0


class Fingers:
    """A client of the hand."""

    def __init__(self, world: WorldUser) -> None:
        self.world, self.planner = world, Planner(world)
        self._action = PatientActionClient(
            world.client.node, GripperCommand, '/hand/fingers/gripper_cmd')
        assert self._action.wait_for_server(20.0)

    def move(self, position: float, effort: float = 0.0) -> Any:
        """Move the fingers and return how it ended."""
        goal = GripperCommand.Goal()
        goal.command.position, goal.command.max_effort = position, effort
        client = self.world.client
        handle = client.result(client.in_executor(lambda: self._action.send_goal_async(goal)))
        assert handle.accepted
        return client.result(client.in_executor(handle.get_result_async), 60.0)

    def stand_cube(self, friction: float = 0.8) -> None:
        """Open the fingers, and stand a new cube on a new post between them."""
        self.move(OPEN)
        for name in {'cube', 'post'} & set(self.world.entities()):
            assert self.world.result('delete_entity', entity=name)[0] == OK
        self.world.spawn('post', (0.0, 0.0, 1.12), POST)
        self.world.spawn('cube', (0.0, 0.0, 1.16), f'{CUBE}&friction={friction}')

    def shake(self, seconds: float) -> None:
        """Take the post away and accelerate the hand by one gravity, on a circle."""
        assert self.world.result('delete_entity', entity='post')[0] == OK
        goal = TrajectoryClient(self.world.client, '/hand/carriage').send(
            trajectory_to_message(shaking(seconds)))
        assert goal.result(120.0).status == SUCCEEDED


@pytest.fixture(scope='module')
def fingers() -> Iterator[Fingers]:
    """Run the hand for the tests of this file."""
    with running_robot(f'robot:={HAND}', FASTER, namespace='/hand') as user:
        yield Fingers(WorldUser(user.client, user.program, HAND))


@statement('D3', 'C5')
def test_a_cube_is_grasped_and_let_go(fingers: Fingers) -> None:
    """Stalled with max_effort, which stays; attached in the scene, and free when let go."""
    fingers.stand_cube()
    answer = fingers.move(CLOSED, 10.0)
    assert answer.status == GoalStatus.STATUS_SUCCEEDED
    assert (answer.result.stalled, answer.result.reached_goal) == (True, False)
    assert answer.result.position == pytest.approx(0.025, abs=1e-3)
    fingers.planner.wait(lambda objects: 'cube' not in objects, 30.0)
    attached = fingers.planner.attached()['cube']
    assert attached.link_name == 'palm'
    assert set(attached.touch_links) == {'palm', 'left_finger', 'right_finger'}
    states = fingers.world.client.collect('/hand/joint_states', JointState)
    last = states.wait(100)[-1]
    assert last.effort[last.name.index('finger_joint1')] == pytest.approx(-10.0, rel=0.02)
    states.close()
    fingers.move(OPEN)
    fingers.planner.wait(lambda objects: 'cube' in objects, 30.0)
    assert fingers.planner.objects()['cube'].pose.position.z == pytest.approx(1.16, abs=5e-3)
    assert 'cube' not in fingers.planner.attached()


@statement('D1', 'D2')
@pytest.mark.parametrize(('force', 'friction', 'holds'), [
    (10.0, 0.8, True), (3.0, 0.8, False), (10.0, 0.0, False)])
def test_friction_holds_what_it_can(
    fingers: Fingers, force: float, friction: float, holds: bool
) -> None:
    """0.3 kg through 1 g: by 10 N and friction 0.8, not by 3 N, not without friction."""
    fingers.stand_cube(friction)
    fingers.move(CLOSED, force)
    fingers.shake(6.0)
    height = fingers.world.position('cube')[2]
    if holds:
        # The carriage sags by 3 mm under the cube.
        assert height == pytest.approx(1.16, abs=5e-3)
    else:
        assert height < 1.1


@statement('D6')
def test_contacts_are_told_while_somebody_listens(fingers: Fingers) -> None:
    """Fifty times a second of simulated time, from both sides; none where nothing is touched."""
    fingers.stand_cube()
    fingers.move(CLOSED, 10.0)
    seen = fingers.world.client.collect('/hand/gripper/contacts', ContactInformation, 100)
    found = seen.wait(80)
    stamps = sorted({one.header.stamp.sec * 10**9 + one.header.stamp.nanosec for one in found})
    # The first one comes as soon as somebody listens.
    assert min(after - before for before, after in pairwise(stamps[1:])) == 20_000_000
    assert {(one.contact_body_1, one.contact_body_2) for one in found} == {
        ('left_finger', 'cube'), ('right_finger', 'cube')}
    sides = {one.contact_body_1: one.normal.y for one in found}
    assert sides['left_finger'] * sides['right_finger'] == pytest.approx(-1.0, abs=0.01)
    assert {one.header.frame_id for one in found} == {'world'}
    fingers.move(OPEN)
    clear = fingers.world.entity('cube').header.stamp
    state = EntityState(pose=pose((1.0, 1.0, 0.1)))
    assert fingers.world.result('set_entity_state', entity='cube', state=state)[0] == OK
    seen.clear()
    clock = fingers.world.clock()
    clock.wait(30)
    late = [one for one in seen.messages
            if (one.header.stamp.sec, one.header.stamp.nanosec) > (clear.sec + 1, clear.nanosec)]
    assert late == []
    seen.close()
