"""Questions, commands, and what goes wrong."""

from __future__ import annotations

import os
import signal
import threading

import numpy as np
import pytest
from conftest import Serve, children, simulated

import ballroom


def test_a_state_is_of_its_tick_and_equals_the_run_without_a_network(plane: ballroom.Server) -> None:
    state, alone = plane.step(600), simulated("plane", 10)
    assert (state.tick, state.time_s, state.paused) == (600, 10.0, True)
    assert f"{state.state_hash:016x}" == alone["state_hash"]
    assert (state.ball_ball_hits, state.ball_wall_hits) == tuple(alone["collisions"].values())
    for ball in alone["balls"]:
        assert state[ball["name"]].center_m.tolist() == ball["center_m"]


def test_arrays_have_a_row_a_ball_and_64_bits_and_are_read_only(plane: ballroom.Server) -> None:
    state = plane.state()
    assert state.names == ("cue", "five", "four", "one", "six", "three", "two")
    for array, columns in [
        (state.uv, 2),
        (state.center_m, 3),
        (state.velocity_m_per_s, 3),
        (state.omega_rad_per_s, 3),
        (state.orientation_xyzw, 4),
    ]:
        assert array.shape == (7, columns)
        assert array.dtype == np.float64
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1.0
    cue = state["cue"]
    assert cue.center_m.tolist() == [-3.0, 0.0625, 0.15]
    assert cue.velocity_m_per_s.tolist() == [5.0, 0.0, 0.0]
    assert (cue.radius_m, cue.mass_kg, cue.player, len(state)) == (0.15, 1.0, True, 7)
    assert np.all(state.roster.inertia_factor == 0.4)
    assert "cue" in state
    assert "eight" not in state
    with pytest.raises(KeyError, match="no ball is named 'eight'"):
        state["eight"]


def test_a_push_changes_the_velocity_by_what_the_scene_says(plane: ballroom.Server) -> None:
    press = plane.world().scene["steering"]["impulse_m_per_s"]
    plane.steer("cue", "up")
    plane.steer(None, (0.0, -0.25))
    assert plane.state()["cue"].velocity_m_per_s.tolist() == [5.0, 0.75 * press, 0.0]


def test_scene_info_and_stats_say_what_is_served(plane: ballroom.Server) -> None:
    assert plane.scene()["name"] == "plane"
    assert len(plane.scene()["ball"]) == len(plane.state())
    assert plane.info()["tick_rate_hz"] == plane.world().tick_rate_hz == 60
    assert {"real_time_factor", "commands_refused", "states_skipped"} <= plane.stats().keys()


def test_pause_resume_speed_and_reset_answer_with_the_tick(serve: Serve) -> None:
    server = serve("bowl")
    paused = server.pause()
    assert server.state().tick == paused.tick
    assert server.step(5).tick == paused.tick + 5
    assert server.speed(0.5).tick == paused.tick + 5
    reset = server.reset()
    assert (reset.tick, reset.epoch) == (0, paused.epoch + 1)
    server.resume()
    with server.states(timeout_s=server.timeout_s) as states:
        assert next(state.tick for state in states if state.tick >= 3) < 100


def test_what_is_refused_carries_the_servers_own_reason(plane: ballroom.Server) -> None:
    with pytest.raises(ballroom.RefusedError, match='"one" is no player\'s ball'):
        plane.steer("one", "up")
    with pytest.raises(ballroom.RefusedError, match="vector of length at most 1") as refused:
        plane.steer("cue", (3.0, 4.0))
    assert refused.value.reason.startswith("direction")
    with pytest.raises(ballroom.RefusedError, match="1 to 1000000"):
        plane.step(0)
    plane.resume()
    with pytest.raises(ballroom.RefusedError, match="pause before stepping"):
        plane.step()


def test_who_moves_the_clock_of_another_is_noticed(plane: ballroom.Server, monkeypatch: pytest.MonkeyPatch) -> None:
    with ballroom.connect(plane.endpoint) as other:
        look = plane.state

        def look_late() -> ballroom.State:
            other.step()
            return look()

        monkeypatch.setattr(plane, "state", look_late)
        with pytest.raises(ballroom.OutOfStepError, match="somebody else moves the clock"):
            plane.step()


def test_a_script_that_asks_too_fast_is_slowed_and_not_refused(plane: ballroom.Server) -> None:
    def is_refused() -> bool:
        asked = [plane._session.get("ballroom/v1/main/srv/info", timeout=20.0) for _ in range(100)]
        refused = [reply.err.payload.to_string() for replies in asked for reply in replies if reply.err]
        return any("too many questions" in reason for reason in refused)

    if not any(is_refused() for _ in range(400)):
        pytest.skip("this machine asks fewer than 2000 questions a second")
    for _ in range(100):
        assert plane.info()["arena"] == "main"


def test_nobody_there_is_said_with_the_endpoint(plane: ballroom.Server) -> None:
    with pytest.raises(ballroom.NoServerError, match=r"nobody listens at tcp/127.0.0.1:1 "):
        ballroom.connect("tcp/127.0.0.1:1", timeout_s=0.2)
    with pytest.raises(ballroom.NoServerError, match=r"no arena other at .*, but main"):
        ballroom.connect(plane.endpoint, arena="other", timeout_s=0.2)


def test_a_silent_server_is_an_error_in_time_and_not_for_ever(serve: Serve) -> None:
    server = serve("plane", paused=True)
    process = int(children()[0])
    with ballroom.connect(server.endpoint, timeout_s=0.5) as hasty:
        os.kill(process, signal.SIGSTOP)
        try:
            with pytest.raises(ballroom.NoAnswerError, match=r"did not answer srv/snapshot within 0.5 s"):
                hasty.state()
        finally:
            os.kill(process, signal.SIGCONT)
    assert server.step().tick == 1


def test_a_server_that_dies_in_the_middle_of_a_step_is_an_error(serve: Serve) -> None:
    server = serve("thousand", paused=True)
    threading.Timer(0.3, os.kill, [int(children()[0]), signal.SIGKILL]).start()
    with pytest.raises(ballroom.NoServerError, match="went away"):
        server.step(1_000_000)


def test_a_closed_session_says_so(plane: ballroom.Server) -> None:
    other = ballroom.connect(plane.endpoint)
    other.close()
    other.close()
    with pytest.raises(ballroom.BallroomError, match="cannot be asked"):
        other.state()


def test_sessions_leave_no_thread_and_no_file_behind(plane: ballroom.Server) -> None:
    def used() -> tuple[int, int, int]:
        return threading.active_count(), len(os.listdir("/proc/self/task")), len(os.listdir("/proc/self/fd"))

    def visit() -> None:
        with ballroom.connect(plane.endpoint) as server, server.states() as states, server.events() as hits:
            next(states)
            hits.poll()

    visit()
    before = used()
    for _ in range(10):
        visit()
    assert used() == before
