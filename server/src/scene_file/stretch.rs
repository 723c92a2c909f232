//! A scene with another number of balls: its cloud holds more or fewer, and the room is stretched sideways until
//! each ball has as much of the floor as before. Heights stay, so that speeds and energies stay alike.

use super::{SceneError, SceneText};
use protocol::codec::MAX_BALLS;
use protocol::scene::{Cloud, Floor, Scene};

/// Gives the scene `count` balls in all.
pub fn to_count(text: &SceneText, scene: &mut Scene, count: u32) -> Result<(), SceneError> {
    let (written, clouds) = (scene.balls.len() as u32, scene.clouds.len());
    let [cloud] = scene.clouds.as_mut_slice() else {
        let message =
            format!("the scene has {clouds} clouds: only one with exactly one can have any number of balls");
        return Err(text.error("cloud", message));
    };
    if count <= written || count as usize > MAX_BALLS {
        let message =
            format!("{count} balls were asked for: this scene takes {} to {MAX_BALLS}", written + 1);
        return Err(text.error("cloud[0].count", message));
    }
    let factor = (f64::from(count) / (f64::from(written) + f64::from(cloud.count))).sqrt();
    cloud.count = count - written;
    stretch(scene, factor);
    Ok(())
}

/// Multiplies every horizontal length of the room, and no size of a ball.
fn stretch(scene: &mut Scene, factor: f64) {
    let each = |lengths: &mut [f64]| lengths.iter_mut().for_each(|x| *x *= factor);
    match &mut scene.floor {
        Floor::Grid { x_m, y_m, .. } => {
            each(x_m);
            each(y_m);
        }
        Floor::Net { control_points_m } => {
            control_points_m.iter_mut().flatten().for_each(|point| each(&mut point[..2]));
        }
        Floor::Polynomial { x_m, y_m, terms } => {
            each(x_m);
            each(y_m);
            for term in terms {
                (0..term.px + term.py).for_each(|_| term.c /= factor);
            }
        }
    }
    if let Some(bounds) = &mut scene.walls.bounds {
        each(&mut bounds.x_m);
        each(&mut bounds.y_m);
    }
    scene.walls.planes.iter_mut().for_each(|plane| each(&mut plane.point_m));
    for ball in &mut scene.balls {
        [&mut ball.center_m, &mut ball.contact_m].into_iter().flatten().for_each(|place| each(place));
    }
    for Cloud { around_m, within_m, .. } in &mut scene.clouds {
        each(around_m);
        *within_m *= factor;
    }
}
