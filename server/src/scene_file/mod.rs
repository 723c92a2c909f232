//! Scene files: from the text people write to what the engine takes, refusing with file, line and field.

mod cloud;
mod dial;
mod edit;
mod fault;
mod floor;
mod limits;
mod palette;
mod stretch;
mod walls;

use crate::rehearsal::{Asked, LARGEST_M, Rehearsed, rehearse};
use ballroom_physics as physics;
pub use edit::Edited;
use nalgebra::Vector3;
use protocol::scene::{Accuracy, Integrator, Motion, Scene};
pub use protocol::scene_text::SceneError;
use protocol::scene_text::{MAX_SCENE_BYTES, error_at, parse};
use std::borrow::Cow;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// The scenes that come with the program: name and text.
const BUILT_IN: [(&str, &str); 16] = [
    ("original", include_str!("../../scenes/original.toml")),
    ("original_frictionless", include_str!("../../scenes/original_frictionless.toml")),
    ("bowl", include_str!("../../scenes/bowl.toml")),
    ("derby", include_str!("../../scenes/derby.toml")),
    ("plane", include_str!("../../scenes/plane.toml")),
    ("cradle", include_str!("../../scenes/cradle.toml")),
    ("galperin", include_str!("../../scenes/galperin.toml")),
    ("saddle", include_str!("../../scenes/saddle.toml")),
    ("trough", include_str!("../../scenes/trough.toml")),
    ("monkey", include_str!("../../scenes/monkey.toml")),
    ("break", include_str!("../../scenes/break.toml")),
    ("corner", include_str!("../../scenes/corner.toml")),
    ("bullet", include_str!("../../scenes/bullet.toml")),
    ("bicubic", include_str!("../../scenes/bicubic.toml")),
    ("thousand", include_str!("../../scenes/thousand.toml")),
    ("gas", include_str!("../../scenes/gas.toml")),
];

/// Names of the scenes that come with the program.
pub fn built_in_names() -> impl Iterator<Item = &'static str> {
    BUILT_IN.iter().map(|(name, _)| *name)
}

/// The text of a scene and where it came from.
#[derive(Clone, Debug)]
pub struct SceneText {
    file: String,
    text: Cow<'static, str>,
    /// How many balls are wanted, when it is not what the text says.
    balls: Option<u32>,
    /// What places the clouds instead of their own seeds.
    seed: Option<u64>,
    /// How exactly it shall be run, when it is not what was written.
    accuracy: Option<Accuracy>,
    /// Whether `file` is a path it was read from.
    is_file: bool,
}

impl SceneText {
    /// A text under a name for messages.
    pub fn new(file: impl Into<String>, text: impl Into<Cow<'static, str>>) -> Self {
        Self { file: file.into(), text: text.into(), balls: None, seed: None, accuracy: None, is_file: false }
    }

    /// A built-in scene by its bare name; a file when `scene` ends in `.toml` or holds a path separator.
    pub fn open(scene: &str) -> Result<Self, SceneError> {
        let fault = |message: String| SceneError {
            file: scene.to_owned(),
            line_column: None,
            field: String::new(),
            message,
        };
        let is_path = Path::new(scene).extension().is_some_and(|end| end == "toml")
            || scene.contains(std::path::is_separator);
        if is_path {
            let file = std::fs::File::open(scene).map_err(|e| fault(format!("cannot be opened: {e}")))?;
            let mut text = String::new();
            // One byte more than is allowed shows that there are more.
            let limit = MAX_SCENE_BYTES as u64 + 1;
            file.take(limit).read_to_string(&mut text).map_err(|e| fault(format!("cannot be read: {e}")))?;
            return Ok(Self { is_file: true, ..Self::new(scene, text) });
        }
        Self::built_in(scene)
    }

    /// The same, read again if it came from a file.
    pub fn reopen(&self) -> Result<Self, SceneError> {
        let again = if self.is_file { Self::open(&self.file)? } else { self.clone() };
        Ok(again.with_balls(self.balls).with_accuracy(self.accuracy))
    }

