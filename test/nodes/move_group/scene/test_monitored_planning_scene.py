# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When changes of the planning scene are published."""

from types import SimpleNamespace

import numpy as np
from rclpy.task import Future

from armsim_ros.config.ompl_planning import PlanningParameters
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.nodes.move_group.scene.scene_topics import MonitoredPlanningScene
from armsim_ros.planning.scene.octomap import octomap_from_cells
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


def test_octomaps_are_published_five_times_a_second():
    """A map that comes sooner goes out with a later message; one that is gone is 'cleared'."""
    messages, looks, now = [], [], [0.0]

    def submit(work):
        work()
        done = Future()
        done.set_result(None)
        return done

    publisher = SimpleNamespace(get_subscription_count=lambda: 1, publish=messages.append)
    node = SimpleNamespace(
        create_publisher=lambda *_: publisher,
        create_timer=lambda period, look, **_: looks.append(look),
        executor=SimpleNamespace(create_task=lambda task: task()))
    scene = PlanningScene(KinematicModel(load_cell('sunday').model))
    MonitoredPlanningScene(SimpleNamespace(
        node=node, scene=scene, planning_parameters=PlanningParameters(),
        states=SimpleNamespace(stamp_ns=0), edits=SimpleNamespace(submit=submit),
        clock=lambda: now[0]))
    looks[0]()
    made = [octomap_from_cells(np.array([[k, 0, 0]]), np.ones(1, dtype=np.float32), 0.1, np.eye(4))
            for k in range(3)]
    for octomap in made:
        scene.set_octomap(octomap)
        looks[0]()
        now[0] += 0.1
    assert [message.world.octomap.octomap.id for message in messages] == ['', 'OcTree', 'OcTree']
    for message, octomap in zip(messages[1:], (made[0], made[2]), strict=True):
        assert bytes(message.world.octomap.octomap.data.tobytes()) == octomap.full_data()
    now[0] += 1.0
    scene.set_octomap(None)
    looks[0]()
    assert messages[-1].world.octomap.octomap.id == 'cleared'
    assert not messages[-1].world.octomap.octomap.data
