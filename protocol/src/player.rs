//! Players: who drives which ball, and what they say while they do.
//!
//! A player asks `srv/claim` for a ball and is given a secret [`Token`]. From then on nobody else steers that ball. The
//! player sends [`Drive`] messages on `drive/<player>`, each with **all** commands that are not acknowledged yet, so that
//! a lost, late, repeated or overtaken message needs no remedy: the next one says it all. The server does each command
//! once, in the order of its numbers, and publishes an [`Ack`] on `ack/<player>` for every message. A message without
//! commands says that the player is there. Who says nothing for [`LEASE_MILLIS`], goes, or asks `srv/release` loses the
//! ball; a force that is held ends then, and what still waits is refused.
//!
//! A **wanted tick** is one of the epoch that is named with it, else of the present one. A command acts at that tick, or
//! at the next tick boundary when it is past, and never before the one sent before it. When its epoch is over before its
//! tick has come it acts at the next boundary.
//!
//! Whoever may subscribe to `drive/*` can read tokens: where players do not trust each other, Zenoh's access control
//! keeps that key for the server.

use crate::codec::MAX_BALL_NAME_BYTES;
use crate::command::{CommandFault, Direction, Reply, SteerMode};
use crate::keys::Name;
use crate::snapshot::Collisions;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Most players of an arena who hold a ball.
pub const MAX_PLAYERS: usize = 64;
/// Most commands of one player that are not acknowledged yet.
pub const MAX_WINDOW: usize = 64;
/// How long a player may be silent, wall milliseconds.
pub const LEASE_MILLIS: u64 = 2000;
/// How far ahead of the present a wanted tick may be.
pub const MAX_TICKS_AHEAD: u64 = 1000;
/// Longest [`Drive`], bytes: a full window of the longest commands has less than 12 KiB.
pub const MAX_DRIVE_BYTES: usize = 16 << 10;
/// Longest [`Claim`] and [`Release`], bytes.
pub const MAX_CLAIM_BYTES: usize = 512;
/// Largest number of a message or of a command: readers of JSON keep it exactly.
const MAX_NUMBER: u64 = 1 << 53;
/// Digits of a token.
const TOKEN_DIGITS: usize = 32;

/// What proves that a player holds a ball: 128 random bits as 32 hexadecimal digits. It is written in no log.
#[derive(Clone, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Token(String);

impl Token {
    /// Of random bits.
    pub fn from_bits(bits: u128) -> Self {
        Self(format!("{bits:0TOKEN_DIGITS$x}"))
    }

    /// Its digits, to be compared without telling how many are right.
    pub const fn as_bytes(&self) -> &[u8] {
        self.0.as_bytes()
    }
}

impl TryFrom<String> for Token {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        if text.len() == TOKEN_DIGITS && text.bytes().all(|b| b.is_ascii_hexdigit()) {
            Ok(Self(text))
        } else {
            Err(format!("a token has {TOKEN_DIGITS} hexadecimal digits"))
        }
    }
}

impl From<Token> for String {
    fn from(token: Token) -> Self {
        token.0
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token(…)")
    }
}

/// Asks for a ball.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Who.
    pub player: Name,
    /// Which; the first free one of the players' balls when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ball: Option<String>,
}

/// Gives a ball back.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Release {
    /// Who.
    pub player: Name,
    /// As it was given.
    pub token: Token,
}

/// The answer to a [`Claim`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Claimed {
    /// From which tick on, or why not.
    #[serde(flatten)]
    pub reply: Reply,
    /// What was given; absent when refused.
    #[serde(flatten, default, skip_serializing_if = "Option::is_none")]
    pub grant: Option<Grant>,
}

/// A ball that is a player's.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Grant {
    /// Who.
    pub player: Name,
    /// Which ball.
    pub ball: String,
    /// Number of this claim in the arena.
    pub claim: u64,
    /// The secret.
    pub token: Token,
    /// How long the player may be silent.
    pub lease_s: f64,
}

