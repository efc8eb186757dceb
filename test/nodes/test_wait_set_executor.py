# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Executor that keeps its wait set: what wakes it, what it waits for, what it continues."""

from functools import partial
import threading

from control_msgs.action import GripperCommand
import pytest
import rclpy
from rclpy.action import ActionClient, ActionServer
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.event_handler import EventHandler, PublisherEventCallbacks
from rclpy.exceptions import InvalidHandle
from rclpy.executors import ConditionReachedException, TimeoutException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from std_msgs.msg import Int32, String
from std_srvs.srv import Trigger

from armsim_ros.nodes import qos, wait_set_executor
from armsim_ros.nodes.wait_set_executor import WaitSetExecutor

PATIENCE = 30.0


class Loop:
    """An executor with a node, stepped by the test."""

    def __init__(self, monkeypatch):
        self.context = Context()
        rclpy.init(
            args=[], context=self.context, signal_handler_options=SignalHandlerOptions.NO)
        self.executor = WaitSetExecutor(context=self.context)
        self.node = Node('served', context=self.context)
        self.executor.add_node(self.node)
        self.waits = 0
        self.over = False
        wait = wait_set_executor._Entities.wait

        def counted(entities):
            self.waits += 1
            return wait(entities)

        monkeypatch.setattr(wait_set_executor._Entities, 'wait', counted)

    def _time_over(self):
        self.over = True
        self.executor.wake()

    def until(self, condition):
        """Run callbacks until a condition holds; fail after a long time."""
        self.over = False
        patience = threading.Timer(PATIENCE, self._time_over)
        patience.start()
        try:
            while not condition():
                callback, *_ = self.executor.wait_for_ready_callbacks(
                    None, None, self._is_over)
                callback()
                callback.result()
        finally:
            patience.cancel()

    def _is_over(self):
        return self.over

    def end(self):
        """Take everything down."""
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.shutdown()


@pytest.fixture
def loop(monkeypatch):
    """Return a loop that ends with the test."""
    made = Loop(monkeypatch)
    yield made
    made.end()


@pytest.fixture
def reports_rarely(monkeypatch):
    """Check for incompatible endpoints once an hour: a check takes a wait of its own."""
    monkeypatch.setattr(wait_set_executor, '_PERIOD', 3600.0)


@pytest.mark.usefixtures('reports_rarely')
def test_a_callback_is_followed_by_a_single_wait(loop):
    """A callback that concerns no other task does not wake the executor."""
    seen = []
    loop.node.create_subscription(
        Int32, 'numbers', lambda message: seen.append(message.data), qos.LATCHED)
    publisher = loop.node.create_publisher(Int32, 'numbers', qos.LATCHED)
    for number in range(20):
        publisher.publish(Int32(data=number))
        loop.until(lambda number=number: seen == list(range(number + 1)))
    settled = loop.waits
    for number in range(20, 40):
        publisher.publish(Int32(data=number))
        loop.until(lambda number=number: seen == list(range(number + 1)))
    assert loop.waits - settled == 20


@pytest.mark.parametrize('kind', [ReentrantCallbackGroup, MutuallyExclusiveCallbackGroup])
def test_entities_of_all_kinds_are_served(loop, kind):
    """Timers, topics, services, actions and their clients reach their callbacks."""
    node, seen = loop.node, set()
    options = {'callback_group': kind()}
    timer = node.create_timer(0.01, lambda: seen.add('timer'), **options)
    node.create_subscription(Int32, 'numbers', lambda _: seen.add('topic'), 1, **options)
    publisher = node.create_publisher(Int32, 'numbers', 1)
    guard = node.create_guard_condition(lambda: seen.add('guard'), **options)

    def answer(request, response):
        seen.add('service')
        return response

    def execute(goal):
        goal.succeed()
        seen.add('action')
        return GripperCommand.Result(position=2.0)

    node.create_service(Trigger, 'answer', answer, **options)
    client = node.create_client(Trigger, 'answer', **options)
    server = ActionServer(node, GripperCommand, 'grip', execute, **options)
    actions = ActionClient(node, GripperCommand, 'grip', **options)
    loop.until(lambda: 'timer' in seen and client.service_is_ready()
               and actions.server_is_ready() and publisher.get_subscription_count())
    publisher.publish(Int32())
    guard.trigger()
    response = client.call_async(Trigger.Request())
    goal = actions.send_goal_async(GripperCommand.Goal())
    loop.until(lambda: response.done() and goal.done())
    result = goal.result().get_result_async()
    loop.until(lambda: result.done() and len(seen) == 5)
    assert result.result().result.position == 2.0
    timer.cancel()
    server.destroy()
    actions.destroy()


def test_a_task_goes_on_when_a_callback_has_what_it_waits_for(loop):
    """Whichever of the two has begun first, and whatever task was continued first."""
    group = ReentrantCallbackGroup()
    futures = {name: Future() for name in ('first', 'second', 'third')}
    begun, done = [], []

    async def chain(name, before):
        begun.append(name)
        await futures[before]
        done.append(name)
        if name in futures:
            futures[name].set_result(None)

    # The newest task is continued first: each gives the next what it waits for.
    tasks = [('second', 'first'), ('third', 'second'), ('end', 'third')]
    for count, task in enumerate(tasks, 1):
        loop.node.create_guard_condition(partial(chain, *task), callback_group=group).trigger()
        loop.until(lambda count=count: len(begun) == count)
    begin = loop.node.create_guard_condition(
        lambda: futures['first'].set_result(None), callback_group=group)
    begin.trigger()
    loop.until(lambda: len(done) == 3)
    assert done == ['second', 'third', 'end']


