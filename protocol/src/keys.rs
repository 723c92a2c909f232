//! The names under which everything travels: `ballroom/v1/<arena>/…`.
//!
//! | key | who speaks | what |
//! |---|---|---|
//! | `state` | server | a [`Snapshot`](crate::snapshot::Snapshot) each tick, as a binary frame ([`codec`](crate::codec)) |
//! | `event` | server | [`Events`](crate::event::Events), JSON |
//! | `stats` | server | [`Stats`](crate::stats::Stats) once a second, JSON |
//! | `meta/scene` | server | the [`Scene`](crate::scene::Scene) at each start of an epoch, JSON |
//! | `cmd/<player>` | player | one line of JSON, unanswered |
//! | `drive/<player>` | player | [`Drive`](crate::player::Drive): commands for a claimed ball, until they are acknowledged, JSON |
//! | `ack/<player>` | server | [`Ack`](crate::player::Ack): what became of them, JSON |
//! | `srv/command` | anyone, asked | a command in, a [`Reply`](crate::command::Reply) out, JSON |
//! | `srv/snapshot` | anyone, asked | the [`World`](crate::snapshot::World), binary or `?format=json` |
//! | `srv/scene` | anyone, asked | the scene, JSON |
//! | `srv/stats` | anyone, asked | the newest statistics, JSON |
//! | `srv/info` | anyone, asked | frames, units, versions, JSON |
//! | `srv/balls` | anyone, asked | some or all [`Balls`](crate::listing::Balls): `?name=a;name=b`, `?player=true`, `?tag=x`, `?spawned=true`, `?within=x0,y0,x1,y1`, JSON |
//! | `srv/parameters` | anyone, asked | [`Parameters`](crate::parameter::Parameters) of the scene: value, unit, range, whether it may be set, JSON |
//! | `srv/features` | anyone, asked | [`Features`](crate::listing::Features): what is supported, with limits, JSON |
//! | `srv/scenes` | anyone, asked | [`Scenes`](crate::listing::Scenes) that come with the program, JSON |
//! | `srv/claim` | anyone, asked | a [`Claim`](crate::player::Claim) in, [`Claimed`](crate::player::Claimed) out, JSON |
//! | `srv/release` | anyone, asked | a [`Release`](crate::player::Release) in, a [`Reply`](crate::command::Reply) out, JSON |
//! | `srv/players` | anyone, asked | who drives which ball: [`Players`](crate::player::Players), JSON |
//! | `srv/slots` | anyone, asked | the [`Timeline`](crate::timeline::Timeline): how far a rewind reaches, and the slots, JSON |
//! | `srv/checkpoint` | anyone, asked | the present state or `?slot=a` as a [`SavedState`](crate::timeline::SavedState), JSON |
//! | `srv/state` | anyone, asked | the [`State`](crate::state::State) of the clock, JSON |
//! | `srv/check` | anyone, asked | a scene as TOML in, a [`Check`](crate::check::Check) out, JSON |
//! | `srv/clients` | anyone, asked | [`Clients`](crate::report::Clients): who reads, and how states reach them, JSON |
//! | `report/<role>/<id>` | who reads states | a [`Report`](crate::report::Report) once a second, JSON |
//! | `alive/<role>/<id>` | each for itself | a liveliness token while it lives |
//!
//! What the server publishes carries a [`Stamp`](crate::report::Stamp) as its attachment: a number and a wall time.
//! What a process with several arenas is asked has keys of its own: [`arenas`](crate::arenas).
//!
//! The chunk `v1` changes when old and new can no longer understand each other.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Longest [`Name`], bytes.
pub const MAX_NAME_BYTES: usize = 32;

/// The arena when nobody names one.
pub const DEFAULT_ARENA: &str = "main";

/// A chunk of a key: 1 to 32 of `a-z`, `0-9`, `_` and `-`, so that no name can smuggle in a wildcard or a slash.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Name(String);

/// Why a text is no [`Name`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the name {given:?} is not 1 to 32 of a-z, 0-9, _ and -")]
pub struct BadName {
    /// What was given, cut at 64 bytes.
    given: String,
}

