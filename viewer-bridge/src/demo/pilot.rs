//! From what is wanted to commands. The terminal never waits for an answer: presses have none, and the others are
//! asked on a thread of their own, which tells what was refused.

use crate::demo::keys::Wish;
use ballroom_client::{Client, LivelinessToken, renew_every};
use protocol::command::{Command, Direction, DirectionName, Scope, SpeedFactor, SteerMode};
use protocol::keys::{Name, Role};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::time::{Duration, Instant};

/// Commands that wait for the server; a stuck one makes further ones pointless.
const MAX_WAITING: usize = 16;
/// For so long our own last speed is trusted over the server's statistics, which come once a second.
const SPEED_MEMORY: Duration = Duration::from_secs(3);
/// Speeds to choose from.
const SPEEDS: [f64; 11] = [1.0 / 64.0, 1.0 / 32.0, 1.0 / 16.0, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

/// Who drives.
pub struct Pilot {
    client: Client,
    player: Name,
    questions: SyncSender<Command>,
    speed: Option<(f64, Instant)>,
    renewed: Instant,
    /// Tells the others that someone steers.
    _presence: LivelinessToken,
}

impl Pilot {
    /// Drives through `client` under the name `player`.
    pub fn new(client: Client, player: Name) -> anyhow::Result<Self> {
        let presence = client.announce(Role::Player, &player)?;
        let (questions, inbox) = sync_channel(MAX_WAITING);
        let asker = client.clone();
        std::thread::Builder::new().name("ask".into()).spawn(move || {
            for command in inbox {
                match asker.command(&command) {
                    Ok(reply) if !reply.ok => tracing::warn!("refused: {}", reply.error),
                    Ok(_) => {}
                    Err(fault) => tracing::warn!("{fault}"),
                }
            }
        })?;
        Ok(Self { client, player, questions, speed: None, renewed: Instant::now(), _presence: presence })
    }

    /// Does what is wanted, given whether the arena is paused and how fast it is meant to run.
    pub fn fulfil(&mut self, wish: Wish, paused: bool, speed_factor: f64) {
        match wish {
            Wish::Push(direction) => self.steer(Direction::Vector(direction), SteerMode::Impulse),
            Wish::Hold(held) => self.hold(held),
            Wish::TogglePause => self.ask(if paused { Command::Resume {} } else { Command::Pause {} }),
            Wish::Reset => self.ask(Command::Reset { scope: Scope::All, seed: None }),
            Wish::Step => self.ask(Command::Step { ticks: 1 }),
            Wish::Faster | Wish::Slower => {
                let known = self.speed.filter(|(_, at)| at.elapsed() < SPEED_MEMORY);
                let factor =
                    neighbour(known.map_or(speed_factor, |(factor, _)| factor), wish == Wish::Faster);
                self.speed = Some((factor, Instant::now()));
                self.ask(Command::Speed { factor: SpeedFactor::Times(factor) });
            }
            Wish::Quit => {}
        }
    }

    /// The speed that was asked for last, or else the reported one.
    pub fn speed(&self, reported: f64) -> f64 {
        self.speed.filter(|(_, at)| at.elapsed() < SPEED_MEMORY).map_or(reported, |(factor, _)| factor)
    }

    /// Renews a held force when it is time, at this many simulated seconds a second.
    pub fn renew(&mut self, held: Option<[f64; 2]>, speed_factor: f64) {
        if held.is_some() && self.renewed.elapsed() >= renew_every(self.speed(speed_factor)) {
            self.hold(held);
        }
    }

    fn hold(&mut self, held: Option<[f64; 2]>) {
        self.renewed = Instant::now();
        let direction = held.map_or(Direction::Named(DirectionName::Stop), Direction::Vector);
        self.steer(direction, SteerMode::Force);
    }

    fn steer(&self, direction: Direction, mode: SteerMode) {
        if let Err(fault) = self.client.press(&self.player, &Command::Steer { ball: None, direction, mode }) {
            tracing::warn!("{fault}");
        }
    }

    fn ask(&self, command: Command) {
        if self.questions.try_send(command).is_err() {
            tracing::warn!("the server is behind with its answers; that key is forgotten");
        }
    }
}

/// The next speed of the list above or below.
fn neighbour(factor: f64, faster: bool) -> f64 {
    let mut above = SPEEDS.iter().copied().filter(|s| *s > factor * 1.001);
    let below = SPEEDS.iter().copied().rev().find(|s| *s < factor * 0.999);
    let next = if faster { above.next() } else { below };
    next.unwrap_or(if faster { SPEEDS[SPEEDS.len() - 1] } else { SPEEDS[0] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_go_up_and_down_the_list_and_stop_at_its_ends() {
        assert_eq!([neighbour(1.0, true), neighbour(1.0, false), neighbour(1.5, true)], [2.0, 0.5, 2.0]);
        assert_eq!([neighbour(16.0, true), neighbour(1.0 / 64.0, false)], [16.0, 1.0 / 64.0]);
    }
}
