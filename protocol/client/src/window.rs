//! What a player has sent and what came of it: plain data, without any session.

use protocol::command::{Direction, SteerMode};
use protocol::player::{Ack, Acted, Drive, MAX_WINDOW, Sent, Token};
use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

/// Outcomes kept for someone to look at; the oldest give way.
const MAX_OUTCOMES: usize = 1024;

/// When a command is wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// At this tick; at the next boundary without one.
    pub tick: Option<u64>,
    /// Of this epoch; of the present one without one.
    pub epoch: Option<u64>,
}

impl Wanted {
    /// At a tick of an epoch.
    pub const fn at(epoch: u64, tick: u64) -> Self {
        Self { tick: Some(tick), epoch: Some(epoch) }
    }
}

/// The commands that are not acknowledged yet, and the outcomes of those that are.
#[derive(Debug)]
pub(crate) struct Window {
    token: Token,
    claim: u64,
    /// Number of the next message.
    number: u64,
    /// The last command up to which all are acknowledged.
    acked: u64,
    sent: VecDeque<(Sent, Instant)>,
    /// Acknowledged while one before is not.
    early: BTreeMap<u64, Acted>,
    outcomes: VecDeque<Acted>,
    latency: Option<Duration>,
    /// Rounds of sending since the last acknowledgement.
    unanswered: u32,
    ended: Option<String>,
}

impl Window {
    pub const fn new(token: Token, claim: u64) -> Self {
        Self {
            token,
            claim,
            number: 1,
            acked: 0,
            sent: VecDeque::new(),
            early: BTreeMap::new(),
            outcomes: VecDeque::new(),
            latency: None,
            unanswered: 0,
            ended: None,
        }
    }

    /// Takes a command and gives its number, or nothing when too many are not acknowledged yet.
    pub fn push(
        &mut self,
        wanted: Wanted,
        direction: Direction,
        mode: SteerMode,
        now: Instant,
    ) -> Option<u64> {
        if self.sent.len() >= MAX_WINDOW {
            return None;
        }
        let seq = self.acked + self.sent.len() as u64 + 1;
        let Wanted { tick, epoch } = wanted;
        self.sent.push_back((Sent { seq, tick, epoch, direction, mode }, now));
        Some(seq)
    }

    /// The next message: everything that is not acknowledged yet.
    pub fn message(&mut self) -> Drive {
        let number = self.number;
        self.number += 1;
        Drive {
            token: self.token.clone(),
            number,
            acked: self.acked,
            latency_ms: self.latency.map(|latency| latency.as_secs_f64() * 1e3),
            sent: self.sent.iter().map(|(sent, _)| sent.clone()).collect(),
        }
    }

    /// Takes an acknowledgement in; one of another claim is not meant.
    pub fn take(&mut self, ack: Ack, now: Instant) {
        if ack.claim != self.claim {
            return;
        }
        self.unanswered = 0;
        let waited_for = |acted: &Acted| acted.seq > self.acked;
        let news: Vec<Acted> = ack.acted.into_iter().filter(waited_for).collect();
        self.early.extend(news.into_iter().map(|acted| (acted.seq, acted)));
        while let Some((_, since)) = self.sent.front()
            && let Some(acted) = self.early.remove(&(self.acked + 1))
        {
            self.latency = Some(now.saturating_duration_since(*since));
            self.acked += 1;
            self.sent.pop_front();
            if self.outcomes.len() >= MAX_OUTCOMES {
                self.outcomes.pop_front();
            }
            self.outcomes.push_back(acted);
        }
        // Nobody but the server could acknowledge what was never sent; it must not take memory.
        let last = self.acked + self.sent.len() as u64;
        self.early.retain(|seq, _| *seq <= last);
        if ack.ended.is_some() {
            self.ended = self.ended.take().or(ack.ended);
        }
    }

    /// Says why the ball is lost, unless it was before.
    pub fn end(&mut self, why: impl Into<String>) {
        self.ended.get_or_insert_with(|| why.into());
    }

