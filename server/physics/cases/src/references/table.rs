//! The generated files: states at ticks and times of hits in more digits than the engine has.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// Rate of the ticks, Hz: sevenths of a second fall everywhere within the engine's steps, which are short binary fractions.
pub const RATE_HZ: u32 = 7;
/// How far the files go, s.
pub const SECONDS: u32 = 10;

/// A ball at a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Centre, m.
    pub center: Vector3<f64>,
    /// Velocity of the centre, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity in rad/s and orientation, ball to world, if it rolls.
    pub turning: Option<(Vector3<f64>, UnitQuaternion<f64>)>,
}

/// What a file says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Largest difference of any number between two computations of different order, step and length of numbers.
    pub own_error: f64,
    /// States by tick and ball.
    pub ticks: Vec<Vec<Seen>>,
    /// Times of the hits in their order, s.
    pub hits: Vec<f64>,
}

impl Table {
    /// Reads a file of this crate.
    ///
    /// # Panics
    /// With the line that is not as the generator writes it.
    pub fn read(text: &str) -> Self {
        let mut table = Self::default();
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            table.take(line).unwrap_or_else(|| panic!("not a line of a reference: {line}"));
        }
        table
    }

    /// The error that a file carries, without reading the rest; not a number if it carries none.
    pub fn own_error_of(text: &str) -> f64 {
        let error = text.lines().find_map(|line| line.strip_prefix("error,"));
        error.and_then(|error| error.parse().ok()).unwrap_or(f64::NAN)
    }

    fn take(&mut self, line: &str) -> Option<()> {
        let (kind, rest) = line.split_once(',')?;
        let numbers: Vec<f64> = rest.split(',').map(str::parse).collect::<Result<_, _>>().ok()?;
        match (kind, numbers.as_slice()) {
            ("error", [error]) => self.own_error = *error,
            ("hit", [_, seconds]) => self.hits.push(*seconds),
            ("tick", [tick, ball, state @ ..]) => {
                if self.ticks.len() == *tick as usize {
                    self.ticks.push(vec![]);
                }
                let balls = self.ticks.last_mut()?;
                (balls.len() == *ball as usize).then(|| balls.push(seen(state)))?;
            }
            _ => return None,
        }
        Some(())
    }
}

fn seen(state: &[f64]) -> Seen {
    let vector = |at: usize| Vector3::from_row_slice(&state[at..at + 3]);
    let turning = (state.len() == 13).then(|| {
        let q = Quaternion::new(state[12], state[9], state[10], state[11]);
        (vector(6), UnitQuaternion::from_quaternion(q))
    });
    Seen { center: vector(0), velocity: vector(3), turning }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_to_the_last_number() {
        let table = Table::read(
            "# words\nerror,1e-20\ntick,0,0,1,2,3,4,5,6\ntick,0,1,1,2,3,4,5,6,7,8,9,0,0,0,1\nhit,0,0.5\ntick,1,0,2,2,3,4,5,6",
        );
        assert_eq!((table.own_error, table.hits.as_slice()), (1e-20, &[0.5][..]));
        assert_eq!(table.ticks.iter().map(Vec::len).collect::<Vec<_>>(), [2, 1]);
        assert_eq!(table.ticks[1][0].center.x, 2.0);
        let (omega, orientation) = table.ticks[0][1].turning.unwrap();
        assert_eq!((omega.z, orientation.angle()), (9.0, 0.0));
    }
}
