# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When changes of the planning scene are published."""

from types import SimpleNamespace

from rclpy.task import Future

from armsim_ros.config.move_group.ompl_planning import PlanningParameters
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.nodes.move_group.scene.monitored_planning_scene import MonitoredPlanningScene
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import SceneUpdate


def test_an_edit_is_published_at_once():
    """It does not wait for the timer; an edit during the work on a message follows it."""
    messages, works = [], []

    def submit(work):
        works.append((work, Future()))
        return works[-1][1]

    publisher = SimpleNamespace(get_subscription_count=lambda: 1, publish=messages.append)
    node = SimpleNamespace(
        create_publisher=lambda *_: publisher, create_timer=lambda *_, **__: None,
        executor=SimpleNamespace(create_task=lambda task: task()))
    scene = PlanningScene(KinematicModel(load_cell('sunday').model))
    MonitoredPlanningScene(SimpleNamespace(
        node=node, scene=scene, planning_parameters=PlanningParameters(),
        states=SimpleNamespace(stamp_ns=0), edits=SimpleNamespace(submit=submit)))
    for padding in (0.01, 0.02):
        scene.apply(SceneUpdate(link_padding={'link_6': padding}))
    assert len(works) == 1
    for work, done in works:
        work()
        done.set_result(None)
    assert [{item.link_name: item.padding for item in message.link_padding}['link_6']
            for message in messages] == [0.01, 0.02]