    /// A scene that comes with the program.
    pub fn built_in(scene: &str) -> Result<Self, SceneError> {
        let known = BUILT_IN.iter().find(|(name, _)| *name == scene);
        let (name, text) = known.ok_or_else(|| {
            let names = built_in_names().collect::<Vec<_>>().join(", ");
            SceneError {
                file: scene.chars().take(64).collect(),
                line_column: None,
                field: String::new(),
                message: format!(
                    "no built-in scene has this name: use one of {names}, or a file ending in .toml"
                ),
            }
        })?;
        Ok(Self::new(format!("{name}.toml"), *text))
    }

    /// The same with its clouds placed anew: the one at place i has the seed `seed` + i.
    #[must_use]
    pub const fn with_seed(mut self, seed: Option<u64>) -> Self {
        self.seed = seed;
        self
    }

    /// The same with `count` balls in all, when one is given. The scene must have exactly one cloud, which makes up the
    /// number; the room is stretched sideways by the root of the ratio, so that as much of the floor is covered as
    /// before, and its heights stay.
    #[must_use]
    pub fn with_balls(mut self, count: Option<u32>) -> Self {
        self.balls = count.or(self.balls);
        self
    }

    /// What places the clouds instead of their own seeds.
    pub const fn seed(&self) -> Option<u64> {
        self.seed
    }

    /// Where it came from, for messages.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The whole text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// How many balls are wanted, when it is not what the text says.
    pub const fn balls(&self) -> Option<u32> {
        self.balls
    }

    /// Reads it; what it means is not checked.
    pub fn parse(&self) -> Result<Scene, SceneError> {
        parse(&self.file, &self.text)
    }

    /// Reads and checks it, and places its clouds.
    pub fn load(&self) -> Result<LoadedScene, SceneError> {
        let mut scene = self.parse()?;
        limits::check(self, &scene)?;
        if let Some(count) = self.balls {
            stretch::to_count(self, &mut scene, count)?;
            limits::check(self, &scene)?;
        }
        if let Some(seed) = self.seed {
            for (place, cloud) in (0..).zip(&mut scene.clouds) {
                cloud.seed = seed.wrapping_add(place);
            }
        }
        let walls = walls::convert(self, &scene)?;
        let mut balls = scene.balls.iter().enumerate().map(|(i, ball)| Placed::of_ball(i, ball)).collect();
        cloud::place_all(self, &scene, &walls, &mut balls)?;
        palette::colour(&mut balls);
        let (walls, wall_fields) = walls.into_iter().unzip();
        let physics = physics::Scene {
            floor: floor::convert(self, &scene.floor)?,
            walls,
            balls: balls.iter().map(|ball| ball.spec.clone()).collect(),
            gravity: Vector3::from(scene.gravity_m_per_s2),
            motion: match scene.motion {
                Motion::Frictionless => physics::MotionLaw::Frictionless,
                Motion::Rolling => physics::MotionLaw::Rolling,
            },
            restitution: scene.restitution,
            accuracy: accuracy(scene.accuracy),
            hit_budget: scene.hit_budget,
        };
        let cards = balls.into_iter().map(|ball| ball.card).collect();
        let source = self.clone();
        LoadedScene { source, scene: Arc::new(scene), physics, cards, wall_fields, rehearsed: None }
            .rehearse()
    }

    pub(crate) fn error(&self, field: impl std::fmt::Display, message: String) -> SceneError {
        error_at(&self.file, &self.text, &field.to_string(), message)
    }
}

fn accuracy(accuracy: Accuracy) -> physics::Accuracy {
    match accuracy {
        Accuracy::Tolerance { tolerance_m } => physics::Accuracy::Tolerance(tolerance_m),
        // Until it has been rehearsed.
        Accuracy::Error { .. } | Accuracy::Budget { .. } => physics::Accuracy::Tolerance(LARGEST_M),
        Accuracy::Fixed { integrator, step_s } => {
            let scheme = match integrator {
                Integrator::Rk4 => physics::Scheme::Rk4,
                Integrator::Tsit5 => physics::Scheme::Tsit5,
                Integrator::Dop853 => physics::Scheme::Dop853,
            };
            physics::Accuracy::Fixed(scheme, step_s)
        }
    }
}

