//! Lists for whoever asks: balls, scenes, features.

use crate::snapshot::{Roster, World};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Most balls of one answer; the rest is counted.
pub const MAX_ROWS: usize = 4096;

/// Balls of one tick, in the order of their names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Balls {
    /// Epoch of the tick.
    pub epoch: u64,
    /// Which tick.
    pub tick: u64,
    /// Simulated time.
    pub time_s: f64,
    /// Those that were asked for.
    pub balls: Vec<BallRow>,
    /// How many more there are that were asked for.
    pub left_out: usize,
}

/// One ball at one tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BallRow {
    /// Its name.
    pub name: String,
    /// Whether a player may steer it.
    pub player: bool,
    /// What it may be selected by.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tags: Vec<String>,
    /// Whether it was spawned, and is not of the scene.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub spawned: bool,
    /// Radius.
    pub radius_m: f64,
    /// Mass.
    pub mass_kg: f64,
    /// Red, green, blue.
    pub color_rgb: [u8; 3],
    /// Parameters of the touching point.
    pub uv: [f64; 2],
    /// Centre.
    pub center_m: [f64; 3],
    /// Velocity of the centre.
    pub velocity_m_per_s: [f64; 3],
    /// Angular velocity.
    pub omega_rad_per_s: [f64; 3],
    /// Orientation, ball to world.
    pub orientation_xyzw: [f64; 4],
}

/// Which balls are asked for: those that meet every condition that is given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Selection {
    /// By name, any of these.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<String>,
    /// Whether a player may steer it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub player: Option<bool>,
    /// By a tag of theirs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tag: Option<String>,
    /// Whether they were spawned.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spawned: Option<bool>,
    /// Centre within x0, y0, x1, y1, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub within_m: Option<[f64; 4]>,
}

impl Selection {
    /// From the words behind a key: `name=a;name=b;player=true;tag=x;spawned=false;within=x0,y0,x1,y1`, parted by `;` or `&`.
    pub fn parse(words: &str) -> Result<Self, String> {
        let mut selection = Self::default();
        for word in words.split([';', '&']).filter(|word| !word.is_empty()) {
            match word.split_once('=').unwrap_or((word, "")) {
                ("name", name) => selection.names.push(name.to_owned()),
                ("player", yes) => selection.player = Some(truth("player", yes)?),
                ("tag", tag) => selection.tag = Some(tag.to_owned()),
                ("spawned", yes) => selection.spawned = Some(truth("spawned", yes)?),
                ("within", corners) => selection.within_m = Some(rectangle(corners)?),
                _ => {
                    return Err(format!(
                        "{word:?} is unknown: use name=NAME, player=true, tag=TAG, spawned=true or within=X0,Y0,X1,Y1"
                    ));
                }
            }
        }
        Ok(selection)
    }

    /// As it stands behind a key.
    pub fn words(&self) -> String {
        let names = self.names.iter().map(|name| format!("name={name}"));
        let player = self.player.map(|player| format!("player={player}"));
        let within = self.within_m.map(|w| format!("within={},{},{},{}", w[0], w[1], w[2], w[3]));
        let tag = self.tag.as_ref().map(|tag| format!("tag={tag}"));
        let spawned = self.spawned.map(|spawned| format!("spawned={spawned}"));
        names.chain(player).chain(tag).chain(spawned).chain(within).collect::<Vec<_>>().join(";")
    }

    /// Places in the roster of the balls that it means, ascending; `center_m` gives x and y of the one at a place.
    pub fn places(&self, roster: &Roster, center_m: impl Fn(usize) -> [f64; 2]) -> Vec<usize> {
        let mut places: Vec<usize> = if self.names.is_empty() {
            (0..roster.names.len()).collect()
        } else {
            self.names.iter().filter_map(|name| roster.place_of(name)).collect()
        };
        places.sort_unstable();
        places.dedup();
        places.retain(|&place| {
            let is_within = |[x0, y0, x1, y1]: [f64; 4]| {
                let [x, y] = center_m(place);
                (x0..=x1).contains(&x) && (y0..=y1).contains(&y)
            };
            self.player.is_none_or(|player| roster.player[place] == player)
                && self.tag.as_ref().is_none_or(|tag| roster.is_tagged(place, tag))
                && self.spawned.is_none_or(|spawned| roster.is_spawned(place) == spawned)
                && self.within_m.is_none_or(is_within)
        });
        places
    }

