# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What teleoperators without a device of their own have to have for LeRobot."""

from typing import Any

from lerobot.teleoperators import Teleoperator


class Undemanding(Teleoperator):
    """A teleoperator that feels nothing, and has nothing to calibrate or to set up."""

    @property
    def feedback_features(self) -> dict[str, type]:
        """Names of what it can feel: nothing."""
        return {}

    @property
    def is_calibrated(self) -> bool:
        """Whether it is calibrated: always."""
        return True

    def calibrate(self) -> None:
        """Do nothing: there is no device."""

    def configure(self) -> None:
        """Do nothing: there is no device."""

    def send_feedback(self, feedback: dict[str, Any]) -> None:
        """Do nothing: it feels nothing."""
