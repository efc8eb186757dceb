# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The node of one command: discovery, calls, subscriptions. Imports rclpy when it is made."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Mapping
import os
from pathlib import Path
import time
from typing import Any, TypeVar

from armsim_ros2.errors import CliError, hint
from armsim_ros2.interfaces import load

T = TypeVar('T')

_PROFILES = ('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE')
#: Discovery is complete when nothing new has come for so many periods: more than the 0.3 s after
#: which a program announces itself again if its first answer was lost.
_QUIET = 16
#: How many times as long it takes if more programs run than there are processors.
_BUSY = 4
#: How many periods more discovery may take if a node is known without its publishers.
_LATE = 75
#: How often the graph is read while something is expected [s].
_PERIOD = 0.02
#: Longest wait inside the middleware; Ctrl-C takes effect after it [s].
_SPIN = 0.1
#: How long a server may take for its response when no limit is given [s].
_NO_LIMIT = float('inf')


class Session:
    """
    A hidden node and its executor, as a context manager.

    :param options: spin_time, use_sim_time and ros_args of the command line, if it has them.
    :param name: of the node; by default a hidden one.
    """

    def __init__(self, options: Namespace, name: str | None = None) -> None:
        self.fast = announce_often()
        import rclpy
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.parameter import Parameter
        from rclpy.signals import SignalHandlerOptions

        self._spin_time = float(getattr(options, 'spin_time', 0.5))
        self._context = Context()
        words = [word for word in getattr(options, 'ros_args', None) or () if word != '--ros-args']
        try:
            # Without external logging no file is written.
            rclpy.init(context=self._context, signal_handler_options=SignalHandlerOptions.NO,
                       args=['--ros-args', '--disable-external-lib-logs', *words])
        except (RuntimeError, ValueError) as error:
            raise CliError(f'the middleware does not start: {error}') from None
        self.node = rclpy.create_node(
            name or f'_ros2cli_{os.getpid()}', context=self._context,
            start_parameter_services=False, automatically_declare_parameters_from_overrides=True,
            parameter_overrides=[
                Parameter('use_sim_time', value=bool(getattr(options, 'use_sim_time', False))),
                Parameter('start_type_description_service', value=False)])
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._start = time.monotonic()
        self._settled = False

    def __enter__(self) -> Session:
        """Return the session."""
        return self

    def __exit__(self, *failure: object) -> None:
        """Remove the node from the graph."""
        import rclpy

        self._executor.shutdown(0)
        self.node.destroy_node()
        rclpy.shutdown(context=self._context)

    def settle(self) -> None:
        """Wait until discovery brings nothing new, at most for the spin time."""
        if self._settled:
            return
        self._settled = True
        # Periods are counted instead of seconds: a machine that delays this process delays
        # discovery, too. If it is busy, other programs answer later.
        scale = _BUSY if os.getloadavg()[0] > (os.cpu_count() or 1) else 1
        most = scale * round(self._spin_time / _PERIOD)
        last, quiet = self._size(), 0
        for period in range(most + _LATE):
            if (quiet >= scale * _QUIET or period >= most) and self._is_complete():
                return
            time.sleep(_PERIOD)
            size = self._size()
            quiet = quiet + 1 if size == last and size[0] > 1 else 0
            last = size

    def _size(self) -> tuple[int, int, int]:
        return (len(self.node.get_node_names()), len(self.node.get_topic_names_and_types()),
                len(self.node.get_service_names_and_types()))

    def _is_complete(self) -> bool:
        """Return whether publishers are known of every node; each node has some."""
        from rclpy.node import NodeNameNonExistentError

        try:
            return all(self.node.get_publisher_names_and_types_by_node(*names)
                       for names in self.node.get_node_names_and_namespaces())
        except NodeNameNonExistentError:
            return False

    def find(self, check: Callable[[], T | None], patience: float = 0.0) -> T | None:
        """
        Return what a check of the graph finds; None after the time in which a node is discovered.

        :param check: returns None or another false value as long as it finds nothing.
        :param patience: longer time to wait [s].
        """
        end = self._start + max(patience, 2.0 if self.fast else 5.0)
        while True:
            found = check()
            if found or time.monotonic() > end:
                return found or None
            time.sleep(_PERIOD)

    def absolute(self, name: str) -> str:
        """
        Return the full name of a topic, service or action.

        :raises CliError: the name is not valid.
        """
        from rclpy.exceptions import InvalidServiceNameException, InvalidTopicNameException
        from rclpy.expand_topic_name import expand_topic_name
        from rclpy.validate_full_topic_name import validate_full_topic_name

        try:
            full = expand_topic_name(name, self.node.get_name(), self.node.get_namespace())
            validate_full_topic_name(full)
        except (ValueError, InvalidServiceNameException, InvalidTopicNameException) as error:
            raise CliError(' '.join(str(error).split())) from None
        return str(full)

    def topics(self, hidden: bool = True) -> dict[str, list[str]]:
        """Return the topics of the graph and their types, sorted."""
        return visible(self.node.get_topic_names_and_types(), hidden)

    def services(self, hidden: bool = True) -> dict[str, list[str]]:
        """Return the services of the graph and their types, sorted."""
        return visible(self.node.get_service_names_and_types(), hidden)

    def actions(self) -> dict[str, list[str]]:
        """Return the actions of the graph and their types, sorted."""
        from rclpy.action import get_action_names_and_types

        return visible(get_action_names_and_types(self.node), True)

    def nodes(self, hidden: bool = False) -> list[str]:
        """Return the full names of the nodes in the graph, sorted; duplicates stay."""
        return sorted(
            f'{namespace.rstrip("/")}/{name}'
            for name, namespace in self.node.get_node_names_and_namespaces()
            if hidden or (name and not name.startswith('_')))

    def types_of(self, name: str, known: Callable[[], Mapping[str, list[str]]],
                 message: str, patience: float = 0.0) -> list[str]:
        """
        Return the types of a topic, service or action as soon as it is in the graph.

        :param known: returns those in the graph.
        :param message: of the failure; {} is the name.
        :raises CliError: it is not in the graph.
        """
        full = self.absolute(name)
        types = self.find(lambda: known().get(full), patience)
        if types is None:
            raise CliError(message.format(name) + hint(full, known()))
        return types

    def require_node(self, name: str, hidden: bool = False, patience: float = 0.0,
                     message: str = "Node not found: '{}'") -> str:
        """
        Return the full name of a node as soon as it is in the graph.

        :param message: of the failure; {} is the name.
        :raises CliError: it is not in the graph.
        """
        full = name if name.startswith('/') else f'/{name}'
        if not self.find(lambda: full in self.nodes(hidden), patience):
            raise CliError(message.format(name) + hint(full, self.nodes(hidden)))
        return full

    def spin(self, done: Callable[[], bool] = lambda: False, limit: float = _NO_LIMIT) -> bool:
        """
        Run callbacks.

        :param done: ends it; checked after each callback.
        :param limit: longest time [s].
        :returns: whether it is done.
        """
        end = time.monotonic() + limit
        while not done():
            left = end - time.monotonic()
            if left <= 0:
                return False
            self._executor.spin_once(timeout_sec=min(_SPIN, left))
        return True

    def client(self, kind: str, name: str, patience: float = 0.0) -> Any:
        """
        Return a client whose service is available.

        :param kind: type of the service.
        :raises CliError: it is not in the graph in time.
        """
        client = self.node.create_client(load(kind, 'srv'), name)
        if not self.find(client.service_is_ready, patience):
            raise CliError(f"Service '{name}' is not available{hint(name, self.services())}")
        return client

    def call(self, kind: str, name: str, /, patience: float = 0.0, limit: float = 10.0,
             **fields: Any) -> Any:
        """
        Call a service and return its response.

        :param kind: type of the service.
        :param patience: how long the service may take to appear [s].
        :param limit: how long the response may take [s].
        :param fields: of the request.
        :raises CliError: the service does not appear or does not respond in time.
        """
        client = self.client(kind, name, patience)
        future = client.call_async(load(kind, 'srv').Request(**fields))
        if not self.spin(future.done, limit):
            raise CliError(f"Service '{name}' did not respond within {limit:g} s")
        return future.result()


