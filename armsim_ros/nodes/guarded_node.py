# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A node whose services answer whatever they are asked."""

from __future__ import annotations

from collections.abc import Callable
import inspect
import traceback
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node
from rclpy.service import Service
from type_description_interfaces.srv import GetTypeDescription

from armsim_ros.nodes import qos

#: Packages of the services that rclpy serves itself.
_RCLPYS = ('rcl_interfaces', 'type_description_interfaces')

Answer = Callable[[Any, Any], Any]


class GuardedNode(Node):
    """
    A node that answers a request even where the code that should has failed.

    rclpy's own services of parameters and types raise at some requests that others may well
    make, such as a parameter of an unknown type; their clients would wait for ever. They get a
    response in which nothing was done, and where it has room for that, why.

    :param name: of the node.
    :param options: those of ``rclpy.node.Node``.
    """

    def __init__(self, name: str, **options: Any) -> None:
        super().__init__(name, **options)
        for service in self.services:
            if service.srv_type is GetTypeDescription:  # made past create_service
                service.callback = self._guarded(service.srv_type, service.callback)

    def create_service(
        self, srv_type: Any, srv_name: str, callback: Answer, **options: Any
    ) -> Service:
        """Serve, a burst of requests too; a callback that fails is logged and answered for."""
        options.setdefault('qos_profile', qos.SERVICES)
        return super().create_service(
            srv_type, srv_name, self._guarded(srv_type, callback), **options
        )

    def destroy_node(self) -> None:
        """Take all endpoints down; those of actions, too, which rclpy leaves to their makers."""
        for waitable in list(self.waitables):
            if isinstance(waitable, (ActionServer, ActionClient)):
                waitable.destroy()  # type: ignore[no-untyped-call] # rclpy's
        super().destroy_node()  # type: ignore[no-untyped-call] # rclpy's

    def _guarded(self, kind: Any, callback: Answer) -> Answer:
        if inspect.iscoroutinefunction(callback):

            async def later(request: Any, response: Any) -> Any:
                try:
                    return await callback(request, response)
                except Exception as error:  # noqa: BLE001 - the client waits
                    return self._failed(kind, request, error)

            return later

        def now(request: Any, response: Any) -> Any:
            try:
                return callback(request, response)
            except Exception as error:  # noqa: BLE001 - the client waits
                return self._failed(kind, request, error)

        return now

    def _failed(self, kind: Any, request: Any, error: Exception) -> Any:
        """Return an answer that reports that nothing was done, and log why."""
        text = f'{type(error).__name__}: {error}'
        if kind.__module__.startswith(_RCLPYS):
            self.get_logger().warning(f'a request of type {kind.__name__} was not served: {text}')
        else:
            self.get_logger().error(
                f'a request of type {kind.__name__} failed inside the program; please report '
                f'this:\n{traceback.format_exc()}'
            )
        refused = SetParametersResult(successful=False, reason=text)
        if kind is SetParameters:
            return kind.Response(results=[refused] * len(request.parameters))
        if kind is SetParametersAtomically:
            return kind.Response(result=refused)
        return kind.Response()