impl Name {
    /// The text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl FromStr for Name {
    type Err = BadName;

    fn from_str(text: &str) -> Result<Self, BadName> {
        let allowed = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_' || b == b'-';
        if (1..=MAX_NAME_BYTES).contains(&text.len()) && text.bytes().all(allowed) {
            Ok(Self(text.to_owned()))
        } else {
            Err(BadName { given: text.chars().take(64).collect() })
        }
    }
}

impl TryFrom<String> for Name {
    type Error = BadName;

    fn try_from(text: String) -> Result<Self, BadName> {
        text.parse()
    }
}

impl From<Name> for String {
    fn from(name: Name) -> Self {
        name.0
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.0)
    }
}

/// Who holds a liveliness token, or tells how it reads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// An arena; its id is the server's instance.
    Server,
    /// Someone who looks.
    Viewer,
    /// Someone who steers.
    Player,
    /// A program of the command line, or of one's own.
    #[default]
    Tool,
    /// A script in Python.
    Script,
}

impl Role {
    /// Everyone who may read.
    pub const READERS: [Self; 4] = [Self::Viewer, Self::Player, Self::Tool, Self::Script];

    /// Its name in keys.
    pub const fn chunk(self) -> &'static str {
        match self {
            Self::Server => "server",
            Self::Viewer => "viewer",
            Self::Player => "player",
            Self::Tool => "tool",
            Self::Script => "script",
        }
    }
}

/// All keys of one arena.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Keys {
    prefix: String,
}

impl Keys {
    /// The keys of `arena`.
    pub fn new(arena: &Name) -> Self {
        Self { prefix: format!("ballroom/v1/{arena}") }
    }

    /// States, one a tick. One that no other follows is said once more a tenth of a second later, under the same stamp, for
    /// links that were busy.
    pub fn state(&self) -> String {
        self.under("state")
    }

    /// Hits.
    pub fn event(&self) -> String {
        self.under("event")
    }

    /// Statistics.
    pub fn stats(&self) -> String {
        self.under("stats")
    }

    /// The scene, published at each start of an epoch.
    pub fn meta_scene(&self) -> String {
        self.under("meta/scene")
    }

    /// One player's unanswered commands.
    pub fn cmd(&self, player: &Name) -> String {
        self.under(&format!("cmd/{player}"))
    }

    /// All players' unanswered commands.
    pub fn cmd_of_anyone(&self) -> String {
        self.under("cmd/*")
    }

    /// Whose command arrived under `key`, if it is one of this arena's.
    pub fn player_of(&self, key: &str) -> Option<Name> {
        key.strip_prefix(&self.prefix)?.strip_prefix("/cmd/")?.parse().ok()
    }

    /// One player's commands for a claimed ball.
    pub fn drive(&self, player: &Name) -> String {
        self.under(&format!("drive/{player}"))
    }

    /// All players' commands for claimed balls.
    pub fn drive_of_anyone(&self) -> String {
        self.under("drive/*")
    }

    /// Who drives by the message that arrived under `key`, if it is one of this arena's.
    pub fn driver_of(&self, key: &str) -> Option<Name> {
        key.strip_prefix(&self.prefix)?.strip_prefix("/drive/")?.parse().ok()
    }

    /// What became of one player's commands.
    pub fn ack(&self, player: &Name) -> String {
        self.under(&format!("ack/{player}"))
    }

    /// Asks for a ball.
    pub fn srv_claim(&self) -> String {
        self.under("srv/claim")
    }

    /// Gives a ball back.
    pub fn srv_release(&self) -> String {
        self.under("srv/release")
    }

    /// Who drives which ball.
    pub fn srv_players(&self) -> String {
        self.under("srv/players")
    }

    /// Commands that are answered.
    pub fn srv_command(&self) -> String {
        self.under("srv/command")
    }

    /// The world for late joiners.
    pub fn srv_snapshot(&self) -> String {
        self.under("srv/snapshot")
    }

