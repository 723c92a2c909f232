//! `top`: a dashboard of a server in the terminal, or as text for scripts.

mod screen;
pub mod table;

use super::connection::{ANSWER_TIMEOUT, Connection};
use super::sight::{Lookout, Sight};
use super::signals::abort_on_signal;
use anyhow::bail;
use ballroom_client::Abort;
use crossterm::event::{self, Event};
use protocol::command::{Command, RunState, Scope};
use screen::{Screen, Terminal, Wish};
use std::io::{IsTerminal, Write, stdout};
use std::time::{Duration, Instant};

/// Time between two looks: as often as a server has news.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// Longest wait for a key, so that a signal is seen.
const SLICE: Duration = Duration::from_millis(100);

/// Watch arenas, clients and streams of a server in the terminal
#[derive(clap::Args)]
#[command(after_help = "\
Keys: up and down choose an arena, p pauses it or lets it run, r resets it after a second y, q quits.
TARGET and ACTUAL are simulated seconds per wall second; p50, p99 and MAX how long a tick takes; LATE the ticks that ended
after their deadline. AGE is a state's age when it reaches the client, by the two machines' clocks; LOST are states that were
published and did not arrive, OVERTAKEN those that arrived and were not read in time.

Examples:
  ballroom top
  ballroom top --once
  ballroom top --once --json | jq .clients")]
pub struct Top {
    /// Print one table as plain text and end
    #[arg(long)]
    once: bool,
    /// A line of JSON an arena, once a second
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: Connection,
}

impl Top {
    pub fn run(self) -> anyhow::Result<()> {
        if !self.once && !self.json && !stdout().is_terminal() {
            bail!("stdout is no terminal: use --once or --json");
        }
        let abort = abort_on_signal()?;
        let mut lookout = Lookout::new(self.connection.open(abort.clone(), ANSWER_TIMEOUT)?);
        if !self.once && !self.json {
            return watch(&mut lookout, &abort);
        }
        while !abort.is_aborted() {
            print(&lookout.look()?, self.json)?;
            if self.once {
                break;
            }
            std::thread::sleep(LOOK_EVERY);
        }
        Ok(())
    }
}

fn print(sights: &[Sight], as_json: bool) -> anyhow::Result<()> {
    let mut out = stdout().lock();
    if as_json {
        for sight in sights {
            writeln!(out, "{}", serde_json::to_string(sight)?)?;
        }
        return Ok(());
    }
    let details = sights.iter().flat_map(|sight| table::details(sight, usize::MAX));
    for line in table::arenas(sights, None, usize::MAX).into_iter().chain(details) {
        writeln!(out, "{line}")?;
    }
    Ok(())
}

fn watch(lookout: &mut Lookout, abort: &Abort) -> anyhow::Result<()> {
    let mut screen = Screen::default();
    screen.see(lookout.look()?);
    let terminal = Terminal::take()?;
    let mut next_look = Instant::now() + LOOK_EVERY;
    while !abort.is_aborted() {
        terminal.show(&screen.lines(Terminal::width()?))?;
        if event::poll(SLICE)?
            && let Event::Key(key) = event::read()?
            && let Some(wish) = screen.press(key)
        {
            if wish == Wish::Quit {
                break;
            }
            let said = fulfil(lookout, &screen, wish);
            screen.say(said.unwrap_or_else(|error| format!("{error:#}")));
            next_look = Instant::now();
        }
        if Instant::now() >= next_look {
            screen.see(lookout.look()?);
            next_look = Instant::now() + LOOK_EVERY;
        }
    }
    Ok(())
}

/// What came of a wish, in words.
fn fulfil(lookout: &mut Lookout, screen: &Screen, wish: Wish) -> anyhow::Result<String> {
    let (arena, command) = match wish {
        Wish::Quit => return Ok(String::new()),
        Wish::Reset(arena) => (arena, Command::Reset { scope: Scope::All, seed: None }),
        Wish::PauseOrResume(arena) => {
            let is_playing = screen.chosen().is_some_and(|sight| sight.row.state == RunState::Playing);
            (arena, if is_playing { Command::Pause {} } else { Command::Resume {} })
        }
    };
    let Some(client) = lookout.client_of(&arena)? else { bail!("{arena} is no arena's name") };
    let reply = client.command(&command)?;
    Ok(if reply.ok { format!("{arena}: done at tick {}", reply.tick) } else { reply.error })
}
