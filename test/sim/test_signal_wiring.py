# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Inputs and outputs that simulation.yaml wires to suction cups (``hardware.io``)."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from armsim_ros.control.arm_state import Signals
from armsim_ros.sim.vacuum_control import finger_switches, wire_signals
from armsim_ros.stack import ArmSim

HAND = Path(__file__).parents[1] / 'support' / 'robots' / 'hand'


class Cup:
    """A suction cup that notes what it is told."""

    def __init__(self):
        self.calls = []
        self.gripper = SimpleNamespace(held='')

    def on(self):
        self.calls.append('on')

    def off(self):
        self.calls.append('off')


def test_an_output_switches_a_cup_and_an_input_shows_what_it_holds():
    """Only a change of the output counts; a reset switches off."""
    signals, cup = Signals(), Cup()
    assert wire_signals(signals, {'digital_out_0': 'cup', 'digital_in_3': 'cup/grasping'},
                        {'cup': cup}) == []
    for value in (1.0, 1.0, 0.0, 1.0):
        signals.set('digital_out_0', value)
    signals.set('digital_out_1', 1.0)
    assert cup.calls == ['on', 'off', 'on']
    assert signals.get('digital_in_3') == 0.0
    cup.gripper.held = 'box'
    assert signals.get('digital_in_3') == 1.0
    signals.reset()
    assert cup.calls[-1] == 'off'


@pytest.mark.parametrize('wire', [
    {'digital_out_0': 'no_cup'}, {'digital_out_0': 'cup/grasping'}, {'digital_in_0': 'cup'},
    {'analog_out_0': 'cup'}])
def test_a_wire_that_leads_nowhere_is_a_line(wire):
    """It names the signal, the target and the cups that there are."""
    line, = wire_signals(Signals(), wire, {'cup': Cup()})
    (signal, target), = wire.items()
    assert f"hardware.io: {signal}: '{target}' cannot be wired" in line
    assert 'as CUP: cup;' in line


def test_an_output_closes_and_opens_fingers():
    """The joint goes where the SRDF's states 'closed' and 'open' have it."""
    sim = ArmSim(HAND)
    signals = sim.manager.arm.signals
    fingers = finger_switches(sim.manager, sim.model)
    assert wire_signals(signals, {'digital_out_16': 'finger_joint1'}, {}, fingers) == []
    for value, position in ((1.0, 0.0), (0.0, 0.04)):
        signals.set('digital_out_16', value)
        sim.run_until(sim.time + 1.0)
        assert sim.joint_positions['finger_joint1'] == pytest.approx(position, abs=1e-3)
