//! The answer to `srv/check`: whether a scene could be run, and what is proved about its floor.

use serde::{Deserialize, Serialize};

/// What came of a check: a fault, or what the scene holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// Whether it could be run.
    pub ok: bool,
    /// Why not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<Fault>,
    /// What it holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<Checked>,
}

/// What is wrong with a scene, and where.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// From 1; none when it is about the file as a whole.
    pub line: Option<usize>,
    /// From 1; likewise.
    pub column: Option<usize>,
    /// The field; empty when it is about no single one.
    pub field: String,
    /// What is wrong, and what would be right.
    pub message: String,
    /// All of it in one line.
    pub text: String,
}

/// A scene that could be run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checked {
    /// Its name.
    pub name: String,
    /// What to look for.
    pub description: String,
    /// How many balls.
    pub balls: usize,
    /// How many of them for players.
    pub players: usize,
    /// How many walls.
    pub walls: usize,
    /// Degrees of the floor in u and v.
    pub degree: [usize; 2],
    /// Energy at the start.
    pub energy_j: f64,
    /// What is proved about the floor.
    pub certificate: Floor,
}

/// Brackets that hold over the whole patch: each true value lies between the two numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Floor {
    /// Steepest slope.
    pub steepest_deg: [f64; 2],
    /// Largest concave curvature.
    pub curvature_per_m: [f64; 2],
    /// Radius below which every ball touches the floor once; none when the floor is nowhere concave.
    pub reach_m: Option<[f64; 2]>,
}

impl From<&crate::scene_text::SceneError> for Check {
    fn from(error: &crate::scene_text::SceneError) -> Self {
        let [line, column] = error.line_column.map_or([None; 2], |place| place.map(Some));
        let (field, message, text) = (error.field.clone(), error.message.clone(), error.to_string());
        Self { ok: false, fault: Some(Fault { line, column, field, message, text }), scene: None }
    }
}
