//! Lists for whoever asks: balls, scenes, features.

use crate::snapshot::{Roster, Snapshot, World};
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
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// By name, any of these.
    pub names: Vec<String>,
    /// Whether a player may steer it.
    pub player: Option<bool>,
    /// Centre within x0, y0, x1, y1, m.
    pub within_m: Option<[f64; 4]>,
}

impl Selection {
    /// From the words behind a key: `name=a;name=b;player=true;within=x0,y0,x1,y1`, parted by `;` or `&`.
    pub fn parse(words: &str) -> Result<Self, String> {
        let mut selection = Self::default();
        for word in words.split([';', '&']).filter(|word| !word.is_empty()) {
            match word.split_once('=').unwrap_or((word, "")) {
                ("name", name) => selection.names.push(name.to_owned()),
                ("player", "true") => selection.player = Some(true),
                ("player", "false") => selection.player = Some(false),
                ("within", corners) => selection.within_m = Some(rectangle(corners)?),
                _ => {
                    return Err(format!(
                        "{word:?} is unknown: use name=NAME, player=true or within=X0,Y0,X1,Y1"
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
        names.chain(player).chain(within).collect::<Vec<_>>().join(";")
    }

    fn takes(&self, roster: &Roster, state: &Snapshot, i: usize) -> bool {
        let [x, y, _] = state.center_m[i];
        (self.names.is_empty() || self.names.contains(&roster.names[i]))
            && self.player.is_none_or(|player| roster.player[i] == player)
            && self.within_m.is_none_or(|[x0, y0, x1, y1]| (x0..=x1).contains(&x) && (y0..=y1).contains(&y))
    }

    /// The balls of a world that it means.
    pub fn of(&self, World { roster, snapshot: state, .. }: &World) -> Balls {
        let meant: Vec<usize> = (0..roster.names.len().min(state.center_m.len()))
            .filter(|&i| self.takes(roster, state, i))
            .collect();
        let shown = &meant[..meant.len().min(MAX_ROWS)];
        let row = |&i: &usize| BallRow {
            name: roster.names[i].clone(),
            player: roster.player[i],
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
            within_m: Some([-1.0, -2.5, 3.0, 4.0]),
        };
        assert_eq!(Selection::parse(&selection.words()), Ok(selection.clone()));
        assert_eq!(Selection::parse(&selection.words().replace(';', "&")), Ok(selection));
        assert_eq!(Selection::parse(""), Ok(Selection::default()));
        for bad in ["colour=red", "player=maybe", "within=1,2,3", "within=3,0,1,1", "within=0,0,nan,1"] {
            assert!(Selection::parse(bad).is_err(), "{bad}");
        }
    }
}
