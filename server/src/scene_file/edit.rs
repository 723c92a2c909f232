//! A loaded scene with other balls, another floor or other numbers.

use super::{Card, LoadedScene, Placed, SceneError, SceneText, limits, palette};
use crate::parameters;
use ballroom_physics::surface::bezier::BezierPatch;
use ballroom_physics::{Floor, SceneFault};
use nalgebra::Vector3;
use protocol::change::PointMove;
use protocol::codec::MAX_BALLS;
use protocol::command::Refusal;
use protocol::parameter::Value;
use protocol::scene::{self, Ball, WallBox, WallPlane};
use protocol::snapshot::Roster;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// What a scene became.
pub struct Edited {
    /// The scene.
    pub scene: LoadedScene,
    /// For each place in its list of balls, that of the same ball in the list before.
    pub kept: Vec<Option<usize>>,
}

impl LoadedScene {
    /// With more balls behind the others.
    pub fn with_balls(&self, balls: &[Ball]) -> Result<Edited, SceneError> {
        let command = SceneText::new("spawn", "");
        let before = self.physics.balls.len();
        if before + balls.len() > MAX_BALLS {
            let message =
                format!("there would be {} balls: at most {MAX_BALLS} are run", before + balls.len());
            return Err(command.error("balls", message));
        }
        let mut known: BTreeSet<&str> = self.physics.balls.iter().map(|ball| ball.name.as_str()).collect();
        for (i, ball) in balls.iter().enumerate() {
            let field = format!("balls[{i}]");
            limits::check_ball(&command, &field, ball)?;
            if !known.insert(&ball.name) {
                let message = format!("there is a ball {:?} already: give each a name of its own", ball.name);
                return Err(command.error(format_args!("{field}.name"), message));
            }
        }
        let mut scene = self.clone();
        for (i, ball) in balls.iter().enumerate() {
            let Placed { spec, mut card } = Placed::of_ball(i, ball);
            card.field = format!("balls[{i}]");
            card.is_spawned = true;
            card.color_rgb.get_or_insert(palette::of_place(before + i));
            scene.physics.balls.push(spec);
            scene.cards.push(card);
        }
        let kept = (0..scene.cards.len()).map(|place| (place < before).then_some(place)).collect();
        Ok(Edited { scene, kept })
    }

    /// Without the balls at these places in the list.
    pub fn without(&self, places: impl Iterator<Item = usize>) -> Edited {
        let gone: BTreeSet<usize> = places.collect();
        let stay: Vec<usize> = (0..self.cards.len()).filter(|place| !gone.contains(place)).collect();
        let mut scene = self.clone();
        scene.physics.balls = stay.iter().map(|place| self.physics.balls[*place].clone()).collect();
        scene.cards = stay.iter().map(|place| self.cards[*place].clone()).collect();
        Edited { scene, kept: stay.into_iter().map(Some).collect() }
    }

    /// With control points of its floor, whose net is `patch`, elsewhere. The floor is then a net in full, and the walls
    /// stay where they were; if it is again that of `origin`, it is that to the last bit.
    pub fn with_points(
        &self,
        patch: &BezierPatch,
        points: &[PointMove],
        origin: &Self,
    ) -> Result<Edited, SceneError> {
        let command = SceneText::new("move_control_points", "");
        let [p, q] = patch.degree();
        let mut net = patch.net().to_vec();
        for (i, &PointMove { row, column, to_m }) in points.iter().enumerate() {
            if row > q || column > p {
                let message =
                    format!("row {row}, column {column}: the net has rows 0 to {q} and columns 0 to {p}");
                return Err(command.error(format_args!("points[{i}]"), message));
            }
            net[column * (q + 1) + row] = Vector3::from(to_m);
        }
        let moved = BezierPatch::new([p, q], net);
        let moved = moved.ok_or_else(|| command.error("points", "is no patch the engine can take".into()))?;
        let mut scene = self.clone();
        let served = Arc::make_mut(&mut scene.scene);
        if origin.net().as_ref() == Some(&moved) {
            scene.physics.floor = origin.physics.floor.clone();
            (served.floor, served.walls) = (origin.scene.floor.clone(), origin.scene.walls.clone());
        } else {
            self.write_out_walls(served);
            let rows = (0..=q).map(|j| (0..=p).map(|i| moved.point(i, j).into()).collect()).collect();
            served.floor = scene::Floor::Net { control_points_m: rows };
            scene.physics.floor = Floor::Bezier(moved);
        }
        Ok(Edited { kept: (0..self.cards.len()).map(Some).collect(), scene })
    }

    /// The floor's exact net.
    fn net(&self) -> Option<BezierPatch> {
        match &self.physics.floor {
            Floor::Bezier(patch) => Some(patch.clone()),
            Floor::Polynomial { x, y, terms } => BezierPatch::from_polynomial(*x, *y, terms),
        }
    }

    /// Walls that stood on the floor's borders by default do not move with it.
    fn write_out_walls(&self, served: &mut scene::Scene) {
        if served.walls.bounds.is_some() || !served.walls.planes.is_empty() {
            return;
        }
        match &self.scene.floor {
            scene::Floor::Grid { x_m, y_m, .. } | scene::Floor::Polynomial { x_m, y_m, .. } => {
                served.walls.bounds = Some(WallBox { x_m: *x_m, y_m: *y_m });
            }
            scene::Floor::Net { .. } => {
                let planes = self.physics.walls.iter();
                let plane = planes.map(|w| WallPlane { point_m: w.point.into(), normal: w.normal.into() });
                served.walls.planes = plane.collect();
            }
        }
    }

    /// With other numbers.
    pub fn with_parameters(&self, values: &BTreeMap<String, Value>) -> Result<Edited, Refusal> {
        let mut scene = self.clone();
        let served = Arc::make_mut(&mut scene.scene);
        values.iter().try_for_each(|(name, value)| parameters::set(served, name, value))?;
        scene.physics.gravity = Vector3::from(served.gravity_m_per_s2);
        scene.physics.restitution = served.restitution;
        scene.physics.accuracy = super::accuracy(served.accuracy);
        scene.physics.hit_budget = served.hit_budget;
        Ok(Edited { kept: (0..self.cards.len()).map(Some).collect(), scene })
    }

    /// What the engine refuses, without file and line: what it is about came by a command.
    pub fn explain(&self, fault: &SceneFault) -> String {
        let (field, message) = super::fault::name(self, fault);
        format!("{field}: {message}")
    }

    /// Who the balls are, in an order of their places.
    pub(crate) fn roster(&self, places: &[usize]) -> Roster {
        let balls = &self.physics.balls;
        let mut tags: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for (id, place) in places.iter().enumerate() {
            for tag in &self.cards[*place].tags {
                tags.entry(tag.clone()).or_default().push(id);
            }
        }
        let is_spawned = |id: &usize| self.cards[places[*id]].is_spawned;
        let card = |place: &usize| -> &Card { &self.cards[*place] };
        Roster {
            names: places.iter().map(|&i| balls[i].name.clone()).collect(),
            radius_m: places.iter().map(|&i| balls[i].radius).collect(),
            mass_kg: places.iter().map(|&i| balls[i].mass).collect(),
            inertia_factor: places.iter().map(|&i| balls[i].inertia_factor).collect(),
            color_rgb: places.iter().map(|i| card(i).color_rgb.unwrap_or_default()).collect(),
            player: places.iter().map(|i| card(i).player).collect(),
            tags,
            spawned: (0..places.len()).filter(is_spawned).collect(),
        }
    }
}
