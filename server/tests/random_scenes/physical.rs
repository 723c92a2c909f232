//! The first run of a scene, looked at beat by beat with the laws of mechanics in hand.

use crate::generate::BEATS;
use crate::script::{Act, Deed, act};
use ballroom_physics::{
    Accuracy, BallSpec, BallState, Controller, Hit, HitPartner, MotionLaw, Report, Scene,
};
use nalgebra::{Vector2, Vector3};
use protocol::scene::Floor;
use server::LoadedScene;

/// Deepest overlap, in radii of the smaller ball.
const OVERLAP: f64 = 1e-9;
/// How an error of velocity becomes one of position in the engine's tolerance, s.
const ERROR_TIME_S: f64 = 0.35;
/// Rounding of a sum of energies, relative to the sum of their sizes; and of one hit.
const ROUNDING: [f64; 2] = [1e-13, 1e-15];
/// What a hit below the rest speed may take, J/kg.
const REST_LOSS: f64 = 1e-12;
/// What a fixed step may lose of the energy: it promises nothing, and only faults that no step explains are caught.
const FIXED_STEP: f64 = 1e-4;

/// What the first run leaves for others to be compared with.
pub struct Run {
    /// The state hash after each beat.
    pub hashes: Vec<u64>,
    /// The balls at the end.
    pub last: Vec<BallState>,
    /// How many hits there were.
    pub hits: u64,
    /// How much of the script was refused.
    pub refused: u64,
    /// Whether hits piled up, so that balls were held or hopped.
    pub piled: bool,
}

/// Runs the scene at 60 Hz and holds it to the laws.
pub fn hold(loaded: &LoadedScene, start: &Controller, script: &[Act]) -> Result<Run, String> {
    let laws = Laws::of(loaded, start);
    let mut engine = start.clone();
    let mut hashes = vec![];
    let mut was = Sums::of(&laws, &engine);
    let first = was.energy;
    let (mut driven, mut refused) = (false, 0);
    for beat in 0..BEATS {
        refused += act(&mut engine, script, beat, |place| place);
        let deeds = || script.iter().filter(|act| act.beat == beat);
        driven |= deeds().any(|act| matches!(act.deed, Deed::Drive { .. }));
        // A push gives momentum of its own.
        was.momentum = laws.momentum(&engine);
        let mut hits = vec![];
        let before = engine.report();
        for tick in 1..=2 {
            engine.advance_to(ballroom_physics::Time::of_tick(2 * beat + tick, 60));
            hits.extend_from_slice(engine.hits());
        }
        hashes.push(engine.state_hash());
        let report = engine.report().since(&before);
        let now = Sums::of(&laws, &engine);
        laws.hold_places(&engine)
            .and_then(|()| laws.hold_energy(&engine, [first, was.energy, now.energy]))
            .and_then(|()| laws.hold_losses(&engine, &hits, &report, [was.energy, now.energy]))
            .and_then(
                |()| if driven { Ok(()) } else { laws.hold_momentum(&hits, was.momentum, now.momentum) },
            )
            .map_err(|fault| format!("{fault}, in beat {beat}"))?;
        was = now;
    }
    let (report, last) = (engine.report(), engine.balls().collect());
    let hits = report.collisions.ball_ball + report.collisions.ball_wall;
    Ok(Run { hashes, last, hits, refused, piled: report.fallbacks > 0 })
}

/// What is conserved.
struct Sums {
    /// Less what players put in, J.
    energy: f64,
    /// Over (1+k) m and horizontal, N s.
    momentum: Vector2<f64>,
}

impl Sums {
    fn of(laws: &Laws, engine: &Controller) -> Self {
        let energy = engine.energy() - engine.steering_work();
        Self { energy, momentum: laws.momentum(engine) }
    }
}

/// A scene seen as mechanics sees it; balls by id.
struct Laws<'a> {
    scene: &'a Scene,
    balls: Vec<&'a BallSpec>,
    /// Level floor and gravity straight down.
    flat: bool,
}

