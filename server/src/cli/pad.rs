//! What a player sees: the lines of the pad as a function of what is known, and how long a key takes to be seen.

use protocol::player::{Acted, PlayerRow};
use protocol::snapshot::{Collisions, Roster, Snapshot};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Presses whose effect is still to be seen.
const MAX_PRESSES: usize = 64;
/// States remembered: an acknowledgement may come after the state that shows its command.
const MAX_STATES: usize = 256;
/// Players listed.
const MAX_ROWS: usize = 8;

/// Everything that is shown.
#[derive(Default)]
pub struct Pad {
    /// Who plays here.
    pub player: String,
    /// Which ball.
    pub ball: String,
    /// Where.
    pub arena: String,
    /// Who the balls are.
    pub roster: Roster,
    /// The newest state, unless the server is gone.
    pub state: Option<Snapshot>,
    /// Who else plays.
    pub players: Vec<PlayerRow>,
    /// From the last key to the state that showed what it did.
    pub seen_after: Option<Duration>,
    /// From the last command to its acknowledgement.
    pub acked_after: Option<Duration>,
    /// Commands that are not acknowledged yet.
    pub waiting: usize,
}

impl Pad {
    /// The lines, top to bottom.
    pub fn lines(&self) -> Vec<String> {
        let own = self.players.iter().find(|row| row.player.as_str() == self.player);
        let hits = own.map_or_else(Collisions::default, |row| row.hits);
        let mut lines = vec![
            format!("{} of arena {}, driven by {}", self.ball, self.arena, self.player),
            format!(
                "speed    {:>10}   hits {} balls, {} walls since it was claimed",
                self.speed(),
                hits.ball_ball,
                hits.ball_wall
            ),
            format!(
                "latency  {:>10} from key to sight, {} to acknowledgement{}",
                millis(self.seen_after),
                millis(self.acked_after),
                if self.waiting > 0 { format!(", {} on their way", self.waiting) } else { String::new() }
            ),
        ];
        if let Some(row) = own {
            let (lost, all) = (row.lost, row.messages + row.lost);
            lines.push(format!("messages {all:>10}   {lost} lost, {} came twice", row.repeated));
            let rank = format!("{} of {}", row.rank, self.players.len());
            lines.push(format!("rank     {rank:>10}   by hits with other balls, most first"));
        }
        lines.extend(self.table());
        lines.push(self.clock());
        lines.push("arrows push, q quits".to_owned());
        lines
    }

    fn speed(&self) -> String {
        let ball = self.roster.names.binary_search_by(|known| known.as_str().cmp(&self.ball)).ok();
        let velocity = ball.and_then(|ball| self.state.as_ref()?.velocity_m_per_s.get(ball));
        velocity.map_or_else(
            || "-".to_owned(),
            |v| format!("{:.2} m/s", v.iter().map(|x| x * x).sum::<f64>().sqrt()),
        )
    }

    fn table(&self) -> Vec<String> {
        let mut rows: Vec<&PlayerRow> = self.players.iter().collect();
        rows.sort_by_key(|row| row.rank);
        let line = |row: &&PlayerRow| {
            let own = if row.player.as_str() == self.player { "  <" } else { "" };
            format!("  {:>2} {:16} {:16} {:>6}{own}", row.rank, row.player, row.ball, row.hits.ball_ball)
        };
        let mut table: Vec<String> = rows.iter().take(MAX_ROWS).map(line).collect();
        if rows.len() > MAX_ROWS {
            table.push(format!("  and {} more", rows.len() - MAX_ROWS));
        }
        table
    }

    fn clock(&self) -> String {
        match &self.state {
            Some(state) if state.paused => format!("tick {}, {:.1} s, paused", state.tick, state.time_s),
            Some(state) => format!("tick {}, {:.1} s", state.tick, state.time_s),
            None => "the server is gone".to_owned(),
        }
    }
}

fn millis(time: Option<Duration>) -> String {
    time.map_or_else(|| "-".to_owned(), |time| format!("{:.0} ms", time.as_secs_f64() * 1e3))
}

/// From a key to the first state that shows what it did: one that is later than the tick at which its command acted.
#[derive(Default)]
pub struct Latency {
    presses: VecDeque<(u64, Instant)>,
    states: VecDeque<(Mark, Instant)>,
    /// Acted, and not seen yet.
    unseen: VecDeque<(Mark, Instant)>,
    last: Option<Duration>,
}

/// Which state; while the clock stands, one of the same tick may come after a command.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Mark {
    epoch: u64,
    tick: u64,
}

impl Latency {
    /// A key was pressed, and became command `seq`.
    pub fn pressed(&mut self, seq: u64, now: Instant) {
        push(&mut self.presses, (seq, now), MAX_PRESSES);
    }

    /// A command was acknowledged.
    pub fn acted(&mut self, acted: &Acted) {
        let Some(at) = self.presses.iter().position(|(seq, _)| *seq == acted.seq) else { return };
        let Some((_, pressed)) = self.presses.remove(at) else { return };
        if acted.is_done() {
            let mark = Mark { epoch: acted.epoch, tick: acted.tick };
            push(&mut self.unseen, (mark, pressed), MAX_PRESSES);
            self.match_up();
        }
    }

