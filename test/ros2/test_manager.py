# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which controller manager ``ros2 control`` calls."""

from argparse import Namespace

import pytest

from armsim_ros2.errors import CliError
from armsim_ros2.manager import Manager


class Session:
    """
    A graph with controller managers.

    :param managers: their names.
    """

    def __init__(self, *managers):
        self._services = {f'{name}/list_controllers': [
            'controller_manager_msgs/srv/ListControllers'] for name in managers}

    def absolute(self, name):
        """Return a full name."""
        return name if name.startswith('/') else f'/{name}'

    def find(self, check, patience=0.0):
        """Return what is found at once."""
        return check()

    def settle(self):
        """Do nothing: the graph is complete."""

    def names(self, kind):
        """Return the services."""
        return self._services


def manager_of(chosen, *managers):
    """Return the name of the manager that is called."""
    return Manager(Session(*managers), Namespace(controller_manager=chosen)).name


def test_the_only_manager_is_taken(capsys):
    """Without -c, with a line on standard error unless it has the default name."""
    assert manager_of(None, '/left/manager') == '/left/manager'
    assert capsys.readouterr().err == 'using the controller manager /left/manager\n'
    assert manager_of(None, '/left/manager', '/controller_manager') == '/controller_manager'
    assert capsys.readouterr().err == ''


@pytest.mark.parametrize('chosen', [None, '/middle/manager'])
def test_several_managers_are_named(chosen):
    """Without -c, or where the chosen manager is missing; upstream waits for ever."""
    with pytest.raises(CliError, match=r'choose a controller manager with -c: /l/m, /r/m$') as it:
        manager_of(chosen, '/l/m', '/r/m')
    assert it.value.status == 1
