//! A world becomes another one while it runs: balls come and go, the floor moves, numbers change.

use crate::scene_file::{Edited, SceneError};
use crate::world::World;
use ballroom_physics::Successor;
use protocol::change::PointMove;
use protocol::command::{Refusal, code};
use protocol::listing::Selection;
use protocol::parameter::Value;
use protocol::scene::Ball;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A change made ready, from one world and no other.
pub struct Change {
    pub(crate) from: Arc<World>,
    pub(crate) to: Arc<World>,
    pub(crate) successor: Successor,
}

impl Change {
    /// Balls come.
    pub fn spawn(world: &Arc<World>, balls: &[Ball]) -> Result<Self, Refusal> {
        Self::to(world, world.loaded().with_balls(balls).map_err(|error| failed(&error))?)
    }

    /// Balls go, by id.
    pub fn delete(world: &Arc<World>, ids: &[usize]) -> Result<Self, Refusal> {
        let places = world.start().scene_index();
        Self::to(world, world.loaded().without(ids.iter().map(|id| places[*id])))
    }

    /// Control points of the floor move.
    pub fn move_points(world: &Arc<World>, points: &[PointMove]) -> Result<Self, Refusal> {
        let edited = world.loaded().with_points(world.start().patch(), points, world.origin().loaded());
        Self::to(world, edited.map_err(|error| failed(&error))?)
    }

    /// Numbers change.
    pub fn set_parameters(world: &Arc<World>, values: &BTreeMap<String, Value>) -> Result<Self, Refusal> {
        Self::to(world, world.loaded().with_parameters(values)?)
    }

    fn to(world: &Arc<World>, Edited { scene, kept }: Edited) -> Result<Self, Refusal> {
        let successor = world.start().successor(world.loaded().physics(), scene.physics(), &kept);
        let successor =
            successor.map_err(|fault| Refusal::new(code::OPERATION_FAILED, scene.explain(&fault)))?;
        let to = World::after(world, scene, successor.at_start().clone());
        Ok(Self { from: world.clone(), to: Arc::new(to), successor })
    }
}

/// Ids of the balls that are meant. Those that are named must all be there, and there must be one.
pub fn meant(
    world: &World,
    selection: &Selection,
    center_m: impl Fn(usize) -> [f64; 2],
) -> Result<Vec<usize>, Refusal> {
    selection.names.iter().try_for_each(|name| world.ball(name).map(drop))?;
    let ids = selection.places(world.roster(), center_m);
    if ids.is_empty() {
        return Err(Refusal::new(code::NOT_FOUND, format!("no ball is meant by {}", selection.words())));
    }
    Ok(ids)
}

/// Of a command there is no file and no line.
fn failed(error: &SceneError) -> Refusal {
    let SceneError { field, message, .. } = error;
    Refusal::new(code::OPERATION_FAILED, format!("{field}: {message}"))
}
