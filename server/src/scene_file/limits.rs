//! Which numbers make sense. The ranges are far wider than any scene needs: beyond them a slip of the pen is likelier
//! than a wish, and rounding would eat the tolerance.

use super::{SceneError, SceneText, palette};
use ballroom_physics::surface::bezier::MAX_DEGREE;
use protocol::codec::{MAX_BALL_NAME_BYTES, MAX_BALLS};
use protocol::keys::Name;
use protocol::scene::{Accuracy, Ball, Cloud, Floor, Inertia, MAX_TAGS, Scene};
use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// Places, m.
const PLACE: RangeInclusive<f64> = -1e6..=1e6;
/// Radii and lengths of things, m.
const SIZE: RangeInclusive<f64> = 1e-6..=1e6;
/// Speeds, m/s.
const SPEED: RangeInclusive<f64> = -1e4..=1e4;

/// Refuses the first number, name or size out of its range.
pub fn check(text: &SceneText, scene: &Scene) -> Result<(), SceneError> {
    let check = Check { text };
    if scene.name.parse::<Name>().is_err() {
        return check.refuse("name", format!("is {:?}: use 1 to 32 of a-z, 0-9, _ and -", scene.name));
    }
    check.all("gravity_m_per_s2", &scene.gravity_m_per_s2, &(-1e4..=1e4))?;
    if scene.gravity_m_per_s2[2] >= 0.0 {
        return check.refuse("gravity_m_per_s2", "must point down: its third number is below 0".into());
    }
    check.number("restitution", scene.restitution, &(0.0..=1.0))?;
    match scene.accuracy {
        Accuracy::Tolerance { tolerance_m } => {
            check.number("accuracy.tolerance_m", tolerance_m, &(1e-13..=1e-2))
        }
        Accuracy::Error { error_m } => check.number("accuracy.error_m", error_m, &(1e-11..=1e-2)),
        Accuracy::Budget { budget_evaluations } => {
            check.number("accuracy.budget_evaluations", budget_evaluations, &(1.0..=1e9))
        }
        Accuracy::Fixed { step_s, .. } => check.number("accuracy.step_s", step_s, &(1e-6..=0.1)),
    }?;
    if scene.hit_budget == 0 {
        return check.refuse("hit_budget", "is 0: use at least 1, or leave it out".into());
    }
    check.floor(&scene.floor)?;
    check.walls(scene)?;
    check.number("steering.impulse_m_per_s", scene.steering.impulse_m_per_s, &(0.0..=1e4))?;
    check.number("steering.acceleration_m_per_s2", scene.steering.acceleration_m_per_s2, &(0.0..=1e4))?;
    check.number("steering.speed_limit_m_per_s", scene.steering.speed_limit_m_per_s, &(0.0..=1e4))?;
    let mut count = scene.balls.len();
    for (i, cloud) in scene.clouds.iter().enumerate() {
        check.cloud(i, cloud)?;
        count = count.saturating_add(cloud.count as usize);
    }
    if count > MAX_BALLS {
        let field = if scene.clouds.is_empty() { "ball" } else { "cloud[0].count" };
        return check.refuse(field, format!("the scene holds {count} balls: at most {MAX_BALLS} are run"));
    }
    let mut names = BTreeMap::new();
    for (i, ball) in scene.balls.iter().enumerate() {
        check.ball(&format!("ball[{i}]"), ball)?;
        if let Some(first) = names.insert(ball.name.as_str(), i) {
            let message =
                format!("is {:?} like ball[{first}]'s: give each ball a name of its own", ball.name);
            return check.refuse(format_args!("ball[{i}].name"), message);
        }
    }
    Ok(())
}

/// Refuses the first number or name of a ball out of its range; `field` is what it stands under.
pub fn check_ball(text: &SceneText, field: &str, ball: &Ball) -> Result<(), SceneError> {
    Check { text }.ball(field, ball)
}

struct Check<'a> {
    text: &'a SceneText,
}

