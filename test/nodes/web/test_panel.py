# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the panel may ask for, over its websocket, beside a stack that is not ours."""

import asyncio
import json
import secrets

from moveit_msgs.msg import CollisionObject
import numpy as np
import pytest

pytest.importorskip('viser')

import websockets.asyncio.client as websocket_client

from armsim_ros.nodes.conversions.octomap import octomap_to_message
from armsim_ros.nodes.web.parts.object_commands import object_from_dict, object_to_dict
from armsim_ros.planning.scene.octomap import octomap_from_cells

PATIENCE = 20.0


class Panel:
    """A panel without a browser."""

    def __init__(self, connection):
        self.state, self._connection = {}, connection

    async def ask(self, what, **values):
        """Ask for something."""
        await self._connection.send(json.dumps({'do': what, **values}))

    async def until(self, *path, satisfies=bool):
        """Read until a value of a section is as wanted, and return it."""
        async with asyncio.timeout(PATIENCE) if hasattr(asyncio, 'timeout') else _forever():
            while True:
                value = self.state
                for step in path:
                    value = value.get(step) if isinstance(value, dict) else None
                if value is not None and satisfies(value):
                    return value
                await self.read()

    async def read(self):
        """Take over the next message."""
        self.state.update(json.loads(await self._connection.recv()))


class _forever:  # noqa: N801 - stands in for asyncio.timeout of Python 3.11
    async def __aenter__(self):
        return self

    async def __aexit__(self, *_):
        return None


@pytest.fixture
def talk(served_page):
    """Return a function that lets a panel do something from its opening to its closing."""
    def run(work):
        address = f'ws://127.0.0.1:{served_page.server.port}/panel/{secrets.token_hex(8)}'

        async def inner():
            async with websocket_client.connect(address, max_size=None) as connection:
                panel = Panel(connection)
                await panel.until('programs', satisfies=lambda one: not one['waiting'])
                await panel.until('goal', 'group')  # before there is a scene, and without one
                return await work(panel)

        return asyncio.run(inner())

    return run


def test_robot_and_controllers_are_told(talk):
    """Groups, limits and states, as the descriptions have them."""
    async def work(panel):
        robot = await panel.until('robot')
        assert robot['groups'][0]['states'] == ['up']
        assert [one['name'] for one in robot['groups'][0]['joints']] == ['turn', 'bend']
        (controller,) = await panel.until('controllers')
        assert controller['joints'] == ['bend', 'turn']

    talk(work)


def test_plan_and_execute_arrives(fake_stack, talk):
    """The plan is told as curves, then the end."""
    async def work(panel):
        await panel.ask('goal_state', name='up')
        await panel.until('goal', 'kind', satisfies=lambda kind: kind == 'reachable')
        await panel.ask('plan', execute=True)
        assert (await panel.until('plan'))['duration'] == 2.0
        assert (await panel.until('result'))['text'] == 'arrived'

    talk(work)
    assert fake_stack.positions == {'turn': 1.0, 'bend': 0.5}


def test_stop_ends_a_motion_of_another_user(fake_stack, talk):
    """One executes, the other stops it."""
    fake_stack.release.clear()

    async def work(panel):
        await panel.ask('goal_state', name='up')
        await panel.ask('plan', execute=True)
        await panel.until('activity', 'what', satisfies=lambda what: what == 'executing')
        await panel.ask('plan')
        assert 'executing already' in (await panel.until('note'))['text']
        await panel.ask('stop')
        assert (await panel.until('result'))['text'] == 'stopped'

    talk(work)
    fake_stack.release.set()


def test_a_motion_tells_how_far_it_is(fake_stack, talk):
    """In seconds, of those that it takes."""
    fake_stack.release.clear()

    async def work(panel):
        await panel.ask('goal_state', name='up')
        await panel.ask('plan', execute=True)
        last = await panel.until('activity', satisfies=lambda one: (
            one['what'] == 'executing' and one['elapsed'] > 0.5))
        assert (last['elapsed'] <= last['total'], last['total']) == (True, 2.0)
        fake_stack.release.set()
        assert (await panel.until('result'))['text'] == 'arrived'
        assert panel.state['activity'] is None

    talk(work)


@pytest.mark.parametrize('straight', [False, True], ids=['search', 'straight line'])
def test_planning_tells_how_long_it_takes_and_is_stopped(fake_stack, talk, straight):
    """What was to be executed then is not."""
    fake_stack.planned.clear()
    fake_stack.positions.update(turn=0.0, bend=0.0)

    async def work(panel):
        await panel.ask('goal_state', name='up')
        await panel.ask('plan', execute=True, straight=straight, planning_time=60.0)
        last = await panel.until('activity', satisfies=lambda one: one['elapsed'] > 0.5)
        assert (last['what'], last['total']) == ('planning', 60.0)
        await panel.ask('stop')
        assert (await panel.until('result'))['text'] == 'stopped'
        fake_stack.planned.set()
        await panel.ask('plan')  # only when nothing else goes on
        assert (await panel.until('result', 'text', satisfies=lambda text: 'planned' in text))

    talk(work)
    assert fake_stack.positions == {'turn': 0.0, 'bend': 0.0}


