# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The programs spawner, unspawner and hardware_spawner."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import TimeoutError as FutureTimeoutError
import math
from pathlib import Path
import signal
import sys
import time
from typing import Any, NoReturn

from controller_manager_msgs.srv import ListControllers

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.cli.node_arguments import read_node_arguments
from armsim_ros.clients.controller_manager import ControllerManagerClient, ParameterClient, STRICT
from armsim_ros.clients.ros_client import NotServedError, RosClient
from armsim_ros.errors import ArmsimError, ControllerError
from armsim_ros.nodes.upstream.spawner_arguments import (
    add_manager_options,
    ControllerRequest,
    entries_of,
    parse_spawner_arguments,
    parse_unspawner_arguments,
    SpawnerRequest,
)

#: How often a call is made that is not answered.
TRIES = 3
#: Period at which a service is waited for [s]; that of rclpy is a quarter of a second.
_LOOK = 0.02
#: A manager is discovered in this time; only a longer wait is reported [s].
_SILENT_WAIT = 1.0
_DONE = {'load_controller': 'loaded', 'configure_controller': 'configured',
         'cleanup_controller': 'cleaned up', 'unload_controller': 'unloaded'}


class ManagerClient(ControllerManagerClient):
    """
    A manager by its name.

    All that the manager refuses raises a ControllerError.

    :param manager: the manager's name, absolute or relative to the namespace.
    :param call_timeout: [s] for an answer.
    :param namespace: '' is that of the node.
    """

    def __init__(
        self, client: RosClient, manager: str, call_timeout: float, namespace: str = ''
    ) -> None:
        namespace = (namespace or client.node.get_namespace()).rstrip('/')
        self.name = manager if manager.startswith('/') else f'{namespace}/{manager}'
        self._ros, self._call_timeout = client, call_timeout
        super().__init__(self, self.name)

    @property
    def namespace(self) -> str:
        """The namespace of the manager and of its controllers, such as ``/sunday``."""
        return self.name.rpartition('/')[0] or '/'

    def wait(self, timeout: float) -> None:
        """
        Wait until the manager answers.

        :param timeout: [s]; 0 waits for ever.
        :raises ControllerError: it does not appear in time.
        """
        service = f'{self.name}/list_controllers'
        limit = timeout or math.inf
        if self._appears(ListControllers, service, min(limit, _SILENT_WAIT)):
            return
        self._ros.node.get_logger().info(f'waiting for {self.name} to become available')
        if not self._appears(ListControllers, service, limit - _SILENT_WAIT):
            raise ControllerError(
                f'no controller manager answers as {self.name} within {timeout:g} s; start the '
                "simulation, or name the manager with '-c'")

    def switch(
        self, *, activate: Sequence[str] = (), deactivate: Sequence[str] = (),
        strictness: int = STRICT, timeout: float = 5.0, asap: bool = True
    ) -> Any:
        """Switch controllers; strictly, all or none."""
        response = super().switch(activate=activate, deactivate=deactivate, timeout=timeout,
                                  strictness=strictness, asap=asap)
        if not response.ok:
            names = ', '.join([*activate, *deactivate])
            reason = response.message or 'the manager refuses to switch'
            raise ControllerError(f'{names}: {reason}')
        return response

    def call(self, service: str, kind: type[Any], request: Any = None) -> Any:
        """
        Call a service that may not be there yet, and return its response.

        :raises ControllerError: no answer, several times.
        """
        for _ in range(TRIES):
            deadline = time.monotonic() + self._call_timeout
            if not self._appears(kind, service, self._call_timeout):
                continue
            answer = self._ros.call(kind, service, request)
            try:
                return answer.result(max(0.0, deadline - time.monotonic()))
            except (FutureTimeoutError, TimeoutError, NotServedError):
                answer.cancel()
        raise ControllerError(
            f'{service} did not answer {TRIES} times within {self._call_timeout:g} s')

    def _named(self, service: str, kind: type[Any], name: str) -> bool:
        if not super()._named(service, kind, name):
            raise ControllerError(f"'{name}' could not be {_DONE[service]}; see the manager's log")
        return True

    def _appears(self, kind: type[Any], service: str, timeout: float) -> bool:
        """Return whether a service is there within a time [s]."""
        self._ros.prepare(kind, service)
        deadline = time.monotonic() + timeout
        while not self._ros.serves(kind, service):
            if time.monotonic() > deadline:
                return False
            time.sleep(_LOOK)
        return True


