# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The page in a real browser, with a real robot behind it."""

from contextlib import ExitStack
import math
from pathlib import Path
import re
import signal
import subprocess
import sys

import numpy as np
import pytest
from sensor_msgs.msg import JointState

pytest.importorskip('viser')
pytest.importorskip('playwright')

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.trajectory import CANCELED, trajectory_message, TrajectoryClient
from armsim_ros.testing.page_user import changed, chromium_path, printed_address, reddish
from armsim_ros.testing.program import private_domain, ros_environment, start_program
from armsim_ros.testing.robot_user import READY, RobotUser

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(chromium_path() is None, reason='needs Debian package chromium'),
]

ROOT = Path(__file__).parents[3]
JOINTS = [f'joint_{number}' for number in range(1, 7)]
SCAN_FOOD = dict(zip(JOINTS, (0.0, 0.4569, 0.4905, -0.5519, 1.57, 0.0), strict=True))
LABELS = (
    'Reset view', 'Frames', 'Stop', 'Plan', 'Group', 'Goal state', 'Joints', 'Speed',
    'Acceleration', 'Pipeline', 'Planner', 'Planning time', 'Straight line', 'Execute',
    'Plan & Execute', 'Time', 'Replay', 'Clear', 'Motion', 'Scene', 'Box', 'Sphere', 'Cylinder',
    'Mesh', 'Allow collisions', 'Controllers', 'Simulation', 'Jog',
)
#: What is cut off at the side, and what is written too small.
MISFITS = """() => {
  const all = [...document.querySelectorAll('body *')].filter((one) => one.checkVisibility());
  const named = (found) => found.map((one) => one.outerHTML.slice(0, 80));
  const own = (one) => [...one.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
  const size = (one) => parseFloat(getComputedStyle(one).fontSize);
  return {
    wide: named(all.filter((one) => one.getBoundingClientRect().right > innerWidth + 1)),
    small: named(all.filter((one) => own(one) && size(one) < 13)),
  };
}"""


class Stack:
    """A robot and its page, each program by itself, and a client beside them."""

    def __init__(self, held):
        self._held = held
        self.domain = held.enter_context(private_domain())
        self.programs = {}
        for name in ('simulation', 'move_group', 'web'):
            self.start(name)
        self.address = printed_address(self.programs['web'].wait_for_line('^page: ', 60))
        self.client = held.enter_context(ClientNode(self.domain, 'user'))
        self.programs['move_group'].wait_for_line(READY, 60)
        self.robot = RobotUser(self.client, self.programs['simulation'], '/sunday')
        self.arm = TrajectoryClient(self.client, '/sunday/arm_joint_controller')

    def start(self, name, *arguments):
        """Start a program."""
        self.programs[name] = self._held.enter_context(
            start_program(name, self.domain, *arguments))

    def kill(self, name):
        """Kill a program so that it can tell nobody."""
        self.programs[name].signal(signal.SIGKILL)
        self.programs[name].wait()

    def tool_pose(self, positions):
        """Return the pose of the tool at joint positions, (4, 4)."""
        return self.robot.move_group.pose('link_6', positions, 'world')

    def valid(self, positions):
        """Return whether the robot would touch nothing."""
        return self.robot.move_group.valid('manipulator', positions)


@pytest.fixture(scope='module')
def stack():
    """Run the default robot and its page for this file."""
    with ExitStack() as held:
        yield Stack(held)


@pytest.fixture(scope='module')
def open_page(stack, open_window):
    """Return a function that opens the page in a window of its own."""
    return lambda: open_window(stack.address)


@pytest.fixture(scope='module')
def first_page(open_page):
    """Open the page that most tests use."""
    return open_page()


@pytest.fixture
def page(stack, first_page):
    """Return the page, the robot at rest and nothing planned; nothing failed in the browser."""
    first_page.choose('Goal state', 'current')
    first_page.wait_until_ready()
    stack.robot.wait_until_still()
    clear = first_page.tab.get_by_role('button', name='Clear')
    if clear.is_visible():
        clear.click()
    first_page.slide('Speed', 100)
    yield first_page
    assert first_page.page_errors == []


def test_three_clicks_from_the_address_to_the_moved_arm(stack, page):
    """A goal state is chosen, 'Plan & Execute' pressed, and the arm is there."""
    page.go('scan_food')
    assert stack.robot.distance(SCAN_FOOD) < 0.01


def test_every_label_is_there(page):
    """What documents and people call by name has that name."""
    html = page.tab.content()
    texts = set(page.tab.evaluate(
        '[...document.querySelectorAll("button, summary, label, span")]'
        '.map((one) => one.textContent.trim())'))
    assert [label for label in LABELS if label not in texts] == []
    assert 'aria-label="Scene"' in html