def test_a_collision_is_told_in_words_and_can_be_allowed(fake_stack, talk):
    """Those pairs, both ways."""
    fake_stack.contacts = [('upper', 'box_1')]

    async def work(panel):
        await panel.ask('joints', values={'turn': 9.0})
        goal = await panel.until('goal', satisfies=lambda one: one['kind'] == 'collision')
        assert goal['positions']['turn'] == 2.0
        assert goal['text'] == 'in collision: box_1 touches upper'
        await panel.ask('allow', pairs=goal['touching'])
        fake_stack.contacts = []
        await panel.until('goal', 'kind', satisfies=lambda kind: kind == 'reachable')

    talk(work)
    matrix = fake_stack.matrix
    one, other = (matrix.entry_names.index(name) for name in ('upper', 'box_1'))
    assert matrix.entry_values[one].enabled[other]
    assert matrix.entry_values[other].enabled[one]


def test_an_object_is_added_moved_attached_and_removed(fake_stack, talk):
    """Through apply_planning_scene alone."""
    def first(panel, satisfies):
        return panel.until('objects', satisfies=lambda found: bool(found) and satisfies(found[0]))

    async def work(panel):
        await panel.ask('add', shape='box')
        await first(panel, lambda one: one['id'] == 'box_1')
        await panel.ask('change', id='box_1', xyz=[0.5, 0.0, 0.2], size=[0.1, 0.2, 0.3])
        await first(panel, lambda one: one['size'] == [0.1, 0.2, 0.3])
        await panel.ask('change', id='box_1', xyz=[0.6, 0.0, 0.2])
        await first(panel, lambda one: one['xyz'] == [0.6, 0.0, 0.2])
        await panel.ask('attach', id='box_1')
        await first(panel, lambda one: one['link'] == 'lower')
        assert fake_stack.attached['box_1'].touch_links == ['lower']
        await panel.ask('detach', id='box_1')
        await first(panel, lambda one: not one['link'])
        await panel.ask('save_scene')
        saved = await panel.until('saved_scene')
        await panel.ask('remove', id='box_1')
        await panel.until('objects', satisfies=lambda _: True)
        await panel.ask('load_scene', text=saved)
        await first(panel, lambda one: one['id'] == 'box_1')
        await panel.ask('remove', id='box_1')

    talk(work)


def test_an_octomap_is_shown_and_emptied(fake_stack, talk):
    """Its number of cells in the panel; the button calls clear_octomap."""
    cells = octomap_from_cells(np.array([[5, 0, 0], [5, 0, 2], [5, 0, 4]]), np.array(
        [1.0, 1.0, -1.0], dtype=np.float32), 0.05, np.eye(4))

    async def work(panel):
        fake_stack.octomap = octomap_to_message(cells, 'base')
        assert await panel.until('octomap') == {'cells': 2, 'resolution': 0.05}
        await panel.ask('clear_octomap')
        while panel.state['octomap'] is not None:
            await panel.read()
        assert fake_stack.octomap is None

    talk(work)


def test_a_controller_is_switched(fake_stack, talk):
    """And its new state is told at once."""
    async def work(panel):
        manager = '/arm/controller_manager'
        await panel.ask('switch', manager=manager, name='arm', active=False)
        await panel.until('controllers', satisfies=lambda found: found[0]['state'] == 'inactive')
        await panel.ask('switch', manager=manager, name='arm', active=True)
        await panel.until('controllers', satisfies=lambda found: found[0]['state'] == 'active')

    talk(work)


@pytest.mark.parametrize(('ask', 'text'), [
    ({'do': 'nonsense'}, 'does not know the command'),
    ({'do': 'plan', 'speed': 7}, 'speed'),
    ({'do': 'plan', 'surprise': 1}, 'surprise'),
    ({'do': 'joints', 'values': {'nobody': 1.0}}, 'nobody'),
    ({'do': 'joints', 'values': {'turn': 'x'}}, 'turn'),
    ({'do': 'goal_state', 'name': 'nowhere'}, "no state 'nowhere'"),
    ({'do': 'remove', 'id': 'nothing'}, "no object 'nothing'"),
    ({'do': 'load_scene', 'text': '{}'}, 'not a scene'),
    ({'do': 'add_mesh', 'name': 'a.stl', 'data': 'AAAA'}, "'a.stl'"),
    ({'do': 'camera', 'topic': '/nowhere'}, 'publishes no images'),
    ({'do': 'jog', 'joint': 'turn', 'share': 0.5}, 'no servo runs'),
    ({'do': 'scrub', 'time': -1.0}, 'time'),
])
def test_a_wrong_question_is_answered_with_a_sentence(talk, ask, text):
    """And the panel goes on."""
    async def work(panel):
        panel.state.pop('note', None)
        await panel.ask(ask.pop('do'), **ask)
        assert text in (await panel.until('note'))['text']

    talk(work)


def test_a_refused_change_of_the_scene_is_shown(talk, fake_stack):
    """Whoever sent it: a topic has no answer, and move_group's log is not in the browser."""
    async def work(panel):
        panel.state.pop('note', None)
        fake_stack.refuse("collision_object: unknown frame 'map'")
        note = await panel.until('note')
        assert note['text'] == "collision_object: unknown frame 'map'"

    talk(work)


def test_what_a_planning_scene_says_is_kept_word_for_word():
    """Saved and read again, an object is the same."""
    item = CollisionObject(id='a')
    item.header.frame_id = 'base'
    item.pose.orientation.w = 1.0
    assert object_from_dict(json.loads(json.dumps(object_to_dict(item)))) == item
