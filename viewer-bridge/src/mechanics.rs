//! What follows from a ball's state and its constants: its energy in three parts, and the floor's reaction.

use crate::surface::Jet;
use nalgebra::{Matrix2, Vector2, Vector3};
use protocol::scene::{Motion, Scene};
use protocol::snapshot::{Roster, Snapshot};

/// Energy in its parts, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Of the centre's motion.
    pub kinetic_j: f64,
    /// Of the rotation; 0 for a sliding ball, whose rotation nothing changes.
    pub spin_j: f64,
    /// Of the centre's height over z = 0.
    pub potential_j: f64,
}

impl Energy {
    /// All of it, J.
    pub fn total_j(self) -> f64 {
        self.kinetic_j + self.spin_j + self.potential_j
    }
}

impl std::iter::Sum for Energy {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), |sum, part| Self {
            kinetic_j: sum.kinetic_j + part.kinetic_j,
            spin_j: sum.spin_j + part.spin_j,
            potential_j: sum.potential_j + part.potential_j,
        })
    }
}

/// The constants of a scene's motion.
#[derive(Clone, Copy, Debug)]
pub struct Mechanics {
    gravity: Vector3<f64>,
    rolls: bool,
}

impl Mechanics {
    /// Those of a scene.
    pub fn of(scene: &Scene) -> Self {
        Self { gravity: scene.gravity_m_per_s2.into(), rolls: scene.motion == Motion::Rolling }
    }

    /// A ball's energy.
    pub fn energy(&self, roster: &Roster, state: &Snapshot, ball: usize) -> Energy {
        let [mass, radius] = [roster.mass_kg[ball], roster.radius_m[ball]];
        let squared = |vector: [f64; 3]| Vector3::from(vector).norm_squared();
        let inertia = if self.rolls { roster.inertia_factor[ball] * mass * radius * radius } else { 0.0 };
        Energy {
            kinetic_j: 0.5 * mass * squared(state.velocity_m_per_s[ball]),
            spin_j: 0.5 * inertia * squared(state.omega_rad_per_s[ball]),
            potential_j: -mass * self.gravity.dot(&Vector3::from(state.center_m[ball])),
        }
    }

