//! Commands as they arrive: bounded, in order, drained by the tick loop.

use crate::ready::Ready;
use crate::wanted::{Moment, Wanted, When};
use protocol::command::{Command, Refusal, Reply, code};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Most commands waiting for one tick.
pub const INBOX_CAPACITY: usize = 1024;

/// How a reply reaches whoever asked; called off the tick thread, and may not wait there for the asker.
pub type Answer = Box<dyn FnOnce(&Reply) + Send>;

/// A command on its way.
pub struct Request {
    /// What to do.
    pub command: Command,
    /// What was made ready for it.
    pub ready: Ready,
    /// Whom to tell, if anyone asked.
    pub answer: Option<Answer>,
}

/// A reply on its way back.
pub struct Answered {
    /// Whom to tell.
    pub answer: Answer,
    /// What.
    pub reply: Reply,
}

/// A request that was not taken, and why.
pub struct Refused {
    /// Whom to tell.
    pub answer: Option<Answer>,
    /// Why, for whoever asked.
    pub why: Refusal,
}

/// What is said of whatever comes or waits when the tick loop has ended.
pub const ENDING: &str = "the server ends";

/// The queue between the network and the tick loop.
pub struct Inbox {
    waiting: Mutex<Waiting>,
    arrived: Condvar,
    /// The next tick that a player's command waits for, to be seen without the lock.
    next_wanted: AtomicU64,
    accepted: AtomicU64,
    refused: AtomicU64,
}

#[derive(Default)]
struct Waiting {
    requests: VecDeque<Request>,
    wanted: Wanted,
    closed: bool,
}

impl Default for Inbox {
    fn default() -> Self {
        Self {
            waiting: Mutex::default(),
            arrived: Condvar::new(),
            next_wanted: AtomicU64::new(u64::MAX),
            accepted: AtomicU64::new(0),
            refused: AtomicU64::new(0),
        }
    }
}

impl Inbox {
    /// Takes a request, or says why not when the queue is full or closed.
    pub fn offer(&self, request: Request) -> Result<(), Refused> {
        let mut waiting = self.lock();
        if waiting.closed {
            return Err(Refused { answer: request.answer, why: Refusal::new(code::ENDING, ENDING) });
        }
        if waiting.requests.len() >= INBOX_CAPACITY {
            let why = Refusal::new(code::TOO_MANY, "too many commands wait for one tick: send fewer");
            return Err(Refused { answer: request.answer, why });
        }
        waiting.requests.push_back(request);
        drop(waiting);
        self.arrived.notify_one();
        Ok(())
    }

    /// Takes a command of a player's claim for the tick at which it is wanted, or says why not.
    pub fn offer_at(&self, claim: u64, when: When, request: Request) -> Result<(), Refusal> {
        let mut waiting = self.lock();
        if waiting.closed {
            return Err(Refusal::new(code::ENDING, ENDING));
        }
        waiting.wanted.push(claim, when, request)?;
        self.next_wanted.store(waiting.wanted.next_tick(), Ordering::Relaxed);
        drop(waiting);
        self.arrived.notify_one();
        Ok(())
    }

    /// Takes back what waits for its tick of a claim.
    pub fn withdraw(&self, claim: u64) -> Vec<Request> {
        let mut waiting = self.lock();
        let gone = waiting.wanted.withdraw(claim);
        self.next_wanted.store(waiting.wanted.next_tick(), Ordering::Relaxed);
        gone
    }

    /// The next tick that a player's command waits for; the largest number when none does.
    pub fn next_wanted_tick(&self) -> u64 {
        self.next_wanted.load(Ordering::Relaxed)
    }

    /// Moves everything that waits to the end of `out`, in order of arrival, and then what is wanted by `now`.
    pub fn drain_into(&self, out: &mut Vec<Request>, now: Moment) {
        let mut waiting = self.lock();
        out.extend(waiting.requests.drain(..));
        waiting.wanted.drain_into(out, now);
        self.next_wanted.store(waiting.wanted.next_tick(), Ordering::Relaxed);
    }

    /// Moves everything that waits to the end of `out`, whatever tick it is wanted at.
    pub fn drain_all_into(&self, out: &mut Vec<Request>) {
        // Of an epoch that never comes: nothing waits for its tick any more.
        self.drain_into(out, Moment { epoch: u64::MAX, tick: 0 });
    }

    /// Takes no more; what waits can still be drained.
    pub fn close(&self) {
        self.lock().closed = true;
    }

    /// Whether it takes no more.
    pub fn is_closed(&self) -> bool {
        self.lock().closed
    }

    /// Sleeps until `deadline` or until something waits.
    pub fn wait_until(&self, deadline: Instant) {
        let mut waiting = self.lock();
        while waiting.requests.is_empty() && !waiting.wanted.is_due() {
            let left = deadline.saturating_duration_since(Instant::now());
            if left == Duration::ZERO {
                return;
            }
            waiting = self.arrived.wait_timeout(waiting, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts a command that was obeyed.
    pub fn count_accepted(&self) {
        self.accepted.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts a command that was or a question that was refused, wherever that was.
    pub fn count_refused(&self) {
        self.refused.fetch_add(1, Ordering::Relaxed);
    }

    /// Commands obeyed and refused so far.
    pub fn counts(&self) -> [u64; 2] {
        [self.accepted.load(Ordering::Relaxed), self.refused.load(Ordering::Relaxed)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(ticks: u64) -> Request {
        Request { command: Command::Step { ticks }, ready: Ready::Nothing, answer: None }
    }

    #[test]
    fn requests_come_out_in_order_and_the_queue_is_bounded() {
        let inbox = Inbox::default();
        for i in 0..INBOX_CAPACITY {
            assert!(inbox.offer(step(i as u64)).is_ok());
        }
        assert!(inbox.offer(step(0)).is_err());
        let mut out = Vec::new();
        inbox.drain_into(&mut out, Moment::default());
        let ticks = out.iter().map(|request| match request.command {
            Command::Step { ticks } => ticks,
            _ => u64::MAX,
        });
        assert!(ticks.eq(0..INBOX_CAPACITY as u64));
        assert!(inbox.offer(step(0)).is_ok());
        inbox.close();
        assert_eq!(inbox.offer(step(0)).err().map(|refused| refused.why.code), Some(code::ENDING));
    }

    #[test]
    fn waiting_ends_at_an_arrival_or_the_deadline() {
        let inbox = Inbox::default();
        let start = Instant::now();
        inbox.wait_until(start + Duration::from_millis(20));
        assert!(start.elapsed() >= Duration::from_millis(20));
        std::thread::scope(|scope| {
            scope.spawn(|| inbox.offer(step(1)).map_err(|_| ()).unwrap());
            inbox.wait_until(Instant::now() + Duration::from_mins(1));
        });
        assert!(start.elapsed() < Duration::from_secs(30));
    }
}
