# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services of a vendor's endpoints."""

import asyncio
from types import SimpleNamespace

import pytest
from std_srvs.srv import Trigger

from armsim_ros.errors import SimulationError
from armsim_ros.nodes.vendors import ArmNodes, Endpoints
from armsim_ros.stack import ArmSim


class Offered(ArmNodes):
    """Endpoints whose changes are made at once, and whose services are called directly."""

    def __init__(self):
        self.logged, self._group = [], None
        self.log = SimpleNamespace(error=self.logged.append)

    async def change(self, function):
        """Do it at once."""
        return function()

    def create_service(self, kind, name, handle, **_):
        """Keep what a node would create."""
        self.handle = handle

    def get_logger(self):
        """Return the node's log."""
        return self.log

    def answer(self, function):
        """Offer a service as a node does; return its answer."""
        self.service(self, Trigger, '~/try', function)
        return asyncio.run(self.handle(Trigger.Request(), Trigger.Response()))


@pytest.mark.parametrize(('error', 'text', 'logged'), [
    (SimulationError('the simulation ends'), 'the simulation ends', False),
    (ArithmeticError('no eigenvalues'), 'ArithmeticError: no eigenvalues', True)])
def test_whatever_fails_is_answered(error, text, logged):
    """The client has the reason; a failure that nobody foresaw is in the log, too."""
    def fail(_, response):
        response.success = True
        raise error
    offered = Offered()
    answer = offered.answer(fail)
    assert (answer.success, answer.message) == (False, text)
    assert any('Traceback' in line and text in line for line in offered.logged) is logged


def test_an_unloaded_controller_publishes_once_more():
    """So its endpoints can end what they began; one of the same name has its own."""
    manager, published = ArmSim('sunday').manager, []
    endpoints = Endpoints(SimpleNamespace(manager=manager))
    for name in ('old', 'new'):
        controller = manager.load(SimpleNamespace(
            name='freedrive', type='ur_controllers/FreedriveModeController', parameters={}))
        endpoints.add(controller, SimpleNamespace(
            publish=lambda _, name=name: published.append(name)))
        if name == 'old':
            manager.unload('freedrive')
    for time_ns in (1, 2):
        endpoints.publish(time_ns)
    assert published == ['old', 'new', 'new']