#: Time for an answer of the manager [s].
_CALL_TIMEOUT = 10.0
_ENDS = (signal.SIGINT, signal.SIGTERM)


def main(argv: Sequence[str] | None = None) -> int:
    """
    Spawn controllers.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 when all are in the requested state or a signal ended it, 1 at the first failure,
        or with ``--keep-going`` after those that could be loaded.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    request = parse_spawner_arguments(words)
    name = f'spawner_{request.controllers[0].name}'
    return run_client(name, ros_args, lambda client: _Spawner(client, request, ros_args).run())


def run_client(name: str, ros_args: Sequence[str], work: Callable[[RosClient], None]) -> int:
    """
    Run a short-lived client of a manager.

    :param name: the node's name.
    :param work: raises an ArmsimError where it fails, and KeyboardInterrupt at a signal.
    :returns: 0, or 1 after a failure, which is logged.
    """
    for number in _ENDS:
        signal.signal(number, _interrupt)
    with RosClient(name, ros_args) as client:
        try:
            work(client)
        except ArmsimError as error:
            client.node.get_logger().error(str(error))
            return 1
        except KeyboardInterrupt:
            pass
    return 0


def _interrupt(number: int, frame: object) -> NoReturn:
    raise KeyboardInterrupt


class _Spawner:
    """
    A run of the spawner.

    :param ros_args: of the spawner's own node; their parameter files are those of all controllers.
    """

    def __init__(
        self, client: RosClient, request: SpawnerRequest, ros_args: Sequence[str]
    ) -> None:
        node = client.node
        self._log = node.get_logger()
        self._request = request
        self._options = options = request.options
        if request.ignored:
            self._log.warning(f"ignored: {' '.join(request.ignored)}")
        namespace = node.get_namespace()
        if options.namespace:
            if namespace != '/':
                raise ControllerError(
                    f"--namespace {options.namespace} and the remapping '__ns:={namespace}' "
                    'exclude each other; use the remapping alone')
            self._log.warning("'--namespace' is deprecated; use --ros-args -r __ns:=NAMESPACE")
            namespace = f"/{options.namespace.strip('/')}"
        self._files = tuple(
            str(file) for file in read_node_arguments(ros_args, node.get_name()).files)
        for controller in request.controllers:
            for file in (*controller.files, *self._files):
                if not Path(file).is_file():
                    raise ControllerError(f"parameter file '{file}' does not exist")
        self._manager = ManagerClient(
            client, options.controller_manager, options.service_call_timeout, namespace)

    def run(self) -> None:
        """
        Spawn the controllers, and with ``--unload-on-kill`` wait for a signal and unload them.

        :raises ControllerError: a controller cannot be brought into its state.
        """
        try:
            self._spawn()
            if self._options.unload_on_kill:
                self._log.info('waiting for a signal, to unload the controllers then')
                signal.pause()
        except KeyboardInterrupt:
            for number in _ENDS:
                signal.signal(number, signal.SIG_IGN)
            if not self._options.unload_on_kill:
                raise
            names = [controller.name for controller in self._request.controllers
                     if not controller.inactive]
            unload(self._manager, names, self._options.switch_timeout)
            self._log.info(f"unloaded: {', '.join(names) or 'none'}")

    def _spawn(self) -> None:
        options = self._options
        self._manager.wait(options.controller_manager_timeout)
        loaded = self._manager.states()
        lost, group = [], []
        for controller in self._request.controllers:
            name = controller.name
            if name in loaded:
                self._log.warning(f"controller '{name}' is loaded already")
            else:
                try:
                    self._load(controller)
                except ControllerError as error:
                    if not options.keep_going or options.activate_as_group:
                        raise
                    self._log.error(str(error))
                    lost.append(name)
                    continue
            if controller.load_only:
                continue
            self._manager.configure(name)
            if controller.inactive:
                continue
            if options.activate_as_group:
                group.append(name)
            else:
                self._activate([name])
        if group:
            self._activate(group)
        if lost:
            raise ControllerError(f"not loaded: {', '.join(lost)}")

    def _load(self, controller: ControllerRequest) -> None:
        name = controller.name
        described: dict[str, object] = {}
        if controller.ros_args:
            described['node_options_args'] = [
                word for text in controller.ros_args for word in text.split()]
        files = [str(Path(file).resolve()) for file in (*controller.files, *self._files)]
        entries = entries_of(name, self._manager.namespace, files)
        for remark in entries.remarks:
            self._log.error(remark)
        if entries.files:
            described['params_file'] = list(entries.files)
        if entries.type:
            described['type'] = entries.type
        if entries.fallback_controllers:
            described['fallback_controllers'] = list(entries.fallback_controllers)
        if described:
            parameters = ParameterClient(self._manager, self._manager.name)
            refusals = parameters.set_all(
                {f'{name}.{key}': value for key, value in described.items()})
            for parameter, reason in refusals.items():
                if reason:
                    raise ControllerError(f"parameter '{parameter}': {reason}")
        self._manager.load(name)
        self._log.info(f"loaded '{name}'")

    def _activate(self, names: Sequence[str]) -> None:
        options = self._options
        self._manager.switch(
            activate=names, asap=options.switch_asap, timeout=options.switch_timeout)
        self._log.info(f'active: {", ".join(names)}')


def unload(manager: ManagerClient, names: Iterable[str], switch_timeout: float) -> None:
    """
    Deactivate and unload controllers.

    :param switch_timeout: [s].
    :raises ControllerError: a controller is not loaded, or the manager refuses.
    """
    states = manager.states()
    missing = [name for name in names if name not in states]
    if missing:
        loaded = ', '.join(states) or 'none'
        raise ControllerError(f'not loaded: {", ".join(missing)}; loaded: {loaded}')
    active = [name for name in names if states[name] == 'active']
    if active:
        manager.switch(deactivate=active, timeout=switch_timeout)
    for name in names:
        manager.unload(name)


def unspawn(argv: Sequence[str] | None = None) -> int:
    """
    Deactivate and unload controllers.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 when all are gone, 1 at the first failure.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    arguments = parse_unspawner_arguments(words)
    name = f'unspawner_{arguments.controllers[0]}'
    return run_client(name, ros_args, lambda client: _unspawn_all(client, arguments))


