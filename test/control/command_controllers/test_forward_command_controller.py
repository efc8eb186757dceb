# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Forward controllers: what they pass on, what they drop, how they hand over."""

from types import SimpleNamespace

import numpy as np
import pytest

from armsim_ros.errors import ControllerError

FORWARD = 'forward_command_controller/ForwardCommandController'
MULTI = 'forward_command_controller/MultiInterfaceForwardCommandController'
GROUPS = {
    'position': 'position_controllers/JointGroupPositionController',
    'velocity': 'velocity_controllers/JointGroupVelocityController',
    'effort': 'effort_controllers/JointGroupEffortController',
}
LONGEST_STEP = 3.0 * 0.01 + 1e-9


@pytest.fixture
def bench(rig):
    """Return joints with a group controller, by its interface."""

    def make(kind, **parameters):
        made = rig()
        controller = made.load('stream', GROUPS[kind], joints=['a', 'b'], **parameters)
        assert made.manager.switch(activate=['stream']).ok
        made.step()
        return made, controller

    return make


@pytest.mark.parametrize(
    ('type', 'parameters', 'missing'),
    [
        (FORWARD, {'interface_name': 'position'}, 'joints'),
        (FORWARD, {'joints': ['a']}, 'interface_name'),
        (MULTI, {'interface_names': ['position']}, 'joint'),
        (MULTI, {'joint': 'a'}, 'interface_names'),
        (GROUPS['velocity'], {}, 'joints'),
        ('effort_controllers/JointEffortController', {}, 'joint'),
    ],
)
def test_empty_parameter(rig, type, parameters, missing):  # noqa: A002
    """A parameter that is needed and empty lets configure fail, by its name."""
    with pytest.raises(ControllerError, match=f"'{missing}'"):
        rig().load('stream', type, **parameters)


@pytest.mark.parametrize(
    ('type', 'changes', 'claimed'),
    [
        (FORWARD, {'joints': ['b', 'a'], 'interface_name': 'velocity'},
         ('b/velocity', 'a/velocity')),
        (MULTI, {'joint': 'b', 'interface_names': ['velocity', 'position']},
         ('b/velocity', 'b/position')),
        (GROUPS['effort'], {'joints': ['a']}, ('a/effort',)),
        ('velocity_controllers/JointVelocityController', {'joint': 'a'}, ('a/velocity',)),
    ],
)
def test_configured_with_parameters_that_were_set_after_loading(
    rig, type, changes, claimed  # noqa: A002
):
    """
    A controller that was loaded without joints gets them before it is configured.

    forward_command_controller/test/test_forward_command_controller.cpp: ConfigureParamsSuccess.
    """
    made = rig()
    controller = made.manager.load(SimpleNamespace(name='stream', type=type, parameters={}))
    controller.set_parameters(changes)
    made.manager.configure('stream')
    assert controller.required_command_interfaces == claimed
    assert made.manager.switch(activate=['stream']).ok


def test_joints_that_are_set_while_it_is_active_wait_for_configure(rig):
    """The claimed joints follow on (forward_command_controller.cpp, read_parameters)."""
    made = rig()
    controller = made.load('stream', FORWARD, joints=['a', 'b'], interface_name='position')
    assert made.manager.switch(activate=['stream']).ok
    controller.set_parameters({'joints': ['b']})
    assert controller.receive([0.01, 0.02]) == ''
    made.step()
    np.testing.assert_allclose(made.hardware.command.position, [0.01, 0.02])
    assert made.manager.switch(deactivate=['stream']).ok
    assert made.manager.switch(activate=['stream']).ok
    assert controller.joints == ('a', 'b')
    assert made.manager.switch(deactivate=['stream']).ok
    made.manager.configure('stream')
    assert controller.joints == ('b',)


@pytest.mark.parametrize('joint', ['a', 'nowhere'])
def test_unknown_interface(rig, joint):
    """What the hardware lacks is told of at activation."""
    made = rig()
    made.load('stream', FORWARD, joints=[joint], interface_name='colour')
    result = made.manager.switch(activate=['stream'])
    assert not result.ok
    assert f'{joint}/colour' in result.message


