# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
LeRobot opens what is collected, and finds environment, robot and expert: ``make test-lerobot``.

Elsewhere these tests are skipped: LeRobot needs Python 3.12 and some gigabytes.
"""

from contextlib import closing

import pytest

from armsim_ros.data import collect, Plan
from armsim_ros.data.episodes import EpisodeRunner, Source

pytest.importorskip('lerobot')
plugin = pytest.importorskip('lerobot_robot_armsim')

ARGUMENTS = {'obs_type': 'pixels_agent_pos'}


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a data set of two episodes with pictures."""
    folder = tmp_path_factory.mktemp('data') / 'set'
    collect(Plan(Source('armsim/PickCube-v1', ARGUMENTS), 2), folder)
    return folder


def test_lerobot_opens_a_collected_set(folder):
    """Frames, tasks and windows of time, in batches."""
    from lerobot.datasets.lerobot_dataset import LeRobotDataset
    from torch.utils.data import DataLoader

    plain = LeRobotDataset('any/name', root=folder, video_backend='pyav')
    assert plain.num_episodes == 2
    last = plain[len(plain) - 1]
    assert last['task'] == 'Pick up the red cube.'
    assert last['observation.images.front'].shape == (3, 96, 96)
    assert bool(last['next.success'])
    windows = {'observation.state': [-0.05, 0.0], 'action': [0.0, 0.05]}
    data = LeRobotDataset('any/name', root=folder, video_backend='pyav', delta_timestamps=windows)
    batch = next(iter(DataLoader(data, batch_size=4, shuffle=True)))
    assert batch['action'].shape == (4, 2, 7)


def test_features_of_environment_and_set_agree(folder):
    """Names and shapes are equal, so that training and evaluation need no renaming."""
    from lerobot.datasets.lerobot_dataset import LeRobotDataset
    from lerobot.envs.utils import env_to_policy_features

    data = LeRobotDataset('any/name', root=folder, video_backend='pyav')
    config = plugin.ArmsimEnvConfig()
    for name, feature in env_to_policy_features(config).items():
        height_last = tuple(data.meta.features[name]['shape'])
        expected = (3, *height_last[:2]) if 'images' in name else height_last
        assert feature.shape == expected, name


@pytest.mark.parametrize('parallel', [False, True])
def test_lerobot_makes_the_environment(parallel):
    """In one process and in several, which unpickle the configuration first."""
    from lerobot.envs.factory import make_env, make_env_config

    config = make_env_config('armsim', task='Reach-v1', obs_type='environment_state_agent_pos')
    vector = make_env(config, n_envs=2, use_async_envs=parallel)['armsim'][0]
    try:
        observation, _ = vector.reset(seed=[1, 2], options={'lerobot_new_rollout': True})
        assert observation['agent_pos'].shape == (2, 7)
        assert vector.call('_max_episode_steps') == (100, 100)
        vector.step(vector.action_space.sample())
    finally:
        vector.close()


def test_the_expert_moves_the_robot():
    """The teleoperator's actions solve the task of the robot that is connected."""
    from lerobot.robots.utils import make_robot_from_config
    from lerobot.teleoperators.utils import make_teleoperator_from_config

    robot = make_robot_from_config(
        plugin.ArmsimConfig(id='arm', transport='local', camera_names=['front']))
    expert = make_teleoperator_from_config(plugin.ArmsimExpertConfig(id='expert'))
    expert.connect()
    robot.connect()
    try:
        observation = robot.get_observation()
        assert {name: getattr(value, 'shape', float) for name, value in observation.items()} == (
            robot.observation_features)
        for _ in range(100):
            sent = robot.send_action(expert.get_action())
            if robot.task.is_success:
                break
        assert robot.task.is_success
        assert set(sent) == set(robot.action_features)
    finally:
        robot.disconnect()
    assert not robot.is_connected