impl<'a> Laws<'a> {
    fn of(loaded: &'a LoadedScene, start: &Controller) -> Self {
        let scene = loaded.physics();
        let level = matches!(&loaded.scene().floor, Floor::Polynomial { terms, .. } if terms.is_empty());
        let flat = level && scene.gravity.x == 0.0 && scene.gravity.y == 0.0;
        Self { scene, balls: start.scene_index().iter().map(|i| &scene.balls[*i]).collect(), flat }
    }

    /// k where rotation takes part.
    fn k(&self, ball: &BallSpec) -> f64 {
        if self.scene.motion == MotionLaw::Rolling { ball.inertia_factor } else { 0.0 }
    }

    fn momentum(&self, engine: &Controller) -> Vector2<f64> {
        let each = self.balls.iter().zip(engine.balls());
        each.map(|(ball, state)| state.velocity.xy() * ((1.0 + self.k(ball)) * ball.mass)).sum()
    }

    /// How far a state read off an arc may lie from the true path, m: the tolerance. Schemes of fixed step name none.
    fn arc_error(&self) -> Option<f64> {
        match self.scene.accuracy {
            _ if self.flat => Some(0.0),
            Accuracy::Tolerance(tolerance) => Some(tolerance),
            Accuracy::Fixed(..) => None,
        }
    }

    /// All finite, on the floor, within the walls and apart.
    fn hold_places(&self, engine: &Controller) -> Result<(), String> {
        let states: Vec<BallState> = engine.balls().collect();
        let deepest = engine.report().deepest_penetration;
        let smallest = self.balls.iter().map(|ball| ball.radius).fold(f64::INFINITY, f64::min);
        if deepest > OVERLAP * smallest {
            return Err(format!("a hit overlaps by {deepest:e} m"));
        }
        let slack = self.arc_error();
        for (id, (ball, state)) in self.balls.iter().zip(&states).enumerate() {
            let vectors = [state.center, state.normal, state.velocity, state.omega];
            if !vectors.iter().flat_map(Vector3::iter).chain(&state.orientation).all(|x| x.is_finite()) {
                return Err(format!("ball {id} is nowhere: {state:?}"));
            }
            if state.uv.iter().any(|x| !(-1e-9..=1.0 + 1e-9).contains(x)) {
                return Err(format!("ball {id} leaves the floor at {}", state.uv));
            }
            let foot = engine.patch().jet(state.uv.x, state.uv.y).point;
            let off = (state.center - state.normal * ball.radius - foot).norm();
            let room = OVERLAP * ball.radius + slack.unwrap_or(1e-3 * ball.radius);
            if off > room {
                return Err(format!("ball {id} is {off:e} m off the floor"));
            }
            for (n, wall) in self.scene.walls.iter().enumerate() {
                let depth = ball.radius - wall.normal.dot(&(state.center.xy() - wall.point));
                if depth > room {
                    return Err(format!("ball {id} is {depth:e} m in wall {n}"));
                }
            }
            for (other, (theirs, there)) in self.balls.iter().zip(&states).enumerate().take(id) {
                let depth = ball.radius + theirs.radius - (state.center - there.center).norm();
                let room =
                    OVERLAP * ball.radius.min(theirs.radius) + 2.0 * slack.unwrap_or(1e-3 * ball.radius);
                if depth > room {
                    return Err(format!("balls {other} and {id} overlap by {depth:e} m"));
                }
            }
        }
        Ok(())
    }

