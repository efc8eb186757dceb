# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the fingers of grippers touch, and what they hold."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.model.grippers import Gripper
from armsim_ros.model.world_objects import FLOOR
from armsim_ros.sim.physics.mujoco_model import object_body_name
from armsim_ros.sim.physics.robot_spec import element_name
from armsim_ros.sim.simulation import Simulation

#: An object that two fingers press from opposite sides for so long is held, and an object that
#: they have not pressed for so long is not [ns].
GRASP_NS = 200_000_000
#: Cosine between the pushes of two fingers below which they are opposite: 120 degrees and more.
OPPOSITE = -0.5

_OBJECT, _WORLD = object_body_name(''), 'world'


@dataclass(frozen=True, slots=True, eq=False)
class FingerContact:
    """
    A point where a link of a gripper touches something else.

    :param link: of the gripper.
    :param other: name of an object, or of another link.
    :param is_object: whether the other body is an object, as the floor is.
    :param position: (3,) in the world [m].
    :param normal: (3,) from the link into the other body.
    :param depth: overlap [m].
    :param force: along the normal [N].
    """

    link: str
    other: str
    is_object: bool
    position: Vector
    normal: Vector
    depth: float
    force: float


class FingerContacts:
    """
    Checks the fingers of grippers; only in the thread that ticks.

    :param simulation: has them.
    :param grippers: theirs.
    """

    def __init__(self, simulation: Simulation, grippers: Iterable[Gripper]) -> None:
        self._simulation = simulation
        self._grippers = tuple(grippers)
        self._robot = element_name(simulation.model.name, '')
        self._pressed: dict[tuple[str, str], tuple[int, int]] = {}
        self._held: dict[tuple[str, str], Gripper] = {}

    def contacts(self, gripper: Gripper) -> list[FingerContact]:
        """Return where a gripper touched something else in the last step."""
        model, data = self._simulation.mujoco_model, self._simulation.mujoco_data
        found, force = [], np.zeros(6)
        for i, contact in enumerate(data.contact[: data.ncon]):
            if contact.efc_address < 0:
                continue
            names = [model.body(int(model.geom_bodyid[geom])).name for geom in contact.geom]
            links = [name.removeprefix(self._robot) for name in names]
            first = links[0] in gripper.bodies
            if first == (links[1] in gripper.bodies):
                continue
            mine, other = (links[0], links[1]) if first else (links[1], links[0])
            mujoco.mj_contactForce(model, data, i, force)
            normal = contact.frame[:3] if first else -contact.frame[:3]
            is_object = other == _WORLD or other.startswith(_OBJECT)
            other = FLOOR if other == _WORLD else other.removeprefix(_OBJECT)
            found.append(FingerContact(
                mine, other, is_object,
                contact.pos.copy(), normal.copy(), -float(contact.dist), float(force[0])))
        return found

    def squeezed(self) -> dict[str, Gripper]:
        """Return the free objects that are pressed from opposite sides now, and by what."""
        free = {name for name, item in self._simulation.world.objects.items()
                if item.mass is not None}
        return {
            name: gripper
            for gripper in self._grippers if free
            for name in _between(gripper, self.contacts(gripper))
            if name in free}

    def held(self) -> Mapping[str, Gripper]:
        """Return what was squeezed in all samples for long enough, and not released since."""
        now, there = self._simulation.time_ns, self._simulation.world.objects
        squeezed = {(name, gripper.palm): gripper for name, gripper in self.squeezed().items()}
        pressed = {pair: (self._pressed.get(pair, (now, now))[0], now) for pair in squeezed}
        for pair, (since, last) in self._pressed.items():
            if pair in self._held and pair[0] in there and now - last < GRASP_NS:
                pressed.setdefault(pair, (since, last))
        self._pressed = pressed
        self._held = {
            pair: squeezed.get(pair) or self._held[pair]
            for pair, (since, last) in pressed.items() if last - since >= GRASP_NS}
        return {name: gripper for (name, _), gripper in self._held.items()}


def _between(gripper: Gripper, contacts: Iterable[FingerContact]) -> list[str]:
    """Return the objects on which two bodies of a gripper press against each other."""
    pushes: dict[str, dict[str, Vector]] = {}
    for contact in contacts:
        if contact.is_object and contact.force > 0.0:
            bodies = pushes.setdefault(contact.other, {})
            body = gripper.bodies[contact.link]
            bodies[body] = bodies.get(body, np.zeros(3)) + contact.force * contact.normal
    return [name for name, bodies in pushes.items() if _any_opposite(list(bodies.values()))]


def _any_opposite(pushes: list[Vector]) -> bool:
    return any(
        float(push.dot(other)) < OPPOSITE * float(np.linalg.norm(push) * np.linalg.norm(other))
        for i, push in enumerate(pushes) for other in pushes[i + 1:])
