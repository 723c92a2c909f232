//! What of a world a command may change, beside where its balls are: who they are, its floor, its numbers.

use crate::codec::MAX_BALL_NAME_BYTES;
use crate::command::CommandFault;
use crate::keys::Name;
use crate::listing::Selection;
use crate::parameter::Value;
use crate::scene::Ball;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Most balls of one spawn, and most names of one selection.
pub const MAX_CHANGED_BALLS: usize = 1024;
/// Most control points moved at once: all of the largest net.
pub const MAX_MOVED_POINTS: usize = 13 * 13;
/// Most parameters set at once.
pub const MAX_SET_PARAMETERS: usize = 16;
/// Largest coordinate, m.
const LARGEST_M: f64 = 1e6;

/// Where a control point of the floor shall be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointMove {
    /// Row, along v, from 0.
    pub row: usize,
    /// Column, along u, from 0.
    pub column: usize,
    /// x, y and z.
    pub to_m: [f64; 3],
}

fn refuse<T>(why: String) -> Result<T, CommandFault> {
    Err(CommandFault::new(why))
}

fn count(what: &str, count: usize, most: usize) -> Result<(), CommandFault> {
    if (1..=most).contains(&count) {
        Ok(())
    } else {
        refuse(format!("{count} {what} at once: use 1 to {most}"))
    }
}

/// Whether a ball may be called this.
pub(crate) fn check_name(name: &str) -> Result<(), CommandFault> {
    if name.is_empty() || name.len() > MAX_BALL_NAME_BYTES {
        return refuse(format!("a ball has a name of 1 to {MAX_BALL_NAME_BYTES} bytes"));
    }
    Ok(())
}

/// Whether a spawn makes sense as far as the wire goes; numbers are for the server to check, as those of a scene file.
pub(crate) fn check_spawn(balls: &[Ball]) -> Result<(), CommandFault> {
    count("balls are spawned", balls.len(), MAX_CHANGED_BALLS)?;
    balls.iter().try_for_each(|ball| check_name(&ball.name))
}

/// Whether control points can be told apart and where they go.
pub(crate) fn check_points(points: &[PointMove]) -> Result<(), CommandFault> {
    count("points are moved", points.len(), MAX_MOVED_POINTS)?;
    let mut known = BTreeSet::new();
    for PointMove { row, column, to_m } in points {
        if !known.insert((row, column)) {
            return refuse(format!("the point in row {row} and column {column} is moved twice"));
        }
        if let Some(x) = to_m.iter().find(|x| !(-LARGEST_M..=LARGEST_M).contains(*x)) {
            return refuse(format!("{x} of the point in row {row} and column {column}: use -1e6 to 1e6"));
        }
    }
    Ok(())
}

/// Whether there are parameters to set; names and ranges are the server's to know.
pub(crate) fn check_values(values: &BTreeMap<String, Value>) -> Result<(), CommandFault> {
    count("parameters are set", values.len(), MAX_SET_PARAMETERS)
}

/// Whether a selection says something, and something that can be.
pub(crate) fn check_selection(selection: &Selection) -> Result<(), CommandFault> {
    if *selection == Selection::default() {
        return refuse("no ball is meant: give names, player, tag, spawned or within_m".into());
    }
    if selection.names.len() > MAX_CHANGED_BALLS {
        return refuse(format!(
            "{} balls are named at once: use at most {MAX_CHANGED_BALLS}",
            selection.names.len()
        ));
    }
    selection.names.iter().try_for_each(|name| check_name(name))?;
    if let Some(tag) = selection.tag.as_deref().filter(|tag| tag.parse::<Name>().is_err()) {
        return refuse(format!("tag is {tag:?}: use 1 to 32 of a-z, 0-9, _ and -"));
    }
    if let Some([x0, y0, x1, y1]) = selection.within_m {
        let is_there = |low: f64, high: f64| low <= high && low.abs().max(high.abs()) <= LARGEST_M;
        if !is_there(x0, x1) || !is_there(y0, y1) {
            return refuse(
                "within_m is no rectangle: use [X0, Y0, X1, Y1] in metres, low before high".into(),
            );
        }
    }
    Ok(())
}
