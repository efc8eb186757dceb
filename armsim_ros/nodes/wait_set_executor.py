# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An executor whose turns cost little in a node of a hundred endpoints."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Generator, Iterator, Sequence
from contextlib import ExitStack, suppress
from typing import Any, TypeGuard

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.event_handler import EventHandler, QoSPublisherEventType, QoSSubscriptionEventType
from rclpy.exceptions import InvalidHandle
from rclpy.executors import (
    ConditionReachedException,
    ExternalShutdownException,
    ShutdownException,
    SingleThreadedExecutor,
)
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.task import Task

Turn = tuple[Task, Any, Any]
"""What an executor yields: a task, its entity and the entity's node."""

#: The kinds of a node's entities that have a handle, in the order in which they are served, and
#: what they are called in a wait set.
_KINDS = (('timers', 'timer'), ('subscriptions', 'subscription'), ('clients', 'client'),
          ('services', 'service'))
#: How often incompatible endpoints are reported [s].
_PERIOD = 1.0
#: What rclpy has each publisher and subscription listen for, to log a warning; values of both
#: types may be equal.
_WARNINGS = {
    QoSPublisherEventType: (
        QoSPublisherEventType.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS,
        QoSPublisherEventType.RCL_PUBLISHER_INCOMPATIBLE_TYPE),
    QoSSubscriptionEventType: (
        QoSSubscriptionEventType.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS,
        QoSSubscriptionEventType.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE),
}


def _is_warning(entity: Any) -> TypeGuard[EventHandler]:
    """Return whether an entity is an event whose callback only logs a warning."""
    known = getattr(entity, 'only_warns', None)
    if known is None:  # once: it is asked for in every turn, and types of events compare slowly
        known = entity.only_warns = isinstance(entity, EventHandler) and (
            entity.event_type in _WARNINGS[type(entity.event_type)])
    return bool(known)


def _never() -> bool:
    return False


class WaitSetExecutor(SingleThreadedExecutor):
    """
    An executor for a single thread, with the wait set kept from turn to turn.

    rclpy's makes a wait set of all entities for every turn, and after every callback it wakes
    itself to make another. Here entities are collected again only where they have changed, and
    a callback wakes the executor only where another task may have waited for it.

    rclpy adds two events to each publisher and subscription that only log a warning about an
    incompatible endpoint; they are not waited for, but checked once a second.

    Destroyed entities are released at the next turn, or by :meth:`shutdown`.

    :param context: rclpy's; None for its default.
    """

    def __init__(self, *, context: Context | None = None) -> None:
        super().__init__(context=context)
        self._entities: _Entities | None = None
        self._reports_incompatible = False

    def add_node(self, node: Node) -> bool:
        """Run a node; the first must stay as long as the executor."""
        if not self._reports_incompatible:
            self._reports_incompatible = True
            node.create_timer(
                _PERIOD, self._report_incompatible, clock=Clock(clock_type=ClockType.STEADY_TIME))
        return bool(super().add_node(node))

    def can_execute(self, entity: Any) -> bool:
        """Return whether to wait for an entity."""
        return not _is_warning(entity) and bool(super().can_execute(entity))

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """Do as rclpy's executor; from the thread that runs the callbacks."""
        if self._entities is not None:
            self._entities.close()
            self._entities = None
        return super().shutdown(timeout_sec)

    @property
    def has_unfinished(self) -> bool:
        """Whether a callback, coroutine or task has not ended, or not begun."""
        return any(not task.done() and not task.cancelled() for task, *_ in self._tasks)

    def _report_incompatible(self) -> None:
        events = [each for node in self.get_nodes() for each in node.waitables
                  if _is_warning(each)]
        if not events:
            return  # an empty wait set is an error
        context = self._context.handle
        assert context is not None  # a node of it has called this
        with ExitStack() as alive:
            alive.enter_context(context)
            wait_set = _rclpy.WaitSet(0, 0, 0, 0, 0, len(events), context)
            wait_set.clear_entities()
            listed = []
            for event in events:
                try:
                    alive.enter_context(event)
                except InvalidHandle:  # destroyed by another thread
                    continue
                event.add_to_wait_set(wait_set)
                listed.append(event)
            wait_set.wait(0)
            for event in listed:
                if event.is_ready(wait_set):
                    event.callback(event.take_data())

    def _make_handler(
        self, entity: Any, node: Node,
        take_from_wait_list: Callable[[Any], Callable[[], Coroutine[Any, Any, None]] | None],
    ) -> Task:
        """Return a task that takes what is there for an entity and runs its callback."""
        entity._executor_event = True

        async def handler() -> None:
            if self._is_shutdown or not entity.callback_group.beginning_execution(entity):
                entity._executor_event = False
                self.wake()
                return
            execute = take_from_wait_list(entity)
            entity._executor_event = False
            wake_others()
            try:
                if execute is not None:
                    await execute()
            finally:
                entity.callback_group.ending_execution(entity)
                wake_others()

        def wake_others() -> None:
            # Unfinished tasks have been continued before the wait; some may wait for this one.
            if any(other is not task and not other.done() for other, *_ in self._tasks):
                self.wake()

        task = Task(handler, executor=self)
        with self._tasks_lock:
            self._tasks.append((task, entity, node))
        return task

    def _wait_for_ready_callbacks(
        self, timeout_sec: Any = None, nodes: list[Node] | None = None,
        condition: Callable[[], bool] = _never,
    ) -> Generator[Turn, None, None]:
        """
        Yield what is ready, as rclpy's executor does; with a timeout, that is what does it.

        :raises ShutdownException: the executor was shut down.
        :raises ConditionReachedException: ``condition`` is true.
        """
        if timeout_sec is not None or nodes is not None:
            yield from super()._wait_for_ready_callbacks(timeout_sec, nodes, condition)
            return
        found = False
        while not found and not self._is_shutdown and not condition():
            for turn in self._unfinished():
                found = True
                yield turn
            for entity, node, take in self._ready():
                found = True
                yield self._make_handler(entity, node, take), entity, node
        if self._is_shutdown:
            raise ShutdownException
        if condition():
            raise ConditionReachedException

    def _unfinished(self) -> Iterator[Turn]:
        """Yield the tasks that have not ended, the newest first."""
        with self._tasks_lock:
            turns = list(self._tasks)
        if turns:
            for turn in reversed(turns):
                if not turn[0].done() and not turn[0].cancelled():
                    yield turn
            with self._tasks_lock:
                self._tasks = [turn for turn in self._tasks
                               if not turn[0].done() and not turn[0].cancelled()]

    def _ready(self) -> Iterator[tuple[Any, Node, Callable[[Any], Any]]]:
        """Wait, and yield the entities that are ready, their nodes and how to take from them."""
        made_of = _made_of(self.get_nodes())
        entities = self._entities
        if entities is None or entities.made_of != made_of:
            if entities is not None:
                entities.close()
                self._entities = None  # a failure below must not leave a closed set in use
            entities = self._entities = _Entities(
                made_of, (self._guard.handle, self._sigint_gc.handle), self._context.handle)
        ready = entities.wait()
        if self._is_shutdown:
            raise ShutdownException
        if not self._context.ok():
            raise ExternalShutdownException
        takes = {'waitable': self._take_waitable, 'timer': self._take_timer,
                 'subscription': self._take_subscription, 'client': self._take_client,
                 'service': self._take_service, 'guard_condition': self._take_guard_condition}
        for kind, entity, node in ready:
            if entity.callback_group.can_execute(entity):
                yield entity, node, takes[kind]
            elif kind == 'guard_condition':  # the wait has reset it
                entity.trigger()


