//! The first run of a scene, looked at beat by beat with the laws of mechanics in hand.

use crate::generate::BEATS;
use crate::scheme::Scheme;
use crate::script::{Act, BEATS_PER_S, Deed, act};
use ballroom_physics::{Accuracy, BallSpec, BallState, Controller, Hit, HitPartner, MotionLaw, Scene};
use nalgebra::{Vector2, Vector3};
use protocol::scene::Floor;
use server::LoadedScene;

/// Deepest overlap, in radii of the smaller ball.
pub const OVERLAP: f64 = 1e-9;
/// Rounding of a place, in ulps of its largest coordinate.
const ULPS: f64 = 8.0;
/// What a step's measured change of energy is multiplied with, for steps that begin between the states that are measured.
const STEPS_BETWEEN: f64 = 2.0;
/// How an error of velocity becomes one of position in the engine's tolerance, s.
const ERROR_TIME_S: f64 = 0.35;
/// Rounding of a sum of energies, relative to the sum of their sizes; and of one hit.
const ROUNDING: [f64; 2] = [1e-13, 1e-15];
/// What a hit below the rest speed may take, J/kg.
const REST_LOSS: f64 = 1e-12;
/// What the first run leaves for others to be compared with.
pub struct Run {
    /// The state hash after each beat.
    pub hashes: Vec<u64>,
    /// What else each beat leaves.
    pub beats: Vec<Beat>,
    /// The balls at the end.
    pub last: Vec<BallState>,
    /// How many hits there were.
    pub hits: u64,
    /// How much of the script was refused.
    pub refused: u64,
    /// Whether hits piled up, so that balls were held or hopped.
    pub piled: bool,
    /// Deepest overlap or reach into a wall at a tick, over the smaller radius.
    pub deepest: f64,
}

/// What hits did in a beat.
pub struct Beat {
    pub hits: Vec<Hit>,
    /// Energy that went, J, and how much of it other than restitution explains.
    took: f64,
    room: f64,
    /// Whether every hit was one contact, and none was held or without rebound.
    plain: bool,
}

impl Beat {
    /// Whether the energy that went could be compared with what was `due` by restitution.
    pub fn hold_losses(&self, due: f64) -> Result<bool, String> {
        if !self.plain {
            return Ok(false);
        }
        let (took, room) = (self.took, self.room + 1e-12 * due);
        if (took - due).abs() > room {
            return Err(format!("hits took {took} J where restitution says {due}, within {room:e}"));
        }
        Ok(true)
    }
}

/// Runs the scene at 60 Hz and holds it to the laws.
pub fn hold(laws: &Laws<'_>, start: &Controller, script: &[Act]) -> Result<Run, String> {
    let mut engine = start.clone();
    let mut run =
        Run { hashes: vec![], beats: vec![], last: vec![], hits: 0, refused: 0, piled: false, deepest: 0.0 };
    let mut was = Sums::of(laws, &engine);
    let first = was.energy;
    let (mut driven, mut strayed) = (false, 0.0);
    for beat in 0..BEATS {
        run.refused += act(&mut engine, script, beat, |place| place);
        let deeds = || script.iter().filter(|act| act.beat == beat);
        driven |= deeds().any(|act| matches!(act.deed, Deed::Drive { .. }));
        // A push gives momentum of its own.
        was.momentum = laws.momentum(&engine);
        let mut hits = vec![];
        let before = engine.report();
        strayed += laws.stray(&engine, &[]);
        for tick in 1..=2 {
            engine.advance_to(ballroom_physics::Time::of_tick(2 * beat + tick, 60));
            hits.extend_from_slice(engine.hits());
        }
        run.hashes.push(engine.state_hash());
        let report = engine.report().since(&before);
        strayed += laws.stray(&engine, &hits);
        let now = Sums::of(laws, &engine);
        let room = laws.energy_room(&engine, strayed);
        let fault = |fault| format!("{fault}, in beat {beat}");
        run.deepest = run.deepest.max(laws.hold_places(&engine).map_err(fault)?);
        laws.hold_energy(&engine, room, [first, was.energy, now.energy]).map_err(fault)?;
        if !driven {
            laws.hold_momentum(&hits, was.momentum, now.momentum).map_err(fault)?;
        }
        let plain = report.clusters == 0 && engine.report().fallbacks == 0 && report.rest_hits == 0;
        run.beats.push(Beat { hits, took: was.energy - now.energy, room, plain });
        was = now;
    }
    let report = engine.report();
    run.last = engine.balls().collect();
    run.hits = report.collisions.ball_ball + report.collisions.ball_wall;
    run.piled = report.fallbacks > 0;
    Ok(run)
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
pub struct Laws<'a> {
    pub scene: &'a Scene,
    pub balls: Vec<&'a BallSpec>,
    /// Level floor and gravity straight down.
    flat: bool,
    scheme: Option<Scheme<'a>>,
}

