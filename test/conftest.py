# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Gives every test process a ROS graph of its own, before anything can import rclpy."""

from contextlib import ExitStack
import faulthandler
import gc
import os
from pathlib import Path

from failures_at_once import FailuresAtOnce
from jobs import ByStack, ChosenJob, JOBS
from pressure import Pressure
import pytest
from rendering import rendering_backend

from armsim_ros.cli.environment import FASTDDS_PROFILES, QuietEnd

if 'DISPLAY' not in os.environ:
    # MuJoCo reads it when it is imported, and any conftest may be the first to do so.
    os.environ.setdefault('MUJOCO_GL', 'egl')

#: Domain ids up to 101 keep Fast DDS below the ephemeral ports of Linux.
_FIRST_DOMAIN, _LAST_DOMAIN = 40, 99


_TESTS = Path(__file__).parent
#: Folders and files whose tests run programs in real time, or join a ROS graph; those whose files
#: take long come first, so that no worker is left with one.
_REAL_TIME = [
    _TESTS / name
    for name in ('conformance', 'system', 'nodes', 'launch/test_running.py',
                 'interfaces/test_between_processes.py')
]
#: Folders each of which has one stack for most of its tests.
_ONE_STACK = [
    _TESTS / name
    for name in ('conformance/controllers', 'conformance/move_group', 'conformance/pymoveit2',
                 'conformance/ros2', 'conformance/streaming', 'conformance/world',
                 'nodes/move_group', 'nodes/moveit_py', 'system/simulation/running')
]
#: How programs find each other; what forgets quickly who was killed is set where it is tested.
_PROFILES = _TESTS / 'support/fastdds_profiles.xml'
#: How long a stack may take to end after the last test [s].
_PATIENCE_AT_END = 120
_END = pytest.StashKey()
#: Folder -> what its tests share.
_SHARED = pytest.StashKey()


def pytest_addoption(parser):
    """Add the choice of a job, see scripts/run_tests.py."""
    parser.addoption('--job', choices=JOBS, help='run the tests of this job only')
    parser.addoption('--stops', type=int, default=12, help='random stops of a moving arm')


def pytest_configure(config):
    """Choose the domain; workers of pytest-xdist take those after what the caller set."""
    domain = int(os.environ.get('ROS_DOMAIN_ID', _FIRST_DOMAIN + os.getpid()))
    worker = os.environ.get('PYTEST_XDIST_WORKER')
    if worker:
        domain += 1 + int(worker.removeprefix('gw'))
    if worker or 'ROS_DOMAIN_ID' not in os.environ:
        domain = _FIRST_DOMAIN + (domain - _FIRST_DOMAIN) % (_LAST_DOMAIN - _FIRST_DOMAIN + 1)
    os.environ['ROS_DOMAIN_ID'] = str(domain)
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    for name in ('RMW_IMPLEMENTATION', 'ROS_STATIC_PEERS', 'ROS_LOCALHOST_ONLY',
                 'ROS_NAMESPACE', *FASTDDS_PROFILES):
        os.environ.pop(name, None)
    os.environ[FASTDDS_PROFILES[0]] = str(_PROFILES)
    config.stash[_SHARED] = {}
    config.stash[_END] = QuietEnd()
    config.pluginmanager.register(FailuresAtOnce(config))
    config.pluginmanager.register(Pressure())
    config.pluginmanager.register(ByStack(_ONE_STACK))
    if config.option.job:
        config.pluginmanager.register(ChosenJob(config.option.job, _REAL_TIME))