@pytest.mark.parametrize('kind', list(GROUPS))
def test_holds_until_the_first_command(bench, kind):
    """Nothing is written before a command comes, nor for one from before the activation."""
    made, controller = bench(kind)
    made.manager.switch(deactivate=['stream'])
    controller.receive([1.0, 1.0])
    before = made.hardware.state.position.copy()
    made.manager.switch(activate=['stream'])
    made.run(0.5)
    np.testing.assert_allclose(made.hardware.state.position, before, atol=1e-12)


@pytest.mark.parametrize('kind', list(GROUPS))
def test_commands_are_passed_on_as_they_are(bench, kind):
    """
    No limit of the joints bounds a command, and it stands until another one comes.

    forward_controllers_base.cpp, update.
    """
    made, controller = bench(kind)
    assert controller.receive([90.0, -50.0]) == ''
    made.step()
    np.testing.assert_array_equal(made.hardware.command.of(kind), [90.0, -50.0])
    made.run(10.0)
    np.testing.assert_array_equal(made.hardware.command.of(kind), [90.0, -50.0])
    made.hardware.command.of(kind)[:] = 0.0
    made.step()
    np.testing.assert_array_equal(made.hardware.command.of(kind), [90.0, -50.0])


@pytest.mark.parametrize('kind', list(GROUPS))
def test_silence_ends_motion_by_parameter(bench, kind):
    """With command_timeout a velocity becomes 0, an effort is not given, a position stays."""
    made, controller = bench(kind, command_timeout=0.5)
    controller.receive([0.5, -0.5])
    made.run(0.45)
    np.testing.assert_array_equal(made.hardware.command.of(kind), [0.5, -0.5])
    made.run(0.3)
    rest = {'position': [0.5, -0.5], 'velocity': [0.0, 0.0], 'effort': [np.nan, np.nan]}
    np.testing.assert_array_equal(made.hardware.command.of(kind), rest[kind])


def test_a_command_without_successors_is_looked_at_when_its_time_is_over(bench):
    """Updates that are left out end at the very tick at which command_timeout does."""
    made, controller = bench('velocity', command_timeout=0.5)
    controller.receive([0.5, -0.5])
    taken_ns = made.now_ns
    made.step()
    assert controller.next_update(made.now_ns) == taken_ns + 500_000_000


def test_commands_that_come_in_time_go_on(bench):
    """The timeout runs from the last command."""
    made, controller = bench('velocity', command_timeout=0.1)
    for _ in range(20):
        controller.receive([0.5, 0.5])
        made.run(0.05)
    assert made.hardware.state.velocity == pytest.approx([0.5, 0.5])


@pytest.mark.parametrize(
    ('values', 'words'),
    [
        ([np.nan, 0.0], 'nan for a/position'),
        ([0.0, np.inf], 'inf for b/position'),
        ([0.0], '1 values; expected 2'),
        ([], '0 values; expected 2'),
        ([0.0] * 3, '3 values; expected 2'),
    ],
)
def test_what_is_no_command(bench, values, words):
    """It is dropped with one warning, the last command stays, the controller stays active."""
    made, controller = bench('position')
    controller.receive([0.2, 0.2])
    made.run(0.2)
    made.texts()
    for _ in range(10):
        controller.receive(values)
        made.step()
    (text,) = made.texts()
    assert words in text
    assert controller.active
    np.testing.assert_allclose(made.hardware.command.position, [0.2, 0.2])


@pytest.mark.parametrize(('kind', 'left'), [('position', 0.3), ('velocity', 0.0), ('effort', 0.0)])
def test_deactivation(bench, kind, left):
    """
    Positions stay; velocity and effort become 0.

    joint_group_velocity_controller.cpp and joint_group_effort_controller.cpp, on_deactivate.
    """
    made, controller = bench(kind)
    controller.receive([0.3, 0.3])
    made.run(0.3)
    made.manager.switch(deactivate=['stream'])
    np.testing.assert_allclose(made.hardware.command.of(kind), [left, left])


