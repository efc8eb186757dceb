# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services and actions in both directions, over a real connection."""

import json
import threading
import time

import pytest
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.task import Future
from std_srvs.srv import SetBool
from tf2_msgs.action import LookupTransform

from armsim_ros.clients.action_client import PatientActionClient

ACTION = 'tf2_msgs/action/LookupTransform'


class Served:
    """An action server whose goals end when the test wants it."""

    def __init__(self, node):
        self.node, self.pending = node, []
        self.server = ActionServer(
            node, LookupTransform, '/look', self.execute,
            callback_group=ReentrantCallbackGroup(),
            goal_callback=self.decide, cancel_callback=self.cancel)

    def decide(self, goal):
        """Reject a frame, and log why."""
        if goal.target_frame != 'no':
            return GoalResponse.ACCEPT
        self.node.get_logger().error('there is no such frame')
        return GoalResponse.REJECT

    async def execute(self, goal):
        """Wait for a cancel where the goal names the frame so, else succeed."""
        goal.publish_feedback(LookupTransform.Feedback())
        if goal.request.target_frame == 'wait':
            waiting = Future()
            self.pending.append(waiting)
            await waiting
            goal.canceled()
        else:
            goal.succeed()
        result = LookupTransform.Result()
        result.transform.header.frame_id = goal.request.target_frame
        return result

    def cancel(self, _):
        """End all that wait."""
        for waiting in self.pending:
            self.node.executor.create_task(waiting.set_result, None)
        return CancelResponse.ACCEPT


@pytest.fixture(scope='module')
def served(peer):
    """Serve an action and a service."""
    def switch(request, response):
        response.success, response.message = request.data, 'switched'
        return response

    peer.create_service(SetBool, '/switch', switch)
    return Served(peer)


def test_a_service_answers_once_with_the_clients_id(talk, served):
    """Arguments as an object or a list; the type in the call is not needed."""
    client = talk()
    expected = {'op': 'service_response', 'id': 7, 'service': 'switch', 'result': True,
                'values': {'success': True, 'message': 'switched'}}
    assert client.call('switch', {'data': True}, id=7) == expected
    assert client.call('switch', [True], id=7, type='rosapi/Topics') == expected


def test_a_request_may_come_in_fragments_and_its_answer_too(talk):
    """In any order; the answer in another encoding where the call names one."""
    client, text = talk(), json.dumps(
        {'op': 'call_service', 'service': '/rosapi/get_time', 'id': 'whole'})
    for number in (2, 0, 1):
        client.send('fragment', id='a', num=number, total=3,
                    data=text[20 * number:20 * (number + 1) if number < 2 else None])
    assert client.until('service_response')['id'] == 'whole'
    client.send('call_service', service='/rosapi/services', fragment_size=100)
    first = client.receive()
    parts = [first, *(client.receive() for _ in range(first['total'] - 1))]
    assert [part['num'] for part in parts] == list(range(first['total']))
    answer = json.loads(''.join(part['data'] for part in parts))
    assert '/rosapi/services' in answer['values']['services']
    client.send('call_service', service='/rosapi/get_time', compression='png')
    assert client.receive()['op'] == 'png'


@pytest.mark.parametrize(('call', 'text'), [
    ({'service': '/swich'}, "no such service; did you mean '/switch'?"),
    ({'service': '/switch', 'args': {'data': 1}}, 'data: expected true or false, got 1'),
    ({'service': '/switch', 'args': {'on': True}}, 'on: no such field'),
    ({'service': '/switch', 'args': 'yes'}, 'args must be: list or object'),
    ({'service': 'not a name'}, 'is not a name of ROS'),
], ids=['not there', 'wrong kind', 'wrong field', 'no object', 'no name'])
def test_a_call_that_fails_has_one_answer(talk, served, call, text):
    """The values are the reason, and no status comes before."""
    client = talk()
    client.send('call_service', id='x', **call)
    answer = client.receive()
    assert (answer['op'], answer['id'], answer['result']) == ('service_response', 'x', False)
    assert text in answer['values']


def test_a_call_ends_with_its_time_or_its_server(talk, peer):
    """The values say which; calls of a client do not wait for each other."""
    async def wait(_, response):
        await Future()
        return response

    service = peer.create_service(SetBool, '/slow', wait, callback_group=ReentrantCallbackGroup())
    client = talk()
    client.send('call_service', service='/slow', id='gone')
    client.send('call_service', service='/slow', id='late', timeout=0.3)
    assert client.call('/rosapi/get_time', id='meanwhile')['id'] == 'meanwhile'
    late = client.until('service_response')
    assert (late['id'], late['result'], late['values']) == (
        'late', False, '/slow: no answer within 0.3 s')
    peer.destroy_service(service)  # its answer stays away
    gone = client.until('service_response')
    assert (gone['id'], gone['result']) == ('gone', False)
    assert gone['values'] == '/slow: the server has gone without an answer'