    /// What the integrator and rounding may have changed of the energy until now, J.
    fn energy_room(&self, engine: &Controller) -> f64 {
        let report = engine.report();
        let hits = (report.collisions.ball_ball + report.collisions.ball_wall) as f64;
        let gravity = self.scene.gravity.norm();
        let mut room = 0.0;
        let mut size = 0.0;
        for (ball, state) in self.balls.iter().zip(engine.balls()) {
            let (k, speed) = (self.k(ball), state.velocity.norm());
            let sigma = ball.radius * state.omega.dot(&state.normal).abs();
            // Errors of place and speed that one tolerance holds, at twice the speed of now.
            let slope = gravity + 2.0 * ((1.0 + k) * speed + k * sigma) / ERROR_TIME_S;
            room += ball.mass * (slope * (1.0 + engine.time().seconds()));
            size += ball.mass
                * (0.5 * (1.0 + k) * speed * speed + 0.5 * k * sigma * sigma + gravity * state.center.norm());
        }
        let motion = match self.scene.accuracy {
            _ if self.flat => 0.0,
            Accuracy::Tolerance(tolerance) => room * tolerance,
            Accuracy::Fixed(..) => FIXED_STEP * size,
        };
        let mass: f64 = self.balls.iter().map(|ball| ball.mass).sum();
        motion + size * (ROUNDING[0] + ROUNDING[1] * hits) + report.rest_hits as f64 * REST_LOSS * mass
    }

    /// Conserved by elastic hits, never raised by others. Where hits piled up and balls were held, nothing is claimed.
    fn hold_energy(&self, engine: &Controller, [first, was, now]: [f64; 3]) -> Result<(), String> {
        if engine.report().fallbacks > 0 {
            return Ok(());
        }
        let room = self.energy_room(engine);
        if self.scene.restitution == 1.0 && (now - first).abs() > room {
            return Err(format!("the energy went from {first} to {now} J, by more than {room:e}"));
        }
        if now - was > room {
            return Err(format!("the energy rose from {was} to {now} J, by more than {room:e}"));
        }
        Ok(())
    }

    /// On a level floor each hit of impulse J takes `(1-e)/(1+e) J^2 (c^2/M_i + c^2/M_j)/2`, c the cosine of the line of
    /// centres with the floor. Several contacts at once are left to [`Self::hold_energy`].
    fn hold_losses(
        &self,
        engine: &Controller,
        hits: &[Hit],
        report: &Report,
        [was, now]: [f64; 2],
    ) -> Result<(), String> {
        if !self.flat || report.clusters > 0 || engine.report().fallbacks > 0 || report.rest_hits > 0 {
            return Ok(());
        }
        let e = self.scene.restitution;
        let inverse = |id: usize| 1.0 / ((1.0 + self.k(self.balls[id])) * self.balls[id].mass);
        let loss = |hit: &Hit| {
            let give = match hit.partner {
                HitPartner::Wall(_) => inverse(hit.ball),
                HitPartner::Ball(other) => {
                    let [r, s] = [hit.ball, other].map(|id| self.balls[id].radius);
                    (1.0 - ((r - s) / (r + s)).powi(2)) * (inverse(hit.ball) + inverse(other))
                }
            };
            0.5 * (1.0 - e) / (1.0 + e) * hit.impulse * hit.impulse * give
        };
        let due: f64 = hits.iter().map(loss).sum();
        let room = self.energy_room(engine) + 1e-12 * due;
        if (was - now - due).abs() > room {
            return Err(format!("hits took {} J where restitution says {due}, within {room:e}", was - now));
        }
        Ok(())
    }

    /// On a level floor only walls and players change it.
    fn hold_momentum(&self, hits: &[Hit], was: Vector2<f64>, now: Vector2<f64>) -> Result<(), String> {
        let walled = hits.iter().any(|hit| matches!(hit.partner, HitPartner::Wall(_)));
        if !self.flat || walled {
            return Ok(());
        }
        let mass: f64 = self.balls.iter().map(|ball| ball.mass).sum();
        let change = (now - was).norm();
        if change > 1e-12 * mass * (1.0 + was.norm() / mass) {
            return Err(format!("momentum went from {was} to {now}"));
        }
        Ok(())
    }
}
