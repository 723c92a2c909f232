//! Numbers of a scene that may be read, and some of them set while it runs.

use serde::{Deserialize, Serialize};

/// What a parameter is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a value is a number, a list of three numbers or a word")]
pub enum Value {
    /// A number.
    Number(f64),
    /// x, y and z.
    Vector([f64; 3]),
    /// One of some words.
    Word(String),
}

/// All parameters of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// Epoch whose they are.
    pub epoch: u64,
    /// One by one.
    pub parameters: Vec<Parameter>,
}

/// One of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// As in the scene file, with a dot before the part of a part.
    pub name: String,
    /// What it is.
    pub value: Value,
    /// In which unit; empty for a plain number or a word.
    pub unit: String,
    /// Whether it may be set while the scene runs.
    pub settable: bool,
    /// Least and largest number that it may be set to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// What it means.
    pub meaning: String,
}
