# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The control thread and the executor's thread, and their failures."""

from __future__ import annotations

import threading
import traceback

from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.impl.rcutils_logger import RcutilsLogger

from armsim_ros.nodes.simulation.priority_watch import DutyLimit
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.pacer import prioritize_thread


def prioritize_process(control_priority: int) -> bool:
    """
    Give the calling thread, and all that it starts from now on, SCHED_FIFO priority 1.

    Call it before the first node exists, so that the middleware's threads have it too. The
    control thread shares the interpreter's lock with all Python threads, and those share
    the middleware's locks with its threads: were one of them preempted by another program while
    it holds a lock, the control thread would wait for that program: with ten clients on two
    processors the 99th percentile of its lateness is then tens of milliseconds instead of a
    third of a core (``python -m benchmarks control_thread``). What they may use is limited, see
    :class:`DutyLimit`.

    :param control_priority: of the control thread; 0 asks for none here either.
    :returns: whether there is the permission.
    """
    return prioritize_thread(min(1, control_priority))


class ControlThread:
    """
    Runs the control loop.

    :param loop: the loop; nothing else may tick it.
    """

    def __init__(self, loop: ControlLoop) -> None:
        self.failure = ''
        self._loop = loop
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name='control', daemon=True)

    @property
    def failed(self) -> bool:
        """Whether the loop has ended by itself; ``failure`` is the reason."""
        return bool(self.failure)

    def start(self) -> None:
        """Start to tick."""
        self._thread.start()

    def stop(self, timeout: float) -> None:
        """End the loop and wait for it, at most ``timeout`` [s]."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(timeout)

    def _run(self) -> None:
        try:
            self._loop.run(self._stop)
        except Exception:  # noqa: BLE001 - whatever it is, the program must report it and end
            self.failure = traceback.format_exc()


class ExecutorThread:
    """
    Spins an executor; a callback's exception is logged, and the others go on.

    :param executor: holds the nodes.
    :param logger: takes what callbacks raise.
    """

    def __init__(self, executor: SingleThreadedExecutor, logger: RcutilsLogger) -> None:
        self._executor = executor
        self._logger = logger
        self._stopped = False
        self._thread = threading.Thread(target=self._run, name='executor', daemon=True)

    def start(self) -> None:
        """Start to spin."""
        self._thread.start()

    def stop(self, timeout: float) -> None:
        """End the executor and wait for it, at most ``timeout`` [s]."""
        self._stopped = True
        self._executor.create_task(lambda: None)  # a mere wake does not end spin_once
        if self._thread.is_alive():
            self._thread.join(timeout)
        self._executor.shutdown(0.0)

    def _run(self) -> None:
        limit = DutyLimit()
        while not self._stopped:
            limit.rest()
            try:
                self._executor.spin_once()
            except ExternalShutdownException:
                return
            except rclpy_implementation.RCLError as error:
                self._logger.warning(f'an answer was not delivered: {error}')
            except Exception:  # noqa: BLE001 - no request may end the program
                self._logger.error(
                    'a request failed inside the program; please report this:\n'
                    + traceback.format_exc()
                )
