"""Several arenas of one server, and what their clocks do."""

from __future__ import annotations

import pytest
from conftest import Serve, simulated

import ballroom


def test_arenas_of_one_server_run_side_by_side_and_end_one_by_one(plane: ballroom.Server) -> None:
    with plane.start_arena("left", "bowl", paused=True) as left:
        with plane.start_arena("right", "gas", balls=30, tick_rate_hz=120, paused=True) as right:
            assert {name: row["scene"] for name, row in plane.arenas().items()} == {
                "left": "bowl",
                "main": "plane",
                "right": "gas",
            }
            assert (len(right.state()), right.world().tick_rate_hz) == (30, 120)
        assert f"{left.step(60).state_hash:016x}" == simulated("bowl", 1)["state_hash"]
        assert plane.state().tick == 0
        assert plane.stop_arena("left").tick == 60
    assert sorted(plane.arenas()) == ["main", "right"]
    for name, code, reason in [("right", 5, "runs already"), ("new", 3, "no built-in scene")]:
        with pytest.raises(ballroom.RefusedError, match=reason) as refused:
            plane.start_arena(name, "nowhere")
        assert refused.value.code == code
    with pytest.raises(ballroom.RefusedError, match="give either") as refused:
        plane.start_arena("new")
    assert refused.value.code == 100


def test_a_stopped_arena_stands_at_its_start(serve: Serve) -> None:
    server = serve("original")
    assert server.run_state() == "playing"
    start = server.state()
    server.set_state("paused")
    server.step(5)
    assert server.run_state() == "paused"
    assert server.set_state("stopped") == ballroom.Reply(tick=0, epoch=start.epoch + 1)
    assert (server.run_state(), server.state().tick, server.state().paused) == ("stopped", 0, True)
    server.set_state("playing")
    assert server.run_state() == "playing"


def test_a_reader_of_states_is_seen_with_age_and_rate(serve: Serve) -> None:
    server = serve("plane")
    with server.states(server.timeout_s) as states:
        for _ in states:
            rows = server.clients()
            if rows and rows[0]["age_ms"] is not None:
                break
    assert (rows[0]["role"], rows[0]["lost"]) == ("script", None)
    assert rows[0]["states_per_s"] > 0
    assert rows[0]["bytes_per_s"] > 100 * rows[0]["states_per_s"]
    assert 0 <= rows[0]["age_ms"][0] <= rows[0]["age_ms"][1]
    assert rows[0]["received"] > 0


def test_a_scene_is_checked_and_reloaded(plane: ballroom.Server) -> None:
    bad = plane.check('version = 1\nname = "nothing"\n')
    assert not bad["ok"]
    assert bad["fault"]["line"] is not None
    assert bad["fault"]["text"].startswith("toml:")
    epoch = plane.load_scene("gas", balls=20).epoch
    assert len(plane.state()) == 20
    assert plane.reload_scene().epoch == epoch + 1
    assert plane.scene()["name"] == "plane"
