# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A controller manager for a program that has nothing else to do: calls wait, refusals raise."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import TimeoutError as FutureTimeoutError
import math
import time
from typing import Any

from controller_manager_msgs.srv import ListControllers

from armsim_ros.clients.controller_manager import ControllerManagerClient, STRICT
from armsim_ros.clients.ros_client import NotServedError, RosClient
from armsim_ros.errors import ControllerError

#: How often a call is made that is not answered.
TRIES = 3
#: Period at which a service is waited for [s]; that of rclpy is a quarter of a second.
_LOOK = 0.02
#: A manager is discovered in this time; only a longer wait is reported [s].
_SILENT_WAIT = 1.0
_DONE = {'load_controller': 'loaded', 'configure_controller': 'configured',
         'cleanup_controller': 'cleaned up', 'unload_controller': 'unloaded'}


class ManagerClient(ControllerManagerClient):
    """
    A manager by its name.

    All that the manager refuses raises a ControllerError.

    :param client: the program's node.
    :param manager: the manager's name, absolute or relative to the namespace.
    :param call_timeout: [s] for an answer.
    :param namespace: '' is that of the node.
    """

    def __init__(
        self, client: RosClient, manager: str, call_timeout: float, namespace: str = ''
    ) -> None:
        namespace = (namespace or client.node.get_namespace()).rstrip('/')
        self.name = manager if manager.startswith('/') else f'{namespace}/{manager}'
        self._ros = client
        self._call_timeout = call_timeout
        super().__init__(self, self.name)

    @property
    def namespace(self) -> str:
        """The namespace of the manager and of its controllers, such as ``/sunday``."""
        return self.name.rpartition('/')[0] or '/'

    def wait(self, timeout: float) -> None:
        """
        Wait until the manager answers.

        :param timeout: [s]; 0 waits for ever.
        :raises ControllerError: it does not appear in time.
        """
        service = f'{self.name}/list_controllers'
        limit = timeout or math.inf
        if self._appears(ListControllers, service, min(limit, _SILENT_WAIT)):
            return
        self._ros.node.get_logger().info(f'waiting for {self.name} to become available')
        if not self._appears(ListControllers, service, limit - _SILENT_WAIT):
            raise ControllerError(
                f'no controller manager answers as {self.name} within {timeout:g} s; start the '
                "simulation, or name the manager with '-c'"
            )

    def switch(
        self,
        *,
        activate: Sequence[str] = (),
        deactivate: Sequence[str] = (),
        strictness: int = STRICT,
        timeout: float = 5.0,
        asap: bool = True,
    ) -> Any:
        """Switch controllers; strictly, all or none."""
        response = super().switch(activate=activate, deactivate=deactivate, timeout=timeout,
                                  strictness=strictness, asap=asap)
        if not response.ok:
            names = ', '.join([*activate, *deactivate])
            reason = response.message or 'the manager refuses to switch'
            raise ControllerError(f'{names}: {reason}')
        return response

    def call(self, service: str, kind: type[Any], request: Any = None) -> Any:
        """
        Call a service that may not be there yet, and return its response.

        :raises ControllerError: no answer, several times.
        """
        for _ in range(TRIES):
            deadline = time.monotonic() + self._call_timeout
            if not self._appears(kind, service, self._call_timeout):
                continue
            answer = self._ros.call(kind, service, request)
            try:
                return answer.result(max(0.0, deadline - time.monotonic()))
            except (FutureTimeoutError, TimeoutError, NotServedError):
                answer.cancel()
        raise ControllerError(
            f'{service} did not answer {TRIES} times within {self._call_timeout:g} s')

    def _named(self, service: str, kind: type[Any], name: str) -> bool:
        if not super()._named(service, kind, name):
            raise ControllerError(f"'{name}' could not be {_DONE[service]}; see the manager's log")
        return True

    def _appears(self, kind: type[Any], service: str, timeout: float) -> bool:
        """Return whether a service is there within a time [s]."""
        self._ros.prepare(kind, service)
        deadline = time.monotonic() + timeout
        while not self._ros.serves(kind, service):
            if time.monotonic() > deadline:
                return False
            time.sleep(_LOOK)
        return True
