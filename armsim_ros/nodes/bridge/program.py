# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The bridge from start to end."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from importlib.util import find_spec
import secrets
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.bridge.advertised import AdvertisedActions, AdvertisedServices
from armsim_ros.nodes.bridge.calls import Goals, ServiceCalls
from armsim_ros.nodes.bridge.configuration import Configuration, Interface
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.package_files import PackageFiles
from armsim_ros.nodes.bridge.permissions import Permissions
from armsim_ros.nodes.bridge.protocol import Protocol
from armsim_ros.nodes.bridge.publishers import Publishers
from armsim_ros.nodes.bridge.rosapi import RosApi
from armsim_ros.nodes.bridge.server import BridgeServer
from armsim_ros.nodes.bridge.settings import BridgeSettings
from armsim_ros.nodes.bridge.topics import Topics
from armsim_ros.nodes.ports import is_loopback
from armsim_ros.packages import Packages, split_path

#: How long connections may take to close at the end [s].
_END = 1.0


class BridgeProgram:
    """
    The node, and the servers that its configuration has.

    :param interface: of the program.
    :param given: values of the command line.
    :param ros_args: ``--ros-args`` sections.
    """

    def __init__(self, interface: Interface, given: dict[str, Any], ros_args: Sequence[str]
                 ) -> None:
        self._interface, self._given, self._ros_args = interface, given, ros_args
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ended: asyncio.Event | None = None

    def stop(self) -> None:
        """End ``run``; from any thread."""
        if self._loop is not None and self._ended is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._ended.set)

    async def run(self) -> int:
        """
        Serve until ``stop``.

        :returns: the exit status.
        :raises ArmsimError: a value is wrong, or the port cannot be opened.
        """
        self._loop, self._ended = asyncio.get_running_loop(), asyncio.Event()
        self._loop.set_default_executor(ThreadPoolExecutor(1, 'imports'))
        with BridgeLink(self._interface.node, self._ros_args, self._loop) as link:
            descriptor = ParameterDescriptor(dynamic_typing=True)
            configuration = self._interface.read(
                self._given, lambda name, value: link.node.declare_parameter(
                    name, value, descriptor).value)
            if configuration.unused:
                print(f'bridge: not used here: {", ".join(configuration.unused)}', flush=True)
            settings = configuration.settings
            token = settings.token
            if not token and not is_loopback(settings.address):
                token = secrets.token_urlsafe(24)
            files = PackageFiles(link, Packages(split_path(settings.packages_path),
                                                near=split_path(settings.near)))
            rosbridge = (_Rosbridge(link, settings, token, files)
                         if configuration.rosbridge else None)
            foxglove: Any = None
            try:
                if rosbridge is not None:
                    await rosbridge.server.open()
                foxglove = await _open_foxglove(
                    link, configuration, token, files, self._interface.foxglove_port)
                if rosbridge is not None:
                    print(f'rosbridge: {rosbridge.server.url}', flush=True)
                if foxglove is not None:
                    print(f'foxglove: {foxglove.url}', flush=True)
                await self._ended.wait()
            finally:
                if rosbridge is not None:
                    await rosbridge.close()
                if foxglove is not None:
                    foxglove.close()
        return 0


class _Rosbridge:
    """The server of rosbridge, and the parts that serve its operations."""

    def __init__(self, link: BridgeLink, settings: BridgeSettings, token: str,
                 files: PackageFiles) -> None:
        rosapi = RosApi(link, settings)
        self._topics = Topics(link)
        self._goals = Goals(link, settings.cancel_on_disconnect)
        protocol = Protocol(
            link, Permissions.of(settings), self._topics,
            Publishers(link, settings.unregister_timeout),
            ServiceCalls(link, rosapi.services, settings.default_call_service_timeout),
            AdvertisedServices(link, settings.default_call_service_timeout), self._goals,
            AdvertisedActions(link))
        self.server = BridgeServer(settings, token, protocol.receive,
                                   lambda: rosapi.show_clients(self.server.clients),
                                   protocol.drop, files.get)

    async def close(self) -> None:
        """Close the port and all that its clients use."""
        with suppress(asyncio.TimeoutError, TimeoutError):
            await asyncio.wait_for(self.server.close(), _END)
        self._goals.close()
        self._topics.close()


async def _open_foxglove(link: BridgeLink, configuration: Configuration, token: str,
                         files: PackageFiles, port_argument: str) -> Any:
    """
    Return the server of Foxglove, None where it is not requested.

    :raises ArmsimError: its package is missing, or its port is taken.
    """
    if configuration.foxglove is None:
        return None
    if find_spec('foxglove') is None:
        raise ArmsimError("foxglove needs the Python package 'foxglove-sdk', which is not "
                          "installed; python3 -m pip install 'armsim_ros[foxglove]'")
    from armsim_ros.nodes.bridge.foxglove_server import FoxgloveServer

    server = FoxgloveServer(link, configuration.settings, configuration.foxglove, token, files,
                            port_argument)
    await server.open()
    return server
