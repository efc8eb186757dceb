# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
An arm that takes commands while a program runs on it.

As ur_robot_driver: ``controller_stopper.cpp`` (robotRunningCallback, findAndStopControllers).
"""

from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from threading import Event
from types import SimpleNamespace

import numpy as np
import pytest
from ur_arm import ARM, JOINTS, positions, swing

from armsim_ros.control.arm_state import Mode
from armsim_ros.control.mailbox import GoalStatus
from armsim_ros.stack import ArmSim
from armsim_ros.trajectory import JointTrajectory


def add_freedrive(sim):
    """Add a freedrive controller, inactive."""
    sim.manager.load(SimpleNamespace(
        name='freedrive', type='ur_controllers/FreedriveModeController', parameters={}))
    sim.manager.configure('freedrive')


def errors(sim):
    """Return the texts of new errors."""
    return [event.text for event in sim.manager.poll_events() if event.level == 'error']


def states(sim):
    """Return controller -> its state."""
    return {info.name: info.state for info in sim.manager.list_controllers()}


@pytest.mark.parametrize('end', ['stop_program', 'protective_stop', 'power_off'])
def test_without_its_program_the_arm_has_no_active_controllers(sim, end):
    """
    The arm's controllers are inactive until the program runs; the others stay active.

    HW-C6, HW-B5.
    """
    goal = swing(sim, ARM)
    sim.run_until(sim.time + 0.4)
    before = states(sim)
    if end == 'power_off':
        sim.manager.arm.power_to(Mode.POWER_OFF)
    else:
        getattr(sim.manager.arm, end)()
    sim.step(100)
    assert goal.status is GoalStatus.ABORTED
    assert states(sim) == {**before, ARM: 'inactive'}
    assert not sim.manager.controllers[ARM].send_goal(goal.trajectory).accepted
    rest = positions(sim)
    sim.run_until(sim.time + 5.0)
    sim.clear_stop()
    sim.manager.arm.power_to(Mode.RUNNING)
    sim.run_until(sim.time + 4.0)
    assert states(sim)[ARM] == 'inactive'
    assert sim.manager.arm.play() == ''
    sim.run_until(sim.time + 0.5)
    assert states(sim) == before
    assert np.abs(positions(sim) - rest).max() < 0.2
    sim.execute(JointTrajectory(JOINTS, np.array([1.0]), rest[None], np.zeros((1, 6))))


def test_what_reads_states_of_a_controller_of_the_arm_is_set_aside_with_it(sim):
    """A program that stops leaves no controller active that reads states of another's."""
    sim.manager.load(SimpleNamespace(name='loop', type='pid_controller/PidController', parameters={
        'dof_names': ['joint_1'], 'command_interface': 'velocity',
        'reference_and_state_interfaces': ['position'], 'gains': {'joint_1': {'p': 1.0}}}))
    sim.manager.load(SimpleNamespace(
        name='reader', type='joint_state_broadcaster/JointStateBroadcaster', parameters={
            'joints': ['loop/joint_1'], 'interfaces': ['position']}))
    for name in ('loop', 'reader'):
        sim.manager.configure(name)
    assert sim.manager.switch(['loop', 'reader'], [ARM]).ok
    sim.manager.arm.stop_program()
    sim.step(2)
    assert {states(sim)[name] for name in ('loop', 'reader')} == {'inactive'}
    assert sim.manager.arm.play() == ''
    sim.step(2)
    assert {states(sim)[name] for name in ('loop', 'reader')} == {'active'}


def test_what_becomes_active_before_the_program_runs_is_set_aside():
    """HW-C6: With a program that is to be played first, controllers wait inactive for it."""
    sim = ArmSim('sunday', overrides={
        'simulation.hardware.vendor': 'ur', 'simulation.hardware.program': 'STOPPED'})
    sim.step(20)
    assert states(sim)[ARM] == 'inactive'
    sim.manager.request_switch([ARM])
    sim.step(20)
    assert states(sim)[ARM] == 'inactive'
    sim.manager.arm.play()
    sim.step(20)
    assert states(sim)[ARM] == 'active'


@pytest.mark.parametrize('program', ['PLAYING', 'STOPPED'])
def test_play_reports_what_keeps_the_controllers_of_the_program_inactive(program):
    """
    What a client activates in place of a stopped program's controllers stays active.

    Re-enacts controller_stopper.cpp, findAndStopControllers and startControllers.
    """
    sim = ArmSim('sunday', overrides={
        'simulation.hardware.vendor': 'ur', 'simulation.hardware.program': program})
    add_freedrive(sim)
    sim.manager.arm.stop_program()
    sim.step(20)
    assert sim.manager.switch(['freedrive']).ok
    sim.manager.arm.set_slider(0.5)
    sim.step(20)
    assert states(sim)['freedrive'] == 'active'
    sim.manager.poll_events()
    assert sim.manager.arm.play() == ''
    sim.step(20)
    assert (states(sim)[ARM], states(sim)['freedrive']) == ('inactive', 'active')
    (error,) = errors(sim)
    assert f"'{ARM}' cannot be active together with 'freedrive'" in error


@pytest.fixture
def busy_manager(sim):
    """Return a context in which another thread changes controllers, so that switches wait."""
    @contextmanager
    def busy():
        with ThreadPoolExecutor(1) as other:
            held, done = Event(), Event()

            def hold():
                with sim.manager._structure:
                    held.set()
                    done.wait()

            holding = other.submit(hold)
            held.wait()
            try:
                yield
            finally:
                done.set()
                holding.result()

    return busy


