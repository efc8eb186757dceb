# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Meshes and textures of the robot over HTTP: ``/package/PACKAGE/PATH``."""

from __future__ import annotations

import asyncio
from functools import partial
from http import HTTPStatus
from pathlib import Path
import re
from urllib.parse import unquote

from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from std_msgs.msg import String
from websockets.http11 import Request, Response

from armsim_ros.nodes.access import answer
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.packages import Packages

PREFIX = '/package/'
#: Ending -> kind of content; no other file is served.
_KINDS = {
    '.dae': 'model/vnd.collada+xml', '.fbx': 'application/octet-stream', '.stl': 'model/stl',
    '.obj': 'model/obj', '.mtl': 'model/mtl', '.glb': 'model/gltf-binary',
    '.gltf': 'model/gltf+json', '.urdf': 'application/xml', '.xacro': 'application/xml',
    '.png': 'image/png', '.jpg': 'image/jpeg', '.jpeg': 'image/jpeg', '.webp': 'image/webp',
    '.tif': 'image/tiff', '.tiff': 'image/tiff',
}
_PACKAGE = re.compile(r'(?:package|model)://([^/"\'\s<>]+)')
_DESCRIPTION = 'robot_description'
_LATCHED = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
#: How long a description may take to arrive, and how often that is checked [s].
_PATIENCE, _PAUSE = 2.0, 0.05


class PackageFiles:
    """
    Files of the packages that a robot description in the graph names.

    :param packages: where packages are found.
    """

    def __init__(self, link: BridgeLink, packages: Packages) -> None:
        self._link, self._packages = link, packages
        self._named: dict[str, set[str]] = {}
        self._topics: set[str] = set()

    async def get(self, path: str, request: Request) -> Response | None:
        """Return the answer to a GET; None for a path that is not of packages."""
        if not path.startswith(PREFIX):
            return None
        package, _, rest = unquote(path.removeprefix(PREFIX)).partition('/')
        content = await self.read(package, rest)
        if content is None:
            return answer(HTTPStatus.NOT_FOUND, 'no such mesh or texture of a package that a '
                          'robot_description names\n')
        response = answer(HTTPStatus.OK, content, _KINDS[Path(rest).suffix.lower()])
        if origin := request.headers.get('Origin'):  # the access rules have admitted it
            response.headers['Access-Control-Allow-Origin'] = origin
        return response

    async def read(self, package: str, path: str) -> bytes | None:
        """Return a file's content, None where it may not be read or is not there."""
        if Path(path).suffix.lower() not in _KINDS or not await self._is_named(package):
            return None
        return await asyncio.to_thread(self._content, package, path)

    async def _is_named(self, package: str) -> bool:
        """Return whether a description names a package; the first call waits for them."""
        for _ in range(round(_PATIENCE / _PAUSE)):
            self._subscribe()
            if any(package in found for found in self._named.values()):
                return True
            if self._topics and len(self._named) >= len(self._topics):
                return False
            await asyncio.sleep(_PAUSE)
        return False

    def _subscribe(self) -> None:
        """Read the descriptions that have appeared."""
        for name, types in self._link.topic_types().items():
            if (name.rpartition('/')[2] == _DESCRIPTION and 'std_msgs/msg/String' in types
                    and name not in self._topics):
                self._topics.add(name)
                self._link.subscribe(String, name, _LATCHED, partial(self._receive, name))

    def _receive(self, topic: str, message: String) -> None:
        self._named[topic] = set(_PACKAGE.findall(message.data))

    def _content(self, package: str, path: str) -> bytes | None:
        folder = self._packages.find(package)
        if folder is None:
            return None
        try:
            file = (folder / path).resolve()
            return file.read_bytes() if file.is_relative_to(folder.resolve()) else None
        except (OSError, ValueError):
            return None