/// A scene that has been read, checked and filled with its balls.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    source: SceneText,
    scene: Arc<Scene>,
    physics: physics::Scene,
    cards: Vec<Card>,
    wall_fields: Vec<String>,
    rehearsed: Option<Rehearsed>,
}

/// What the engine does not need to know of a ball.
#[derive(Clone, Debug)]
pub(crate) struct Card {
    /// Where it stands in the file: `ball[2]`, or its `cloud[0]`.
    pub field: String,
    /// Red, green, blue.
    pub color_rgb: Option<[u8; 3]>,
    /// Whether a player may steer it.
    pub player: bool,
    /// What it is selected by.
    pub tags: Vec<String>,
    /// Whether it came by a command.
    pub is_spawned: bool,
}

impl LoadedScene {
    /// The text it was read from.
    pub const fn source(&self) -> &SceneText {
        &self.source
    }

    /// The scene as people wrote it and viewers get it.
    pub const fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The scene as the engine takes it.
    pub const fn physics(&self) -> &physics::Scene {
        &self.physics
    }

    /// What was found for the budget or the error that it asks for, if it does: from then on it is a scene with that tolerance.
    pub const fn rehearsed(&self) -> Option<Rehearsed> {
        self.rehearsed
    }

    /// The error over 10 s that is asked for, m.
    pub const fn asked_error_m(&self) -> Option<f64> {
        match (self.rehearsed, self.physics.accuracy) {
            (Some(Rehearsed { asked: Asked::Error(error_m), .. }), _) => Some(error_m),
            (_, physics::Accuracy::Tolerance(tolerance_m)) => Some(tolerance_m),
            (_, physics::Accuracy::Fixed(..)) => None,
        }
    }

    /// With the tolerance that gives what it asks for.
    fn rehearse(mut self) -> Result<Self, SceneError> {
        if let Some(found) = rehearse(&self)? {
            tracing::info!("{}: {found}", self.scene.name);
            self.physics.accuracy = physics::Accuracy::Tolerance(found.tolerance_m);
            Arc::make_mut(&mut self.scene).accuracy = Accuracy::Tolerance { tolerance_m: found.tolerance_m };
            self.rehearsed = Some(found);
        }
        Ok(self)
    }

    /// Sets the engine up, naming the place in the file when it refuses.
    pub fn controller(&self) -> Result<physics::Controller, SceneError> {
        physics::Controller::new(&self.physics).map_err(|fault| self.refused(&fault))
    }

    /// What the engine refuses, with the place in the file.
    pub(crate) fn refused(&self, fault: &physics::SceneFault) -> SceneError {
        fault::locate(self, fault)
    }
}

/// A ball with all its places known.
#[derive(Clone, Debug)]
struct Placed {
    spec: physics::BallSpec,
    card: Card,
}

impl Placed {
    fn of_ball(index: usize, ball: &protocol::scene::Ball) -> Self {
        // `limits` saw to it that exactly one is there.
        let place = match (ball.center_m, ball.contact_m, ball.uv) {
            (Some(xy), _, _) => physics::Place::Center(xy.into()),
            (_, Some(xy), _) => physics::Place::Contact(xy.into()),
            (_, _, uv) => physics::Place::Uv(uv.unwrap_or_default().into()),
        };
        Self {
            spec: physics::BallSpec {
                name: ball.name.clone(),
                radius: ball.radius_m,
                mass: ball.mass_kg,
                inertia_factor: ball.inertia.factor(),
                place,
                velocity: ball.velocity_m_per_s.into(),
                spin: ball.spin_rad_per_s,
            },
            card: Card {
                field: format!("ball[{index}]"),
                color_rgb: ball.color.as_deref().and_then(palette::parse),
                player: ball.player,
                tags: distinct(&ball.tags),
                is_spawned: false,
            },
        }
    }
}

/// Tags in order, each once.
fn distinct(tags: &[String]) -> Vec<String> {
    let mut tags = tags.to_vec();
    tags.sort_unstable();
    tags.dedup();
    tags
}

#[cfg(test)]
mod tests;