def test_what_has_not_ended_is_known(loop):
    """A task counts from its creation, before it has begun, until it ends."""
    future, begun = Future(), []

    async def wait():
        begun.append(1)
        await future

    assert not loop.executor.has_unfinished
    task = loop.executor.create_task(wait)
    assert loop.executor.has_unfinished
    loop.until(lambda: begun)
    assert loop.executor.has_unfinished
    future.set_result(None)
    loop.executor.wake()
    loop.until(task.done)
    assert not loop.executor.has_unfinished


def test_another_thread_continues_a_task(loop):
    """A future that is set anywhere, and a wake, suffice."""
    future, done = Future(), []

    async def wait():
        done.append(await future)

    loop.node.create_guard_condition(wait).trigger()
    loop.until(lambda: len(loop.executor._tasks) == 1 and not done)

    def elsewhere():
        future.set_result(7)
        loop.executor.wake()

    thread = threading.Timer(0.05, elsewhere)
    thread.start()
    loop.until(lambda: done)
    thread.join()
    assert done == [7]


def test_a_group_of_one_callback_at_a_time_waits_for_its_coroutine(loop):
    """Another entity of the group is served after the coroutine, and no trigger is lost."""
    group, future, order = MutuallyExclusiveCallbackGroup(), Future(), []

    async def long():
        order.append('begun')
        await future
        order.append('ended')

    first = loop.node.create_guard_condition(long, callback_group=group)
    second = loop.node.create_guard_condition(
        lambda: order.append('other'), callback_group=group)
    first.trigger()
    loop.until(lambda: order)
    second.trigger()
    other = loop.node.create_guard_condition(
        lambda: future.set_result(None), callback_group=ReentrantCallbackGroup())
    other.trigger()
    loop.until(lambda: 'other' in order)
    assert order == ['begun', 'ended', 'other']


def test_entities_that_come_and_go_are_noticed(loop):
    """A service made later is served; a destroyed service is released at the next turn."""
    served = []

    def answer(request, response):
        served.append('served')
        return response

    tick = loop.node.create_guard_condition(lambda: served.append('tick'))
    tick.trigger()
    loop.until(lambda: served)
    client = loop.node.create_client(Trigger, 'late')
    service = loop.node.create_service(Trigger, 'late', answer)
    assert client.wait_for_service(PATIENCE)
    response = client.call_async(Trigger.Request())
    loop.until(response.done)
    assert served == ['tick', 'served']
    handle = service.handle
    loop.node.destroy_service(service)
    tick.trigger()
    loop.until(lambda: len(served) == 3)
    tick.trigger()
    loop.until(lambda: len(served) == 4)
    with pytest.raises(InvalidHandle), handle:
        pass


def test_shutdown_releases_all_entities(loop):
    """A node that is destroyed after the executor's shutdown is gone at once."""
    seen = []
    loop.node.create_guard_condition(lambda: seen.append(1)).trigger()
    service = loop.node.create_service(Trigger, 'gone', lambda _, response: response)
    loop.until(lambda: seen)
    handle = service.handle
    loop.executor.shutdown()
    loop.node.destroy_node()
    with pytest.raises(InvalidHandle), handle:
        pass


def test_a_condition_or_a_timeout_ends_the_wait(loop):
    """As rclpy's executor, it raises what ended the wait."""
    with pytest.raises(TimeoutException):
        loop.executor.wait_for_ready_callbacks(0.01)
    threading.Timer(0.05, loop._time_over).start()
    with pytest.raises(ConditionReachedException):
        loop.until(lambda: False)


def test_incompatible_endpoints_are_reported(loop, capfd):
    """A reader that asks for more than is offered is warned of (rclpy's event_handler.py)."""
    loop.node.create_publisher(String, 'text', 1)
    loop.node.create_subscription(String, 'text', lambda _: None, qos.LATCHED)
    seen = []

    def warned():
        seen.append(capfd.readouterr().err)
        return "New publisher discovered on topic 'text'" in ''.join(seen)

    loop.until(warned)


def test_messages_do_not_wait_for_warnings(loop):
    """No event of an incompatible endpoint is waited for; all else is."""
    loop.node.create_publisher(String, 'text', 1)
    subscription = loop.node.create_subscription(String, 'text', lambda _: None, 1)
    events = list(loop.node.waitables)
    assert events
    assert all(isinstance(each, EventHandler) for each in events)
    assert not any(map(loop.executor.can_execute, events))
    assert loop.executor.can_execute(subscription)


def test_a_callback_of_a_match_runs(loop):
    """An event that somebody asked for is waited for."""
    matched = []
    loop.node.create_publisher(
        String, 'text', 1, event_callbacks=PublisherEventCallbacks(matched=matched.append))
    loop.node.create_subscription(String, 'text', lambda _: None, 1)
    loop.until(lambda: matched)