impl<'a> Laws<'a> {
    pub fn of(loaded: &'a LoadedScene, start: &Controller) -> Self {
        let scene = loaded.physics();
        let level = matches!(&loaded.scene().floor, Floor::Polynomial { terms, .. } if terms.is_empty());
        let flat = level && scene.gravity.x == 0.0 && scene.gravity.y == 0.0;
        let balls = start.scene_index().iter().map(|i| &scene.balls[*i]).collect();
        Self { scene, balls, flat, scheme: Scheme::of(scene, start) }
    }

    /// k where rotation takes part.
    pub fn k(&self, ball: &BallSpec) -> f64 {
        if self.scene.motion == MotionLaw::Rolling { ball.inertia_factor } else { 0.0 }
    }

    fn momentum(&self, engine: &Controller) -> Vector2<f64> {
        let each = self.balls.iter().zip(engine.balls());
        each.map(|(ball, state)| state.velocity.xy() * ((1.0 + self.k(ball)) * ball.mass)).sum()
    }

    /// Energy that the steps of half a beat may lose or gain, J, and a step more for each of `hits`.
    fn stray(&self, engine: &Controller, hits: &[Hit]) -> f64 {
        let Some(scheme) = self.scheme.as_ref().filter(|_| !self.flat) else { return 0.0 };
        let of_ball = |id: usize| STEPS_BETWEEN * scheme.stray(self.balls[id], &engine.ball(id));
        let of_hit = |hit: &Hit| match hit.partner {
            HitPartner::Ball(other) => of_ball(hit.ball) + of_ball(other),
            HitPartner::Wall(_) => of_ball(hit.ball),
        };
        let steps = (0.5 / (f64::from(BEATS_PER_S) * scheme.step)).ceil();
        steps * (0..self.balls.len()).map(of_ball).sum::<f64>() + hits.iter().map(of_hit).sum::<f64>()
    }

    /// All finite, on the floor, within the walls and apart, to 1e-9 of the smaller radius whatever the scheme. Returns the
    /// deepest overlap, over that radius.
    fn hold_places(&self, engine: &Controller) -> Result<f64, String> {
        let states: Vec<BallState> = engine.balls().collect();
        let deepest = engine.report().deepest_penetration;
        let smallest = self.balls.iter().map(|ball| ball.radius).fold(f64::INFINITY, f64::min);
        let size = states.iter().map(|state| state.center.amax()).fold(0.0, f64::max);
        let rounding = ULPS * f64::EPSILON * size;
        if deepest > OVERLAP * smallest + rounding {
            return Err(format!("a hit overlaps by {deepest:e} m"));
        }
        let mut worst = 0.0_f64;
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
            let room = OVERLAP * ball.radius + rounding;
            if off > room {
                return Err(format!("ball {id} is {off:e} m off the floor"));
            }
            for (n, wall) in self.scene.walls.iter().enumerate() {
                let depth = ball.radius - wall.normal.dot(&(state.center.xy() - wall.point));
                worst = worst.max(depth / ball.radius);
                if depth > room {
                    return Err(format!("ball {id} is {depth:e} m in wall {n}"));
                }
            }
            for (other, (theirs, there)) in self.balls.iter().zip(&states).enumerate().take(id) {
                let depth = ball.radius + theirs.radius - (state.center - there.center).norm();
                let smaller = ball.radius.min(theirs.radius);
                let room = OVERLAP * smaller + rounding;
                worst = worst.max(depth / smaller);
                if depth > room {
                    return Err(format!("balls {other} and {id} overlap by {depth:e} m"));
                }
            }
        }
        Ok(worst)
    }

    /// What the integrator and rounding may have changed of the energy until now, J; `strayed` of it is that of a fixed step.
    fn energy_room(&self, engine: &Controller, strayed: f64) -> f64 {
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
            Accuracy::Fixed(..) => strayed,
        };
        let mass: f64 = self.balls.iter().map(|ball| ball.mass).sum();
        motion + size * (ROUNDING[0] + ROUNDING[1] * hits) + report.rest_hits as f64 * REST_LOSS * mass
    }

    /// Conserved by elastic hits, never raised by others. Where hits piled up and balls were held, nothing is claimed.
    fn hold_energy(&self, engine: &Controller, room: f64, [first, was, now]: [f64; 3]) -> Result<(), String> {
        if engine.report().fallbacks > 0 {
            return Ok(());
        }
        if self.scene.restitution == 1.0 && (now - first).abs() > room {
            return Err(format!("the energy went from {first} to {now} J, by more than {room:e}"));
        }
        if now - was > room {
            return Err(format!("the energy rose from {was} to {now} J, by more than {room:e}"));
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
