//! Players over real sessions and in real terminals.

use super::PATIENCE;
use super::serving::Serving;
use super::terminal::Terminal;
use ballroom_client::{Client, ClientError, Driver};
use protocol::command::{Command, Direction, DirectionName, SteerMode, code};
use protocol::player::{Drive, PlayerRow, Token};
use std::time::{Duration, Instant};
use zenoh::Wait;

/// A level table without friction at the walls, and two players' balls that only commands move.
pub const TWO: &str = r#"
version = 1
name = "two"
floor.polynomial = { x_m = [-9.0, 9.0], y_m = [-9.0, 9.0] }
ball = [
  { name = "red", radius_m = 0.5, mass_kg = 1.0, center_m = [3.0, 0.0], player = true },
  { name = "blue", radius_m = 0.5, mass_kg = 1.0, center_m = [-3.0, 0.0], player = true },
]
"#;

const UP: Direction = Direction::Named(DirectionName::Up);

/// A served table with more arguments.
pub fn serve_two(arguments: &[&str]) -> Serving {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("two.toml");
    std::fs::write(&file, TWO).unwrap();
    Serving::start(&[&[file.to_str().unwrap()], arguments].concat())
}

fn claim(client: &Client, player: &str, ball: &str) -> Result<Driver, String> {
    client.claim(&player.parse().unwrap(), Some(ball)).map_err(|error| match error {
        ClientError::Refused { why, .. } => why,
        other => panic!("{other}"),
    })
}