def _made_of(nodes: Sequence[Node]) -> list[Any]:
    """Return all nodes and all that is waited for in them."""
    return [[node, [each for each in node.waitables if not _is_warning(each)], list(node.guards),
             *(list(getattr(node, kind)) for kind, _ in _KINDS)] for node in nodes]


class _Entities:
    """
    What an executor waits for, as a wait set that is filled anew for each wait.

    :param made_of: what :func:`_made_of` returns.
    :param guards: handles of guard conditions that only end the wait.
    :param context: handle of rclpy's context.
    """

    def __init__(self, made_of: list[Any], guards: Sequence[Any], context: Any) -> None:
        self.made_of = made_of
        self._alive = ExitStack()
        self._ended_by = guards
        #: (kind, pointer) -> entity and node.
        self._by_pointer: dict[tuple[str, int], tuple[Any, Node]] = {}
        #: Those that can always be executed, and the others.
        self._always: list[tuple[str, Any]] = []
        self._sometimes: list[tuple[str, Any, Any]] = []
        self._waitables: list[tuple[Any, Node]] = []
        counts = dict.fromkeys((kind for _, kind in _KINDS), 0)
        counts['guard_condition'], counts['event'] = len(guards), 0
        for handle in (*guards, context):
            self._alive.enter_context(handle)
        for node, waitables, own_guards, *kinds in made_of:
            for kind, entities in (('guard_condition', own_guards), *zip(
                (kind for _, kind in _KINDS), kinds, strict=True)):
                for entity in entities:
                    if self._keep(kind, entity, node):
                        counts[kind] += 1
            for waitable in waitables:
                with suppress(InvalidHandle):
                    self._alive.enter_context(waitable)
                    self._waitables.append((waitable, node))
                    number = waitable.get_num_entities()
                    for kind in counts:
                        counts[kind] += getattr(number, f'num_{kind}s')
        self._set = _rclpy.WaitSet(
            counts['subscription'], counts['guard_condition'], counts['timer'], counts['client'],
            counts['service'], counts['event'], context)
        add = self._set
        self._add = {
            'timer': add.add_timer, 'subscription': add.add_subscription,
            'client': add.add_client, 'service': add.add_service,
            'guard_condition': add.add_guard_condition}

    def _keep(self, kind: str, entity: Any, node: Node) -> bool:
        """Keep an entity alive until :meth:`close`; return whether it still was."""
        handle = entity.handle
        try:
            self._alive.enter_context(handle)
        except InvalidHandle:
            return False
        if type(entity.callback_group) is ReentrantCallbackGroup:
            self._always.append((kind, handle))
        else:
            self._sometimes.append((kind, entity, handle))
        self._by_pointer[kind, handle.pointer] = entity, node
        return True

    def wait(self) -> list[tuple[str, Any, Node]]:
        """Wait until anything is ready; return the kinds, entities and nodes of it."""
        wait_set, add = self._set, self._add
        wait_set.clear_entities()
        for kind, handle in self._always:
            add[kind](handle)
        for kind, entity, handle in self._sometimes:
            if entity.callback_group.can_execute(entity):
                add[kind](handle)
        waitables = [each for each in self._waitables
                     if each[0].callback_group.can_execute(each[0])]
        for waitable, _ in waitables:
            waitable.add_to_wait_set(wait_set)
        for handle in self._ended_by:
            wait_set.add_guard_condition(handle)
        wait_set.wait(-1)
        ready = [('waitable', *each) for each in waitables if each[0].is_ready(wait_set)]
        for kind in add:
            for pointer in wait_set.get_ready_entities(kind):
                found = self._by_pointer.get((kind, pointer))
                # rcl reports timers that have been cancelled meanwhile.
                if found and (kind != 'timer' or found[0].handle.is_timer_ready()):
                    ready.append((kind, *found))
        return ready

    def close(self) -> None:
        """Let go of all entities."""
        self._alive.close()
