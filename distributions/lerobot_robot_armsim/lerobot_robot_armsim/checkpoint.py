# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A policy that LeRobot has trained, as ``armsim evaluate`` calls it."""

from pathlib import Path
from typing import Any

from lerobot.common.control_utils import predict_action
from lerobot.configs.policies import PreTrainedConfig
from lerobot.policies.factory import get_policy_class, make_pre_post_processors
import numpy as np
from numpy.typing import NDArray
import torch

from armsim_ros.data.features import ENVIRONMENT, frames_of, IMAGES, STATE


class Checkpoint:
    """
    Returns an action for an observation of a task.

    :param folder: ``pretrained_model`` of a checkpoint.
    """

    def __init__(self, folder: Path) -> None:
        config = PreTrainedConfig.from_pretrained(folder)
        self._device = torch.device(config.device)
        self._policy = get_policy_class(config.type).from_pretrained(folder)
        self._before, self._after = make_pre_post_processors(
            config, pretrained_path=str(folder),
            preprocessor_overrides={'device_processor': {'device': str(self._device)}})
        self._features = config.input_features
        #: The instruction of an episode; policies of vision and language read it.
        self.task_description = ''

    @property
    def arguments(self) -> dict[str, Any]:
        """Arguments of a task that is observed as in training."""
        pictures = {name.removeprefix(IMAGES): feature.shape[1:]
                    for name, feature in self._features.items() if name.startswith(IMAGES)}
        if not pictures:
            kind = 'environment_state_agent_pos' if ENVIRONMENT in self._features else 'state'
            return {'obs_type': kind}
        return {'obs_type': 'pixels_agent_pos' if STATE in self._features else 'pixels',
                'cameras': tuple(pictures), 'image_size': tuple(next(iter(pictures.values())))}

    def reset(self) -> None:
        """Forget the last episode."""
        self._policy.reset()

    def __call__(self, observation: Any) -> NDArray[np.float32]:
        """Return the next action."""
        frame = {name: value for name, value in frames_of(observation).items()
                 if name in self._features}
        action = predict_action(
            frame, self._policy, self._device, self._before, self._after, use_amp=False,
            task=self.task_description)
        return action.squeeze(0).cpu().numpy()
