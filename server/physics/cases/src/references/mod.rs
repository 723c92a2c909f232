//! Trajectories on any floor, from another formulation: Newton and Euler with a multiplier, in 33 and 42 digits, made by
//! `generators/trajectories.py` and kept in `data/`.
//!
//! Errors are the largest over the ticks of 7 Hz of 10 s. Each file carries the largest difference of any number between
//! two computations of different order, step and precision, which the title of its cases tells; what is written is rounded
//! to f64.

mod charts;
mod compare;
mod floors;
mod table;

use crate::case::Case;
use crate::scenes::{HOLLOW, SOLID};
use ballroom_physics::{Accuracy, Scene, SceneFault};
use compare::{Ground, Reference, Start};
use floors::Chart;

pub use compare::angle_between;
pub use table::{RATE_HZ, SECONDS, Seen, Table};

const SLIDING: f64 = 0.0;
const ALL: &[Chart] = &[Chart::Plain, Chart::Net, Chart::Bent, Chart::Leaning];
/// For floors that are nets of heights already.
const NETS: &[Chart] = &[Chart::Plain, Chart::Bent, Chart::Leaning];
/// For floors whose degree leaves no room for another chart.
const PLAIN: &[Chart] = &[Chart::Plain];

const fn ball(radius: f64, k: f64, contact: [f64; 2], velocity: [f64; 2], spin: f64) -> Start {
    Start { radius, k, contact, velocity, spin, mass: 1.0 }
}

macro_rules! reference {
    ($ground:expr, $name:literal, $title:literal, $($ball:expr),*) => {
        Reference {
            name: $name,
            title: $title,
            text: include_str!(concat!("../../data/", $name, ".csv")),
            ground: $ground.clone(),
            balls: vec![$($ball),*],
            walls: vec![],
            restitution: 1.0,
        }
    };
}

fn with_symmetry() -> Vec<Reference> {
    let incline = Ground { shape: floors::INCLINE, half: 64.0, ..BUMPS };
    let pit = Ground { shape: floors::pit(), half: 10.0, gravity: 9.8, charts: PLAIN };
    let cylinder = Ground { shape: floors::PARABOLA, half: 8.0, gravity: 9.81, charts: ALL };
    let bowl = Ground { shape: floors::BOWL, half: 3.0, ..cylinder.clone() };
    let released = |k| ball(1.0, k, [-3.0, 0.0], [0.0, 0.0], 0.0);
    let across = |k| ball(0.2, k, [0.8, 0.0], [0.0, 0.0], 0.0);
    let orbit = |k, spin| ball(0.1, k, [0.9, 0.0], [0.0, 1.1], spin);
    vec![
        reference!(
            incline,
            "incline-solid",
            "across an incline, solid with spin",
            ball(0.5, SOLID, [3.0, -7.0], [2.0, 1.5], 12.0)
        ),
        reference!(pit, "pit-sliding", "released in the pit, sliding", released(SLIDING)),
        reference!(pit, "pit-solid", "released in the pit, solid", released(SOLID)),
        reference!(pit, "pit-hollow", "released in the pit, hollow", released(HOLLOW)),
        reference!(cylinder, "cylinder-sliding", "across a parabolic cylinder, sliding", across(SLIDING)),
        reference!(cylinder, "cylinder-solid", "across a parabolic cylinder, solid", across(SOLID)),
        reference!(
            cylinder,
            "cylinder-helix",
            "along a parabolic cylinder with spin",
            ball(0.2, SOLID, [0.8, -1.5], [0.0, 0.5], 7.0)
        ),
        reference!(bowl, "bowl-sliding", "round a paraboloid, sliding", orbit(SLIDING, 0.0)),
        reference!(bowl, "bowl-hollow", "round a paraboloid, hollow with spin", orbit(HOLLOW, 11.0)),
        reference!(
            bowl,
            "tight-solid",
            "curvature 0.95 of what the radius allows",
            ball(1.9, SOLID, [0.9, 0.0], [0.0, 1.1], 2.0)
        ),
    ]
}

const BUMPS: Ground = Ground { shape: floors::BUMPS, half: 3.0, gravity: 9.81, charts: ALL };

fn over_bumps(k: f64, spin: f64) -> Start {
    ball(0.25, k, [1.2, -0.7], [-0.4, 1.3], spin)
}

fn bumps_solid() -> Reference {
    reference!(
        BUMPS,
        "bumps-solid",
        "over a floor without symmetry, solid with spin",
        over_bumps(SOLID, -9.0)
    )
}

/// Largest errors of centre, velocity, angular velocity and orientation beside the reference `bumps-solid`.
pub fn bumps_errors(accuracy: Accuracy) -> Result<[f64; 4], SceneFault> {
    let reference = bumps_solid();
    let scene = Scene { accuracy, ..reference.scene(Chart::Plain) };
    let [center, velocity, spin, orientation, ..] = reference.errors(&scene)?;
    Ok([center, velocity, spin, orientation])
}

