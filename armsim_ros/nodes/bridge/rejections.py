# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Why a server rejected a goal: an action's rejection has no text, but the server's log has."""

from __future__ import annotations

import asyncio

from rcl_interfaces.msg import Log
from rclpy.qos import QoSDurabilityPolicy, QoSProfile

from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.rosapi.graph import Graph

#: Nodes keep what they have logged for late subscribers.
_PROFILE = QoSProfile(depth=1000, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
#: How long the log may take to arrive [s].
_PATIENCE = 0.7


async def logged_error(link: BridgeLink, action: str, since: int) -> str:
    """
    Return the error that an action's server has logged, '' where there is none.

    :param action: full name.
    :param since: what is older is another's [ns], of the system's clock.
    """
    servers = [node.strip('/').replace('/', '.')
               for node in Graph(link).providers([f'{action}/_action/send_goal'])]
    found: asyncio.Future[str] = link.loop.create_future()

    def settle(text: str) -> None:
        if not found.done():
            found.set_result(text)

    def receive(message: Log) -> None:
        stamp = message.stamp.sec * 10**9 + message.stamp.nanosec
        if message.level >= Log.ERROR and stamp >= since and any(
                f'{message.name}.'.startswith(f'{server}.') for server in servers):
            link.schedule(lambda: settle(message.msg))

    subscription = await link.run(
        lambda: link.node.create_subscription(Log, '/rosout', receive, _PROFILE))
    try:
        return await asyncio.wait_for(found, _PATIENCE)
    except (asyncio.TimeoutError, TimeoutError):
        return ''
    finally:
        link.in_thread(lambda: link.node.destroy_subscription(subscription))
