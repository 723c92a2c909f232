//! `play`: a ball driven from this terminal.

use super::connection::{ANSWER_TIMEOUT, Connection};
use super::exit::Refused;
use super::pad::{Latency, Pad};
use super::signals::abort_on_signal;
use anyhow::{Context, bail};
use ballroom_client::{Abort, Client, ClientError, DriveFault, Driver, Follower, Update, renew_every};
use crossterm::event::{self, Event};
use protocol::command::{Direction, DirectionName, SteerMode};
use protocol::keys::Name;
use protocol::player::Players;
use server::terminal::keys::{Keys, Wish};
use server::terminal::screen::{self, RawMode};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};

/// Longest wait for a key before the rest is looked after.
const KEY_PATIENCE: Duration = Duration::from_millis(10);
/// How often the pad is drawn.
const DRAW_EVERY: Duration = Duration::from_millis(50);
/// How often it is asked who plays.
const ASK_EVERY: Duration = Duration::from_millis(500);
/// News that wait to be shown; a pad that is behind with more has nothing to show anyway.
const MAX_NEWS: usize = 256;

/// Drive a ball from this terminal
#[derive(clap::Args)]
#[command(after_help = "\
The arrows push the ball: an impulse a press, a held force where the terminal reports releases. Nobody else can steer the
ball until q, or until two seconds after the last sign of life. The rank is by hits with other balls since the ball was
claimed, most first.

Examples:
  ballroom play
  ballroom play red --player ann -e tcp/192.168.1.5:7447")]
pub struct Play {
    /// Which ball; the first free one of the players' balls when not given
    ball: Option<String>,
    /// Name of the player, 1 to 32 of a-z, 0-9, _ and - [default: yours with a number]
    #[arg(long, value_name = "NAME")]
    player: Option<Name>,
    #[command(flatten)]
    connection: Connection,
}

/// Whose terminal it is, with a number that no other pad on this machine has.
fn own_name() -> Name {
    let number = std::process::id();
    let user = std::env::var("USER").unwrap_or_default();
    let named = format!("{user}-{number}").parse();
    named.or_else(|_| format!("player-{number}").parse()).expect("a name and a number")
}

impl Play {
    pub fn run(self) -> anyhow::Result<()> {
        let abort = abort_on_signal()?;
        let client = self.connection.open(abort.clone(), ANSWER_TIMEOUT)?;
        let follower = client.follow()?;
        // Before the ball is claimed: who cannot press a key needs none.
        let Some(terminal) = RawMode::enter().context("the terminal cannot be used")? else {
            bail!(
                "play needs a terminal: scripts steer with `ballroom steer`, or claim a ball from a program"
            );
        };
        let player = self.player.unwrap_or_else(own_name);
        let driver = client.claim(&player, self.ball.as_deref()).map_err(|error| match error {
            ClientError::Refused { why, .. } => Refused(why).into(),
            other => anyhow::Error::from(other),
        })?;
        let news = listen(client.clone(), follower, abort.clone())?;
        let pad = Pad {
            player: player.to_string(),
            ball: driver.ball().to_owned(),
            arena: client.options().arena.to_string(),
            ..Pad::default()
        };
        let keys = Keys::new(terminal.reports_releases());
        let mut table = Table {
            terminal,
            driver,
            pad,
            keys,
            latency: Latency::default(),
            speed: 1.0,
            renewed: Instant::now(),
        };
        let played = table.play(&news, &abort);
        abort.abort();
        screen::restore();
        played
    }
}

/// What comes from the server.
enum News {
    Update(Update),
    Players(Players),
    /// Simulated seconds per wall second.
    Speed(f64),
}

/// Follows the arena on a thread of its own, so that keys never wait for an answer.
fn listen(client: Client, follower: Follower, abort: Abort) -> anyhow::Result<Receiver<(News, Instant)>> {
    let (sender, news) = sync_channel(MAX_NEWS);
    let (telling, end) = (sender.clone(), abort.clone());
    std::thread::Builder::new().name("ask".into()).spawn(move || {
        while !end.is_aborted() {
            ask(&client, &telling);
            std::thread::sleep(ASK_EVERY);
        }
    })?;
    std::thread::Builder::new().name("follow".into()).spawn(move || {
        for update in follower {
            // What does not fit is overtaken by what follows, but for a world.
            let update = (News::Update(update), Instant::now());
            if matches!(update.0, News::Update(Update::World(_))) {
                drop(sender.send(update));
            } else {
                drop(sender.try_send(update));
            }
        }
        abort.abort();
    })?;
    Ok(news)
}

