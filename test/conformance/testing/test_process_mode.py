# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The same tests on the real programs, which serve one test after the other."""

from pathlib import Path
import re
import signal
import sys
import threading
import time

import pytest

from armsim_ros.testing.program import Program

statement = pytest.mark.statement

HAND = Path(__file__).parents[2] / 'support' / 'robots' / 'hand'

TESTS = f"""
    import os

    import pytest
    from armsim_ros import SimulationError
    from armsim_ros.clients.controller_manager import ParameterClient
    from armsim_ros.clients.simulation import SimulationClient
    from armsim_ros.testing import assert_reached, assert_rejected

    os.environ['ROS_DOMAIN_ID'] = '7'

    @pytest.mark.armsim(mode='process', faults={{'joint_6': {{'bias': 0.01}}}})
    def test_over_ros(arm, ros_domain):
        assert ros_domain != 7
        assert arm.name == 'sunday'
        assert arm.seed == 5
        planner = ParameterClient(arm.robot.client, '/move_group')
        assert planner.get('planning_seed') == 5
        arm.move_to('scan_food')
        assert_reached(arm, {{'joint_5': 1.57}})
        before = arm.time
        arm.wait(0.5)
        assert 0.5 <= arm.time - before < 5.0
        arm.follow([(1.0, arm.named_states['home'])])
        with pytest.raises(AssertionError, match="joint 'joint_6' is [+]0.01"):
            assert_reached(arm, 'home')
        assert_rejected(arm, [(1.0, [0.1] * 5)])
        arm.spawn('crate', (0.1, 0.1, 0.1), (0.8, 0.7, 0.05))
        assert arm.entity('crate')[:2, 3].tolist() == [0.8, 0.7]

    @pytest.mark.armsim(mode='process', faults={{'joint_6': {{'lag': 0.001}}}})
    def test_from_the_same_start(arm):
        assert max(map(abs, arm.positions.values())) < 0.001
        assert arm.time < 0.5
        with pytest.raises(SimulationError, match='crate'):
            arm.entity('crate')
        arm.protective_stop()
        assert arm.safety == 'PROTECTIVE_STOP'
        assert_rejected(arm, [(1.0, [0.1] * 6)])
        arm.clear_stop()
        assert arm.safety == 'NORMAL'

    @pytest.mark.armsim(mode='process', faults={{'joint_6': {{}}}})
    def test_while_time_stands_still(arm):
        simulation = SimulationClient(arm.robot.client)
        simulation.pause()
        begin = arm.time
        simulation.step(7)
        assert arm.time - begin == pytest.approx(0.007)
        assert_reached(arm, {{'joint_5': 0.0}})
        simulation.play()

    @pytest.mark.armsim(mode='process', faults={{'joint_6': {{'lag': 0.1}}}})
    def test_at_rest_after_a_trajectory(arm):
        arm.follow([(0.2, [0.1] * 6)])
        assert_reached(arm, {{'joint_6': 0.1}})

    @pytest.mark.armsim(robot={str(HAND)!r}, mode='process')
    def test_holds_and_lets_go(arm, request):
        arm.spawn('post', (0.03,) * 3, (0.0, 0.0, 1.12))
        arm.spawn('cube', (0.05,) * 3, (0.0, 0.0, 1.16), mass=0.3)
        arm.grasp(10.0)
        arm.delete('post')
        arm.wait(0.5)
        assert arm.entity('cube')[2, 3] > 1.15
        arm.release()
        arm.wait(0.5)
        assert arm.entity('cube')[2, 3] < 1.0
        program = arm.robot.program
        request.addfinalizer(lambda: (program.process.kill(), program.wait(30.0)))

    @pytest.mark.armsim(robot={str(HAND)!r}, mode='process')
    def test_after_programs_that_died(arm):
        assert arm.time < 5.0
        with pytest.raises(SimulationError, match='cube'):
            arm.entity('cube')

    @pytest.fixture(autouse=True)
    def printed(arm, capsys):
        with capsys.disabled():
            print('PROGRAM', arm.robot.program.process.pid)
"""


@pytest.fixture(scope='module')
def run(run_file):
    """Return what came of these tests."""
    return run_file(TESTS, '--armsim-keep', '--armsim-seed=5')


@pytest.fixture(scope='module')
def programs(run):
    """Return the process of bringup that each of these tests had."""
    return re.findall(r'PROGRAM (\d+)', run.text)


@statement('G3', 'G5')
def test_the_same_test_runs_on_the_real_programs(run):
    """In mode process the fixture drives bringup on a leased domain, and records what it does."""
    assert run.outcome('test_over_ros') == 'passed'
    assert len(list(run.folder.glob('armsim-artifacts/*.mcap'))) == 6


@statement('G5')
def test_the_next_test_has_the_same_programs_put_back(run, programs):
    """Arm, time and world are as after a start, whatever is wrong with the joints this time."""
    assert run.outcome('test_from_the_same_start') == 'passed'
    assert programs[0] == programs[1]


@statement('G3')
def test_what_is_asked_is_of_now(run):
    """Time and positions are those of the question, not of a message that was on its way."""
    assert run.outcome('test_while_time_stands_still') == 'passed'


@statement('G3')
def test_a_trajectory_ends_when_the_arm_rests(run):
    """A controller answers at the trajectory's end, when a joint that lags has not arrived."""
    assert run.outcome('test_at_rest_after_a_trajectory') == 'passed'


@statement('G3', 'G6')
def test_a_running_stack_grasps_alike(run):
    """By the gripper's action: what is held stays up, what is let go falls."""
    assert run.outcome('test_holds_and_lets_go') == 'passed'


@statement('G5')
def test_another_build_and_programs_that_died_are_started_anew(run, programs):
    """Programs serve tests of one build, and only as long as they run."""
    assert run.outcome('test_after_programs_that_died') == 'passed'
    assert len(programs) == 6
    assert len(set(programs[3:])) == 3


@statement('G5')
def test_programs_end_with_a_pytest_that_is_killed(pytester, strangers_pytest, tmp_path):
    """No program outlives the tests, whatever became of them."""
    pids = tmp_path / 'pids'
    pytester.makepyfile(f"""
        import threading

        def test_hangs(armsim_stack):
            with open({str(pids)!r}, 'w') as file:
                file.write(str(armsim_stack.program.process.pid))
            threading.Event().wait()
    """)
    with Program([sys.executable, '-m', 'pytest']) as user:
        wait_until(lambda: pids.exists() and pids.read_text())
        bringup = Path('/proc', pids.read_text())
        children = [Path('/proc', pid) for pid in Path(
            bringup, 'task', bringup.name, 'children').read_text().split()]
        assert len(children) >= 2
        user.signal(signal.SIGKILL)
        wait_until(lambda: not any(path.exists() for path in (bringup, *children)))


def wait_until(condition, timeout=60.0):
    """Look until something is so."""
    deadline = time.monotonic() + timeout
    pause = threading.Event()
    while not condition():
        assert time.monotonic() < deadline
        pause.wait(0.05)