    /// Outcomes since this was asked last, in order.
    pub fn take_outcomes(&mut self) -> Vec<Acted> {
        self.outcomes.drain(..).collect()
    }

    /// Commands that are not acknowledged yet.
    pub fn waiting(&self) -> usize {
        self.sent.len()
    }

    /// From the last command that was acknowledged to its acknowledgement.
    pub const fn latency(&self) -> Option<Duration> {
        self.latency
    }

    /// A round of sending begins.
    pub const fn count_round(&mut self) {
        self.unanswered += 1;
    }

    /// Rounds of sending since the last acknowledgement.
    pub const fn unanswered(&self) -> u32 {
        self.unanswered
    }

    /// Why the ball is lost, if it is.
    pub fn ended(&self) -> Option<&str> {
        self.ended.as_deref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::command::DirectionName;

    const UP: Direction = Direction::Named(DirectionName::Up);

    fn window() -> Window {
        Window::new(Token::from_bits(1), 7)
    }

    fn push(window: &mut Window) -> Option<u64> {
        window.push(Wanted::default(), UP, SteerMode::Impulse, Instant::now())
    }

    fn ack(claim: u64, acted: &[u64]) -> Ack {
        let acted =
            acted.iter().map(|&seq| Acted { seq, tick: 10 + seq, epoch: 1, code: 1, error: String::new() });
        Ack { claim, heard: 0, next_seq: 0, acted: acted.collect(), ended: None }
    }

    fn take(window: &mut Window, ack: Ack) -> Vec<u64> {
        window.take(ack, Instant::now());
        window.take_outcomes().iter().map(|acted| acted.seq).collect()
    }

    #[test]
    fn everything_is_sent_again_until_it_is_acknowledged() {
        let mut window = window();
        assert_eq!([push(&mut window), push(&mut window), push(&mut window)], [Some(1), Some(2), Some(3)]);
        let seqs = |drive: &Drive| drive.sent.iter().map(|sent| sent.seq).collect::<Vec<_>>();
        let (first, second) = (window.message(), window.message());
        assert_eq!((seqs(&first), seqs(&second)), (vec![1, 2, 3], vec![1, 2, 3]));
        assert_eq!((first.number, second.number, second.acked), (1, 2, 0));
        assert_eq!(take(&mut window, ack(7, &[1, 2])), [1, 2]);
        let third = window.message();
        assert_eq!((seqs(&third), third.acked), (vec![3], 2));
        assert!(third.latency_ms.is_some());
        assert_eq!(push(&mut window), Some(4));
    }

    #[test]
    fn late_repeated_early_and_strange_acknowledgements_do_no_harm() {
        let mut window = window();
        for _ in 0..3 {
            push(&mut window);
        }
        assert!(take(&mut window, ack(6, &[1, 2, 3])).is_empty());
        assert!(take(&mut window, ack(7, &[2, 99])).is_empty());
        assert_eq!(window.waiting(), 3);
        assert_eq!(take(&mut window, ack(7, &[1])), [1, 2]);
        assert!(take(&mut window, ack(7, &[1, 2])).is_empty());
        assert_eq!(take(&mut window, ack(7, &[1, 2, 3])), [3]);
        assert_eq!((window.waiting(), window.message().acked), (0, 3));
    }

    #[test]
    fn a_window_is_bounded_and_moves_on() {
        let mut window = window();
        assert!((1..=MAX_WINDOW as u64).all(|seq| push(&mut window) == Some(seq)));
        assert_eq!(push(&mut window), None);
        window.message().check().unwrap();
        take(&mut window, ack(7, &[1]));
        assert_eq!(push(&mut window), Some(MAX_WINDOW as u64 + 1));
    }

    #[test]
    fn the_first_reason_for_the_end_stays() {
        let mut window = window();
        window.take(Ack { ended: Some("released".into()), ..ack(7, &[]) }, Instant::now());
        window.end("silence");
        assert_eq!(window.ended(), Some("released"));
    }
}
