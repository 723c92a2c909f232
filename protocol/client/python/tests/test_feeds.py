"""The streams of states and hits."""

from __future__ import annotations

import threading

import pytest
from conftest import Serve

import ballroom

PATIENCE_S = 20.0


def test_states_begin_with_the_present_one_and_only_go_forward(serve: Serve) -> None:
    server = serve("bowl")
    with server.states(PATIENCE_S) as states:
        ticks = [next(states).tick for _ in range(20)]
        assert ticks == sorted(set(ticks))
        assert ticks[-1] - ticks[0] == 19 + states.missed_ticks


def test_only_the_newest_state_waits_and_what_it_overtook_is_counted(plane: ballroom.Server) -> None:
    with plane.states(PATIENCE_S) as states:
        assert next(states).tick == 0
        for _ in range(50):
            newest = plane.step()
        seen = next(state for state in states if state.tick == 50)
        assert seen.state_hash == newest.state_hash
        assert seen.center_m.tolist() == newest.center_m.tolist()
        assert states.missed_ticks >= 40


def test_a_streamed_state_has_the_velocities_of_the_answer_to_32_bits(serve: Serve) -> None:
    server = serve("bowl", paused=True)
    with server.states(PATIENCE_S) as states:
        next(states)
        exact, streamed = server.step(60), next(states)
        assert streamed.tick == 60
        assert (streamed.velocity_m_per_s == exact.velocity_m_per_s.astype("f4")).all()
        assert (streamed.orientation_xyzw == exact.orientation_xyzw.astype("f4")).all()
        assert (streamed.velocity_m_per_s != exact.velocity_m_per_s).any()


def test_a_reset_shows_as_a_new_epoch(plane: ballroom.Server) -> None:
    with plane.states(PATIENCE_S) as states:
        plane.step(7)
        epoch = next(states).epoch
        plane.reset()
        fresh = next(state for state in states if state.epoch != epoch)
        assert (fresh.epoch, fresh.tick) == (epoch + 1, 0)


def test_a_push_shows_while_the_clock_stands(plane: ballroom.Server) -> None:
    with plane.states(PATIENCE_S) as states:
        before = next(states)
        plane.steer("cue", "up")
        after = next(states)
        assert (after.epoch, after.tick) == (before.epoch, before.tick)
        assert after["cue"].velocity_m_per_s[1] > before["cue"].velocity_m_per_s[1]


def test_every_hit_comes_once_in_order_and_where_balls_touch(plane: ballroom.Server) -> None:
    with plane.events(PATIENCE_S) as hits:
        state = plane.step(600)
        seen = [next(hits) for _ in range(state.hits)]
        assert hits.missed == 0
    assert [hit.sequence for hit in seen] == list(range(state.hits))
    assert [hit.time_s for hit in seen] == sorted(hit.time_s for hit in seen)
    between_balls = [hit for hit in seen if isinstance(hit.other, str)]
    assert len(between_balls) == state.ball_ball_hits
    first = seen[0]
    assert (first.ball, first.other, first.epoch) == ("cue", "one", state.epoch)
    # The cue runs east at 5 m/s until one diameter from the ball at (1, 0), whose line it passes 0.0625 m off.
    reach_m = (0.3**2 - 0.0625**2) ** 0.5
    assert first.time_s == pytest.approx((4.0 - reach_m) / 5.0, abs=1e-12)
    assert first.impulse_n_s == pytest.approx(5.0 * reach_m / 0.3, abs=1e-12)


def test_hits_that_were_overtaken_are_counted(plane: ballroom.Server) -> None:
    with plane.events(PATIENCE_S) as hits:
        # A message each time there was a hit, and far more of them than wait here.
        while plane.step(20).hits < 1000:
            pass
        last = plane.state().hits - 1
        seen = [next(hits)]
        while seen[-1].sequence < last:
            seen.append(next(hits))
        assert seen[0].sequence + len(seen) + hits.missed == last + 1


def test_a_standing_clock_is_silence_and_silence_ends_the_wait(plane: ballroom.Server) -> None:
    with plane.states(timeout_s=0.1) as states:
        next(states)
        with pytest.raises(ballroom.NoAnswerError, match="does the clock stand"):
            next(states)


def test_closing_the_session_ends_the_iterators_of_other_threads(plane: ballroom.Server) -> None:
    other = ballroom.connect(plane.endpoint)
    states, started = other.states(), threading.Event()
    ticks: list[int] = []

    def listen() -> None:
        for state in states:
            ticks.append(state.tick)
            started.set()

    listener = threading.Thread(target=listen)
    listener.start()
    assert started.wait(PATIENCE_S)
    other.close()
    listener.join(PATIENCE_S)
    assert not listener.is_alive()
    assert ticks == [0]