@pytest.mark.parametrize(('before', 'meanwhile', 'after'), [
    (('play',), ('stop_program', 'play'), 'active'),
    (('stop_program',), ('play', 'stop_program'), 'inactive'),
])
def test_controllers_follow_the_program_where_their_switches_wait(
    sim, busy_manager, before, meanwhile, after
):
    """A change of the program counts on the switches of the change before, even if they wait."""
    for change in before:
        getattr(sim.manager.arm, change)()
        sim.step(2)
    with busy_manager():
        for change in meanwhile:
            getattr(sim.manager.arm, change)()
            sim.step(2)
    sim.step(2)
    assert states(sim)[ARM] == after
    assert errors(sim) == []
    sim.manager.arm.play()
    sim.step(2)
    assert states(sim)[ARM] == 'active'


def test_play_leaves_alone_what_a_client_has_activated_again(sim):
    """A client may activate a controller of the stopped program; play finds nothing wrong."""
    sim.manager.arm.stop_program()
    sim.step(20)
    assert sim.manager.switch([ARM]).ok
    assert sim.manager.arm.play() == ''
    sim.step(20)
    assert states(sim)[ARM] == 'active'
    assert errors(sim) == []


def test_play_reports_a_controller_of_the_program_that_was_unloaded(sim):
    """Re-enacts controller_stopper.cpp, startControllers: could not activate, an error."""
    sim.manager.arm.stop_program()
    sim.step(20)
    sim.manager.unload(ARM)
    sim.manager.poll_events()
    assert sim.manager.arm.play() == ''
    sim.step(20)
    (error,) = errors(sim)
    assert f"no controller '{ARM}' is loaded" in error


def test_freedrive_gives_way_and_holds_when_it_ends(sim):
    """HW-C7: In freedrive a push moves the arm, which does not sink; afterwards it is held."""
    arm, start = sim.manager.arm, positions(sim)
    arm.set_freedrive(True)
    sim.run_until(sim.time + 1.0)
    assert np.abs(positions(sim) - start).max() < 5e-3
    sim.simulation.apply_wrench('link_6', force=(0.0, 30.0, 0.0))
    sim.run_until(sim.time + 0.5)
    sim.simulation.apply_wrench('link_6')
    assert np.abs(positions(sim) - start).max() > 0.1
    arm.set_freedrive(False)
    sim.run_until(sim.time + 0.5)
    rest = positions(sim)
    sim.simulation.apply_wrench('link_6', force=(0.0, 30.0, 0.0))
    sim.run_until(sim.time + 0.5)
    assert np.abs(positions(sim) - rest).max() < 0.02


def test_freedrive_and_what_moves_the_arm_exclude_each_other(sim):
    """
    A switch to both is refused, at once or one after the other; one in place of the other is not.

    As ``prepare_command_mode_switch`` (hardware_interface.cpp of ur_robot_driver).
    """
    add_freedrive(sim)
    refused = sim.manager.switch(['freedrive'])
    assert not refused.ok
    assert f"'freedrive' cannot be active together with '{ARM}'" in refused.message
    assert sim.manager.switch([], [ARM]).ok
    assert not sim.manager.switch(['freedrive', ARM]).ok
    assert sim.manager.switch(['freedrive']).ok
    assert not sim.manager.switch([ARM]).ok
    assert sim.manager.switch([ARM], ['freedrive']).ok


def test_freedrive_is_set_aside_with_the_program(sim):
    """As ``controller_stopper.cpp``, which stops it, too."""
    add_freedrive(sim)
    assert sim.manager.switch(['freedrive'], [ARM]).ok
    for change, state in ((sim.manager.arm.stop_program, 'inactive'),
                          (sim.manager.arm.play, 'active')):
        change()
        sim.step(20)
        assert states(sim)['freedrive'] == state


def test_a_payload_is_what_the_drives_believe(sim):
    """HW-C7: A payload that is not there pushes the held arm upwards; taken back, it does not."""
    start = positions(sim)
    sim.simulation.set_payload('link_6', 2.0, (0.0, 0.0, 0.05))
    sim.run_until(sim.time + 1.0)
    assert np.abs(positions(sim) - start).max() > 5e-4
    sim.simulation.set_payload('link_6', 0.0, (0.0, 0.0, 0.0))
    sim.run_until(sim.time + 1.0)
    assert np.abs(positions(sim) - start).max() < 1e-4


def test_each_link_has_its_payload(sim):
    """One that is set and taken back at another link leaves the first as it was."""
    start = positions(sim)
    sim.simulation.set_payload('link_6', 2.0, (0.0, 0.0, 0.05))
    sim.run_until(sim.time + 1.0)
    lifted = positions(sim)
    sim.simulation.set_payload('link_4', 1.0, (0.1, 0.1, 0.1))
    sim.run_until(sim.time + 1.0)
    assert np.abs(positions(sim) - lifted).max() > 1e-5
    sim.simulation.set_payload('link_4', 0.0, (0.0, 0.0, 0.0))
    sim.run_until(sim.time + 1.0)
    np.testing.assert_allclose(positions(sim), lifted, atol=2e-6)
    assert np.abs(lifted - start).max() > 5e-4


def test_a_reset_restores_slider_outputs_and_program(sim):
    """HW-B7: After a reset the arm is as at the start."""
    arm = sim.manager.arm
    arm.set_slider(0.3)
    arm.signals.set('digital_out_2', 1.0)
    arm.stop_program()
    sim.step(20)
    sim.loop.restart('the simulation was reset')
    sim.step(20)
    assert (arm.slider, arm.signals.get('digital_out_2')) == (1.0, 0.0)
    assert states(sim)[ARM] == 'active'
    sim.execute(JointTrajectory(JOINTS, np.array([1.0]), positions(sim)[None] * 0.9))
