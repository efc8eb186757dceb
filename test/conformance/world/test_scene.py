# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The planner sees the simulated world by itself, and the user's objects are his."""

from __future__ import annotations

from moveit_msgs.msg import CollisionObject, PlanningScene
import pytest
from scene_user import Planner
from simulation_interfaces.msg import EntityState
from world_user import OK, PAUSED, pose, WorldUser

from benchmarks.simulation.scene_edits import SceneEdits

statement = pytest.mark.statement

WORLD = {'cube', 'floor', 'picture', 'star', 'table', 'triangle'}
#: What the tests add as users.
USERS = {'mine', 'later'}


@pytest.fixture
def planner(world: WorldUser) -> Planner:
    """Give the planning scene of the world at its start."""
    planner = Planner(world)
    planner.wait(lambda objects: set(objects) <= WORLD | USERS)
    for name in set(planner.objects()) & USERS:
        planner.edit(name, CollisionObject.REMOVE)
    planner.wait(lambda objects: set(objects) == WORLD)
    return planner


def height(planner: Planner, name: str) -> float:
    """Return where an object is in the scene [m]."""
    return float(planner.objects()[name].pose.position.z)


@statement('C1')
def test_all_objects_are_collision_objects(world: WorldUser, planner: Planner) -> None:
    """Ids are names, primitives stay primitives, the colour is kept; the robot is none."""
    objects = planner.objects()
    cube = objects['cube']
    assert cube.header.frame_id == 'world'
    assert [list(one.dimensions) for one in cube.primitives] == [[0.08, 0.08, 0.025]]
    assert len(objects['table'].primitives) == 5
    assert len(objects['star'].meshes) == 5
    colors = {one.id: one.color for one in planner.scene.object_colors}
    assert (colors['cube'].r, colors['cube'].g) == pytest.approx((0.8, 0.18))


@statement('C2')
def test_who_comes_late_gets_all(world: WorldUser, planner: Planner) -> None:
    """Over the standard topic, as differences; at rest nothing is said."""
    seen = world.client.collect('/planning_scene', PlanningScene)
    first = seen.wait(1)[0]
    assert first.is_diff
    assert first.robot_state.is_diff
    assert {one.id for one in first.world.collision_objects} == WORLD
    assert not first.allowed_collision_matrix.entry_names
    seen.close()


@statement('C3')
def test_what_is_spawned_moved_and_deleted_is_so_in_the_scene(
    world: WorldUser, planner: Planner
) -> None:
    """Within half a second each on a quiet machine; what falls is followed."""
    assert world.become(PAUSED)[0] == OK
    world.spawn('box', (2.0, 2.0, 1.0))
    planner.wait(lambda objects: 'box' in objects)
    state = EntityState(pose=pose((2.0, 2.0, 2.0)))
    assert world.result('set_entity_state', entity='box', state=state)[0] == OK
    planner.wait(lambda objects: abs(objects['box'].pose.position.z - 2.0) < 1e-3)
    state = EntityState(pose=pose((0.7, 0.0, 1.5)))
    assert world.result('set_entity_state', entity='picture', state=state)[0] == OK
    planner.wait(lambda objects: abs(objects['picture'].pose.position.x - 0.7) < 1e-3)
    assert world.result('delete_entity', entity='box')[0] == OK
    planner.wait(lambda objects: 'box' not in objects)


@statement('C3')
def test_what_falls_is_where_it_lies(world: WorldUser, planner: Planner) -> None:
    """The last pose is told, too; then there is silence."""
    world.spawn('box', (2.0, 2.0, 0.3))
    planner.wait(lambda objects: 'box' in objects
                 and abs(objects['box'].pose.position.z - 0.025) < 2e-3)
    seen = world.client.collect('/planning_scene', PlanningScene)
    seen.wait(1)
    clock = world.clock()
    clock.wait(60)
    assert len(seen.messages) == 1
    seen.close()


@statement('C4')
def test_a_users_objects_are_never_touched(world: WorldUser, planner: Planner) -> None:
    """Neither one of another id, nor one of the id of an entity that comes later."""
    planner.edit('mine', CollisionObject.ADD)
    planner.edit('later', CollisionObject.ADD)
    world.spawn('later', (2.0, 2.0, 1.0))
    world.result('delete_entity', entity='later')
    world.result('reset_simulation')
    world.spawn('marker', (2.0, 2.0, 1.0))
    planner.wait(lambda objects: 'marker' in objects)
    for name in ('mine', 'later'):
        assert planner.objects()[name].pose.position.x == 3.0


@statement('C4', 'A19')
def test_a_taken_object_is_the_users_until_a_reset(world: WorldUser, planner: Planner) -> None:
    """Added by the user the simulation stops writing it; removed it stays away."""
    planner.edit('cube', CollisionObject.ADD)
    planner.edit('star', CollisionObject.REMOVE)
    state = EntityState(pose=pose((0.0, 2.0, 2.0)))
    for name in ('cube', 'star', 'triangle'):
        assert world.result('set_entity_state', entity=name, state=state)[0] == OK
    planner.wait(lambda objects: objects['triangle'].pose.position.y > 1.0)
    objects = planner.objects()
    assert 'star' not in objects
    assert objects['cube'].pose.position.x == 3.0
    assert world.result('reset_simulation')[0] == OK
    planner.wait(lambda objects: set(objects) == WORLD
                 and objects['cube'].pose.position.x < 1.0)
    assert height(planner, 'cube') == pytest.approx(1.028, abs=0.02)


@statement('C1', 'C4')
def test_another_world_is_another_scene(world: WorldUser, planner: Planner) -> None:
    """The old objects go with their world; the user's stay."""
    planner.edit('mine', CollisionObject.ADD)
    assert world.result('load_world', uri='empty')[0] == OK
    planner.wait(lambda objects: set(objects) == {'floor', 'mine'})
    assert world.result('unload_world')[0] == OK
    planner.wait(lambda objects: set(objects) == {'mine'})


@statement('C4')
def test_random_edits_of_both_sides_end_as_the_rules_say(
    world: WorldUser, planner: Planner
) -> None:
    """Spawns, moves, deletions and resets here; additions, moves and removals there, by turns."""
    edits = SceneEdits(world.client, seed=1)
    edits.run(60)
    assert len(edits.counts) == 7
    edits.clear()
