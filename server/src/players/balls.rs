//! Which ball a claim means, and why it cannot be had.

use super::held::Held;
use crate::simulation::Stage;
use protocol::command::{Refusal, code};
use protocol::keys::Name;
use protocol::snapshot::Roster;
use std::collections::BTreeMap;

/// Who drives a ball.
pub fn holder<'a>(claims: &'a BTreeMap<Name, Held>, ball: &str) -> Option<&'a Name> {
    claims.iter().find(|(_, held)| held.ball == ball).map(|(player, _)| player)
}

/// That a ball is somebody's.
pub fn taken(ball: &str, player: &Name) -> Refusal {
    Refusal::new(code::INCORRECT_STATE, format!("{ball:?} is driven by {player}"))
}

/// Whether there is such a ball and a player may steer it.
pub fn is_players(roster: &Roster, ball: &str) -> bool {
    let found = roster.names.binary_search_by(|known| known.as_str().cmp(ball));
    found.is_ok_and(|ball| roster.player[ball])
}

/// The balls that may be steered, those of the scene first and in its order.
pub fn players_balls(Stage { scene, roster, .. }: &Stage) -> Vec<String> {
    let own = scene.balls.iter().map(|ball| &ball.name).filter(|name| is_players(roster, name));
    let is_other = |name: &&String| is_players(roster, name) && !scene.balls.iter().any(|b| b.name == **name);
    own.chain(roster.names.iter().filter(is_other)).cloned().collect()
}

/// A ball asked for by name, if it is free.
pub fn wanted_ball(claims: &BTreeMap<Name, Held>, stage: &Stage, ball: String) -> Result<String, Refusal> {
    if !is_players(&stage.roster, &ball) {
        let known = players_balls(stage);
        let known: Vec<&str> = known.iter().map(String::as_str).take(8).collect();
        let why = format!("{ball:?} is no player's ball; those are {}", known.join(", "));
        return Err(Refusal::new(code::NOT_FOUND, why));
    }
    match holder(claims, &ball) {
        Some(player) => Err(taken(&ball, player)),
        None => Ok(ball),
    }
}

/// The first ball that is free.
pub fn free_ball(claims: &BTreeMap<Name, Held>, stage: &Stage) -> Result<String, Refusal> {
    let balls = players_balls(stage);
    if balls.is_empty() {
        return Err(Refusal::new(code::NOT_FOUND, "the scene has no player's ball"));
    }
    balls.into_iter().find(|ball| holder(claims, ball).is_none()).ok_or_else(|| {
        let held = claims.iter().map(|(player, held)| format!("{:?} by {player}", held.ball));
        let why = format!("no ball is free: {}", held.take(8).collect::<Vec<_>>().join(", "));
        Refusal::new(code::INCORRECT_STATE, why)
    })
}
