# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The bridge from start to end."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from importlib.util import find_spec
import secrets
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.bridge.advertised import AdvertisedActions, AdvertisedServices
from armsim_ros.nodes.bridge.calls import Goals, ServiceCalls
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.package_files import PackageFiles
from armsim_ros.nodes.bridge.protocol import Protocol
from armsim_ros.nodes.bridge.publishers import Publishers
from armsim_ros.nodes.bridge.rosapi import RosApi
from armsim_ros.nodes.bridge.server import BridgeServer
from armsim_ros.nodes.bridge.settings import BridgeSettings, Permissions, read_settings
from armsim_ros.nodes.bridge.topics import Topics
from armsim_ros.nodes.ports import is_loopback
from armsim_ros.packages import Packages, split_path

#: How long connections may take to close at the end [s].
_END = 1.0


class BridgeProgram:
    """
    The node, the parts that serve the operations, and the port.

    :param given: values of the command line.
    :param ros_args: ``--ros-args`` sections.
    :param renamed: argument -> its parameter, where that has another name; then rosapi is for the
        clients of this bridge alone.
    """

    def __init__(self, given: dict[str, Any], ros_args: Sequence[str],
                 renamed: Mapping[str, str]) -> None:
        self._given, self._ros_args, self._renamed = given, ros_args, renamed
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
        with BridgeLink(self._ros_args, self._loop) as link:
            descriptor = ParameterDescriptor(dynamic_typing=True)
            settings, unused = read_settings(
                self._given, lambda name, value: link.node.declare_parameter(
                    self._renamed.get(name, name), value, descriptor).value)
            if unused:
                print(f'bridge: not used here: {", ".join(unused)}', flush=True)
            token = settings.token
            if not token and not is_loopback(settings.address):
                token = secrets.token_urlsafe(24)
            rosapi = RosApi(link, settings, is_shared=not self._renamed)
            topics = Topics(link)
            files = PackageFiles(link, Packages(split_path(settings.packages_path),
                                                near=split_path(settings.near)))
            goals = Goals(link, settings.cancel_on_disconnect)
            protocol = Protocol(
                link, Permissions.of(settings), topics,
                Publishers(link, settings.unregister_timeout),
                ServiceCalls(link, rosapi.services, settings.default_call_service_timeout),
                AdvertisedServices(link, settings.default_call_service_timeout), goals,
                AdvertisedActions(link))
            server = BridgeServer(settings, token, protocol.receive,
                                  lambda: rosapi.show_clients(server.clients), protocol.drop,
                                  files.get)
            foxglove: Any = None
            try:
                await server.open()
                foxglove = await _open_foxglove(link, settings, token, files)
                print(f'rosbridge: {server.url}', flush=True)
                if foxglove is not None:
                    print(f'foxglove: {foxglove.url}', flush=True)
                await self._ended.wait()
            finally:
                with suppress(asyncio.TimeoutError, TimeoutError):
                    await asyncio.wait_for(server.close(), _END)
                if foxglove is not None:
                    foxglove.close()
                goals.close()
                topics.close()
        return 0


async def _open_foxglove(link: BridgeLink, settings: BridgeSettings, token: str,
                         files: PackageFiles) -> Any:
    """
    Return the server of Foxglove, None where it is not requested.

    :raises ArmsimError: its package is missing, or its port is taken.
    """
    if settings.foxglove == 'false':
        return None
    if find_spec('foxglove') is None:
        raise ArmsimError("foxglove needs the Python package 'foxglove-sdk', which is not "
                          "installed; python3 -m pip install 'armsim_ros[foxglove]'")
    from armsim_ros.nodes.bridge.foxglove_server import FoxgloveServer

    server = FoxgloveServer(link, settings, token, files)
    await server.open()
    return server