@pytest.mark.parametrize('kind', ['velocity', 'effort'])
def test_deactivation_of_the_general_controller(rig, kind):
    """It writes nothing when it ends (forward_controllers_base.cpp, on_deactivate)."""
    made = rig()
    controller = made.load('stream', FORWARD, joints=['a', 'b'], interface_name=kind)
    made.manager.switch(activate=['stream'])
    controller.receive([0.3, 0.3])
    made.step()
    made.manager.switch(deactivate=['stream'])
    np.testing.assert_array_equal(made.hardware.command.of(kind), [0.3, 0.3])


def test_several_interfaces_of_one_joint(rig):
    """Each value goes to its own interface."""
    made = rig()
    controller = made.load('stream', MULTI, joint='b', interface_names=['velocity', 'position'])
    made.manager.switch(activate=['stream'])
    controller.receive([0.25, 0.01])
    made.step()
    assert made.hardware.command.velocity[1] == 0.25
    assert made.hardware.command.position[1] == 0.01
    assert np.isnan(made.hardware.command.position[0])


@pytest.mark.parametrize('type', ['position_controllers/JointPositionController'])
def test_single_joint(rig, type):  # noqa: A002
    """ROS 1's controllers of one joint take one number."""
    made = rig()
    controller = made.load('one', type, joint='b')
    made.manager.switch(activate=['one'])
    controller.receive((0.02,))
    made.step()
    assert made.hardware.command.position[1] == pytest.approx(0.02)


def test_other_position_after_a_reset_begins_where_the_joint_is(bench):
    """When the commands were erased, as a reset does it, the next one begins at the joint."""
    made, controller = bench('position')
    controller.receive([2.0, 2.0])
    made.run(1.0)
    made.hardware.command.position[:] = np.nan
    made.hardware.state.position[:] = 0.0
    controller.receive([0.01, 0.01])
    made.step()
    np.testing.assert_allclose(made.hardware.command.position, [0.01, 0.01])


def test_two_thousand_switches(rig, trajectory):
    """Between controllers in motion no command steps further than those that were sent."""
    made = rig()
    arm = made.arm('arm')
    streams = {
        kind: made.load(kind, GROUPS[kind], joints=['a', 'b']) for kind in ('position', 'velocity')
    }
    random = np.random.default_rng(7)
    active, position = 'arm', made.hardware.state.position.copy()
    worst = 0.0
    for _ in range(2_000):
        following = random.choice([name for name in ('arm', *streams) if name != active])
        result = made.manager.switch(activate=[following], deactivate=[active])
        assert result.ok, result.message
        active = following
        target = random.uniform(-3.0, 3.0, 2)
        if active == 'arm':
            assert arm.send_goal(trajectory((3.0, target))).accepted
        else:
            near = made.hardware.state.position + 0.01 * target
            streams[active].receive(near if active == 'position' else target)
        for _ in range(int(random.integers(1, 6))):
            made.step()
            worst = max(worst, float(np.abs(made.hardware.state.position - position).max()))
            position = made.hardware.state.position.copy()
    assert worst <= LONGEST_STEP


def test_a_command_that_moves_no_joint_is_followed_while_the_arm_is_stopped(rig):
    """A lamp has nothing to do with the stop; commands of joints are dropped."""
    made = rig()
    made.hardware.other_commands['lamp/on'] = np.nan
    light = made.load('light', FORWARD, joints=['lamp'], interface_name='on')
    joints = made.load('joints', FORWARD, joints=['a'], interface_name='position')
    assert made.manager.switch(activate=['light', 'joints']).ok
    made.manager.arm.protective_stop()
    made.step()
    assert light.receive([1.0]) == ''
    assert 'stop' in joints.receive([0.5])
    made.step()
    assert made.hardware.other_commands['lamp/on'] == 1.0