def test_motion_is_seen_while_it_goes_on(stack, page):
    """While another client moves the arm the picture changes; at rest it does not."""
    rest = page.resting_picture()
    ends = [1.9, 0.4, 0.4, 0.0, 1.0, 0.0], [0.5, 0.4, 0.4, 0.0, 1.0, 0.0]
    goal = stack.arm.send(trajectory_message(
        JOINTS, [(20.0 * (each + 1), ends[each % 2]) for each in range(20)]))
    first = page.wait_for_picture(lambda now: changed(rest, now) > 300)
    page.wait_for_picture(lambda now: changed(first, now) > 300 and changed(rest, now) > 300)
    goal.cancel()
    assert goal.result().status == CANCELED


def test_stop_ends_the_motion(stack, page):
    """The arm stands before it has arrived, and the page says that it was stopped."""
    page.slide('Speed', 5)
    page.choose('Goal state', 'home')
    page.press('Plan & Execute')
    page.wait_for_status('Executing')
    page.press('Stop')
    page.wait_for_result('stopped')
    stack.robot.wait_until_still()
    assert stack.robot.distance(dict.fromkeys(JOINTS, 0.0)) > 0.1


def test_escape_stops_what_another_client_began(stack, page):
    """The motion is not the page's own; the key is as good as the button."""
    goal = stack.arm.send(trajectory_message(JOINTS, [(20.0, [0.5] * 6)]))
    goal.wait_for_feedback()
    page.tab.keyboard.press('Escape')
    assert goal.result().status == CANCELED


def test_the_tool_is_dragged_and_the_arm_goes_where_it_was_put(stack, page):
    """The handle's arrow is pulled: the goal is further along it, turned as before."""
    page.go('scan_food')
    start = page.goal()
    before = stack.tool_pose(start)
    page.choose('Goal state', 'drag the tool')
    page.pull_handle(-25)
    target = page.goal_after(start)
    page.wait_for_verdict('reachable')
    after = stack.tool_pose(target)
    assert 0.02 < np.linalg.norm(after[:3, 3] - before[:3, 3]) < 0.4
    assert np.allclose(after[:3, :3], before[:3, :3], atol=0.02)
    page.press('Plan & Execute')
    page.wait_for_result('arrived')
    assert stack.robot.distance(target) < 0.01


def test_a_goal_out_of_reach_is_grey_and_says_so(page):
    """The handle is pulled far away."""
    page.choose('Goal state', 'scan_food')
    page.wait_for_verdict('reachable')
    page.choose('Goal state', 'drag the tool')
    page.pull_handle(260)
    assert page.wait_for_verdict('unreachable') == 'no joint positions reach this pose'


def test_a_goal_in_collision_is_red_and_names_what_touches(page):
    """The arm is folded onto itself with the sliders; the plan to it is refused in words."""
    page.choose('Goal state', 'scan_food')
    page.wait_for_verdict('reachable')
    free = reddish(page.resting_picture())
    page.unfold('Joints')
    page.type_into('joint_2 [°]', 88)
    page.type_into('joint_3 [°]', 155)
    assert ' touches ' in page.wait_for_verdict('collision')
    assert reddish(page.resting_picture()) > free + 300
    page.press('Plan')
    page.wait_for_status('GOAL_IN_COLLISION')