def _unspawn_all(client: RosClient, arguments: argparse.Namespace) -> None:
    log = client.node.get_logger()
    manager = ManagerClient(client, arguments.controller_manager, arguments.service_call_timeout)
    manager.wait(arguments.controller_manager_timeout)
    unload(manager, arguments.controllers, arguments.switch_timeout)
    log.info(f'unloaded: {", ".join(arguments.controllers)}')


def set_hardware(argv: Sequence[str] | None = None) -> int:
    """
    Configure or activate hardware components.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0, also after a warning of a component that is not there or does not change its
        state; 1 where no manager answers.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    parser = argparse.ArgumentParser(
        prog='hardware_spawner', description='Configure or activate hardware components.')
    parser.add_argument('components', nargs='+', metavar='NAME',
                        help='name of a hardware component')
    state = parser.add_mutually_exclusive_group(required=True)
    state.add_argument('--activate', dest='state', action='store_const', const='active',
                       help='configure and activate the components')
    state.add_argument('--configure', dest='state', action='store_const', const='inactive',
                       help='configure the components')
    add_manager_options(parser)
    options = parser.parse_args(words)
    return run_client('hardware_spawner', ros_args, lambda client: _set_states(client, options))


def _set_states(client: RosClient, options: argparse.Namespace) -> None:
    log = client.node.get_logger()
    manager = ManagerClient(client, options.controller_manager, _CALL_TIMEOUT)
    manager.wait(options.controller_manager_timeout)
    known = manager.hardware_states()
    for name in options.components:
        if name not in known:
            log.warning(
                f"no hardware component '{name}' is loaded; loaded: {', '.join(known) or 'none'}")
        elif (state := manager.set_hardware_state(name, options.state)) != options.state:
            log.warning(
                f"hardware component '{name}' is {state} and does not become {options.state}")
        else:
            log.info(f"hardware component '{name}' is {state}")