impl Check<'_> {
    fn refuse<T>(&self, field: impl Display, message: String) -> Result<T, SceneError> {
        Err(self.text.error(field, message))
    }

    fn number(&self, field: impl Display, value: f64, range: &RangeInclusive<f64>) -> Result<(), SceneError> {
        // NaN is in no range.
        if range.contains(&value) {
            return Ok(());
        }
        self.refuse(field, format!("is {value}: use a number from {} to {}", range.start(), range.end()))
    }

    fn all(
        &self,
        field: impl Display,
        values: &[f64],
        range: &RangeInclusive<f64>,
    ) -> Result<(), SceneError> {
        values.iter().enumerate().try_for_each(|(i, &x)| self.number(format_args!("{field}[{i}]"), x, range))
    }

    fn interval(&self, field: impl Display, [low, high]: [f64; 2]) -> Result<(), SceneError> {
        self.all(&field, &[low, high], &PLACE)?;
        if high - low >= *SIZE.start() {
            return Ok(());
        }
        self.refuse(field, format!("goes from {low} to {high}: the second number must be the larger"))
    }

    fn inertia(&self, field: impl Display, inertia: Inertia) -> Result<(), SceneError> {
        self.number(field, inertia.factor(), &(0.0..=2.0 / 3.0))
    }

    fn floor(&self, floor: &Floor) -> Result<(), SceneError> {
        match floor {
            Floor::Grid { x_m, y_m, control_heights_m: rows } => {
                self.interval("floor.grid.x_m", *x_m)?;
                self.interval("floor.grid.y_m", *y_m)?;
                self.net_size("floor.grid.control_heights_m", rows)?;
                rows.iter().enumerate().try_for_each(|(j, row)| {
                    self.all(format_args!("floor.grid.control_heights_m[{j}]"), row, &PLACE)
                })
            }
            Floor::Net { control_points_m: rows } => {
                self.net_size("floor.net.control_points_m", rows)?;
                rows.iter().enumerate().try_for_each(|(j, row)| {
                    row.iter().enumerate().try_for_each(|(i, point)| {
                        self.all(format_args!("floor.net.control_points_m[{j}][{i}]"), point, &PLACE)
                    })
                })
            }
            Floor::Polynomial { x_m, y_m, terms } => {
                self.interval("floor.polynomial.x_m", *x_m)?;
                self.interval("floor.polynomial.y_m", *y_m)?;
                for (i, term) in terms.iter().enumerate() {
                    let field = format!("floor.polynomial.terms[{i}]");
                    self.number(format_args!("{field}.c"), term.c, &(-1e9..=1e9))?;
                    for (name, power) in [("px", term.px), ("py", term.py)] {
                        self.number(
                            format_args!("{field}.{name}"),
                            f64::from(power),
                            &(0.0..=MAX_DEGREE as f64),
                        )?;
                    }
                }
                Ok(())
            }
        }
    }

    /// A net has 2 to 13 rows, all of one length of 2 to 13.
    fn net_size<T>(&self, field: &str, rows: &[Vec<T>]) -> Result<(), SceneError> {
        let sizes = 2..=MAX_DEGREE + 1;
        let most = sizes.end();
        if !sizes.contains(&rows.len()) {
            return self.refuse(field, format!("has {} rows: use 2 to {most}", rows.len()));
        }
        let width = rows[0].len();
        if !sizes.contains(&width) {
            return self.refuse(format_args!("{field}[0]"), format!("has {width} entries: use 2 to {most}"));
        }
        match rows.iter().position(|row| row.len() != width) {
            Some(j) => {
                let message =
                    format!("has {} entries, the first row has {width}: make them equal", rows[j].len());
                self.refuse(format_args!("{field}[{j}]"), message)
            }
            None => Ok(()),
        }
    }

    fn walls(&self, scene: &Scene) -> Result<(), SceneError> {
        if let Some(bounds) = scene.walls.bounds {
            self.interval("walls.box.x_m", bounds.x_m)?;
            self.interval("walls.box.y_m", bounds.y_m)?;
        }
        if scene.walls.planes.len() > 256 {
            return self
                .refuse("walls.plane", format!("has {} walls: use at most 256", scene.walls.planes.len()));
        }
        for (i, plane) in scene.walls.planes.iter().enumerate() {
            self.all(format_args!("walls.plane[{i}].point_m"), &plane.point_m, &PLACE)?;
            self.all(format_args!("walls.plane[{i}].normal"), &plane.normal, &PLACE)?;
            if plane.normal[0].hypot(plane.normal[1]) < 1e-6 {
                return self.refuse(format_args!("walls.plane[{i}].normal"), "has no direction".into());
            }
        }
        scene.walls.drawn_height_m.map_or(Ok(()), |height| self.number("walls.drawn_height_m", height, &SIZE))
    }

    fn ball(&self, place: &str, ball: &Ball) -> Result<(), SceneError> {
        let field = |name: &str| format!("{place}.{name}");
        if ball.name.is_empty()
            || ball.name.len() > MAX_BALL_NAME_BYTES
            || ball.name.contains(char::is_control)
        {
            let message =
                format!("is {:?}: use 1 to {MAX_BALL_NAME_BYTES} bytes without control signs", ball.name);
            return self.refuse(field("name"), message);
        }
        self.number(field("radius_m"), ball.radius_m, &SIZE)?;
        self.number(field("mass_kg"), ball.mass_kg, &(1e-12..=1e15))?;
        self.inertia(field("inertia"), ball.inertia)?;
        let places = [("center_m", ball.center_m), ("contact_m", ball.contact_m), ("uv", ball.uv)];
        let given = places.iter().filter(|(_, place)| place.is_some()).count();
        if given != 1 {
            let message = format!("has {given} places: give exactly one of center_m, contact_m and uv");
            return self.refuse(place, message);
        }
        for (name, place) in places {
            let range = if name == "uv" { 0.0..=1.0 } else { PLACE };
            place.map_or(Ok(()), |xy| self.all(field(name), &xy, &range))?;
        }
        self.all(field("velocity_m_per_s"), &ball.velocity_m_per_s, &SPEED)?;
        self.number(field("spin_rad_per_s"), ball.spin_rad_per_s, &(-1e6..=1e6))?;
        self.tags(field("tags"), &ball.tags)?;
        match &ball.color {
            Some(color) if palette::parse(color).is_none() => {
                self.refuse(field("color"), format!("is {color:?}: write it as \"#rrggbb\""))
            }
            _ => Ok(()),
        }
    }

    fn tags(&self, field: impl Display, tags: &[String]) -> Result<(), SceneError> {
        if tags.len() > MAX_TAGS {
            return self.refuse(field, format!("has {} tags: use at most {MAX_TAGS}", tags.len()));
        }
        match tags.iter().position(|tag| tag.parse::<Name>().is_err()) {
            Some(i) => self.refuse(
                format_args!("{field}[{i}]"),
                format!("is {:?}: use 1 to 32 of a-z, 0-9, _ and -", tags[i]),
            ),
            None => Ok(()),
        }
    }

    fn cloud(&self, i: usize, cloud: &Cloud) -> Result<(), SceneError> {
        let field = |name: &str| format!("cloud[{i}].{name}");
        if cloud.name.parse::<Name>().is_err() {
            return self
                .refuse(field("name"), format!("is {:?}: use 1 to 32 of a-z, 0-9, _ and -", cloud.name));
        }
        self.number(field("count"), f64::from(cloud.count), &(1.0..=MAX_BALLS as f64))?;
        self.all(field("radius_m"), &cloud.radius_m, &SIZE)?;
        if cloud.radius_m[0] > cloud.radius_m[1] {
            return self.refuse(field("radius_m"), "the second radius must be the larger".into());
        }
        self.number(field("density_kg_per_m3"), cloud.density_kg_per_m3, &(1e-6..=1e9))?;
        self.inertia(field("inertia"), cloud.inertia)?;
        self.all(field("around_m"), &cloud.around_m, &PLACE)?;
        self.number(field("within_m"), cloud.within_m, &SIZE)?;
        self.tags(field("tags"), &cloud.tags)?;
        self.number(field("speed_rms_m_per_s"), cloud.speed_rms_m_per_s, &(0.0..=*SPEED.end()))
    }
}
