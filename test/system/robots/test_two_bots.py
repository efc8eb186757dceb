"""Two of the same arm in one world: each in its namespace, one planner that knows both."""

from concurrent.futures import ThreadPoolExecutor
from contextlib import closing

from controller_manager_msgs.msg import ControllerState
from diagnostic_msgs.msg import DiagnosticArray
from faster import FASTER
from moveit_msgs.msg import MoveItErrorCodes
import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from armsim_ros.clients.controller_manager import ControllerManagerClient
from armsim_ros.clients.motion import SUCCESS
from armsim_ros.clients.trajectory import SUCCEEDED, trajectory_message, TrajectoryClient
from armsim_ros.testing.robot_user import running_robot

SIDES = ('left', 'right')
NUMBERS = range(1, 6)
#: Both lean towards -y: the left one into the place where the right one stands upright.
LEANING = [-1.5708, 1.0, 0.6, 0.0, 0.0]


def joints(side):
    """Return the joints of one arm."""
    return [f'{side}_joint{number}' for number in NUMBERS]


def of(side, positions):
    """Return joint -> position [rad] of one arm."""
    return dict(zip(joints(side), positions, strict=True))


@pytest.fixture(scope='module')
def left():
    """Run the stack, quicker than the wall clock, seen by a user of the left arm."""
    with running_robot('robot:=two_bots', FASTER, namespace='/left') as user:
        yield user


@pytest.fixture(scope='module')
def right(left):
    """Return the same stack, seen by a user of the right arm."""
    return type(left)(left.client, left.program, '/right')


@pytest.fixture(scope='module')
def users(left, right):
    """Return side -> its user."""
    return {'left': left, 'right': right}


@pytest.fixture(autouse=True)
def _upright(users):
    """Begin with both arms upright."""
    goals = [TrajectoryClient(user.client, f'/{side}/bot_joint_controller').send(
        trajectory_message(joints(side), [(1.0, [0.0] * 5)])) for side, user in users.items()
        if user.distance(of(side, [0.0] * 5)) > 0.01]
    assert all(goal.result().status == SUCCEEDED for goal in goals)


def test_both_are_moved_at_once_in_their_namespaces(users):
    """Two actions of one name, two joint_states with the joints of one arm each."""
    targets = {'left': [0.3, -0.2, 0.4, 0.1, 0.2], 'right': [-0.3, 0.3, 0.2, 0.0, -0.2]}
    goals = [TrajectoryClient(user.client, f'/{side}/bot_joint_controller').send(
        trajectory_message(joints(side), [(1.0, targets[side])])) for side, user in users.items()]
    assert [goal.result().status for goal in goals] == [SUCCEEDED, SUCCEEDED]
    for side, user in users.items():
        assert set(user.positions()) == set(joints(side))
        assert user.distance(of(side, targets[side])) < 0.01


def test_each_manager_lists_its_own(left):
    """Controllers of the same names, interfaces of one arm."""
    for side in SIDES:
        manager = ControllerManagerClient(left.client, f'/{side}/controller_manager')
        controllers: dict[str, ControllerState] = manager.controllers()
        assert {name: one.state for name, one in controllers.items()} == {
            'joint_state_controller': 'active', 'bot_joint_controller': 'active'}
        assert set(controllers['bot_joint_controller'].claimed_interfaces) == {
            f'{joint}/position' for joint in joints(side)}
        found = manager.hardware_interfaces()
        assert {one.name.partition('_')[0] for one in (
            *found.command_interfaces, *found.state_interfaces)} == {side}


def test_a_plan_is_refused_where_the_other_arm_stands(left, right):
    """And taken once that has moved away; the same in move_group's own execution."""
    lean = of('left', LEANING)
    assert left.move_group.plan('left_arm', lean).error_code.val != SUCCESS
    assert right.move_group.move('right_arm', of('right', LEANING)).error_code.val == SUCCESS
    assert left.move_group.move('left_arm', lean).error_code.val == SUCCESS
    assert left.distance(lean) < 0.01
    assert right.distance(of('right', LEANING)) < 0.01
    # The way back is barred to the right arm now.
    upright = of('right', [0.0] * 5)
    assert right.move_group.plan('right_arm', upright).error_code.val != SUCCESS
    assert left.move_group.move('left_arm', of('left', [0.0] * 5)).error_code.val == SUCCESS