pub fn until<T>(what: &str, mut probe: impl FnMut() -> Option<T>) -> T {
    let deadline = Instant::now() + PATIENCE;
    loop {
        if let Some(found) = probe() {
            return found;
        }
        assert!(Instant::now() < deadline, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Waits until a ball is free, and claims it.
fn claim_when_free(client: &Client, player: &str, ball: &str) -> Driver {
    until("a free ball", || claim(client, player, ball).ok())
}

pub fn row(client: &Client, player: &str) -> Option<PlayerRow> {
    client.players().unwrap().players.into_iter().find(|row| row.player.as_str() == player)
}

fn velocity(client: &Client, ball: &str) -> [f64; 3] {
    let world = client.snapshot().unwrap();
    let ball = world.roster.names.iter().position(|name| name == ball).unwrap();
    world.snapshot.velocity_m_per_s[ball]
}

#[test]
fn a_claimed_ball_is_driven_by_its_player_and_by_nobody_else() {
    let server = serve_two(&["--paused"]);
    let (ann, bob) = (server.client(), server.client());
    let red = claim(&ann, "ann", "red").unwrap();
    assert_eq!(claim(&bob, "bob", "red").err().unwrap(), "\"red\" is driven by ann");
    let blue = bob.claim(&"bob".parse().unwrap(), None).unwrap();
    assert_eq!((red.ball(), blue.ball()), ("red", "blue"));

    // From the shell, by name and without.
    for arguments in [&["steer", "down", "--ball", "red"][..], &["steer", "down"]] {
        let reply = server.json(4, arguments);
        assert_eq!(reply["code"], code::INCORRECT_STATE, "{reply}");
        assert_eq!(reply["error"], "\"red\" is driven by ann");
    }
    // An unanswered press, under her own name too; with a token of one's own making.
    let refused = ann.stats().unwrap().commands_refused;
    for player in ["bob", "ann"] {
        let press = Command::Steer { ball: None, direction: UP, mode: SteerMode::Impulse };
        bob.press(&player.parse().unwrap(), &press).unwrap();
    }
    let forged = Drive { token: Token::from_bits(1), number: 1, acked: 0, latency_ms: None, sent: vec![] };
    bob.session()
        .put(bob.keys().drive(&"ann".parse().unwrap()), serde_json::to_vec(&forged).unwrap())
        .wait()
        .unwrap();
    until("the refusals", || (ann.stats().unwrap().commands_refused >= refused + 3).then_some(()));
    assert_eq!(velocity(&ann, "red"), [0.0; 3]);

    assert_eq!(red.drive(UP, SteerMode::Impulse), Ok(1));
    assert!(red.settle(PATIENCE));
    let acted = red.acked();
    assert_eq!((acted.len(), acted[0].seq, acted[0].tick, acted[0].is_done()), (1, 1, 0, true));
    assert!(velocity(&ann, "red")[1] > 0.0);
    assert_eq!(velocity(&ann, "blue"), [0.0; 3]);
    let listed = server.json(0, &["players"]);
    assert_eq!(
        (&listed["players"][0]["player"], &listed["players"][0]["ball"]),
        (&"ann".into(), &"red".into())
    );
    let plain = server.tool(&["players"]);
    assert!(plain.stdout.contains("bob              drives blue"), "{}", plain.stdout);

    // Given back, it is open to scripts again.
    red.release();
    assert_eq!(server.json(0, &["steer", "down", "--ball", "red"])["code"], code::OK);
    assert!(row(&bob, "ann").is_none() && row(&bob, "bob").is_some());
}

#[test]
fn a_wanted_tick_is_kept_while_stepping_and_ends_with_its_epoch() {
    let server = serve_two(&["--paused"]);
    let client = server.client();
    let epoch = client.snapshot().unwrap().snapshot.epoch;
    let red = claim(&client, "ann", "red").unwrap();
    let at = |tick| ballroom_client::Wanted::at(epoch, tick);
    for tick in [50, 30, 70, 900] {
        red.drive_at(at(tick), UP, SteerMode::Impulse).unwrap();
    }
    until("them to wait", || row(&client, "ann").filter(|row| row.waiting == 4));
    assert!(client.command(&Command::Step { ticks: 100 }).unwrap().ok);
    let mut acted = until("three acknowledgements", || (red.waiting() == 1).then(|| red.acked()));
    let reset = client.command(&Command::Reset { scope: protocol::command::Scope::All, seed: None }).unwrap();
    assert!(red.settle(PATIENCE));
    acted.extend(red.acked());
    let acted: Vec<_> = acted.iter().map(|acted| (acted.seq, acted.epoch, acted.tick)).collect();
    assert_eq!(acted, [(1, epoch, 50), (2, epoch, 50), (3, epoch, 70), (4, reset.epoch, 0)]);
}

#[test]
fn a_pad_in_a_terminal_shows_what_it_does_and_leaves_the_terminal_as_it_was() {
    let server = serve_two(&[]);
    let client = server.client();
    let mut pad = Terminal::start(&["play", "red", "--player", "ann", "-e", server.endpoint()]);
    pad.shows("red of arena main, driven by ann");
    pad.shows("rank         1 of 1");
    pad.press("\u{1b}[A");
    until("the push", || (velocity(&client, "red")[1] > 0.0).then_some(()));
    pad.finds("a latency", |written| written.contains(" ms from key to sight").then_some(()));
    assert!(server.json(4, &["steer", "up", "--ball", "red"])["error"].as_str().unwrap().contains("ann"));
    pad.press("q");
    let (code, terminal) = pad.end();
    assert_eq!(code, 0, "{terminal}");
    assert!(terminal.contains(" icanon") && terminal.contains(" echo "), "{terminal}");
    until("the ball to be free", || row(&client, "ann").is_none().then_some(()));
}

#[test]
fn a_killed_player_frees_its_ball() {
    let server = serve_two(&[]);
    let client = server.client();
    let pad = Terminal::start(&["play", "red", "--player", "ann", "-e", server.endpoint()]);
    pad.shows("driven by ann");
    assert_eq!(claim(&client, "bob", "red").err().unwrap(), "\"red\" is driven by ann");
    pad.signal("-KILL");
    assert_eq!(claim_when_free(&client, "bob", "red").ball(), "red");
}

#[test]
fn a_stopped_player_loses_its_ball_and_cannot_drive_on() {
    let server = serve_two(&[]);
    let client = server.client();
    let mut pad = Terminal::start(&["play", "red", "--player", "ann", "-e", server.endpoint()]);
    pad.shows("driven by ann");
    pad.signal("-STOP");
    let red = claim_when_free(&client, "bob", "red");
    // It is typed while it sleeps, and sent when it wakes, with the token of old.
    pad.press("\u{1b}[A\u{1b}[A\u{1b}[A");
    pad.signal("-CONT");
    pad.finds("the loss", |written| written.contains("the ball is lost").then_some(()));
    assert_eq!(pad.end().0, 1);
    assert_eq!((velocity(&client, "red"), red.lost()), ([0.0; 3], None));
}

#[test]
fn without_a_terminal_the_pad_says_so() {
    let server = serve_two(&["--paused"]);
    let output = server.tool(&["play"]);
    assert!(output.code == 1 && output.stderr.contains("play needs a terminal"), "{}", output.stderr);
    assert!(server.client().players().unwrap().players.is_empty());
}
