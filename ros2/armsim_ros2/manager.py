# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controller manager that ``ros2 control`` calls."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
import sys
from typing import Any

from armsim_ros2.errors import CliError
from armsim_ros2.interfaces import load
from armsim_ros2.parameter_files import parameters_in
from armsim_ros2.session import Session

_DEFAULT = 'controller_manager'
_LIST_TYPE = 'controller_manager_msgs/srv/ListControllers'
#: How long the manager may take to appear [s]; launch files call these verbs before it runs.
PATIENCE = 20.0


class Manager:
    """
    A controller manager.

    :param options: controller_manager is its name, None for the only one in the graph.
    :raises CliError: there is none in time, or there are several.
    """

    def __init__(self, session: Session, options: Namespace) -> None:
        self._session = session
        chosen = options.controller_manager
        self.name = session.absolute(chosen) if chosen else self._only()
        if not session.find(lambda: self._is_manager(self.name), 2.0 if chosen else 0.0):
            print(f'waiting for service {self.name}/list_controllers to become available...',
                  file=sys.stderr)
        if not session.find(lambda: self._is_manager(self.name), PATIENCE):
            raise CliError(f'Could not contact service {self.name}/list_controllers'
                           f'{_listing(self._managers())}')

    @property
    def namespace(self) -> str:
        """The namespace of the manager and its controllers, without a slash at the end."""
        return self.name.rpartition('/')[0]

    def call(self, service: str, /, **fields: Any) -> Any:
        """Call a service of the manager and return the response."""
        kind = ''.join(word.capitalize() for word in service.split('_'))
        return self._session.call(f'controller_manager_msgs/srv/{kind}', f'{self.name}/{service}',
                                  patience=PATIENCE, limit=30.0, **fields)

    def controllers(self) -> list[Any]:
        """Return the states of the loaded controllers."""
        return list(self.call('list_controllers').controller)

    def switch(self, activate: list[str], deactivate: list[str], strictness: int = 1,
               asap: bool = True, timeout: float = 5.0) -> Any:
        """
        Switch controllers.

        :param strictness: 1 is best effort, 2 strict, 0 the manager's default.
        :param timeout: [s]
        """
        seconds, rest = divmod(timeout, 1.0)
        duration = load('builtin_interfaces/Duration', 'msg')(
            sec=int(seconds), nanosec=int(rest * 1e9))
        return self.call('switch_controller', activate_controllers=activate,
                         deactivate_controllers=deactivate, strictness=strictness,
                         activate_asap=asap, timeout=duration)

    def set_file(self, controller: str, file: Path) -> None:
        """
        Set the parameters that name a controller's parameter file and its type.

        :raises CliError: the file is not YAML, or the manager refuses.
        """
        from rclpy.parameter import Parameter

        values: dict[str, Any] = {'params_file': [str(file)]}
        for name in ('type', 'fallback_controllers'):
            value = parameters_in(file, f'{self.namespace}/{controller}').get(name)
            if value:
                values[name] = value
        parameters = [Parameter(f'{controller}.{name}', value=value).to_parameter_msg()
                      for name, value in values.items()]
        response = self._session.call('rcl_interfaces/srv/SetParameters',
                                      f'{self.name}/set_parameters', parameters=parameters)
        for parameter, result in zip(parameters, response.results, strict=True):
            if not result.successful:
                raise CliError(f'Setting parameter {parameter.name} failed: {result.reason}')

    def _managers(self) -> list[str]:
        suffix = '/list_controllers'
        return [name.removesuffix(suffix) for name, types in self._session.names('service').items()
                if _LIST_TYPE in types and name.endswith(suffix)]

    def _is_manager(self, name: str) -> bool:
        return name in self._managers()

    def _only(self) -> str:
        """Return the default manager, or the only one in the graph."""
        session, default = self._session, self._session.absolute(_DEFAULT)
        if session.find(self._managers) and not self._is_manager(default):
            session.settle()
        names = self._managers()
        if default in names or not names:
            return default
        if len(names) > 1:
            raise CliError(f'Could not contact service {default}/list_controllers'
                           + _listing(names))
        print(f'using the controller manager {names[0]}', file=sys.stderr)
        return names[0]


def _listing(names: list[str]) -> str:
    return f'; choose a controller manager with -c: {", ".join(names)}' if names else ''