def test_deltas_move_the_tip():
    """A delta of the gamepad moves the tip along the world's axes; 1 leaves the gripper."""
    robot = plugin.Armsim(plugin.ArmsimConfig(
        id='arm', transport='local', action='ee_delta', ee_step=0.005))
    robot.connect()
    try:
        assert set(robot.action_features) == {'delta_x', 'delta_y', 'delta_z', 'gripper'}
        before = robot.task.hand.point
        for _ in range(6):
            sent = robot.send_action(
                {'delta_x': 0.0, 'delta_y': 0.0, 'delta_z': -3.0, 'gripper': 1})
        assert sent == {'delta_x': 0.0, 'delta_y': 0.0, 'delta_z': -1.0, 'gripper': 1}
        way = robot.task.hand.point - before
        assert way == pytest.approx((0.0, 0.0, -0.03), abs=0.003)
        assert robot.get_observation()['gripper.pos'] == 0.0
        robot.send_action({'delta_x': 0.0, 'delta_y': 0.0, 'delta_z': 0.0, 'gripper': 2})
        assert robot.get_observation()['gripper.pos'] == 100.0
    finally:
        robot.disconnect()


def test_devices_are_found_by_their_types():
    """Their classes are where LeRobot's rule for plug-ins expects them."""
    from lerobot.cameras.utils import make_cameras_from_configs
    from lerobot.robots.utils import make_robot_from_config
    from lerobot.teleoperators.utils import make_teleoperator_from_config

    robot = make_robot_from_config(plugin.ArmsimConfig(id='arm', robot='panda'))
    leader = make_teleoperator_from_config(plugin.ArmsimJointsConfig(id='leader', robot='panda'))
    assert list(robot.action_features) == list(leader.action_features)
    assert list(robot.action_features)[-2:] == ['panda_joint7.pos', 'gripper.pos']
    camera = make_cameras_from_configs({'front': plugin.ArmsimCameraConfig()})['front']
    assert not camera.is_connected
    with pytest.raises(ValueError, match='allowed: ros, local'):
        plugin.Armsim(plugin.ArmsimConfig(id='arm', transport='tcp'))
    with pytest.raises(plugin.robot.DeviceNotConnectedError, match='not connected'):
        plugin.Armsim(plugin.ArmsimConfig(id='arm')).get_observation()


@pytest.fixture
def checkpoint(folder, tmp_path):
    """Return the folder of a small policy that knows the features of the data set."""
    from lerobot.configs.types import FeatureType
    from lerobot.datasets.lerobot_dataset import LeRobotDataset
    from lerobot.policies.act.configuration_act import ACTConfig
    from lerobot.policies.act.modeling_act import ACTPolicy
    from lerobot.policies.factory import make_pre_post_processors
    from lerobot.utils.feature_utils import dataset_to_policy_features

    data = LeRobotDataset('any/name', root=folder, video_backend='pyav')
    features = dataset_to_policy_features(data.meta.features)
    config = ACTConfig(
        input_features={name: feature for name, feature in features.items()
                        if name.startswith('observation')},
        output_features={name: feature for name, feature in features.items()
                         if feature.type is FeatureType.ACTION},
        device='cpu', dim_model=32, n_heads=2, dim_feedforward=32, n_encoder_layers=1,
        chunk_size=20, n_action_steps=20, pretrained_backbone_weights=None, use_vae=False)
    ACTPolicy(config).save_pretrained(tmp_path)
    for processor in make_pre_post_processors(config, dataset_stats=data.meta.stats):
        processor.save_pretrained(tmp_path)
    return tmp_path


def test_a_trained_policy_is_evaluated(checkpoint, capsys):
    """A checkpoint chooses what is observed; the command prints the outcome of each seed."""
    from armsim_ros.cli.main import main

    assert main(['evaluate', 'armsim/PickCube-v1', '--policy', str(checkpoint),
                 '--episodes', '1']) == 0
    assert 'of 1 episodes succeed' in capsys.readouterr().out


def test_a_trained_policy_gets_the_instruction(checkpoint, monkeypatch):
    """As in LeRobot (lerobot_eval.py, rollout): the task's description, beside what it sees."""
    from lerobot_robot_armsim.checkpoint import Checkpoint

    policy, instructions = Checkpoint(checkpoint), []
    before = policy._before

    def preprocessed(batch):
        instructions.append(batch['task'])
        return before(batch)

    monkeypatch.setattr(policy, '_before', preprocessed)
    with closing(EpisodeRunner(Source('armsim/PickCube-v1'), policy)) as runner:
        next(runner.steps(0))
    assert instructions == ['Pick up the red cube.']