    /// The balls of a world that it means.
    pub fn of(&self, World { roster, snapshot: state, .. }: &World) -> Balls {
        let meant = self.places(roster, |i| [state.center_m[i][0], state.center_m[i][1]]);
        let shown = &meant[..meant.len().min(MAX_ROWS)];
        let row = |&i: &usize| BallRow {
            name: roster.names[i].clone(),
            player: roster.player[i],
            tags: roster.tags.keys().filter(|tag| roster.is_tagged(i, tag)).cloned().collect(),
            spawned: roster.is_spawned(i),
            radius_m: roster.radius_m[i],
            mass_kg: roster.mass_kg[i],
            color_rgb: roster.color_rgb[i],
            uv: state.uv[i],
            center_m: state.center_m[i],
            velocity_m_per_s: state.velocity_m_per_s[i],
            omega_rad_per_s: state.omega_rad_per_s[i],
            orientation_xyzw: state.orientation_xyzw[i],
        };
        Balls {
            epoch: state.epoch,
            tick: state.tick,
            time_s: state.time_s,
            balls: shown.iter().map(row).collect(),
            left_out: meant.len() - shown.len(),
        }
    }
}

fn truth(what: &str, text: &str) -> Result<bool, String> {
    text.parse().map_err(|_| format!("{what}={text} is neither true nor false"))
}

fn rectangle(text: &str) -> Result<[f64; 4], String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|number| number.trim().parse().ok()).collect();
    match numbers[..] {
        [x0, y0, x1, y1] if x0 <= x1 && y0 <= y1 => Ok([x0, y0, x1, y1]),
        _ => Err(format!("within={text} is no rectangle: use X0,Y0,X1,Y1 in metres, low before high")),
    }
}

/// The scenes that come with the program.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Scenes {
    /// One by one.
    pub scenes: Vec<SceneEntry>,
}

/// One of them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneEntry {
    /// What to load it by.
    pub name: String,
    /// What to look for.
    pub description: String,
}

/// What an arena understands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Features {
    /// The commands, by the word in `cmd`, each with its limits by name.
    pub commands: BTreeMap<String, BTreeMap<String, f64>>,
    /// The questions, by the end of their key, likewise.
    pub questions: BTreeMap<String, BTreeMap<String, f64>>,
    /// What of ROS `simulation_interfaces` a bridge can offer with these: names and numbers of `SimulatorFeatures`.
    #[serde(default)]
    pub ros: BTreeMap<String, u8>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_selection_survives_its_words_and_nonsense_is_refused() {
        let selection = Selection {
            names: vec!["red".into(), "a-1".into()],
            player: Some(false),
            tag: Some("team-a".into()),
            spawned: Some(true),
            within_m: Some([-1.0, -2.5, 3.0, 4.0]),
        };
        assert_eq!(Selection::parse(&selection.words()), Ok(selection.clone()));
        assert_eq!(Selection::parse(&selection.words().replace(';', "&")), Ok(selection));
        assert_eq!(Selection::parse(""), Ok(Selection::default()));
        for bad in
            ["colour=red", "player=maybe", "spawned=2", "within=1,2,3", "within=3,0,1,1", "within=0,0,nan,1"]
        {
            assert!(Selection::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_selection_means_the_balls_that_meet_all_of_it() {
        let roster = Roster {
            names: ["a", "b", "c", "d"].map(String::from).to_vec(),
            player: vec![true, false, false, false],
            tags: [("red".to_owned(), vec![0, 1, 3])].into(),
            spawned: vec![1, 2],
            ..Roster::default()
        };
        let means = |words: &str| {
            let selection = Selection::parse(words).unwrap();
            selection.places(&roster, |place| [place as f64, 0.0])
        };
        assert_eq!(means(""), [0, 1, 2, 3]);
        assert_eq!(means("name=d;name=a;name=d;name=x"), [0, 3]);
        assert_eq!(means("tag=red;player=false"), [1, 3]);
        assert_eq!(means("tag=red;spawned=true"), [1]);
        assert_eq!(means("tag=red;within=1,-1,3,1"), [1, 3]);
        assert_eq!(means("tag=blue"), [0_usize; 0]);
    }
}
