# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The node of one command: names of the graph, calls. Imports rclpy when it is made."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Iterable
import faulthandler
import os
import signal
import threading
import time
from types import FrameType
from typing import Any, TypeVar

from armsim_ros2.discovery import announce_often, settle
from armsim_ros2.errors import CliError, hint
from armsim_ros2.interfaces import load
from armsim_ros2.parsing import Arguments, node_options, Verb

T = TypeVar('T')

#: After this time without an answer a name is not in the graph, with and without frequent
#: announcements [s].
PATIENCE = {True: 2.0, False: 5.0}
#: How often the graph is read while something is expected [s].
_PERIOD = 0.02
#: Longest wait inside the middleware; Ctrl-C takes effect after it [s].
_SPIN = 0.1
#: A shutdown that takes longer is blocked for good, however busy the machine is [s].
_SHUTDOWN_LIMIT = 30.0
_STDERR = 2


class _HeldSignals:
    """
    Defers SIGINT and SIGTERM until ``deliver``, as a context manager.

    An exception within a callback leaves its callback group busy for ever, so that the answer to
    a cancel request would never be read.
    """

    def __init__(self) -> None:
        self._handlers: dict[int, Callable[[int, FrameType | None], Any]] = {}
        self._noted: list[int] = []

    def __enter__(self) -> _HeldSignals:
        """Take over the handlers, if this is the main thread."""
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                handler = signal.getsignal(number)
                if callable(handler):
                    self._handlers[number] = handler
                    signal.signal(number, lambda number, _: self._noted.append(number))
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        """Give the handlers back."""
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        if kind is None:
            self.deliver()

    def deliver(self) -> None:
        """Call the handler of a signal that has come."""
        if self._noted:
            number = self._noted.pop(0)
            self._handlers[number](number, None)


