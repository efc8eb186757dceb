"""Robots of which there was only a URDF, brought up with the files that were generated."""

from faster import LITTLE_FASTER
from public_robots import public_urdf
import pytest

from armsim_ros.clients.motion import SUCCESS
from armsim_ros.clients.trajectory import SUCCEEDED
from armsim_ros.resources import PACKAGE, share_folder
from armsim_ros.testing.robot_user import running_robot
from armsim_ros.tools.generate_config.main import generate_config

OWN = ('elfin', 'magician')


@pytest.mark.parametrize('robot', ['elfin', 'magician', 'ur5', 'panda', 'xarm7', 'so101'])
def test_a_generated_robot_follows_trajectories_and_plans(robot, tmp_path):
    """A user's path: generate_config, bringup, a trajectory, a plan."""
    urdf = (share_folder(PACKAGE) / 'urdf' / f'{robot}.urdf.xacro' if robot in OWN
            else public_urdf(robot))
    target = tmp_path / robot
    generate_config(urdf, target, states=1000)
    with running_robot(f'robot:={target}', LITTLE_FASTER) as user:
        ready = user.move_group.named_states()['arm', 'ready']
        goal = dict(ready)
        goal[next(iter(goal))] += 0.2  # about the upright axis: no nearer to the floor
        scaling = {'max_velocity_scaling_factor': 0.8, 'max_acceleration_scaling_factor': 0.8}
        assert user.move_group.move('arm', goal, **scaling).error_code.val == SUCCESS
        assert user.distance(goal) < 0.01
        outcome = user.send('arm_controller', list(ready), [(1.0, list(ready.values()))])
        assert outcome.status == SUCCEEDED
        assert user.distance(ready) < 0.01
        if robot == 'panda':
            states = user.move_group.named_states()
            result = user.move_group.move('gripper', states['gripper', 'ready'])
            assert result.error_code.val == SUCCESS
            assert user.distance(states['gripper', 'ready']) < 0.003
