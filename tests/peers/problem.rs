//! A case as every contestant is told it: balls, floor, walls, and what is exact.

use serde::{Deserialize, Serialize};

/// A vector of metres or metres a second.
pub type Triple = [f64; 3];

/// One ball at the start.
#[derive(Clone, Debug, Serialize)]
pub struct Ball {
    /// m.
    pub radius: f64,
    /// kg.
    pub mass: f64,
    /// Moment of inertia over m r^2.
    pub inertia_factor: f64,
    /// Centre, m.
    pub center: Triple,
    /// Velocity of the centre, m/s.
    pub velocity: Triple,
    /// About the floor's normal, rad/s.
    pub spin: f64,
    /// Angular velocity, rad/s.
    pub omega: Triple,
}

/// What holds the balls.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ground {
    /// The plane z = 0, without friction. Peers get neither floor nor gravity and, where many balls meet, a locked z:
    /// less to compute than a floor.
    Plane,
    /// z = c (x^2 + y^2), c in 1/m. Peers get a mesh of it.
    Bowl(f64),
}

/// What a run is measured against.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Truth {
    /// Centres of all balls at every sample, the start included, m.
    Centers(Vec<Vec<Triple>>),
    /// Velocities along x at the end, m/s, and the number of hits.
    Velocities(Vec<f64>, u64),
    /// The energy of the start; places mean nothing in chaos.
    Energy,
}

/// One case.
#[derive(Clone, Debug, Serialize)]
pub struct Problem {
    /// One word.
    pub id: String,
    /// One line.
    pub title: String,
    /// See [`Ground`].
    pub ground: Ground,
    /// Walls stand at these two x and at these two y, m.
    pub walls: Option<[[f64; 2]; 2]>,
    /// The floor ends at plus and minus this, m: at the walls, or where no ball comes.
    pub half: f64,
    /// Whether balls roll without slip; else nothing rubs.
    pub rolls: bool,
    /// m/s^2, downwards.
    pub gravity: f64,
    /// The balls.
    pub balls: Vec<Ball>,
    /// Simulated time, s.
    pub seconds: f64,
    /// States are compared at this rate, Hz.
    pub sample_hz: u32,
    /// Step rates that peers are given, Hz.
    pub rates_hz: Vec<u32>,
    /// Cells of the floor's mesh along a side that peers are given.
    pub cells: Vec<usize>,
    /// Whether many balls meet, so that only energy can be compared.
    pub gas: bool,
    /// What is exact; nobody is told.
    #[serde(skip)]
    pub truth: Truth,
}

impl Problem {
    /// Number of samples after the start.
    pub fn samples(&self) -> u64 {
        (self.seconds * f64::from(self.sample_hz)).round() as u64
    }

    /// Whether anything is hit. A ball alone in a bowl rides best without restitution, which makes it hop over a mesh.
    pub fn has_hits(&self) -> bool {
        self.balls.len() > 1
    }

    /// Samples at the beginning that are not timed.
    pub fn warm_up(&self) -> u64 {
        if self.gas { self.samples() / 10 } else { 0 }
    }
}

/// Balls at one time.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Sample {
    /// Centres, m.
    pub centers: Vec<Triple>,
    /// Velocities, m/s.
    pub velocities: Vec<Triple>,
    /// Angular velocities, rad/s; empty where nothing rolls.
    pub omegas: Vec<Triple>,
}
