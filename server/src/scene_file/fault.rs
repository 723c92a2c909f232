//! What the engine refuses, said in terms of the file.

use super::{LoadedScene, SceneError};
use ballroom_physics::SceneFault;

/// The engine's fault with file, line and field.
pub fn locate(loaded: &LoadedScene, fault: &SceneFault) -> SceneError {
    let (field, message) = name(loaded, fault);
    loaded.source.error(field, message)
}

/// The engine's fault with the field it is about.
pub fn name(loaded: &LoadedScene, fault: &SceneFault) -> (String, String) {
    let card = |i: usize| loaded.cards.get(i).map_or("ball", |card| card.field.as_str());
    let name = |i: usize| loaded.physics.balls.get(i).map_or("?", |ball| ball.name.as_str());
    let wall = |i: usize| loaded.wall_fields.get(i).map_or("walls", String::as_str);
    match fault {
        SceneFault::Number { field, value, want } => {
            (number_field(field, card, wall), format!("is {value}: {want}"))
        }
        SceneFault::SameName { first, second, .. } => (
            format!("{}.name", card(*second)),
            format!("is {:?} like that of {}: give each ball a name of its own", name(*second), card(*first)),
        ),
        SceneFault::Overlap { first, second, depth } => {
            let (a, b) = (name(*first), name(*second));
            (
                card(*second).to_owned(),
                format!("{b:?} overlaps {a:?} ({}) by {depth:e} m: move them apart", card(*first)),
            )
        }
        SceneFault::OffFloor { ball, why } => {
            (card(*ball).to_owned(), format!("{:?} is not over the floor: {why}", name(*ball)))
        }
        SceneFault::InWall { ball, wall: i, depth } => (
            card(*ball).to_owned(),
            format!("{:?} reaches {depth:e} m into wall {i} ({}): move it inside", name(*ball), wall(*i)),
        ),
        SceneFault::TooCurved { ball, lo, hi, at } => (
            format!("{}.radius_m", card(*ball)),
            format!(
                "the floor's curvature times the radius of {:?} reaches {lo:.6} to {hi:.6} at {at}: it must stay below \
                 1, so use a smaller ball or a flatter floor",
                name(*ball)
            ),
        ),
        SceneFault::SecondTouch { ball, radius, lo, hi, contact, touch } => (
            format!("{}.radius_m", card(*ball)),
            format!(
                "is {radius}: the largest ball that touches the floor only once has {lo:.6} to {hi:.6} m, and one that \
                 lies at {contact} touches it again at {touch}, so use a smaller ball or a flatter floor"
            ),
        ),
        SceneFault::OpenBorder { .. } => ("walls".to_owned(), format!("{fault}: put a wall along it")),
        SceneFault::Degenerate { .. } => {
            ("floor".to_owned(), format!("{fault}: move its control points apart, or untwist them"))
        }
    }
}

/// The engine's `balls[2].radius` as the file's `ball[2].radius_m`.
fn number_field<'a>(field: &str, card: impl Fn(usize) -> &'a str, wall: impl Fn(usize) -> &'a str) -> String {
    let indexed = |list: &str| {
        let (index, rest) = field.strip_prefix(list)?.strip_prefix('[')?.split_once(']')?;
        Some((index.parse::<usize>().ok()?, rest.trim_start_matches('.')))
    };
    if let Some((i, rest)) = indexed("balls") {
        let card = card(i);
        let written = match rest {
            "radius" => "radius_m",
            "mass" if card.starts_with("cloud") => "density_kg_per_m3",
            "mass" => "mass_kg",
            "inertia_factor" => "inertia",
            "velocity" if card.starts_with("cloud") => "speed_rms_m_per_s",
            "velocity" => "velocity_m_per_s",
            "spin" => "spin_rad_per_s",
            _ => return card.to_owned(),
        };
        return format!("{card}.{written}");
    }
    if let Some((i, _)) = indexed("walls") {
        return wall(i).to_owned();
    }
    match field {
        "gravity" => "gravity_m_per_s2".to_owned(),
        _ => field.to_owned(),
    }
}
