"""Balls that come and go, a floor that moves, numbers that change."""

from __future__ import annotations

import numpy as np
import pytest

import ballroom


def books(state: ballroom.State) -> float:
    """What stays while hits are elastic."""
    return state.energy_j - state.steering_work_j


def test_balls_come_and_go_while_the_others_roll_on(plane: ballroom.Server) -> None:
    before = plane.step(30)
    came = plane.spawn(
        {
            "guest": {"radius_m": 0.1, "mass_kg": 1.0, "center_m": np.array([-3.0, 1.2]), "tags": ["late", "x"]},
            "shell": {"radius_m": 0.1, "mass_kg": 1, "center_m": (-3.0, -1.2), "inertia": "hollow", "player": True},
        }
    )
    assert (came.tick, came.epoch) == (30, before.epoch + 1)
    state = plane.state()
    assert (state.tick, len(state)) == (30, len(before) + 2)
    assert (state["guest"].tags, state["guest"].spawned, state["cue"].spawned) == (("late", "x"), True, False)
    assert state["cue"].center_m.tolist() == before["cue"].center_m.tolist()
    assert books(state) == pytest.approx(books(before), rel=1e-12)
    assert list(plane.balls(spawned=True)) == ["guest", "shell"]
    assert list(plane.balls(tag="late", spawned=True)) == ["guest"]
    plane.set_selected({"spawned": True}, velocity_m_per_s=(0.0, 0.5, 0.0))
    assert plane.state()["shell"].velocity_m_per_s.tolist() == [0.0, 0.5, 0.0]
    plane.delete(tag="x")
    assert "guest" not in plane.state()
    plane.reset(scope="spawned")
    assert plane.state().names == before.names
    with pytest.raises(ballroom.RefusedError, match="nobody") as refused:
        plane.delete("cue", "nobody")
    assert refused.value.code == 3
    where = plane.state()["cue"].center_m[:2]
    with pytest.raises(ballroom.RefusedError, match="overlap") as refused:
        plane.spawn({"guest": {"radius_m": 0.1, "mass_kg": 1.0, "center_m": where}})
    assert refused.value.code == 5


def test_the_floor_moves_under_the_balls(plane: ballroom.Server) -> None:
    before = plane.step(10)
    scene = plane.scene()
    corner = [scene["floor"]["polynomial"]["x_m"][0], scene["floor"]["polynomial"]["y_m"][0]]
    plane.move_control_points({(0, 0): [*corner, 0.5]})
    state = plane.state()
    assert plane.scene()["floor"]["net"]["control_points_m"][0][0] == [*corner, 0.5]
    assert np.allclose(state.center_m[:, :2], before.center_m[:, :2], atol=1e-11)
    assert (state.center_m[:, 2] > before.center_m[:, 2]).all()
    assert books(state) == pytest.approx(books(before), rel=1e-12)
    plane.move_control_points({(0, 0): [*corner, 0.0]})
    assert plane.scene() == scene
    with pytest.raises(ballroom.RefusedError, match="rows 0 to 1"):
        plane.move_control_points({(7, 0): (0.0, 0.0, 0.0)})


def test_parameters_are_read_and_set_all_or_none(plane: ballroom.Server) -> None:
    known = plane.parameters()
    assert (known["restitution"].range, known["restitution"].settable) == ((0.0, 1.0), True)
    assert not known["motion"].settable
    plane.set_parameters({"restitution": 0.5, "gravity_m_per_s2": (0.0, 0.0, -1.62)})
    known = plane.parameters()
    assert (known["restitution"].value, known["gravity_m_per_s2"].value) == (0.5, [0.0, 0.0, -1.62])
    with pytest.raises(ballroom.RefusedError, match="0 to 1"):
        plane.set_parameters({"hit_budget": 7, "restitution": 2.0})
    assert plane.parameters() == known