class Session:
    """
    A hidden node and its executor, as a context manager.

    With simulated time it begins when that is known, or after the spin time.

    :param options: spin_time, use_sim_time and ros_args of the command line, if it has them.
    :param name: of the node; by default a hidden one.
    """

    def __init__(self, options: Namespace, name: str | None = None) -> None:
        self._patience = PATIENCE[announce_often()]
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
        if getattr(options, 'use_sim_time', False):
            clock = self.node.get_clock()
            self.spin(lambda: clock.now().nanoseconds > 0, self._spin_time)

    def __enter__(self) -> Session:
        """Return the session."""
        return self

    def __exit__(self, *failure: object) -> None:
        """Remove the node from the graph."""
        import rclpy

        self._executor.shutdown(0)
        # Fast DDS may block for good and hold Python's lock, see armsim_ros.nodes.shutdown.
        faulthandler.dump_traceback_later(_SHUTDOWN_LIMIT, exit=True, file=_STDERR)
        try:
            self.node.destroy_node()
            rclpy.shutdown(context=self._context)
        finally:
            faulthandler.cancel_dump_traceback_later()

    def settle(self) -> None:
        """Wait until discovery brings nothing new, at most for the spin time."""
        if not self._settled:
            self._settled = True
            settle(self.node, self._spin_time)

    def find(self, check: Callable[[], T | None], patience: float = 0.0) -> T | None:
        """
        Return what a check of the graph finds; None after the time in which a node is discovered.

        :param check: returns None or another false value as long as it finds nothing.
        :param patience: longer time to wait [s].
        """
        end = self._start + max(patience, self._patience)
        while not (found := check()):
            if time.monotonic() > end:
                self.settle()
                return check() or None
            time.sleep(_PERIOD)
        return found

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

    def names(self, kind: str, hidden: bool = True) -> dict[str, list[str]]:
        """
        Return names in the graph and their types, sorted by name.

        :param kind: topic, service or action.
        """
        if kind == 'action':
            from rclpy.action import get_action_names_and_types

            return visible(get_action_names_and_types(self.node), hidden)
        return visible(getattr(self.node, f'get_{kind}_names_and_types')(), hidden)

    def nodes(self, hidden: bool = False) -> list[str]:
        """Return the full names of the nodes in the graph, sorted; duplicates stay."""
        return sorted(
            f'{namespace.rstrip("/")}/{name}'
            for name, namespace in self.node.get_node_names_and_namespaces()
            if hidden or (name and not name.startswith('_')))

    def types_of(self, kind: str, name: str, message: str = "Unknown {0} '{1}'") -> list[str]:
        """
        Return the types of a topic, service or action as soon as it is in the graph.

        :param message: of the failure; {0} is the kind, {1} the name.
        :raises CliError: it is not in the graph.
        """
        full = self.absolute(name)
        types = self.find(lambda: self.names(kind).get(full))
        if types is None:
            raise CliError(message.format(kind, name) + hint(full, self.names(kind)))
        return types

    def require_node(self, name: str, hidden: bool = False, patience: float = 0.0,
                     known: Callable[[bool], Iterable[str]] | None = None,
                     message: str = "Node not found: '{}'") -> str:
        """
        Return the full name of a node as soon as it is in the graph.

        :param known: returns the nodes that may be chosen; all by default.
        :param message: of the failure; {} is the name.
        :raises CliError: it is not in the graph.
        """
        nodes = known or self.nodes
        full = name if name.startswith('/') else f'/{name}'
        if not self.find(lambda: full in nodes(hidden), patience):
            raise CliError(message.format(name) + hint(full, nodes(hidden)))
        return full

    def spin(self, done: Callable[[], bool] = lambda: False, limit: float = float('inf')) -> bool:
        """
        Run callbacks.

        :param done: ends it; checked after each callback.
        :param limit: longest time [s].
        :returns: whether it is done.
        """
        end = time.monotonic() + limit
        with _HeldSignals() as signals:
            while not done():
                left = end - time.monotonic()
                if left <= 0:
                    return False
                self._executor.spin_once(timeout_sec=min(_SPIN, left))
                signals.deliver()
        return True

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
        service = load(kind, 'srv')
        client = self.node.create_client(service, name)
        if not self.find(client.service_is_ready, patience):
            raise CliError(f"Service '{name}' is not available{hint(name, self.names('service'))}")
        future = client.call_async(service.Request(**fields))
        if not self.spin(future.done, limit):
            raise CliError(f"Service '{name}' did not respond within {limit:g} s")
        return future.result()


def graph_verb(about: str, run: Callable[[Session, Namespace], int | None], *arguments: Arguments
               ) -> Verb:
    """
    Return a verb that reads the graph.

    :param run: gets the session and the parsed arguments.
    """
    def run_in_session(options: Namespace) -> int | None:
        with Session(options) as session:
            return run(session, options)

    return Verb(about, run_in_session, [*arguments, node_options])


def visible(names_and_types: Iterable[tuple[str, list[str]]], hidden: bool
            ) -> dict[str, list[str]]:
    """
    Return names and types, sorted by name.

    :param hidden: whether names with a part that begins with an underscore are included.
    """
    return {name: types for name, types in sorted(names_and_types)
            if hidden or not any(part.startswith('_') for part in name.split('/'))}


def refuse_other_type(session: Session, kind: str, name: str, wanted: str) -> None:
    """
    Fail if a service or action exists with another type: a client would wait for ever.

    :param kind: service or action.
    :param wanted: its type, such as ``std_srvs/srv/Trigger`` or ``std_srvs/Trigger``.
    :raises CliError: it has other types than this one, which clients add to the graph.
    """
    package, *_, last = wanted.split('/')
    others = [found for found in session.names(kind).get(name, ())
              if found.split('/')[::2] != [package, last]]
    if others:
        raise CliError(f"The passed {kind} type is invalid: '{name}' has the type "
                       f"'{', '.join(others)}', not '{wanted}'")
