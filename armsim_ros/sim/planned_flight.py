# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Steps whose commands the controllers know beforehand."""

from __future__ import annotations

from armsim_ros.control.faults import Controllers
from armsim_ros.sim.simulation import MOST_PLANNED, Simulation

#: Fewer updates are not worth a plan.
LEAST_PLANNED = 3


class PlannedFlight:
    """
    Plans updates ahead and does their steps.

    A plan may be made before it is known how much of it will be used, such as before a doze that
    somebody may end. It stays open until ``fly`` or ``land``; nobody else may touch simulation
    and controllers in between.

    :param simulation: the plant.
    :param controllers: the controller manager.
    :param steps: physics steps in a control period.
    :param period: the control period [s].
    """

    def __init__(
        self, simulation: Simulation, controllers: Controllers, steps: int, period: float
    ) -> None:
        self._simulation = simulation
        self._controllers = controllers
        self._steps = steps
        self._period = period
        #: Updates of the open plan, 0 where there is none.
        self.planned = 0
        self._most_planned = MOST_PLANNED

    def plan(self, limit: int) -> int:
        """
        Have updates planned; the last one before the limit is not among them.

        :param limit: physics steps that may be done.
        :returns: steps that are planned, 0 where there is no plan.
        """
        simulation, steps = self._simulation, self._steps
        most = min((limit - 1) // steps, self._most_planned)
        if most < LEAST_PLANNED or not simulation.can_plan(steps):
            return 0
        simulation.begin_plan()
        self.planned = self._controllers.plan(most, simulation.time_ns, self._period)
        if self.planned:
            simulation.take_plan(self.planned, steps)
        return self.planned * steps

    def look_early(self) -> None:
        """Have states read that are due now; the steps of the plan come later."""
        if self.planned and self._controllers.next_look(0, self.planned) == 0:
            self._controllers.look(0)

    def fly(self, limit: int) -> None:
        """
        Do the steps of a plan, the open one or a new one; the last update is not among them.

        Before each update it is looked at whether the joints are where they should be; the first
        update that could be another one than planned is left to be made.

        :param limit: physics steps that may be done.
        :raises SimulationError: the physics became unstable.
        """
        if not (self.planned or self.plan(limit)):
            return
        updates = min(self.planned, (limit - 1) // self._steps)
        try:
            self._follow(updates)
        finally:
            flown = self.land()
        # What cannot be foreseen, such as a joint that is held up, is not planned far ahead.
        self._most_planned = min(2 * flown + LEAST_PLANNED, MOST_PLANNED)

    def land(self) -> int:
        """End the open plan, if there is one; return how many of its updates were done."""
        flown = 0
        if self.planned:
            self.planned = 0
            flown = self._simulation.land()
            self._controllers.land(flown)
        return flown

    def _follow(self, updates: int) -> None:
        """Do the steps of planned updates until one could be another one than planned."""
        controllers, simulation = self._controllers, self._simulation
        done = controllers.next_look(0, updates)
        going_on = simulation.fly(done)
        while going_on and done < updates and controllers.look(done):
            done = controllers.next_look(done + 1, updates)
            going_on = simulation.fly(done)
