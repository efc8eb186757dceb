# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The SRDF's content: planning groups, named states, end effectors, collision pairs."""

from __future__ import annotations

from dataclasses import dataclass, field

from armsim_ros.errors import ModelError, nearest, Problem


@dataclass(frozen=True, slots=True)
class PlanningGroup:
    """
    An SRDF group.

    :param joints: all joints in tree order, fixed and mimic ones too.
    :param active_joints: those that have a variable of their own, passive ones too, in tree
        order.
    :param links: the child links of the joints, in tree order.
    :param chain: (base link, tip link) where the group is a chain, else None.
    :param tips: links at the group's ends.
    :param subgroups: names of the other groups whose joints are all in it, sorted.
    """

    name: str
    joints: tuple[str, ...]
    active_joints: tuple[str, ...]
    links: tuple[str, ...]
    chain: tuple[str, str] | None = None
    tips: tuple[str, ...] = ()
    subgroups: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class EndEffector:
    """An SRDF end effector; ``parent_group`` is '' where none fits."""

    name: str
    group: str
    parent_link: str
    parent_group: str = ''


@dataclass(frozen=True, slots=True)
class VirtualJoint:
    """An SRDF virtual joint between a frame of the world and the root link."""

    name: str
    type: str
    parent_frame: str
    child_link: str


@dataclass(frozen=True, slots=True)
class SemanticModel:
    """
    The content of an SRDF that holds for this robot.

    :param named_states: group -> state -> joint -> value [rad or m].
    :param disabled_collisions: (link, link) -> reason; the pair is sorted by name.
    :param enabled_collisions: pairs that are always checked; sorted by name.
    :param default_disabled: links that are not checked unless a pair enables it.
    """

    name: str = ''
    groups: dict[str, PlanningGroup] = field(default_factory=dict)
    named_states: dict[str, dict[str, dict[str, float]]] = field(default_factory=dict)
    end_effectors: dict[str, EndEffector] = field(default_factory=dict)
    virtual_joint: VirtualJoint | None = None
    passive_joints: tuple[str, ...] = ()
    disabled_collisions: dict[tuple[str, str], str] = field(default_factory=dict)
    enabled_collisions: frozenset[tuple[str, str]] = frozenset()
    default_disabled: frozenset[str] = frozenset()

    @property
    def first_group(self) -> str:
        """Name of the first planning group, '' where the SRDF has none."""
        return next(iter(self.groups), '')

    def named_state(self, group: str, name: str) -> dict[str, float]:
        """
        Return joint -> position [rad or m] of a named state of a planning group.

        :raises ModelError: the group has no such state; names the known ones.
        """
        states = self.named_states.get(group, {})
        if name not in states:
            raise ModelError(
                Problem(
                    f"group '{group}' has no named state '{name}'",
                    allowed=', '.join(states) or 'the SRDF has none',
                    remedy=nearest(name, tuple(states))))
        return states[name]