/// What a player says again and again.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// As it was given.
    pub token: Token,
    /// Number of the message, from 1 on, so that lost ones can be counted; 0 when not counted.
    #[serde(default)]
    pub number: u64,
    /// The last command up to which all acknowledgements have come.
    #[serde(default)]
    pub acked: u64,
    /// From a command to its acknowledgement, as the player measured last.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latency_ms: Option<f64>,
    /// All commands after `acked`, in order, at most [`MAX_WINDOW`].
    #[serde(default)]
    pub sent: Vec<Sent>,
}

/// A command of a player.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sent {
    /// Its number, from 1 on without gaps.
    pub seq: u64,
    /// Wanted tick; the next boundary when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tick: Option<u64>,
    /// Epoch of the wanted tick; the present one when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epoch: Option<u64>,
    /// Where to.
    pub direction: Direction,
    /// Once, or until told otherwise.
    #[serde(default)]
    pub mode: SteerMode,
}

/// What the server knows of a player's commands.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ack {
    /// Number of the claim it belongs to.
    pub claim: u64,
    /// Number of the newest message that has come.
    pub heard: u64,
    /// Number of the command that is expected next; all before it have come.
    pub next_seq: u64,
    /// What became of those that the player does not know of yet, in order; one that waits for its tick is missing.
    pub acted: Vec<Acted>,
    /// Why the ball is no longer the player's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ended: Option<String>,
}

/// What became of one command.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Acted {
    /// Which.
    pub seq: u64,
    /// Tick at which it acted; 0 when it was refused before it came to one.
    pub tick: u64,
    /// Epoch of that tick.
    pub epoch: u64,
    /// One of [`code`](crate::reply::code): done, or why not.
    pub code: u16,
    /// Why not; empty when done.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub error: String,
}

impl Acted {
    /// The reply to command `seq`.
    pub fn of(seq: u64, reply: &Reply) -> Self {
        let Reply { tick, epoch, code, ref error, .. } = *reply;
        Self { seq, tick, epoch, code, error: error.clone() }
    }

    /// Whether it was done.
    pub const fn is_done(&self) -> bool {
        self.code == crate::reply::code::OK
    }
}

/// Who plays, in the order of their names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Players {
    /// One by one.
    pub players: Vec<PlayerRow>,
}

/// One who plays. Messages are those of the present claim.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlayerRow {
    /// Who.
    pub player: Name,
    /// Which ball.
    pub ball: String,
    /// Number of the claim.
    pub claim: u64,
    /// Hits of the ball since it was claimed.
    pub hits: Collisions,
    /// Place by hits with other balls, most first, from 1 on; equals share a place.
    pub rank: usize,
    /// Commands that have come.
    pub commands: u64,
    /// Those of them that were refused.
    pub refused: u64,
    /// Those of them that wait for their tick.
    pub waiting: usize,
    /// Messages that have come.
    pub messages: u64,
    /// Messages that are missing between those that have come.
    pub lost: u64,
    /// Messages that have come again.
    pub repeated: u64,
    /// From a command to its acknowledgement, as the player measured last.
    pub latency_ms: Option<f64>,
    /// Wall time since the last message, to a tenth of a second.
    pub silent_s: f64,
}