    /// The scene, asked for.
    pub fn srv_scene(&self) -> String {
        self.under("srv/scene")
    }

    /// The newest statistics, asked for.
    pub fn srv_stats(&self) -> String {
        self.under("srv/stats")
    }

    /// Frames, units, versions.
    pub fn srv_info(&self) -> String {
        self.under("srv/info")
    }

    /// Some or all balls.
    pub fn srv_balls(&self) -> String {
        self.under("srv/balls")
    }

    /// Numbers of the scene.
    pub fn srv_parameters(&self) -> String {
        self.under("srv/parameters")
    }

    /// What is supported.
    pub fn srv_features(&self) -> String {
        self.under("srv/features")
    }

    /// The scenes that come with the program.
    pub fn srv_scenes(&self) -> String {
        self.under("srv/scenes")
    }

    /// What can be gone back to.
    pub fn srv_slots(&self) -> String {
        self.under("srv/slots")
    }

    /// A state as a file.
    pub fn srv_checkpoint(&self) -> String {
        self.under("srv/checkpoint")
    }

    /// What the clock does.
    pub fn srv_state(&self) -> String {
        self.under("srv/state")
    }

    /// Whether a scene could be run.
    pub fn srv_check(&self) -> String {
        self.under("srv/check")
    }

    /// Who reads the states.
    pub fn srv_clients(&self) -> String {
        self.under("srv/clients")
    }

    /// What one reader says.
    pub fn report(&self, role: Role, id: &Name) -> String {
        self.under(&format!("report/{}/{id}", role.chunk()))
    }

    /// What all readers say.
    pub fn report_of_anyone(&self) -> String {
        self.under("report/*/*")
    }

    /// Whose report arrived under `key`, if it is one of this arena's.
    pub fn reader_of(&self, key: &str) -> Option<(Role, Name)> {
        let (role, id) = key.strip_prefix(&self.prefix)?.strip_prefix("/report/")?.split_once('/')?;
        let role = Role::READERS.into_iter().find(|known| known.chunk() == role)?;
        Some((role, id.parse().ok()?))
    }

    /// One token.
    pub fn alive(&self, role: Role, id: &Name) -> String {
        self.under(&format!("alive/{}/{id}", role.chunk()))
    }

    /// All tokens of a role.
    pub fn alive_all(&self, role: Role) -> String {
        self.under(&format!("alive/{}/*", role.chunk()))
    }

    fn under(&self, rest: &str) -> String {
        format!("{}/{rest}", self.prefix)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_admit_no_wildcard_slash_or_emptiness() {
        for good in ["main", "a", "player-1_x", &"z".repeat(32)] {
            assert_eq!(good.parse::<Name>().unwrap().as_str(), good);
        }
        for bad in ["", "*", "a/b", "A", "é", "a b", "$x", &"z".repeat(33)] {
            assert!(bad.parse::<Name>().is_err(), "{bad:?}");
        }
    }

    #[test]
    fn a_player_is_read_back_from_its_key() {
        let keys = Keys::new(&"main".parse().unwrap());
        let player: Name = "p1".parse().unwrap();
        assert_eq!(keys.cmd(&player), "ballroom/v1/main/cmd/p1");
        assert_eq!(keys.player_of(&keys.cmd(&player)), Some(player));
        assert_eq!(keys.player_of("ballroom/v1/other/cmd/p1"), None);
        assert_eq!(keys.driver_of("ballroom/v1/main/drive/p1"), Some("p1".parse().unwrap()));
        assert_eq!(keys.driver_of("ballroom/v1/main/cmd/p1"), None);
        assert_eq!(keys.player_of("ballroom/v1/main/cmd/p1/x"), None);
        let reader = (Role::Viewer, "v-1".parse().unwrap());
        assert_eq!(keys.reader_of(&keys.report(reader.0, &reader.1)), Some(reader));
        for none in
            ["main/report/server/v1", "main/report/viewer/v1/x", "other/report/viewer/v1", "main/report/x/v1"]
        {
            assert_eq!(keys.reader_of(&format!("ballroom/v1/{none}")), None);
        }
    }
}
