# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The control thread and the executor's thread, and what becomes of their failures."""

from __future__ import annotations

import threading
import traceback

from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.impl.rcutils_logger import RcutilsLogger

from armsim_ros.sim.control_loop import ControlLoop


class ControlThread:
    """
    Runs the control loop.

    :param loop: the loop; nothing else may tick it.
    """

    def __init__(self, loop: ControlLoop) -> None:
        """Prepare; nothing runs yet."""
        self.failure = ''
        self._loop = loop
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name='control', daemon=True)

    @property
    def failed(self) -> bool:
        """Whether the loop ended by itself; ``failure`` tells why."""
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
        except Exception:  # noqa: BLE001 - whatever it is, the program must say it and end
            self.failure = traceback.format_exc()


class ExecutorThread:
    """
    Spins an executor; what a callback raises is logged, and the others go on.

    :param executor: holds the nodes.
    :param logger: takes what callbacks raise.
    """

    def __init__(self, executor: SingleThreadedExecutor, logger: RcutilsLogger) -> None:
        """Prepare; nothing runs yet."""
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
        while not self._stopped:
            try:
                self._executor.spin_once()
            except ExternalShutdownException:
                return
            except Exception:  # noqa: BLE001 - no request may end the program
                self._logger.error(
                    'a request failed inside the program; please report this:\n'
                    + traceback.format_exc()
                )