impl Claim {
    /// Reads and checks one from JSON.
    pub fn from_json(bytes: &[u8]) -> Result<Self, CommandFault> {
        let claim: Self = read(bytes, MAX_CLAIM_BYTES, r#"{"player":"ann","ball":"red"}"#)?;
        claim.check()?;
        Ok(claim)
    }

    /// Whether it makes sense.
    pub fn check(&self) -> Result<(), CommandFault> {
        match &self.ball {
            Some(ball) if ball.is_empty() || ball.len() > MAX_BALL_NAME_BYTES => {
                Err(CommandFault::new("ball is a name of 1 to 64 bytes"))
            }
            _ => Ok(()),
        }
    }
}

impl Release {
    /// Reads one from JSON.
    pub fn from_json(bytes: &[u8]) -> Result<Self, CommandFault> {
        read(bytes, MAX_CLAIM_BYTES, r#"{"player":"ann","token":"…"}"#)
    }
}

impl Drive {
    /// Reads and checks one from JSON.
    pub fn from_json(bytes: &[u8]) -> Result<Self, CommandFault> {
        let drive: Self = read(
            bytes,
            MAX_DRIVE_BYTES,
            r#"{"token":"…","number":1,"acked":0,"sent":[{"seq":1,"direction":"up"}]}"#,
        )?;
        drive.check()?;
        Ok(drive)
    }

