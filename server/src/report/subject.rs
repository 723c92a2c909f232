//! A scene that is measured, and the settings it is run with.

use super::ReportError;
use crate::SceneText;
use crate::scene_file::LoadedScene;
use ballroom_physics::{Accuracy, Controller, Floor, Scene, Scheme, Time};
use nalgebra::Vector3;

/// Ticks a simulated second at which states are compared.
pub const RATE_HZ: u32 = 60;

/// A scene that is measured.
#[derive(Clone, Debug)]
pub struct Subject {
    /// As it was asked for: `bicubic`, `gas:1000`, `my_scene.toml`.
    pub name: String,
    loaded: LoadedScene,
}

impl Subject {
    /// By name or file; `gas:1000` is the scene `gas` with 1000 balls in all.
    pub fn open(asked: &str) -> Result<Self, ReportError> {
        let (scene, count) = match asked.rsplit_once(':').map(|(scene, count)| (scene, count.parse())) {
            Some((scene, Ok(count))) => (scene, Some(count)),
            _ => (asked, None),
        };
        let loaded = SceneText::open(scene)?.with_balls(count).load()?;
        // Refused here with the place in the file; its variants differ by what is named in the refusal.
        loaded.controller()?;
        Ok(Self { name: asked.to_owned(), loaded })
    }

    /// The same room with `count` balls, for a scene with one cloud.
    pub fn with_balls(&self, count: u32) -> Result<Self, ReportError> {
        let loaded = self.loaded.source().clone().with_balls(Some(count)).load()?;
        Ok(Self { name: self.name.clone(), loaded })
    }

    /// Letters for an anchor.
    pub fn id(&self) -> String {
        let stem =
            std::path::Path::new(&self.name).file_stem().map(|stem| stem.to_string_lossy().to_lowercase());
        let letter = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
        stem.unwrap_or_default().chars().map(letter).collect()
    }

    /// What to look for in it, in its author's words.
    pub fn description(&self) -> &str {
        &self.loaded.scene().description
    }

    /// The scene as the engine takes it.
    pub const fn scene(&self) -> &Scene {
        self.loaded.physics()
    }

    /// Its own accuracy.
    pub const fn own(&self) -> Accuracy {
        self.scene().accuracy
    }

    /// How many balls.
    pub fn balls(&self) -> usize {
        self.scene().balls.len()
    }

    /// Whether its number of balls can be asked for.
    pub fn is_crowd(&self) -> bool {
        self.loaded.scene().clouds.len() == 1
    }

    /// Whether the floor is a plane, on which motion has a closed form that no setting changes.
    pub fn is_flat(&self) -> bool {
        matches!(&self.scene().floor, Floor::Polynomial { terms, .. }
            if terms.iter().flatten().all(|&c| c == 0.0))
    }

    /// Radius of the smallest ball, m.
    pub fn smallest_radius(&self) -> f64 {
        self.scene().balls.iter().map(|ball| ball.radius).fold(f64::INFINITY, f64::min)
    }

    /// The scene at its start, computed with `accuracy`.
    pub fn start(&self, accuracy: Accuracy) -> Result<Controller, ReportError> {
        self.start_of(&Scene { accuracy, ..self.scene().clone() })
    }

    /// A variant of the scene at its start.
    pub fn start_of(&self, variant: &Scene) -> Result<Controller, ReportError> {
        Controller::new(variant)
            .map_err(|fault| ReportError::Variant { scene: self.name.clone(), fault: Box::new(fault) })
    }
}

/// Tick `tick` of [`RATE_HZ`].
pub fn tick(tick: usize) -> Time {
    Time::of_tick(tick as u64, RATE_HZ)
}

/// Centres of all balls at the run's time, by id, m.
pub fn centers(run: &Controller) -> impl Iterator<Item = Vector3<f64>> + '_ {
    std::iter::zip(run.balls(), run.scene_index()).map(|(ball, _)| ball.center)
}

/// Seconds of `ticks` ticks.
pub fn seconds(ticks: usize) -> f64 {
    ticks as f64 / f64::from(RATE_HZ)
}

/// What chooses the steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// The engine, to meet a tolerance.
    Tolerance,
    /// A step by name.
    Fixed(Scheme),
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 4] =
        [Self::Tolerance, Self::Fixed(Scheme::Dop853), Self::Fixed(Scheme::Tsit5), Self::Fixed(Scheme::Rk4)];

    /// What it is called.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tolerance => "tolerance",
            Self::Fixed(scheme) => scheme_name(scheme),
        }
    }

    /// That of an accuracy.
    pub const fn of(accuracy: Accuracy) -> Self {
        match accuracy {
            Accuracy::Tolerance(_) => Self::Tolerance,
            Accuracy::Fixed(scheme, _) => Self::Fixed(scheme),
        }
    }

    /// Its settings, coarse to fine: all, or a few.
    pub fn settings(self, quick: bool) -> Vec<Accuracy> {
        let stride = if quick { 2 } else { 1 };
        let powers = |range: std::ops::RangeInclusive<i32>, base: f64| {
            range.step_by(stride).map(move |k| base.powi(-k)).collect::<Vec<_>>()
        };
        let steps =
            |scheme, lengths: Vec<f64>| lengths.into_iter().map(|h| Accuracy::Fixed(scheme, h)).collect();
        match self {
            Self::Tolerance => powers(3..=13, 10.0).into_iter().map(Accuracy::Tolerance).collect(),
            Self::Fixed(Scheme::Rk4) => steps(Scheme::Rk4, powers(3..=11, 2.0)),
            Self::Fixed(Scheme::Tsit5) => steps(Scheme::Tsit5, powers(2..=9, 2.0)),
            // So few that each counts.
            Self::Fixed(Scheme::Dop853) => steps(Scheme::Dop853, (1..=6).map(|k| 0.5_f64.powi(k)).collect()),
        }
    }
}

const fn scheme_name(scheme: Scheme) -> &'static str {
    match scheme {
        Scheme::Rk4 => "rk4",
        Scheme::Tsit5 => "tsit5",
        Scheme::Dop853 => "dop853",
    }
}

/// The number of a setting: metres of a tolerance, seconds of a step.
pub const fn number(accuracy: Accuracy) -> f64 {
    match accuracy {
        Accuracy::Tolerance(number) | Accuracy::Fixed(_, number) => number,
    }
}

/// A setting in words: `tolerance 1e-9 m`, `rk4, step 1/64 s`.
pub fn words(accuracy: Accuracy) -> String {
    match accuracy {
        Accuracy::Tolerance(tolerance) => format!("tolerance {tolerance:.0e} m"),
        Accuracy::Fixed(scheme, step) if (1.0 / step - (1.0 / step).round()).abs() < 1e-9 => {
            format!("{}, step 1/{:.0} s", scheme_name(scheme), 1.0 / step)
        }
        Accuracy::Fixed(scheme, step) => format!("{}, step {step} s", scheme_name(scheme)),
    }
}
