# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What switches suction cups and grippers: a loop that looks after a cup, outputs of an arm."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
import re
from types import MappingProxyType

from armsim_ros.control.arm_state import Signals
from armsim_ros.control.command_controllers.gripper_controller import GripperBase
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.vacuum_gripper import LOOK_NS, VacuumGripper


class VacuumControl:
    """
    Switches a cup; only in the loop's thread.

    :param loop: steps the physics that the cup is in.
    :param gripper: the cup.
    :param changed: called when an object is grasped or let go.
    """

    def __init__(
        self, loop: ControlLoop, gripper: VacuumGripper, changed: Callable[[], object]
    ) -> None:
        self.gripper, self._loop, self._changed = gripper, loop, changed
        self._watched = False
        self._last = ''

    def on(self) -> None:
        """Begin to pull what is near."""
        self.gripper.switch_on()
        if not self._watched:
            self._watched = True
            self._loop.every(LOOK_NS, self._look, at_once=False)

    def off(self) -> None:
        """Let go."""
        self.gripper.switch_off()
        self._notice()

    def _look(self, _: int) -> None:
        self.gripper.look()
        self._notice()
        if not self.gripper.on:
            self._watched = False
            self._loop.forget(self._look)

    def _notice(self) -> None:
        if self.gripper.held != self._last:
            self._last = self.gripper.held
            self._changed()


_OUTPUT, _INPUT = re.compile(r'digital_out_\d+'), re.compile(r'digital_in_\d+')
_GRASPING = '/grasping'


def wire_signals(
    signals: Signals, wires: Mapping[str, str], cups: Mapping[str, VacuumControl],
    fingers: Mapping[str, Callable[[bool], object]] = MappingProxyType({})
) -> list[str]:
    """
    Connect signals with grippers.

    :param wires: output -> cup or joint of fingers, input -> ``CUP/grasping``.
    :param cups: by name.
    :param fingers: joint -> closes (True) or opens them.
    :returns: a line for each wire that leads nowhere.
    """
    problems = []
    for signal, target in wires.items():
        cup = cups.get(target.removesuffix(_GRASPING))
        if cup is not None and _OUTPUT.fullmatch(signal) and not target.endswith(_GRASPING):
            signals.wire({signal: _switch(cup)}, {})
        elif cup is not None and _INPUT.fullmatch(signal) and target.endswith(_GRASPING):
            signals.wire({}, {signal: _holds(cup)})
        elif target in fingers and _OUTPUT.fullmatch(signal):
            signals.wire({signal: fingers[target]}, {})
        else:
            problems.append(
                f"hardware.io: {signal}: '{target}' cannot be wired; allowed: digital_out_N: CUP "
                f'and digital_in_N: CUP{_GRASPING}, with a vacuum gripper as CUP: '
                f'{", ".join(cups) or "there is none"}; digital_out_N: JOINT, with the joint of a '
                "gripper controller for which the SRDF has states 'open' and 'closed': "
                f'{", ".join(fingers) or "there is none"}')
    return problems


def finger_switches(
    manager: ControllerManager, model: RobotModel
) -> dict[str, Callable[[bool], object]]:
    """Return joint -> what has the active gripper controller close (True) or open it."""
    found: dict[str, Callable[[bool], object]] = {}
    states = [(name, values) for group in model.semantic.named_states.values()
              for name, values in group.items()]
    for controller in manager.controllers.values():
        if isinstance(controller, GripperBase):
            joint = controller.parameters.joint
            ends = {name.lower()[:4]: values[joint] for name, values in states if joint in values}
            if 'open' in ends and 'clos' in ends:
                found[joint] = partial(_move_fingers, manager, joint, (ends['open'], ends['clos']))
    return found


def _move_fingers(manager: ControllerManager, joint: str, ends: tuple[float, float],
                  on: bool) -> None:
    for controller in manager.controllers.values():
        if (isinstance(controller, GripperBase) and controller.active
                and controller.parameters.joint == joint):
            controller.close_to(ends[on], 0.0)


def _switch(cup: VacuumControl) -> Callable[[bool], object]:
    return lambda on: cup.on() if on else cup.off()


def _holds(cup: VacuumControl) -> Callable[[], bool]:
    return lambda: bool(cup.gripper.held)
