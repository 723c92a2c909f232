//! The run once more, halted at every hit: it must not change by a bit, the two must touch there, and the energy that hits
//! take must be what restitution says, from what is seen of them alone.

use crate::generate::BEATS;
use crate::physical::{Beat, Laws, OVERLAP, Run};
use crate::script::{Act, act};
use ballroom_physics::tolerance::REST_SPEED;
use ballroom_physics::{BallState, Controller, Hit, HitPartner, Time};
use nalgebra::Vector3;

/// First wait for a hit that the engine takes a little after its time, s; each further one is twice as long.
const WAIT_S: f64 = 1.0 / (1_u64 << 40) as f64;
/// Longest wait after which the hit's own place can still be told, s.
const LATE_S: f64 = 1e-7;
/// Rounding of a place, in ulps of its largest coordinate.
const ULPS: f64 = 8.0;

/// What was looked at.
#[derive(Clone, Copy, Debug, Default)]
pub struct Looks {
    /// Hits whose places were held to touching, and those that were taken too late for it.
    pub hits: u64,
    pub late: u64,
    /// Largest gap or overlap at a hit, over the smaller radius.
    pub farthest: f64,
    /// Beats in which hits took energy, held to restitution.
    pub losses: u64,
}

impl Looks {
    pub fn add(&mut self, other: &Self) {
        self.hits += other.hits;
        self.late += other.late;
        self.farthest = self.farthest.max(other.farthest);
        self.losses += other.losses;
    }
}

pub fn hold(laws: &Laws<'_>, start: &Controller, script: &[Act], run: &Run) -> Result<Looks, String> {
    let mut engine = start.clone();
    let mut looks = Looks::default();
    for beat in 0..BEATS {
        act(&mut engine, script, beat, |place| place);
        let Beat { hits, .. } = &run.beats[beat as usize];
        let end = Time::of_tick(beat + 1, crate::script::BEATS_PER_S);
        let mut hits: Vec<&Hit> = hits.iter().collect();
        hits.sort_by_key(|hit| hit.time);
        let mut told = vec![];
        let (mut due, mut all_seen) = (0.0, true);
        for hit in hits {
            let at = reach(&mut engine, hit, end, &mut told)
                .map_err(|fault| format!("{fault}, halted at hits in beat {beat}"))?;
            let late = at.since(hit.time);
            // Who was hit again meanwhile came another way.
            let again = |other: &Hit| hit.time < other.time && other.time <= at && meet(other, hit);
            if late > LATE_S || told.iter().any(again) {
                looks.late += 1;
                all_seen = false;
                continue;
            }
            looks.hits += 1;
            let impact = Impact::seen(laws, &engine, hit, late);
            let far = impact.hold(laws, hit).map_err(|fault| format!("{fault}, in beat {beat}"))?;
            looks.farthest = looks.farthest.max(far);
            due += impact.loss(laws, hit);
        }
        engine.advance_to(end);
        if engine.state_hash() != run.hashes[beat as usize] {
            return Err(format!("halted at every hit: the state hash differs after beat {beat}"));
        }
        if all_seen {
            let held = run.beats[beat as usize]
                .hold_losses(due)
                .map_err(|fault| format!("{fault}, in beat {beat}"))?;
            looks.losses += u64::from(held && due > 0.0);
        }
    }
    Ok(looks)
}

/// Whether two hits share a ball.
fn meet(one: &Hit, two: &Hit) -> bool {
    let balls = |hit: &Hit| {
        let other = if let HitPartner::Ball(other) = hit.partner { other } else { hit.ball };
        [hit.ball, other]
    };
    balls(one).iter().any(|ball| balls(two).contains(ball))
}

/// Advances until the engine has told of `hit`, which it may take a little after its time.
fn reach(engine: &mut Controller, hit: &Hit, end: Time, told: &mut Vec<Hit>) -> Result<Time, String> {
    let mut wait = 0.0;
    while !told.contains(hit) {
        let until = hit.time.after(wait).max(engine.time()).min(end);
        engine.advance_to(until);
        told.extend_from_slice(engine.hits());
        if until == end && !told.contains(hit) {
            return Err(format!("{hit:?} is not told again"));
        }
        wait = if wait == 0.0 { WAIT_S } else { 2.0 * wait };
    }
    Ok(engine.time().max(hit.time))
}

/// A hit as the balls show it: places brought back to its time.
struct Impact {
    /// Distance from touching, m; negative for an overlap.
    gap: f64,
    /// Radius of the smaller ball, and largest coordinate, m.
    radius: f64,
    size: f64,
    /// Change of the closing speed by a unit impulse, 1/kg.
    give: f64,
    /// What a wait leaves unsure of the place, m.
    unsure: f64,
}

impl Impact {
    fn seen(laws: &Laws<'_>, engine: &Controller, hit: &Hit, late: f64) -> Self {
        let at = |state: &BallState| state.center - state.velocity * late;
        let one = engine.ball(hit.ball);
        let ball = laws.balls[hit.ball];
        // |P d|^2/M, d the line of contact and P the projection to the tangent plane.
        let give = |id: usize, state: &BallState, line: &Vector3<f64>| {
            let tangent = line - state.normal * line.dot(&state.normal);
            tangent.norm_squared() / ((1.0 + laws.k(laws.balls[id])) * laws.balls[id].mass)
        };
        let fall = laws.scene.gravity.norm() + one.velocity.norm_squared() / ball.radius;
        let unsure = fall * late * late;
        match hit.partner {
            HitPartner::Wall(wall) => {
                let wall = &laws.scene.walls[wall];
                let normal = wall.normal.push(0.0);
                let gap = wall.normal.dot(&(at(&one).xy() - wall.point)) - ball.radius;
                let give = give(hit.ball, &one, &normal);
                Self { gap, radius: ball.radius, size: one.center.amax(), give, unsure }
            }
            HitPartner::Ball(other) => {
                let two = engine.ball(other);
                let theirs = laws.balls[other];
                let apart = at(&two) - at(&one);
                let line = apart.normalize();
                Self {
                    gap: apart.norm() - (ball.radius + theirs.radius),
                    radius: ball.radius.min(theirs.radius),
                    size: one.center.amax().max(two.center.amax()),
                    give: give(hit.ball, &one, &line) + give(other, &two, &line),
                    unsure: 2.0 * unsure,
                }
            }
        }
    }

    /// Nobody overlaps at a hit, and who is fast has not turned before touching. Returns how far from touching, over the
    /// smaller radius.
    fn hold(&self, laws: &Laws<'_>, hit: &Hit) -> Result<f64, String> {
        let room = OVERLAP * self.radius + ULPS * f64::EPSILON * self.size + self.unsure;
        let closing = hit.impulse * self.give / (1.0 + laws.scene.restitution);
        if -self.gap > room || (closing > 2.0 * REST_SPEED && self.gap > room) {
            return Err(format!(
                "{hit:?} is {:e} m from touching at {closing:e} m/s, by more than {room:e}",
                self.gap
            ));
        }
        Ok(self.gap.abs() / self.radius)
    }

    /// `(1-e)/(1+e) J^2 give/2`, J.
    fn loss(&self, laws: &Laws<'_>, hit: &Hit) -> f64 {
        let e = laws.scene.restitution;
        0.5 * (1.0 - e) / (1.0 + e) * hit.impulse * hit.impulse * self.give
    }
}