    /// Whether its numbers make sense.
    pub fn check(&self) -> Result<(), CommandFault> {
        let fault = |why: String| Err(CommandFault::new(why));
        if self.sent.len() > MAX_WINDOW {
            return fault(format!("{} commands are sent at once: use at most {MAX_WINDOW}", self.sent.len()));
        }
        if self.number > MAX_NUMBER || self.acked > MAX_NUMBER {
            return fault(format!("number and acked are 0 to {MAX_NUMBER}"));
        }
        if self.latency_ms.is_some_and(|latency| !(0.0..=1e9).contains(&latency)) {
            return fault("latency_ms is 0 to 1e9".into());
        }
        if let Some(sent) = self.sent.iter().find(|sent| !(1..=MAX_NUMBER).contains(&sent.seq)) {
            return fault(format!("seq is {}: use 1 to {MAX_NUMBER}", sent.seq));
        }
        if let Some(pair) = self.sent.windows(2).find(|pair| pair[1].seq != pair[0].seq + 1) {
            return fault(format!("seq {} follows seq {}: leave none out", pair[1].seq, pair[0].seq));
        }
        if let Some(sent) = self.sent.iter().find(|sent| sent.epoch.is_some() && sent.tick.is_none()) {
            return fault(format!("seq {} names an epoch without a tick", sent.seq));
        }
        self.sent.iter().try_for_each(|sent| sent.direction.check())
    }
}

fn read<T: for<'a> Deserialize<'a>>(bytes: &[u8], limit: usize, example: &str) -> Result<T, CommandFault> {
    if bytes.len() > limit {
        return Err(CommandFault::new(format!("{} bytes are too many: at most {limit}", bytes.len())));
    }
    serde_json::from_slice(bytes).map_err(|e| CommandFault::new(format!("{e}; write for instance {example}")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::DirectionName;

    const TOKEN: &str = "00112233445566778899aabbccddeeff";

    fn drive(rest: &str) -> Result<Drive, CommandFault> {
        Drive::from_json(format!(r#"{{"token":"{TOKEN}"{rest}}}"#).as_bytes())
    }

    #[test]
    fn a_drive_message_survives_json_and_a_full_window_of_the_longest_commands_fits() {
        let long = Sent {
            seq: MAX_NUMBER - MAX_WINDOW as u64,
            tick: Some(u64::MAX),
            epoch: Some(u64::MAX),
            direction: Direction::Vector([-0.707_106_781_186_547_5, -1.234_567_890_123_456_7e-300]),
            mode: SteerMode::Impulse,
        };
        let sent = (0..MAX_WINDOW as u64).map(|i| Sent { seq: long.seq + i, ..long.clone() });
        let full = Drive {
            token: Token::from_bits(u128::MAX),
            number: MAX_NUMBER,
            acked: MAX_NUMBER,
            latency_ms: Some(1.234_567_890_123_456_7e-300),
            sent: sent.collect(),
        };
        let bytes = serde_json::to_vec(&full).unwrap();
        assert!(bytes.len() < 12 << 10, "{} bytes", bytes.len());
        let back = Drive::from_json(&bytes).unwrap();
        assert_eq!((back.sent, back.token.as_bytes()), (full.sent, full.token.as_bytes()));

        let short = drive(r#","sent":[{"seq":7,"direction":"up"}]"#).unwrap();
        let up = Direction::Named(DirectionName::Up);
        let sent = Sent { seq: 7, tick: None, epoch: None, direction: up, mode: SteerMode::Impulse };
        assert_eq!((short.number, short.acked, short.sent), (0, 0, vec![sent]));
        assert!(drive("").unwrap().sent.is_empty());
    }

    #[test]
    fn a_drive_message_that_makes_no_sense_is_refused() {
        for rest in [
            r#","speed":1"#,
            r#","number":-1"#,
            r#","number":18446744073709551615"#,
            r#","latency_ms":-1"#,
            r#","latency_ms":1e999"#,
            r#","sent":[{"seq":0,"direction":"up"}]"#,
            r#","sent":[{"seq":1}]"#,
            r#","sent":[{"seq":1,"direction":[2,0]}]"#,
            r#","sent":[{"seq":1,"direction":"up","ball":"red"}]"#,
            r#","sent":[{"seq":1,"direction":"up","epoch":3}]"#,
            r#","sent":[{"seq":1,"direction":"up"},{"seq":3,"direction":"up"}]"#,
            r#","sent":[{"seq":2,"direction":"up"},{"seq":1,"direction":"up"}]"#,
        ] {
            assert!(drive(rest).is_err(), "{rest}");
        }
        let many: Vec<String> = (1..=65).map(|i| format!(r#"{{"seq":{i},"direction":"up"}}"#)).collect();
        assert!(drive(&format!(r#","sent":[{}]"#, many.join(","))).is_err());
        assert!(drive(&" ".repeat(MAX_DRIVE_BYTES)).is_err());
        for token in ["", "0011", &"g".repeat(32)] {
            assert!(Drive::from_json(format!(r#"{{"token":"{token}"}}"#).as_bytes()).is_err(), "{token}");
        }
    }

    #[test]
    fn a_claim_names_a_player_and_at_most_one_ball() {
        let claim = Claim::from_json(br#"{"player":"ann","ball":"red"}"#).unwrap();
        assert_eq!((claim.player.as_str(), claim.ball.as_deref()), ("ann", Some("red")));
        for bad in [r#"{"player":"Ann"}"#, r#"{"player":"a/b"}"#, r#"{"player":"ann","ball":""}"#, "{}", "[]"]
        {
            assert!(Claim::from_json(bad.as_bytes()).is_err(), "{bad}");
        }
    }

    #[test]
    fn no_log_shows_a_token() {
        let release = Release { player: "ann".parse().unwrap(), token: Token::from_bits(7) };
        let said = format!("{release:?}");
        assert!(said.contains("ann") && !said.contains("00000"), "{said}");
    }

    #[test]
    fn an_answer_holds_the_grant_or_the_reason() {
        let grant = Grant {
            player: "ann".parse().unwrap(),
            ball: "red".into(),
            claim: 3,
            token: Token::from_bits(1),
            lease_s: 2.0,
        };
        let yes = Claimed { reply: Reply::of(Ok(()), 9, 8), grant: Some(grant) };
        let text = serde_json::to_string(&yes).unwrap();
        assert!(text.contains(r#""ok":true"#) && text.contains(r#""ball":"red""#), "{text}");
        assert_eq!(serde_json::from_str::<Claimed>(&text).unwrap().grant.unwrap().claim, 3);
        let no = Claimed { reply: crate::reply::Refusal::new(4, "taken").into(), grant: None };
        let text = serde_json::to_string(&no).unwrap();
        assert_eq!(text, r#"{"ok":false,"code":4,"tick":0,"epoch":0,"error":"taken"}"#);
        assert!(serde_json::from_str::<Claimed>(&text).unwrap().grant.is_none());
    }
}