fn without_symmetry() -> Vec<Reference> {
    let bicubic = Ground { shape: floors::bicubic(), half: 1.5, charts: NETS, ..BUMPS };
    let twelve = Ground { shape: floors::twelve(), half: 2.0, charts: PLAIN, ..BUMPS };
    let bumpy = |k, spin| ball(0.05, k, [-0.6, -0.24], [1.0, 0.6], spin);
    let dozen = |k, spin| ball(0.1, k, [0.7, -0.3], [-0.5, 0.9], spin);
    vec![
        reference!(
            BUMPS,
            "bumps-sliding",
            "over a floor without symmetry, sliding",
            over_bumps(SLIDING, 0.0)
        ),
        bumps_solid(),
        reference!(
            BUMPS,
            "whirl-hollow",
            "over a floor without symmetry with 300 rad/s",
            over_bumps(HOLLOW, 300.0)
        ),
        reference!(bicubic, "bicubic-sliding", "over a bumpy bicubic, sliding", bumpy(SLIDING, 0.0)),
        reference!(bicubic, "bicubic-solid", "over a bumpy bicubic, solid with spin", bumpy(SOLID, 16.0)),
        reference!(bicubic, "bicubic-hollow", "over a bumpy bicubic, hollow with spin", bumpy(HOLLOW, -12.0)),
        reference!(twelve, "twelve-sliding", "over degree 12 x 12, sliding", dozen(SLIDING, 0.0)),
        reference!(twelve, "twelve-solid", "over degree 12 x 12, solid with spin", dozen(SOLID, 8.0)),
        reference!(twelve, "twelve-hollow", "over degree 12 x 12, hollow with spin", dozen(HOLLOW, -5.0)),
    ]
}

fn saddles_and_steep() -> Vec<Reference> {
    let saddle = Ground { shape: floors::SADDLE, half: 2.0, gravity: 9.81, charts: ALL };
    let monkey = Ground { shape: floors::MONKEY, half: 2.5, ..saddle.clone() };
    let steep = Ground { shape: floors::STEEP, half: 1.5, ..saddle.clone() };
    let two = |k, spin| ball(0.15, k, [0.5, 0.1], [0.0, 0.3], spin);
    let three = |k, spin| ball(0.1, k, [0.6, 0.2], [-0.7, 0.3], spin);
    let climb = |k, spin| ball(0.1, k, [1.13, 0.1], [0.0, 1.2], spin);
    vec![
        reference!(saddle, "saddle-sliding", "over a saddle, sliding", two(SLIDING, 0.0)),
        reference!(saddle, "saddle-solid", "over a saddle, solid with spin", two(SOLID, 3.0)),
        reference!(saddle, "saddle-hollow", "over a saddle, hollow with spin", two(HOLLOW, -4.0)),
        reference!(monkey, "monkey-sliding", "over a monkey saddle, sliding", three(SLIDING, 0.0)),
        reference!(monkey, "monkey-solid", "over a monkey saddle, solid with spin", three(SOLID, 6.0)),
        reference!(monkey, "monkey-hollow", "over a monkey saddle, hollow with spin", three(HOLLOW, -6.0)),
        reference!(steep, "steep-sliding", "up walls of 70 degrees, sliding", climb(SLIDING, 0.0)),
        reference!(steep, "steep-solid", "up walls of 70 degrees, solid with spin", climb(SOLID, 10.0)),
        reference!(steep, "steep-hollow", "up walls of 70 degrees, hollow with spin", climb(HOLLOW, -15.0)),
    ]
}

fn with_hits() -> Vec<Reference> {
    let first = |k, spin| ball(0.25, k, [0.8, -0.7], [-0.4, 1.3], spin);
    let light = |k, spin| Start { mass: 0.5, ..ball(0.2, k, [-0.8, 0.3], [0.2, 0.0], spin) };
    let corner = vec![[[0.48, 0.36], [-4.0, -3.0]], [[-0.75, 0.0], [12.0, 5.0]]];
    vec![
        Reference {
            walls: corner.clone(),
            ..reference!(
                BUMPS,
                "walls-sliding",
                "between slanting walls on bumps, sliding",
                first(SLIDING, 0.0)
            )
        },
        Reference {
            walls: corner,
            restitution: 0.875,
            ..reference!(BUMPS, "walls-solid", "between slanting walls on bumps, solid", first(SOLID, -9.0))
        },
        reference!(
            BUMPS,
            "pair-sliding",
            "two meet on bumps, sliding",
            first(SLIDING, 0.0),
            light(SLIDING, 0.0)
        ),
        Reference {
            restitution: 0.875,
            ..reference!(
                BUMPS,
                "pair-rolling",
                "solid and hollow meet on bumps",
                first(SOLID, -9.0),
                light(HOLLOW, 5.0)
            )
        },
    ]
}

/// The scene of a reference and what its file says, by its name.
pub fn named(name: &str) -> Option<(Scene, Table)> {
    let reference = all().find(|reference| reference.name == name)?;
    Some((reference.scene(Chart::Plain), Table::read(reference.text)))
}

/// For each reference without hits its name, whether its floor is flat, and what it measures for an accuracy: the largest
/// error of a centre, m.
pub fn smooth() -> impl Iterator<Item = (&'static str, bool, impl Fn(Accuracy) -> Result<f64, SceneFault>)> {
    let references = [with_symmetry(), without_symmetry(), saddles_and_steep()].into_iter().flatten();
    references.map(|reference| {
        let (name, is_flat) = (reference.name, reference.ground.shape == floors::INCLINE);
        let error = move |accuracy| {
            let scene = Scene { accuracy, ..reference.scene(Chart::Plain) };
            Ok(reference.errors(&scene)?[0])
        };
        (name, is_flat, error)
    })
}

/// Every case of this room.
pub fn cases() -> Vec<Case> {
    all().flat_map(Reference::cases).collect()
}

fn all() -> impl Iterator<Item = Reference> {
    [with_symmetry(), without_symmetry(), saddles_and_steep(), with_hits()].into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_computations_of_every_reference_agree_far_beyond_what_is_demanded_of_the_engine() {
        for reference in all() {
            let table = Table::read(reference.text);
            assert!(table.own_error <= 1e-20, "{}: {:e}", reference.name, table.own_error);
            assert_eq!(table.own_error, Table::own_error_of(reference.text), "{}", reference.name);
            assert_eq!(table.ticks.len(), (RATE_HZ * SECONDS + 1) as usize, "{}", reference.name);
        }
    }
}