def test_a_client_serves_a_service(talk, peer):
    """A caller in ROS gets the client's answer, and default values once it is gone."""
    client = talk()
    client.send('advertise_service', service='/mine', type='std_srvs/SetBool')
    client.settle()
    caller = peer.create_client(SetBool, '/mine')
    assert caller.wait_for_service(10)
    answer = caller.call_async(SetBool.Request(data=True))
    request = client.until('call_service')
    assert request['args'] == {'data': True}
    client.send('service_response', service='/mine', id=request['id'], result=True,
                values={'success': True, 'message': 'done'})
    done = threading.Event()
    answer.add_done_callback(lambda _: done.set())
    assert done.wait(10)
    assert answer.result() == SetBool.Response(success=True, message='done')
    assert talk().ask_status('advertise_service', service='/mine', type='std_srvs/SetBool') == (
        'advertise_service /mine: another client serves it')
    answer, done = caller.call_async(SetBool.Request()), threading.Event()
    client.until('call_service')
    client.close()
    answer.add_done_callback(lambda _: done.set())
    assert done.wait(10)
    assert answer.result() == SetBool.Response()


def test_a_goal_has_feedback_and_a_result(talk, served):
    """The status is that of the action."""
    client = talk()
    client.send('send_action_goal', action='/look', action_type=ACTION, id='goal',
                feedback=True, args={'target_frame': 'tool'})
    assert client.until('action_feedback') == {
        'op': 'action_feedback', 'action': '/look', 'id': 'goal', 'values': {}}
    answer = client.until('action_result')
    assert (answer['id'], answer['status'], answer['result']) == ('goal', 4, True)
    assert answer['values']['transform']['header']['frame_id'] == 'tool'


def test_a_goal_is_cancelled_over_another_connection(talk, served):
    """It outlives the connection that sent it, and is known by its id."""
    first = talk()
    first.send('send_action_goal', action='/look', action_type=ACTION, id='far', feedback=True,
               args={'target_frame': 'wait'})
    first.until('action_feedback')
    second = talk()
    second.send('cancel_action_goal', action='/look', id='far')
    answer = first.until('action_result')
    assert (answer['status'], answer['result']) == (5, True)


def test_an_id_of_several_clients_cancels_no_goal_of_another(talk, served):
    """Each process of roslibpy counts from 1; the own goal comes first."""
    clients = [talk() for _ in range(2)]
    for client in clients:
        client.send('send_action_goal', action='/look', action_type=ACTION, id='1', feedback=True,
                    args={'target_frame': 'wait'})
        client.until('action_feedback')
    third = talk()
    third.send('set_level', level='warning')
    assert "several clients have a goal with id '1'" in third.ask_status(
        'cancel_action_goal', action='/look', id='1')
    clients[0].send('cancel_action_goal', action='/look', id='1')
    assert clients[0].until('action_result')['status'] == 5


def test_the_status_of_an_action_is_a_topic(talk, served):
    """Hidden and latched; its type is that of the graph."""
    client = talk()
    client.send('send_action_goal', action='/look', action_type=ACTION, id='seen')
    client.until('action_result')
    client.send('subscribe', topic='/look/_action/status')
    assert client.until('publish')['msg']['status_list'][-1]['status'] == 4


@pytest.mark.parametrize(('fields', 'text'), [
    ({'args': {'target_frame': 'no'}}, 'the server rejected the goal'),
    ({'action': '/lok'}, "no such action is served; did you mean '/look'?"),
    ({'action_type': 'tf2_msgs/LookupTransfrom'}, 'did you mean'),
    ({'args': {'frame': 'x'}}, 'frame: no such field'),
], ids=['rejected', 'not there', 'no such type', 'wrong field'])
def test_a_goal_that_cannot_run_has_a_result(talk, served, fields, text):
    """It says why, with status 0."""
    client = talk()
    client.send(**{'op': 'send_action_goal', 'action': '/look', 'action_type': ACTION, 'id': 1,
                   **fields})
    answer = client.receive()
    assert (answer['op'], answer['id'], answer['status'], answer['result']) == (
        'action_result', 1, 0, False)
    assert text in answer['values']


def test_a_rejection_has_the_error_of_the_servers_log(talk, served):
    """Once the log has found the bridge, which waits for it for a moment only."""
    client, deadline, text = talk(), time.monotonic() + 30.0, ''
    while text != '/look: the server rejected the goal: there is no such frame':
        assert time.monotonic() < deadline, text
        client.send('send_action_goal', action='/look', action_type=ACTION,
                    args={'target_frame': 'no'})
        text = client.until('action_result')['values']


def test_a_client_serves_an_action(talk, peer):
    """Feedback and result reach the caller; a client that leaves aborts its goals."""
    client = talk()
    client.send('advertise_action', action='/mine_too', type=ACTION)
    client.settle()
    caller = PatientActionClient(peer, LookupTransform, '/mine_too')
    assert caller.wait_for_server(10)
    feedback, results = threading.Event(), []
    done = [threading.Event(), threading.Event()]

    def accepted(number, sent):
        sent.result().get_result_async().add_done_callback(
            lambda found: (results.append(found.result()), done[number].set()))

    for number in range(2):
        caller.send_goal_async(LookupTransform.Goal(target_frame='tool'),
                               lambda _: feedback.set()).add_done_callback(
            lambda sent, number=number: accepted(number, sent))
        goal = client.until('send_action_goal')
        assert goal['args']['target_frame'] == 'tool'
        if number == 0:
            client.send('action_feedback', action='/mine_too', id=goal['id'], values={})
            client.send('action_result', action='/mine_too', id=goal['id'], status=4,
                        result=True, values={'error': {'error_string': 'fine'}})
        else:
            client.close()
        assert done[number].wait(10)
    assert feedback.is_set()
    assert [result.status for result in results] == [4, 6]
    assert results[0].result.error.error_string == 'fine'
    caller.destroy()
