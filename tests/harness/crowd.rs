//! Ten clients that misbehave, each a process of its own that takes no processor time from others: they stand for other
//! machines.

use crate::process::Process;
use crate::wait::PATIENCE;
use nix::sys::signal::Signal;
use std::time::{Duration, Instant};

/// How often it is looked at whose time is over.
const LOOK: Duration = Duration::from_millis(50);

/// A way to misbehave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Reads states, then is stopped by a signal; a new one comes when the server has given it up.
    Stopped,
    /// Reads ten states a second of all there are, and remains connected.
    Slow,
    /// Floods with presses.
    Presses,
    /// Floods with bytes that are no command.
    Nonsense,
    /// Floods with questions for the whole world.
    Questions,
    /// Floods the port with bytes that are not Zenoh's.
    Bytes,
    /// Reads states, is killed half a second later, and comes again.
    Vanishing,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Stopped,
        Self::Slow,
        Self::Presses,
        Self::Nonsense,
        Self::Questions,
        Self::Bytes,
        Self::Vanishing,
    ];

    /// The kind of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// What it is called.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stopped => "stopped",
            Self::Slow => "slow",
            Self::Presses => "presses",
            Self::Nonsense => "nonsense",
            Self::Questions => "questions",
            Self::Bytes => "bytes",
            Self::Vanishing => "vanishing",
        }
    }

    /// How many of ten.
    const fn count(self) -> usize {
        match self {
            Self::Stopped => 3,
            Self::Vanishing => 2,
            _ => 1,
        }
    }

    /// How long one stays before another takes its place.
    const fn life(self) -> Option<Duration> {
        match self {
            // A client's lease is two seconds.
            Self::Stopped => Some(Duration::from_secs(3)),
            Self::Vanishing => Some(Duration::from_millis(500)),
            _ => None,
        }
    }

    fn start(self, endpoint: &str) -> Process {
        let does = if matches!(self, Self::Stopped | Self::Vanishing) { "reads" } else { self.name() };
        Process::start_aside("rough-client", &[endpoint, does])
    }
}

struct Member {
    kind: Kind,
    process: Process,
    since: Instant,
}

impl Member {
    fn at(endpoint: &str, kind: Kind) -> Self {
        Self { kind, process: kind.start(endpoint), since: Instant::now() }
    }

    /// Waits until it does what it came for; those that vanish may do so before.
    fn settle(&self) {
        if self.kind != Kind::Vanishing {
            self.process.said(PATIENCE, |line| (line == "here").then_some(()));
        }
        if self.kind == Kind::Stopped {
            self.process.signal(Signal::SIGSTOP);
        }
    }

    fn is_over(&self) -> bool {
        self.kind.life().is_some_and(|life| self.since.elapsed() >= life)
    }
}

/// Three readers that have stopped reading, a slow one, four that flood, two that vanish again and again.
pub struct Crowd {
    members: Vec<Member>,
    endpoint: String,
}

impl Crowd {
    /// All of them at a server.
    pub fn at(endpoint: &str) -> Self {
        Self::of(&Kind::ALL, endpoint)
    }

    /// Those of some kinds only.
    pub fn of(kinds: &[Kind], endpoint: &str) -> Self {
        let each = kinds.iter().flat_map(|&kind| std::iter::repeat_n(kind, kind.count()));
        let members: Vec<Member> = each.map(|kind| Member::at(endpoint, kind)).collect();
        members.iter().for_each(Member::settle);
        Self { members, endpoint: endpoint.to_owned() }
    }

    /// Lets them be for a time.
    pub fn rage_for(&mut self, time: Duration) {
        let end = Instant::now() + time;
        while Instant::now() < end {
            std::thread::sleep(LOOK);
            for member in self.members.iter_mut().filter(|member| member.is_over()) {
                *member = Member::at(&self.endpoint, member.kind);
                member.settle();
            }
        }
    }
}
