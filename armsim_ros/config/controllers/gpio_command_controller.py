# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the gpio controller, as gpio_controllers declares them."""

from __future__ import annotations

from pydantic import model_validator
from typing_extensions import Self

from armsim_ros.config.base import parameter, Settings
from armsim_ros.config.controllers.sensor_broadcasters import BroadcasterParameters
from armsim_ros.errors import nearest


class GpioInterfaces(Settings):
    """Interfaces of a gpio."""

    interfaces: tuple[str, ...] = parameter((), 'names without the gpio', read_only=True)


class GpioCommandControllerParameters(BroadcasterParameters):
    """Parameters of ``gpio_controllers/GpioCommandController``."""

    gpios: tuple[str, ...] = parameter((), 'gpios that are commanded or published', read_only=True)
    command_interfaces: dict[str, GpioInterfaces] = parameter(
        {}, 'gpio -> what is commanded', read_only=True)
    state_interfaces: dict[str, GpioInterfaces] = parameter(
        {}, 'gpio -> published interfaces; all by default', read_only=True)

    @property
    def commands(self) -> tuple[str, ...]:
        """Command interfaces, as ``gpio/interface``."""
        return _names(self.gpios, self.command_interfaces)

    @property
    def interfaces(self) -> tuple[str, ...]:
        """State interfaces that are named."""
        return _names(self.gpios, self.state_interfaces)

    @property
    def missing(self) -> str:
        """Name ``gpios`` where it is empty."""
        return '' if self.gpios else 'gpios'

    @model_validator(mode='after')
    def _only_its_own(self) -> Self:
        for key in ('command_interfaces', 'state_interfaces'):
            for name in getattr(self, key):
                if name not in self.gpios:
                    raise ValueError(f"{key}: '{name}' is not among gpios ("
                                     f'{", ".join(self.gpios)}) {nearest(name, self.gpios)}'
                                     .rstrip())
        return self


def _names(gpios: tuple[str, ...], chosen: dict[str, GpioInterfaces]) -> tuple[str, ...]:
    return tuple(f'{gpio}/{name}' for gpio in gpios if gpio in chosen
                 for name in chosen[gpio].interfaces)
