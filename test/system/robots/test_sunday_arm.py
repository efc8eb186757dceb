"""Sunday: the default robot, started with the arguments of its published launch file."""

from pathlib import Path

import pytest
from rosgraph_msgs.msg import Clock

from armsim_ros.clients.motion import SUCCESS
from armsim_ros.clients.trajectory import SUCCEEDED
from armsim_ros.testing.robot_user import running_robot
from benchmarks.stack import processor_seconds

JOINTS = [f'joint_{number}' for number in range(1, 7)]


@pytest.fixture(scope='module')
def sunday():
    """Run the stack."""
    with running_robot('robot:=sunday', 'paused:=false', 'use_sim_time:=true', 'gui:=false',
                       'headless:=true', 'debug:=false', namespace='/sunday') as user:
        yield user


def test_a_trajectory_is_followed(sunday):
    """A client of the controller's action moves the arm."""
    target = dict(zip(JOINTS, [0.1, 0.2, 0.3, -0.2, 0.4, 0.1], strict=True))
    outcome = sunday.send('arm_joint_controller', JOINTS, [(0.8, list(target.values()))])
    assert outcome.status == SUCCEEDED
    assert sunday.distance(target) < 0.01


def test_a_plan_is_executed_by_itself_later(sunday):
    """A plan of move_action, given to execute_trajectory."""
    target = sunday.move_group.named_states()['manipulator', 'scan_food']
    planned = sunday.move_group.plan('manipulator', target)
    assert planned.error_code.val == SUCCESS
    executed = sunday.move_group.execute(planned.planned_trajectory)
    assert executed.error_code.val == SUCCESS
    assert sunday.distance(target) < 0.01


def test_a_stack_at_rest_rests(sunday):
    """Three simulated seconds take all programs together far less than one processor has."""
    clock = sunday.client.collect('/clock', Clock)
    sunday.wait_until_still()
    programs = [int(pid) for pid in children_of(sunday.program.process.pid)]
    assert len(programs) == 2
    began = clock.wait(1)[-1].clock.sec
    clock.wait_for(lambda message: message.clock.sec > began)
    before = sum(map(processor_seconds, programs))
    clock.wait_for(lambda message: message.clock.sec > began + 3)
    assert sum(map(processor_seconds, programs)) - before < 1.5


def children_of(pid):
    """Return the processes that a process has started."""
    return Path(f'/proc/{pid}/task/{pid}/children').read_text().split()
