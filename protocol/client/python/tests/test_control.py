"""Clock, world and lists: what changes an arena as a whole."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import Serve

import ballroom


def test_running_until_a_time_is_as_many_steps(plane: ballroom.Server) -> None:
    stepped = plane.step(150)
    plane.reset()
    reached = plane.run_until(2.5)
    assert (reached.tick, reached.time_s, reached.state_hash) == (150, 2.5, stepped.state_hash)
    assert plane.run_until(2.501).tick == 151
    with pytest.raises(ballroom.RefusedError, match="is over") as refused:
        plane.run_until(1.0)
    assert refused.value.code == 4


def test_as_fast_as_possible_changes_no_bit(plane: ballroom.Server) -> None:
    plane.speed("max")
    plane.resume()
    with plane.states(plane.timeout_s) as states:
        next(state for state in states if state.tick > 1000)
    tick = plane.pause().tick
    reached = plane.state()
    plane.reset()
    assert plane.step(tick).state_hash == reached.state_hash


def test_a_seed_places_the_balls_anew_and_repeatably(serve: Serve) -> None:
    server = serve("gas", balls=50, paused=True)
    own = server.state().center_m.tolist()
    placed: dict[int | None, list[list[float]]] = {}
    for seed in (7, 8, 7, None):
        server.reset(seed)
        state = server.state()
        assert (state.tick, len(state)) == (0, 50)
        assert placed.setdefault(seed, state.center_m.tolist()) == state.center_m.tolist()
    assert placed[7] != placed[8]
    assert own not in (placed[7], placed[8])
    assert placed[None] == own


def test_a_reset_takes_back_what_its_scope_says(plane: ballroom.Server) -> None:
    start, later = plane.state(), plane.step(90)
    plane.reset(scope="state")
    state = plane.state()
    assert (state.epoch, state.tick) == (later.epoch, 90)
    assert state.center_m.tolist() == start.center_m.tolist()
    moved = plane.step(30)
    plane.reset(scope="time")
    state = plane.state()
    assert (state.epoch, state.tick, state.time_s) == (later.epoch + 1, 0, 0.0)
    assert state.center_m.tolist() == moved.center_m.tolist()


def test_balls_are_set_by_name_and_keep_what_is_not_given(plane: ballroom.Server) -> None:
    before = plane.state()
    plane.set_balls({"cue": {"center_m": np.array([-2.0, 1.0])}, "one": {"velocity_m_per_s": (0.0, 0.25, 0.0)}})
    after = plane.state()
    assert after["cue"].center_m.tolist() == [-2.0, 1.0, 0.15]
    assert after["cue"].velocity_m_per_s.tolist() == before["cue"].velocity_m_per_s.tolist()
    assert after["one"].velocity_m_per_s.tolist() == [0.0, 0.25, 0.0]
    assert after["one"].center_m.tolist() == before["one"].center_m.tolist()


@pytest.mark.parametrize(
    ("name", "center_m", "code"), [("cue", (1.0, 0.1), 5), ("cue", (9.0, 0.0), 5), ("ten", (0, 1), 3)]
)
def test_balls_are_set_all_or_none(plane: ballroom.Server, name: str, center_m: tuple[float, float], code: int) -> None:
    before = plane.state()
    with pytest.raises(ballroom.RefusedError, match=name) as refused:
        plane.set_balls({"two": {"velocity_m_per_s": (1.0, 0.0, 0.0)}, name: {"center_m": center_m}})
    assert refused.value.code == code
    assert plane.state().state_hash == before.state_hash


def test_another_scene_goes_on_as_a_new_epoch_with_its_own_balls(plane: ballroom.Server) -> None:
    with plane.states(plane.timeout_s) as states:
        epoch = next(states).epoch
        loaded = plane.load_scene("bowl")
        assert (loaded.tick, loaded.epoch) == (0, epoch + 1)
        state = next(state for state in states if state.epoch == loaded.epoch)
        assert state.names == ("circling", "hollow", "player", "solid", "spinning")
    assert plane.scene()["name"] == plane.world().scene["name"] == "bowl"
    assert plane.step(60).paused


def test_a_scene_of_ones_own_is_loaded_or_refused_with_its_line(plane: ballroom.Server) -> None:
    text = (
        'version = 1\nname = "mine"\nfloor.polynomial = { x_m = [-1.0, 1.0], y_m = [-1.0, 1.0] }\n'
        'ball = [{ name = "one", radius_m = 0.1, mass_kg = 1.0, center_m = [0.5, 0.0] }]\n'
    )
    plane.load_scene(toml=text)
    assert plane.state()["one"].center_m.tolist() == [0.5, 0.0, 0.1]
    epoch = plane.state().epoch
    for wrong, reason in [(text.replace("[0.5, 0.0]", "[0.95, 0.0]"), "one"), (text + "colour = 1\n", "colour")]:
        with pytest.raises(ballroom.RefusedError, match=reason) as refused:
            plane.load_scene(toml=wrong)
        assert refused.value.code == 105
    with pytest.raises(ballroom.RefusedError, match="nowhere") as refused:
        plane.load_scene("nowhere")
    assert refused.value.code == 3
    assert plane.state().epoch == epoch


def test_balls_are_found_by_name_player_and_place(plane: ballroom.Server) -> None:
    state = plane.step(10)
    assert list(plane.balls()) == list(state.names)
    assert list(plane.balls("two", "cue")) == ["cue", "two"]
    assert list(plane.balls(player=True)) == ["cue"]
    assert list(plane.balls(within_m=(1.1, -0.3, 1.5, 0.3))) == ["three", "two"]
    assert plane.balls("cue", within_m=(1.0, -1.0, 2.0, 1.0)) == {}
    found, known = plane.balls("cue")["cue"], state["cue"]
    assert found.center_m.tolist() == known.center_m.tolist()
    assert found.velocity_m_per_s.tolist() == known.velocity_m_per_s.tolist()
    assert (found.radius_m, found.mass_kg, found.player) == (known.radius_m, known.mass_kg, known.player)
    with pytest.raises(ballroom.RefusedError, match="rectangle"):
        plane.balls(within_m=(1.0, 0.0, -1.0, 0.0))


def test_every_feature_of_the_server_has_its_method(plane: ballroom.Server) -> None:
    features = plane.features()
    named = features["commands"].keys() | features["questions"].keys() - {"snapshot"}
    assert named <= set(dir(plane))
    assert "step" in named
    assert set(plane.scenes()) >= {"original", "plane", "bowl", "gas"}
    assert all(plane.scenes().values())