def visible(names_and_types: list[tuple[str, list[str]]], hidden: bool) -> dict[str, list[str]]:
    """
    Return names and types, sorted by name.

    :param hidden: whether names with a part that begins with an underscore are included.
    """
    return {name: types for name, types in sorted(names_and_types)
            if hidden or not any(part.startswith('_') for part in name.split('/'))}


def other_types(types: list[str], kind: str) -> str:
    """
    Return the types that differ from a type, with commas between.

    :param types: those of a service or action; a client of this process adds its own.
    :param kind: such as ``std_srvs/srv/Trigger`` or ``std_srvs/Trigger``.
    """
    return ', '.join(name for name in types if name.split('/')[::2] != [
        kind.partition('/')[0], kind.rpartition('/')[2]])


def announce_often() -> bool:
    """
    Let Fast DDS announce this process often; a user's own settings are kept.

    :returns: whether nodes are discovered quickly.
    """
    chosen = [os.environ[name] for name in _PROFILES if os.environ.get(name)]
    if chosen:
        return Path(chosen[0]).name == 'fastdds_profiles.xml'
    if Path('DEFAULT_FASTRTPS_PROFILES.xml').is_file():
        return False
    os.environ[_PROFILES[0]] = str(Path(__file__).with_name('fastdds_profiles.xml'))
    return True
