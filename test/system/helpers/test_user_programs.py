# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Users' programs that import the helpers and not armsim_ros, beside an arm with a camera."""

from pathlib import Path
import subprocess
import sys

from moveit_msgs.srv import GetPositionFK
import pytest

from armsim_ros.testing.program import private_domain, ros_environment
from armsim_ros.testing.robot_user import running_robot

PROGRAMS = Path(__file__).parent / 'programs'
EXAMPLE = Path(__file__).parents[3] / 'examples' / 'grasp.py'
#: A program waits for pictures that are drawn at the lowest priority [s].
PATIENCE = 150
#: A script of pymoveit2 with an action client that loses no answer, which rclpy 7.1 now and then
#: does, see armsim_ros/clients/action_client.py: the script would wait for its motion for ever.
LOSING_NOTHING = """
import runpy, sys
import pymoveit2.moveit2
from armsim_ros.clients.action_client import PatientActionClient

pymoveit2.moveit2.ActionClient = PatientActionClient
del sys.argv[0]
runpy.run_path(sys.argv[0], run_name='__main__')
"""


@pytest.fixture(scope='module')
def domain():
    """Lease a domain."""
    with private_domain() as domain:
        yield domain


@pytest.fixture(scope='module')
def robot(drawing, domain):
    """Run an arm with a camera."""
    with running_robot('world:=feeding_place', 'camera:=true', namespace='/sunday',
                       domain=domain) as robot:
        yield robot


@pytest.fixture
def numbers(domain):
    """Return a function that runs a program and returns the numbers that it prints."""
    def run(name, *arguments):
        done = subprocess.run(
            [sys.executable, PROGRAMS / f'{name}.py', *arguments], capture_output=True, text=True,
            env=ros_environment(domain), timeout=PATIENCE, cwd='/')
        assert done.returncode == 0, done.stderr
        return [float(word) for word in done.stdout.split()]

    return run


def test_the_pose_of_the_tool(robot, numbers):
    """What the buffer finds is the planner's forward kinematics of the current state."""
    request = GetPositionFK.Request(fk_link_names=['link_6'])
    request.header.frame_id = 'base_link'
    request.robot_state.is_diff = True
    (expected,) = robot.client.call('/compute_fk', GetPositionFK, request).pose_stamped
    x, y, z, *rotation = numbers('tool_pose', 'base_link', 'link_6')
    position, turned = expected.pose.position, expected.pose.orientation
    assert (x, y, z) == pytest.approx((position.x, position.y, position.z), abs=1e-3)
    cosine = sum(own * other for own, other in zip(
        rotation, (turned.x, turned.y, turned.z, turned.w), strict=True))
    assert abs(cosine) == pytest.approx(1, abs=1e-5)


def test_colour_and_depth_of_the_same_moment(robot, numbers):
    """Both images have the camera's size and one stamp."""
    *sizes, apart, nearest = numbers('colour_and_depth')
    assert sizes == [480, 640, 3, 480, 640]
    assert apart == 0
    assert 0 < nearest < 10


def test_points_of_a_depth_image(robot, numbers):
    """They are those of the camera's own cloud."""
    mine, given, difference = numbers('depth_to_points')
    assert mine == given > 1000
    assert difference < 1e-4


def test_the_cube_is_found_and_put_where_it_belongs(robot, domain):
    """The example works: camera, planner that sees the world, and suction cup together."""
    pytest.importorskip('pymoveit2', reason='pymoveit2 is not installed')
    robot.program.wait_for_line('cameras: camera; drawn by', PATIENCE)
    done = subprocess.run(
        [sys.executable, '-c', LOSING_NOTHING, EXAMPLE], env=ros_environment(domain),
        capture_output=True, text=True, timeout=2 * PATIENCE)
    assert done.returncode == 0, done.stdout + done.stderr
    assert '1 of 1 runs put the cube at its target' in done.stdout
