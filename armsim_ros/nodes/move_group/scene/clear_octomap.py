# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``clear_octomap``."""

from __future__ import annotations

from std_srvs.srv import Empty

from armsim_ros.nodes.move_group.context import Context


class ClearOctomap:
    """
    Answers that there is no octomap.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(Empty, 'clear_octomap', self._answer)

    async def _answer(self, request: Empty.Request, response: Empty.Response) -> Empty.Response:
        self._context.warn_once('clear_octomap: octomaps are not supported, nothing to clear')
        return response