@pytest.hookimpl(trylast=True)
def pytest_collection_finish():
    """Let the garbage collector pass over what lives until the end: tests and modules."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session, exitstatus):
    """Leave what tests shared, then with this status, without a report of leaks of bindings."""
    faulthandler.dump_traceback_later(_PATIENCE_AT_END, exit=True)
    for stack, _ in session.config.stash[_SHARED].values():
        stack.close()
    faulthandler.cancel_dump_traceback_later()
    session.config.stash[_END].status = int(exitstatus)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    """Leave what tests of other folders shared."""
    shared = item.config.stash[_SHARED]
    for folder in [folder for folder in shared if not item.path.is_relative_to(folder)]:
        stack, _ = shared.pop(folder)
        stack.close()


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item, nextitem):
    """
    Collect what the tests of a folder left in cycles.

    A node among it stays in the graph of its domain, without endpoints, beside the next stack.
    """
    if nextitem is None or nextitem.path.parent != item.path.parent:
        gc.collect()


@pytest.fixture(scope='session')
def ros_domain_id():
    """Return the domain that this test process and its children use."""
    return int(os.environ['ROS_DOMAIN_ID'])


@pytest.fixture(scope='session')
def shared_in_folder(request):
    """
    Return a function that gives what the tests of a folder share, entering it for the first.

    It is left before the first test elsewhere: a running stack takes half a core, also from the
    tests of other folders. Once a ``program`` in it runs no more, all that the folder shares is
    entered anew: what one test did to it is no fault of the next.
    """
    shared = request.config.stash[_SHARED]

    def give(enter, folder, name=''):
        stack, given = shared.get(Path(folder)) or (None, {})
        programs = [getattr(each, 'program', None) for each in given.values()]
        if any(program is not None and program.process.poll() is not None for program in programs):
            shared.pop(Path(folder))
            stack.close()
            stack = None
        if stack is None:
            stack, given = shared[Path(folder)] = ExitStack(), {}
        if name not in given:
            given[name] = stack.enter_context(enter())
        return given[name]

    return give


@pytest.fixture(scope='session')
def drawing():
    """Return what draws without a screen; skip where nothing does."""
    backend = rendering_backend()
    if backend is None:
        pytest.skip('nothing on this machine can draw; that this is said is another test')
    return backend


@pytest.fixture
def small_package(tmp_path, monkeypatch):
    """Return a workspace with one small MoveIt package; nothing else is found as a package."""
    monkeypatch.setenv('AMENT_PREFIX_PATH', '')
    return SmallPackage(tmp_path / 'ws' / 'src')


class SmallPackage:
    """
    Two packages as robots are published: ``NAME_moveit_config`` and ``NAME_description``.

    The arm has two joints and a gripper of one; tests write, replace and remove files.
    """

    LINK = ('<link name="{0}"><inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" '
            'iyy="0.01" iyz="0" izz="0.01"/></inertial></link>')
    JOINT = ('<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/>'
             '<origin xyz="0 0 0.2"/><axis xyz="0 1 0"/>'
             '<limit lower="-2" upper="2" effort="50" velocity="2"/></joint>')
    ARM = ''.join((
        LINK.format('base'), LINK.format('upper'), LINK.format('lower'), LINK.format('finger'),
        JOINT.format('shoulder', 'base', 'upper'), JOINT.format('elbow', 'upper', 'lower'),
        JOINT.format('grip', 'lower', 'finger')))
    SRDF = ('<robot name="small"><group name="arm"><joint name="shoulder"/><joint name="elbow"/>'
            '</group><group_state name="bent" group="arm"><joint name="shoulder" value="0.5"/>'
            '<joint name="elbow" value="-0.5"/></group_state></robot>')
    XACRO = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="small">{0}</robot>'
    MOVEIT = (
        'moveit_controller_manager: moveit_simple_controller_manager/'
        'MoveItSimpleControllerManager\n'
        'moveit_simple_controller_manager:\n'
        '  controller_names: [arm_controller]\n'
        '  arm_controller:\n'
        '    {type: FollowJointTrajectory, action_ns: follow_joint_trajectory, default: true,\n'
        '     joints: [shoulder, elbow]}\n')
    ROS2 = (
        'controller_manager:\n  ros__parameters:\n    update_rate: 500\n'
        '    arm_controller: {type: joint_trajectory_controller/JointTrajectoryController}\n'
        '    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}\n'
        'arm_controller:\n  ros__parameters:\n    joints: [shoulder, elbow]\n'
        '    command_interfaces: [position]\n    state_interfaces: [position, velocity]\n')

    def __init__(self, src, name='small'):
        self.name = name
        self.src = src
        self.folder = src / 'repository' / f'{name}_moveit_config'
        self.description = src / 'repository' / 'description_folder'
        self.write('package.xml', f'<package><name>{name}_moveit_config</name></package>')
        self.write('../description_folder/package.xml',
                   f'<package><name>{name}_description</name></package>')
        self.write('../description_folder/urdf/arm.urdf', self.XACRO.format(self.ARM))
        self.write(f'config/{name}.urdf.xacro', self.XACRO.format(
            f'<xacro:include filename="$(find {name}_description)/urdf/arm.urdf"/>'))
        self.write(f'config/{name}.srdf', self.SRDF)
        self.write('config/moveit_controllers.yaml', self.MOVEIT)
        self.write('config/ros2_controllers.yaml', self.ROS2)

    def write(self, name, text):
        """Write a file of the MoveIt package."""
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    def remove(self, *names):
        """Remove files."""
        for name in names:
            (self.folder / name).unlink()

    def ros2_control(self, *joints, plugin='vendor/Hardware', name='Arm', more=''):
        """Put a ``<ros2_control>`` tag into the URDF."""
        tag = (f'<ros2_control name="{name}" type="system"><hardware><plugin>{plugin}</plugin>'
               f'</hardware>{"".join(joints)}</ros2_control>')
        self.write(f'config/{self.name}.urdf.xacro', self.XACRO.format(
            f'<xacro:include filename="$(find {self.name}_description)/urdf/arm.urdf"/>'
            f'{tag}{more}'))
