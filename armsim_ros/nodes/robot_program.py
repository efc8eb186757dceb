# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The programs that serve a robot, and their life from the command line to the exit status.

Each takes the words after its name, by default those of this process, and serves until SIGINT or
SIGTERM. It returns 0 after a signal, 2 after a user's error, 1 after a failure.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
import gc
from importlib import import_module
import os
import signal
import socket
import sys
import threading
from typing import Protocol

from armsim_ros.cli.arguments import parse_arguments, ProgramArguments
from armsim_ros.cli.environment import QuietEnd, refuse, started_by_bringup
from armsim_ros.errors import ArmsimError, USAGE_STATUS
from armsim_ros.nodes.watching import log_lost_answers, watch_process

#: How long a program stays after the last answers to goals that its end aborts [s]: Fast DDS drops
#: what a client's threads have not read when they learn that the sender has left.
LAST_ANSWERS_TIME = 0.1
_NUMBERS = (signal.SIGINT, signal.SIGTERM)


class StopSignals:
    """
    SIGINT and SIGTERM as a flag that is read between the steps of the start.

    Python runs signal handlers in the main thread, once that comes back to the interpreter; one
    that waits for the middleware does not come back. So a separate thread passes the signal on.
    """

    def __init__(self) -> None:
        self.stop_requested = False
        self.on_stop: Callable[[], None] | None = None
        self._reader, self._writer = socket.socketpair()
        self._writer.setblocking(False)
        signal.set_wakeup_fd(self._writer.fileno(), warn_on_full_buffer=False)
        for number in _NUMBERS:
            signal.signal(number, lambda *_: None)
        threading.Thread(target=self._wait, name='signals', daemon=True).start()

    def _wait(self) -> None:
        while signals := self._reader.recv(16):
            if set(signals) & set(_NUMBERS):
                self.stop_requested = True
                if self.on_stop is not None:
                    self.on_stop()


class RobotProgram(Protocol):
    """What is run; made of the arguments and a function that returns whether a signal came."""

    def __init__(self, arguments: ProgramArguments, stop_wanted: Callable[[], bool]) -> None:
        """Read the files; no node exists yet."""

    def run(self) -> int:
        """Run until ``stop`` and return the exit status."""

    def stop(self) -> None:
        """End ``run``; from a signal handler too."""


def serve(module: str, name: str, argv: Sequence[str] | None, *, watched: bool = True) -> int:
    """
    Run a program until SIGINT or SIGTERM.

    What takes time is imported only now, so that a signal finds us listening.

    :param module: where the program's class is.
    :param name: of the class, a ``RobotProgram``.
    :param argv: the words after the program's name; those of this process where None.
    :param watched: whether it reports when it has to wait for a processor.
    :returns: 0 after a signal, 2 after a user's error, else the program's status.
    """
    if started_by_bringup():
        # What does not fit into the pipe while bringup is stopped is lost; we are not.
        for descriptor in (1, 2):
            os.set_blocking(descriptor, False)
    # Its search reads the metadata of all packages that are installed, for plugins of its own.
    os.environ.setdefault('PYDANTIC_DISABLE_PLUGINS', '__all__')
    gc.disable()
    signals = StopSignals()
    log_lost_answers()
    if watched:
        watch_process(module.split('.')[-2])
    try:
        arguments = parse_arguments(sys.argv[1:] if argv is None else argv, xacro=True)
        kind: type[RobotProgram] = getattr(import_module(module), name)
        if signals.stop_requested:
            return 0
        program = kind(arguments, lambda: signals.stop_requested)
        # What is there now stays, and need not be searched for cycles.
        gc.freeze()
        gc.enable()
        signals.on_stop = program.stop
        return program.run()
    except ArmsimError as error:
        refuse(str(error))
        return USAGE_STATUS


def simulation(argv: Sequence[str] | None = None) -> int:
    """Run the simulation."""
    # Nothing is drawn here: MuJoCo need not search for a renderer, nor reject any.
    os.environ['MUJOCO_GL'] = 'disable'
    return serve('armsim_ros.nodes.simulation.program', 'SimulationProgram', argv)


def move_group(argv: Sequence[str] | None = None) -> int:
    """Run move_group: planning, kinematics, the planning scene, execution."""
    end = QuietEnd(1)
    end.status = status = serve('armsim_ros.nodes.move_group.program', 'MoveGroupProgram', argv)
    return status


def servo_node(argv: Sequence[str] | None = None) -> int:
    """Run servo_node: twists, joint jogs and poses to joint commands."""
    return serve('armsim_ros.nodes.servo.program', 'ServoProgram', argv)


def camera(argv: Sequence[str] | None = None) -> int:
    """Run the camera: pictures of a simulation that runs with ``camera:=true``."""
    # It runs at the lowest priority, so that its waiting is no measure of the load.
    return serve('armsim_ros.nodes.camera.program', 'CameraProgram', argv, watched=False)