def test_an_arm_that_gets_in_the_way_stops_a_motion(left, right):
    """The right arm rises where the left one is about to go: move_group ends its motion."""
    assert right.send('bot_joint_controller', joints('right'), [(1.0, LEANING)]
                      ).status == SUCCEEDED
    with ThreadPoolExecutor() as pool:
        motion = pool.submit(left.move_group.move, 'left_arm', of('left', LEANING),
                             max_velocity_scaling_factor=0.1)
        with closing(left.client.collect('/left/joint_states', JointState)) as states:
            states.wait_for(lambda message: min(message.position) < -0.1)
        assert right.send('bot_joint_controller', joints('right'), [(1.0, [0.0] * 5)]
                          ).status == SUCCEEDED
        code = motion.result().error_code
    assert code.val == MoveItErrorCodes.MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE
    assert 'right_link' in code.message
    assert left.distance(of('left', LEANING)) > 0.1


def test_one_plan_over_both_arms(users):
    """It is split over the controllers of both namespaces."""
    user = users['left']
    target = user.move_group.named_states()['both_arms', 'ready']
    result = user.move_group.move('both_arms', target)
    assert result.error_code.val == SUCCESS
    for side, one in users.items():
        assert one.distance({name: target[name] for name in joints(side)}) < 0.01


def test_one_manager_switches_and_the_other_arm_goes_on(left, right):
    """A controller that is stopped holds its arm; the other one follows its trajectory."""
    manager = ControllerManagerClient(left.client, '/left/controller_manager')
    assert manager.switch(deactivate=['bot_joint_controller']).ok
    assert right.send('bot_joint_controller', joints('right'),
                      [(0.6, [0.2] * 5)]).status == SUCCEEDED
    assert right.distance(of('right', [0.2] * 5)) < 0.01
    assert left.distance(of('left', [0.0] * 5)) < 0.01
    assert manager.switch(activate=['bot_joint_controller']).ok


def test_descriptions_of_the_whole_and_of_each(left):
    """URDF and SRDF at the root for the planner's clients, those of one arm beside it."""
    for topic, of_whole in (('robot_description', 'name="world"'),
                            ('robot_description_semantic', 'both_arms')):
        whole = left.client.latched(f'/{topic}', String).data
        alone = left.client.latched(f'/right/{topic}', String).data
        assert of_whole in whole
        assert of_whole not in alone
        assert 'left_link1' in whole
        assert 'left_link1' not in alone
        assert 'right_link1' in alone


def test_one_tree_of_frames(left):
    """All frames hang on the world, each published once."""
    with closing(left.client.collect('/tf', TFMessage)) as messages:
        moving = messages.wait(1)[-1].transforms
    fixed = left.client.latched('/tf_static', TFMessage).transforms
    children = [one.child_frame_id for one in (*moving, *fixed)]
    assert len(children) == len(set(children))
    assert {(one.header.frame_id, one.child_frame_id, one.transform.translation.y)
            for one in fixed if one.header.frame_id == 'world'} == {
        ('world', 'left_base_link', 0.25), ('world', 'right_base_link', -0.25)}


def test_diagnostics_tell_the_robots_apart(left):
    """The namespace precedes the manager's name."""
    arrays = left.client.collect('/diagnostics', DiagnosticArray)
    arrays.wait_for(lambda message: message.status[0].name.startswith('right/'))
    names = {status.name for message in arrays.wait(2) for status in message.status}
    assert {f'{side}/controller_manager: Controllers Activity' for side in SIDES} <= names


def test_joint_states_have_one_clock(left):
    """Both arms are stamped with the time of the one physics."""
    stamps = {}
    for side in SIDES:
        with closing(left.client.collect(f'/{side}/joint_states', JointState)) as states:
            stamps[side] = states.wait(1)[-1].header.stamp.sec
    assert abs(stamps['left'] - stamps['right']) <= 1
