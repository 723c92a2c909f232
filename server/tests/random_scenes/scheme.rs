//! What one step of a scheme of fixed step does to the energy, measured: each ball alone, from where it is, forward and
//! backward. What a run may lose or gain by its steps follows from it.

use ballroom_physics::motion::arc::Arc;
use ballroom_physics::motion::body::{Body, Stepping};
use ballroom_physics::motion::law::State;
use ballroom_physics::surface::chart::Surface;
use ballroom_physics::{Accuracy, BallSpec, BallState, Controller, MotionLaw, Scene, Time};
use nalgebra::Vector3;

/// Places of a step that are looked at.
const LOOKS: u32 = 6;

/// A scheme of fixed step on a scene's floor.
pub struct Scheme<'a> {
    scene: &'a Scene,
    surface: Surface,
    /// Length of its step, s.
    pub step: f64,
}

impl<'a> Scheme<'a> {
    /// None for a scene with a tolerance.
    pub fn of(scene: &'a Scene, start: &Controller) -> Option<Self> {
        let Accuracy::Fixed(_, step) = scene.accuracy else { return None };
        let surface = Surface::new(&scene.floor, start.patch(), start.certificate().orientation);
        Some(Self { scene, surface, step })
    }

    /// The largest change of energy within a step that begins or ends in `state`, J.
    pub fn stray(&self, ball: &BallSpec, state: &BallState) -> f64 {
        let rolls = self.scene.motion == MotionLaw::Rolling;
        let body = Body {
            radius: ball.radius,
            inertia_factor: if rolls { ball.inertia_factor } else { 0.0 },
            rolls,
            applied: self.scene.gravity,
        };
        let [p, q] = self.surface.chart([state.uv.x, state.uv.y]);
        let spin = if rolls { state.omega.dot(&state.normal) * ball.radius } else { 0.0 };
        let mut worst = 0.0_f64;
        for sign in [1.0, -1.0] {
            let w = state.velocity * sign;
            let arc = self.arc(&body, &[p, q, w.x, w.y, w.z, spin * sign]);
            let before = self.energy(&body, &arc, 0.0);
            for look in 1..=LOOKS {
                let dt = self.step * f64::from(look) / f64::from(LOOKS);
                worst = worst.max((self.energy(&body, &arc, dt) - before).abs());
            }
        }
        worst * ball.mass
    }

    fn arc(&self, body: &Body, from: &State) -> Arc {
        let mut stepping = Stepping { try_s: self.step, steps: 0, forced: 0 };
        let mut arc = Arc::empty(body.radius);
        body.launch(&self.surface, self.scene.accuracy, (Time::ZERO, from), &mut stepping, &mut arc);
        arc
    }

    /// J/kg.
    fn energy(&self, body: &Body, arc: &Arc, dt: f64) -> f64 {
        let (state, center, _) = arc.sample(body, &self.surface, dt);
        let (k, w) = (body.inertia_factor, Vector3::new(state[2], state[3], state[4]));
        0.5 * (1.0 + k) * w.norm_squared() + 0.5 * k * state[5] * state[5] - self.scene.gravity.dot(&center)
    }
}