    /// A state came.
    pub fn state(&mut self, state: &Snapshot, now: Instant) {
        // While the clock stands the second state of a tick shows what was done at it.
        let tick = if state.paused { state.tick + 1 } else { state.tick };
        push(&mut self.states, (Mark { epoch: state.epoch, tick }, now), MAX_STATES);
        self.match_up();
    }

    /// The last one that was measured.
    pub const fn last(&self) -> Option<Duration> {
        self.last
    }

    fn match_up(&mut self) {
        while let Some((acted, pressed)) = self.unseen.front() {
            let shows = |(state, came): &&(Mark, Instant)| {
                came >= pressed
                    && (state.epoch > acted.epoch || (state.epoch == acted.epoch && state.tick > acted.tick))
            };
            let Some((_, came)) = self.states.iter().find(shows) else { return };
            self.last = Some(*came - *pressed);
            self.unseen.pop_front();
        }
    }
}

fn push<T>(queue: &mut VecDeque<T>, item: T, most: usize) {
    if queue.len() >= most {
        queue.pop_front();
    }
    queue.push_back(item);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(player: &str, ball: &str, ball_ball: u64, rank: usize) -> PlayerRow {
        PlayerRow {
            player: player.parse().unwrap(),
            ball: ball.into(),
            claim: 1,
            hits: Collisions { ball_ball, ball_wall: 12 },
            rank,
            commands: 5,
            refused: 0,
            waiting: 0,
            messages: 118,
            lost: 2,
            repeated: 1,
            latency_ms: None,
            silent_s: 0.0,
        }
    }

    fn state(epoch: u64, tick: u64) -> Snapshot {
        Snapshot {
            epoch,
            tick,
            time_s: 1.5,
            velocity_m_per_s: vec![[9.0, 9.0, 9.0], [3.0, 4.0, 0.0]],
            ..Snapshot::default()
        }
    }

    fn pad() -> Pad {
        Pad {
            player: "ann".into(),
            ball: "red".into(),
            arena: "main".into(),
            roster: Roster { names: vec!["blue".into(), "red".into()], ..Roster::default() },
            state: Some(state(1, 90)),
            players: vec![row("ann", "red", 3, 2), row("bob", "blue", 7, 1)],
            seen_after: Some(Duration::from_millis(38)),
            acked_after: Some(Duration::from_millis(12)),
            waiting: 0,
        }
    }

    #[test]
    fn the_pad_shows_speed_hits_latency_rank_and_who_else_plays() {
        let lines = pad().lines();
        let expected = [
            "red of arena main, driven by ann",
            "speed      5.00 m/s   hits 3 balls, 12 walls since it was claimed",
            "latency       38 ms from key to sight, 12 ms to acknowledgement",
            "messages        120   2 lost, 1 came twice",
            "rank         2 of 2   by hits with other balls, most first",
            "   1 bob              blue                  7",
            "   2 ann              red                   3  <",
            "tick 90, 1.5 s",
            "arrows push, q quits",
        ];
        assert_eq!(lines, expected);
    }

    #[test]
    fn what_is_not_known_yet_is_a_dash_and_a_lost_server_is_said() {
        let lines = Pad { state: None, players: Vec::new(), seen_after: None, waiting: 3, ..pad() }.lines();
        assert!(lines[1].starts_with("speed             -"), "{lines:?}");
        assert!(
            lines[2].starts_with("latency           - from key") && lines[2].ends_with(", 3 on their way")
        );
        assert_eq!(lines[3], "the server is gone");
    }

    #[test]
    fn a_key_is_seen_in_the_first_state_after_the_tick_at_which_it_acted() {
        let start = Instant::now();
        let after = |millis: u64| start + Duration::from_millis(millis);
        let acted = |seq, tick| Acted { seq, tick, epoch: 1, code: 1, error: String::new() };
        let mut latency = Latency::default();
        latency.pressed(1, after(0));
        latency.state(&state(1, 10), after(5));
        latency.state(&state(1, 11), after(20));
        latency.state(&state(1, 12), after(37));
        // The acknowledgement comes after the state that shows it.
        latency.acted(&acted(1, 10));
        assert_eq!(latency.last(), Some(Duration::from_millis(20)));
        latency.pressed(2, after(40));
        latency.acted(&acted(2, 12));
        assert_eq!(latency.last(), Some(Duration::from_millis(20)));
        latency.state(&state(1, 13), after(70));
        assert_eq!(latency.last(), Some(Duration::from_millis(30)));
        // A new epoch shows it too; a refused one is never seen.
        latency.pressed(3, after(80));
        latency.pressed(4, after(80));
        latency.acted(&Acted { code: 5, ..acted(3, 0) });
        latency.acted(&acted(4, 99));
        latency.state(&state(2, 0), after(95));
        assert_eq!(latency.last(), Some(Duration::from_millis(15)));
    }
}