def test_a_box_is_added_and_avoided(stack, page):
    """A box where the tool would pass: the straight way would hit it, the way taken does not."""
    page.unfold('Joints')
    page.go('scan_food')
    page.type_into('joint_1 [°]', -50)
    page.press('Plan & Execute')
    page.wait_for_result('arrived')
    page.unfold('Scene')
    page.press('Box')
    page.tab.locator('[data-object=box_1]').wait_for()
    place = stack.tool_pose(SCAN_FOOD)[:3, 3]
    for axis, value in zip('xyz', place, strict=True):
        page.type_into(f'Place [m] {axis}', round(float(value), 3))
    assert any(not stack.valid(SCAN_FOOD) for _ in range(100))  # once the box is there
    page.choose('Goal state', 'scan_food')
    assert 'box_1 touches ' in page.wait_for_verdict('collision')
    states = stack.client.collect('/sunday/joint_states', JointState)
    page.type_into('joint_1 [°]', 50)
    page.wait_for_verdict('reachable')
    page.press('Plan & Execute')
    page.wait_for_result('arrived')
    assert stack.robot.distance({**SCAN_FOOD, 'joint_1': math.radians(50)}) < 0.01
    way = [dict(zip(each.name, each.position, strict=True)) for each in states.messages]
    assert all(stack.valid(state) for state in way[::max(1, len(way) // 25)])
    page.press_at('box_1', 'Remove')
    page.tab.locator('[data-object=box_1]').wait_for(state='detached')
    page.fold('Scene')


def test_a_plan_is_scrubbed_drawn_and_cleared(page):
    """The ghost stands where the slider says; the curves are drawn and can be saved."""
    page.choose('Goal state', 'home')
    page.press('Plan')
    page.wait_for_result('planned')
    end = page.resting_picture()
    page.slide('Time', 0)
    page.wait_for_picture(lambda now: changed(end, now) > 300)
    page.unfold('Motion')
    page.tab.locator('#plots canvas').nth(2).wait_for()
    assert page.tab.locator('#plots canvas').count() == 3
    with page.tab.expect_download() as download:
        page.press('CSV')
    assert download.value.path().read_text().startswith('time,joint_1 position,')
    page.fold('Motion')
    page.press('Clear')
    page.tab.get_by_role('button', name='Replay').wait_for(state='hidden')


def test_two_users_have_goals_of_their_own_and_either_stops_the_motion(page, open_page):
    """What one executes the other is told; the other's Stop ends it."""
    other = open_page()
    page.slide('Speed', 5)
    page.choose('Goal state', 'home')
    page.wait_for_verdict('reachable')
    assert other.field('Goal state').input_value() == 'current'
    page.press('Plan & Execute')
    other.wait_for_status('(session ')
    other.press('Stop')
    page.wait_for_result('stopped')
    other.tab.context.close()
    assert other.page_errors == []


def test_a_page_that_is_loaded_again_goes_on_with_its_goal(stack, page):
    """The tab's goal stays with the tab, and the arm goes there."""
    page.choose('Goal state', 'home')
    page.wait_for_verdict('reachable')
    page.tab.reload()
    page.wait_until_ready()
    page.tab.wait_for_function('document.getElementById("goal-state").value === "home"')
    page.press('Plan & Execute')
    page.wait_for_result('arrived')
    assert stack.robot.distance(dict.fromkeys(JOINTS, 0.0)) < 0.01


def test_it_fits_a_narrow_screen_and_can_be_read(page):
    """At 360 pixels nothing is cut off at the side, and no text is below 13 pixels."""
    page.tab.set_viewport_size({'width': 360, 'height': 640})
    try:
        for part in ('Plan', 'Joints', 'Motion', 'Scene', 'Controllers'):
            page.unfold(part)
        found = page.tab.evaluate(MISFITS)
        assert found == {'wide': [], 'small': []}
    finally:
        page.tab.set_viewport_size({'width': 800, 'height': 520})
        for part in ('Joints', 'Motion', 'Scene', 'Controllers'):
            page.fold(part)


def test_it_is_used_by_keyboard_alone(stack, page):
    """From the goal state to the button by tabulator; the arrow keys choose, Enter presses."""
    page.choose('Goal state', 'home')
    page.field('Goal state').focus()
    keyboard = page.tab.keyboard
    keyboard.press('ArrowDown')
    page.wait_for_verdict('reachable')
    state = page.field('Goal state').input_value()
    assert state != 'home'
    for _ in range(4):
        keyboard.press('Tab')
        if page.tab.evaluate('document.activeElement.textContent') == 'Plan & Execute':
            break
    keyboard.press('Enter')
    page.wait_for_result('arrived')
    states = stack.robot.move_group.named_states()
    assert stack.robot.distance(states['manipulator', state]) < 0.01


def test_the_programs_of_the_tutorial_do_what_it_says(stack, page, tmp_path):
    """The first moves the arm; what the second puts into the scene the page shows."""
    text = (ROOT / 'docs' / 'tutorial.md').read_text(encoding='utf-8')
    said = []
    for number, program in enumerate(re.findall(r'```python\n(.*?)```', text, re.DOTALL)):
        file = tmp_path / f'program_{number}.py'
        file.write_text(program, encoding='utf-8')
        said.append(subprocess.run(
            [sys.executable, str(file)], env=ros_environment(stack.domain), capture_output=True,
            text=True, check=True, timeout=60).stdout)
    assert said == ['error code: 0, Goal reached: success\n', 'applied: True\n']
    there = dict(zip(JOINTS, (0.5, 0.4, 0.5, -0.5, 1.5, 0.0), strict=True))
    assert stack.robot.distance(there) < 0.01
    page.unfold('Scene')
    page.tab.locator('[data-object=post]').wait_for()
    page.press_at('post', 'Remove')
    page.tab.locator('[data-object=post]').wait_for(state='detached')
    page.fold('Scene')


@pytest.mark.parametrize('program', ['simulation', 'move_group'])
def test_a_program_is_killed_and_started_again(stack, page, program):
    """The page says which, with the cure, and goes on without being loaded again."""
    stack.kill(program)
    page.wait_for_status(f'{program} does not answer')
    assert page.tab.locator('#status').get_attribute('data-level') == 'error'
    assert f"'armsim {program}'" in page.tab.inner_text('#cures')
    stack.start(program)
    page.wait_until_ready()
    page.go('home')
    page.go('scan_food')
    assert stack.robot.distance(SCAN_FOOD) < 0.01


def test_the_server_is_killed_and_started_again(stack, page):
    """The browser says so, and shows the robot again without being loaded again."""
    stack.kill('web')
    page.tab.get_by_text('connection lost, trying again').wait_for()
    stack.start('web', f'port:={stack.address.rpartition(":")[2]}')
    page.tab.get_by_text('connection lost, trying again').wait_for(state='hidden')
    page.wait_until_ready()
    rest = page.resting_picture()
    page.go('home')
    page.wait_for_picture(lambda now: changed(rest, now) > 300)