    /// The force with which the floor, `jet` at the ball's (u, v), presses on it along the normal, N. Below 0 the floor would have to pull.
    ///
    /// The centre stays a radius r above the contact point S, so with w its velocity and n the upward normal
    /// `w.n = 0` always, and `n.w' = -n'.w`. Newton's law along n then gives `N = -m (g.n + n'.w)`, where the
    /// contact point moves with q' from `(I - r II) q' = [S_u.w; S_v.w]`, and `n'.w = -q'.II I^-1 [S_u.w; S_v.w]`
    /// (Weingarten). A force that a player holds is not on the wire, so its part along n is missing here.
    pub fn reaction_n(&self, jet: &Jet, roster: &Roster, state: &Snapshot, ball: usize) -> f64 {
        let normal = jet.normal;
        let velocity = Vector3::from(state.velocity_m_per_s[ball]);
        let form = |a: f64, b: f64, c: f64| Matrix2::new(a, b, b, c);
        let first = form(jet.du.norm_squared(), jet.du.dot(&jet.dv), jet.dv.norm_squared());
        let second = form(normal.dot(&jet.duu), normal.dot(&jet.duv), normal.dot(&jet.dvv));
        let along = Vector2::new(jet.du.dot(&velocity), jet.dv.dot(&velocity));
        let parallel = (first - second * roster.radius_m[ball]).try_inverse();
        let turning = parallel.zip(first.try_inverse()).map_or(0.0, |(parallel, inverse)| {
            let contact = parallel * along;
            -contact.dot(&(second * inverse * along))
        });
        -roster.mass_kg[ball] * (self.gravity.dot(&normal) + turning)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Surface;
    use protocol::scene::{Floor, Term};

    const GRAVITY: f64 = 9.8;

    /// z = c x^2 over a square of 8 m.
    fn trough(c: f64) -> Surface {
        let terms = vec![Term { px: 2, py: 0, c }];
        Surface::of(&Floor::Polynomial { x_m: [-4.0, 4.0], y_m: [-4.0, 4.0], terms }).unwrap()
    }

    /// One ball of 2 kg and 0.5 m above the middle of the floor.
    fn ball(velocity: [f64; 3]) -> (Mechanics, Roster, Snapshot) {
        let mechanics = Mechanics { gravity: Vector3::new(0.0, 0.0, -GRAVITY), rolls: true };
        let roster = Roster {
            names: vec!["a".into()],
            radius_m: vec![0.5],
            mass_kg: vec![2.0],
            inertia_factor: vec![0.4],
            color_rgb: vec![[0; 3]],
            player: vec![false],
            ..Roster::default()
        };
        let state = Snapshot {
            uv: vec![[0.5, 0.5]],
            center_m: vec![[0.0, 0.0, 0.5]],
            velocity_m_per_s: vec![velocity],
            omega_rad_per_s: vec![[-velocity[1] / 0.5, velocity[0] / 0.5, 3.0]],
            orientation_xyzw: vec![[0.0, 0.0, 0.0, 1.0]],
            ..Snapshot::default()
        };
        (mechanics, roster, state)
    }

    #[test]
    fn a_ball_at_rest_presses_with_its_weight_and_on_a_slope_with_its_part() {
        let (mechanics, roster, state) = ball([0.0; 3]);
        let weight = 2.0 * GRAVITY;
        assert!(
            (mechanics.reaction_n(&trough(0.3).jet(0.5, 0.5), &roster, &state, 0) - weight).abs() < 1e-12
        );
        let slope = vec![Term { px: 1, py: 0, c: 0.75 }];
        let slope =
            Surface::of(&Floor::Polynomial { x_m: [-4.0, 4.0], y_m: [-4.0, 4.0], terms: slope }).unwrap();
        assert!(
            (mechanics.reaction_n(&slope.jet(0.5, 0.5), &roster, &state, 0) - 0.8 * weight).abs() < 1e-12
        );
    }

    #[test]
    fn in_a_trough_the_centripetal_force_of_the_centres_path_is_added_and_over_a_ridge_taken_away() {
        let speed = 3.0;
        for c in [0.3, -0.3] {
            // At the lowest point the contact's radius of curvature is 1/(2c); the centre's is shorter by r.
            let path: f64 = 1.0 / (2.0 * c) - 0.5;
            let expected = 2.0 * (GRAVITY + speed * speed / path);
            let (mechanics, roster, state) = ball([speed, 0.0, 0.0]);
            let found = mechanics.reaction_n(&trough(c).jet(0.5, 0.5), &roster, &state, 0);
            assert!((found - expected).abs() < 1e-11 * expected.abs(), "{c}: {found} {expected}");
            // Along the trough nothing turns.
            let (mechanics, roster, state) = ball([0.0, speed, 0.0]);
            let found = mechanics.reaction_n(&trough(c).jet(0.5, 0.5), &roster, &state, 0);
            assert!((found - 2.0 * GRAVITY).abs() < 1e-11);
        }
    }

    #[test]
    fn the_parts_of_the_energy_are_those_of_a_solid_ball() {
        let (mut mechanics, roster, state) = ball([3.0, 4.0, 0.0]);
        let energy = mechanics.energy(&roster, &state, 0);
        assert!((energy.kinetic_j - 25.0).abs() < 1e-12);
        // Rolling takes 2/5 of the translation's energy; 3 rad/s about the normal add 1/2 k m r^2 9.
        assert!((energy.spin_j - (10.0 + 0.5 * 0.4 * 2.0 * 0.25 * 9.0)).abs() < 1e-12);
        assert!((energy.potential_j - 2.0 * GRAVITY * 0.5).abs() < 1e-12);
        mechanics.rolls = false;
        assert_eq!(mechanics.energy(&roster, &state, 0).spin_j, 0.0);
    }
}