/// Asks who plays and how fast the clock runs; a server that is gone is told of by the follower.
fn ask(client: &Client, telling: &SyncSender<(News, Instant)>) {
    if let Ok(players) = client.players() {
        drop(telling.try_send((News::Players(players), Instant::now())));
    }
    if let Ok(stats) = client.stats() {
        drop(telling.try_send((News::Speed(stats.speed_factor), Instant::now())));
    }
}

/// Everything on the player's side.
struct Table {
    terminal: RawMode,
    driver: Driver,
    pad: Pad,
    keys: Keys,
    latency: Latency,
    speed: f64,
    renewed: Instant,
}

impl Table {
    /// Keys in, lines out, until the player or the server wants the end.
    fn play(&mut self, news: &Receiver<(News, Instant)>, abort: &Abort) -> anyhow::Result<()> {
        let mut drawn: Option<Instant> = None;
        while !abort.is_aborted() {
            let wish = if event::poll(KEY_PATIENCE)? {
                match event::read()? {
                    Event::Key(key) => self.keys.wish(key),
                    Event::FocusLost => self.keys.let_go(),
                    _ => None,
                }
            } else {
                None
            };
            if wish == Some(Wish::Quit) {
                return Ok(());
            }
            self.fulfil(wish)?;
            for (news, came) in news.try_iter() {
                self.learn(news, came);
            }
            for acted in self.driver.acked() {
                self.latency.acted(&acted);
            }
            if drawn.is_none_or(|drawn| drawn.elapsed() >= DRAW_EVERY) {
                drawn = Some(Instant::now());
                self.show()?;
            }
            if let Some(why) = self.driver.lost() {
                self.show()?;
                bail!("the ball is lost: {why}");
            }
        }
        Ok(())
    }

    fn fulfil(&mut self, wish: Option<Wish>) -> anyhow::Result<()> {
        match wish {
            Some(Wish::Push(direction)) => self.steer(Direction::Vector(direction), SteerMode::Impulse),
            Some(Wish::Hold(held)) => self.hold(held),
            _ if self.renewed.elapsed() >= renew_every(self.speed) => match self.keys.held() {
                Some(held) => self.hold(Some(held)),
                None => Ok(()),
            },
            _ => Ok(()),
        }
    }

    fn hold(&mut self, held: Option<[f64; 2]>) -> anyhow::Result<()> {
        self.renewed = Instant::now();
        self.steer(held.map_or(Direction::Named(DirectionName::Stop), Direction::Vector), SteerMode::Force)
    }

    fn steer(&mut self, direction: Direction, mode: SteerMode) -> anyhow::Result<()> {
        match self.driver.drive(direction, mode) {
            Ok(seq) => self.latency.pressed(seq, Instant::now()),
            // A key that comes when nothing goes out would act when nobody expects it any more.
            Err(DriveFault::Full) => {}
            Err(fault) => bail!(fault),
        }
        Ok(())
    }

    fn learn(&mut self, news: News, came: Instant) {
        match news {
            News::Update(Update::World(world)) => {
                self.pad.roster = world.roster;
                self.see(world.snapshot, came);
            }
            News::Update(Update::State(state)) => self.see(*state, came),
            News::Update(Update::Gone) => self.pad.state = None,
            News::Players(Players { players }) => self.pad.players = players,
            News::Speed(factor) => self.speed = factor,
        }
    }

    fn see(&mut self, state: protocol::snapshot::Snapshot, came: Instant) {
        self.latency.state(&state, came);
        self.pad.state = Some(state);
    }

    fn show(&mut self) -> std::io::Result<()> {
        self.pad.seen_after = self.latency.last();
        self.pad.acked_after = self.driver.latency();
        self.pad.waiting = self.driver.waiting();
        self.terminal.show_lines(&self.pad.lines())
    }
}
