# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What vendors' endpoints work with, without a middleware between client and arm."""

from types import SimpleNamespace

from armsim_ros.nodes.vendors import ArmNodes


class Node:
    """Takes endpoints and keeps nothing."""

    def __getattr__(self, _):
        return lambda *_, **__: SimpleNamespace(
            publish=lambda _: None, error=lambda _: None, info=lambda _: None)


class Nodes:
    """The services that endpoints create, to be called directly."""

    def __init__(self, sim):
        (self.robot,) = sim.cell.robots
        self.manager, self.loop, self.arm = sim.manager, sim.loop, sim.manager.arm
        self.services = {}
        self.time_ns = 0
        self._sim = sim

    def new_node(self, _):
        return Node()

    def service(self, _, kind, name, answer):
        self.services[name.removeprefix('~/')] = kind, answer

    def trigger(self, _, name, function, done=''):
        self.services[name.removeprefix('~/')] = None, (function, done)

    def once_active(self, controller, node, create):
        if controller.active:
            create()

    set_payload = ArmNodes.set_payload

    def call(self, name, **request):
        """Call a service between two steps; return the response, of a Trigger its message."""
        kind, answer = self.services[name]
        self.arm.time_ns = self._sim.loop.clock.now_ns
        if kind is None:
            function, done = answer
            refusal = function()
            found = SimpleNamespace(success=not refusal, message=refusal or done)
        else:
            found = kind.Response()
            answer(kind.Request(**request), found)
        self._sim.step(20)
        return found
