//! Hits computed ahead of their time, so that the balls of several are landed and launched side by side.
//!
//! When a hit is due, the next few in the queue are landed with it, and the arcs that follow a hit if nobody else touches
//! its balls are launched together too. Both follow from the arcs that the balls are on, and are the same numbers whenever
//! they are computed. When a hit's turn comes, what was foreseen is used if its balls are still on those arcs, and what was
//! launched if the impact left them in those very states.

use super::Controller;
use super::approach::Due;
use super::prepare::Prepared;
use crate::diagnostics::HitPartner;
use crate::lanes::LANES_MAX;
use crate::motion::arc::{Arc, Path};
use crate::motion::follow::orientations;
use crate::motion::law::State;
use crate::schedule::calendar::Calendar;
use crate::schedule::event::What;
use crate::schedule::time::Time;
use nalgebra::Vector3;

/// Balls below which nothing is foreseen: hits of few balls are soon overtaken by others.
const BALLS_MIN: usize = 16;
/// Hits kept: more than are due on the days that a group is taken from.
const KEPT: usize = 4 * LANES_MAX;

/// What a ball's arc follows from, beside its body and the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Origin {
    start: Time,
    state: State,
    length: f64,
    path: Path,
    applied: Vector3<f64>,
    orientation: [f64; 4],
}

/// A hit, landed on, and what its balls do next.
#[derive(Clone, Debug)]
struct Foreseen {
    hit: Due,
    of: [Option<Origin>; 2],
    /// Of the balls at the impact.
    orientation: [[f64; 4]; 2],
    next: [Prepared; 2],
    /// How many of `next` are launched.
    launched: usize,
}

/// The hits that are foreseen.
#[derive(Debug)]
pub(super) struct Foresight {
    list: Vec<Foreseen>,
    /// What the hits in the list were predicted for; [`Time::NEVER`] in a free place.
    events: Vec<Time>,
    /// Free places.
    free: Vec<u8>,
    /// For each ball the place where a hit of which it is the first was last put.
    place_of: Vec<u8>,
    /// Whose hits may be next.
    pub(super) calendar: Calendar,
    /// Balls computed at once.
    width: usize,
    /// The place of the hit that is being resolved.
    present: usize,
}

/// A copy foresees for itself, and has as much room.
impl Clone for Foresight {
    fn clone(&self) -> Self {
        Self {
            calendar: self.calendar.clone(),
            ..Self::with_room(self.list.len(), self.place_of.len(), self.width)
        }
    }
}

impl Foreseen {
    const NOTHING: Self = Self {
        hit: Due::NOBODY,
        of: [None; 2],
        orientation: [[0.0; 4]; 2],
        next: [Prepared::NOTHING; 2],
        launched: 0,
    };
}

impl Foresight {
    /// For so many balls, `width` of which are computed side by side.
    pub(super) fn new(balls: usize, width: usize) -> Self {
        if width > 2 && balls >= BALLS_MIN {
            Self::with_room(KEPT, balls, width)
        } else {
            Self::with_room(0, 0, width)
        }
    }

    fn with_room(kept: usize, balls: usize, width: usize) -> Self {
        Self {
            list: vec![Foreseen::NOTHING; kept],
            events: vec![Time::NEVER; kept],
            free: (0..kept as u8).collect(),
            place_of: vec![u8::MAX; balls],
            calendar: Calendar::new(balls),
            width,
            present: usize::MAX,
        }
    }

    /// A hit of `ball` at `time` was found.
    pub(super) fn note(&mut self, ball: usize, time: Time) {
        if !self.list.is_empty() {
            self.calendar.note(ball, time);
        }
    }

    fn find(&self, hit: &Due) -> Option<usize> {
        let place = usize::from(self.place_of[hit.ball]);
        let event = self.events.get(place)?;
        (*event == hit.event && self.list[place].hit.is(hit)).then_some(place)
    }

    fn release(&mut self, place: usize) {
        self.events[place] = Time::NEVER;
        self.free.push(place as u8);
    }

    /// Forgets hits that did not come in time, if there is need.
    fn make_room(&mut self, now: Time) {
        if self.free.len() < self.width {
            for place in 0..self.events.len() {
                if self.events[place] < now {
                    self.release(place);
                }
            }
        }
    }

    /// The place of a hit that was kept before, or one that is free, or else that of the latest hit.
    fn place_for(&mut self, hit: &Due) -> usize {
        let place = self
            .find(hit)
            .or_else(|| self.free.pop().map(usize::from))
            .unwrap_or_else(|| (0..self.events.len()).max_by_key(|place| self.events[*place]).unwrap_or(0));
        (self.events[place], self.place_of[hit.ball]) = (hit.event, place as u8);
        place
    }
}

/// A place is told by a byte, and one value is nobody's.
const _: () = assert!(KEPT < u8::MAX as usize);

impl Controller {
    /// Lands on a hit that is due now.
    pub(super) fn land_on(&mut self, hit: &mut Due) {
        if self.work.side_by_side { self.land_with_others(hit) } else { self.approach_one(hit) }
    }

    /// Lands on it with hits that are due soon.
    #[inline(never)]
    fn land_with_others(&mut self, hit: &mut Due) {
        if self.work.foresight.list.is_empty() || !self.is_plain(hit, self.balls[hit.ball].body.rolls) {
            self.work.foresight.present = usize::MAX;
            return self.approach(std::slice::from_mut(hit));
        }
        self.work.foresight.calendar.count(hit.event);
        let known = self.work.foresight.find(hit).filter(|place| self.still_holds(*place));
        let place = known.unwrap_or_else(|| self.foresee(hit));
        self.work.foresight.release(place);
        self.work.foresight.present = place;
        *hit = self.work.foresight.list[place].hit;
    }

    /// The hit is resolved.
    pub(super) const fn close_foreseen(&mut self) {
        self.work.foresight.present = usize::MAX;
    }

    /// The orientation foreseen for a ball at the present hit.
    pub(super) fn foreseen_orientation(&self, ball: usize, time: Time) -> Option<[f64; 4]> {
        let Foresight { list, present, .. } = &self.work.foresight;
        let Foreseen { hit, orientation, .. } = list.get(*present)?;
        let place = hit.landed().iter().position(|landed| landed.ball == ball)?;
        (hit.time == time).then_some(orientation[place])
    }

    /// Puts a ball on the arc foreseen for after the present hit; false if another follows.
    #[inline(never)]
    pub(super) fn goes_on_as_foreseen(&mut self, ball: usize, time: Time, state: &State) -> bool {
        let Foresight { list, present, .. } = &self.work.foresight;
        let Some(Foreseen { next, launched, .. }) = list.get(*present) else { return false };
        let known = next[..*launched].iter().position(|next| next.ball == ball);
        let Some(known) = known.filter(|known| self.follows(&next[*known], ball, time, state)) else {
            return false;
        };
        let list = std::mem::take(&mut self.work.foresight.list);
        self.put_on(&list[self.work.foresight.present].next[known]);
        self.work.foresight.list = list;
        true
    }

    pub(super) fn origin(&self, ball: usize) -> Origin {
        let Arc { start, state, length, path, turning, .. } = &self.arcs[ball];
        let applied = self.balls[ball].body.applied;
        Origin {
            start: *start,
            state: *state,
            length: *length,
            path: *path,
            applied,
            orientation: turning.start,
        }
    }

    /// Whether a foreseen hit's balls are on the arcs that it was computed from.
    fn still_holds(&self, place: usize) -> bool {
        let known = &self.work.foresight.list[place];
        known.hit.landed().iter().zip(&known.of).all(|(landed, of)| *of == Some(self.origin(landed.ball)))
    }

    /// Lands on a hit together with the next that are due, and launches what follows; returns its place.
    fn foresee(&mut self, hit: &Due) -> usize {
        self.work.foresight.make_room(hit.event);
        let mut group = [*hit; LANES_MAX];
        let count = self.choose(&mut group);
        let group = &mut group[..count];
        self.fetch_rest_of(group);
        self.approach(group);
        let mut places = [0; LANES_MAX];
        for (hit, place) in group.iter().zip(&mut places) {
            *place = self.keep(hit);
        }
        if self.balls[hit.ball].body.rolls {
            self.turn_ahead(&places[..count]);
        }
        self.launch_ahead(&places[..count]);
        places[0]
    }

    /// Adds to the first hit of `group` the next that are due and can be computed with it; returns how many it has.
    fn choose(&self, group: &mut [Due; LANES_MAX]) -> usize {
        let width = self.work.foresight.width;
        let (mut count, mut balls) = (1, group[0].landed().len());
        let free = self.work.foresight.free.len();
        let rolls = self.balls[group[0].ball].body.rolls;
        self.fetch_candidates();
        self.work.foresight.calendar.ahead(|ball| {
            let Some(hit) = self.due(ball) else { return true };
            let more = hit.landed().len();
            if self.work.foresight.calendar.is_soon(hit.event)
                && balls + more <= width
                && count < free
                && self.is_plain(&hit, rolls)
                && !group[..count].iter().any(|known| known.is(&hit))
                && self.work.foresight.find(&hit).is_none()
            {
                group[count] = hit;
                (count, balls) = (count + 1, balls + more);
            }
            balls < width && count < free
        });
        count
    }

    /// The hit that comes next for a ball, and for the other if it is with one.
    fn due(&self, ball: usize) -> Option<Due> {
        let next = self.queue.of(ball);
        let partner = match next.what {
            What::Ball { other, stamp } => {
                let other = other as usize;
                if self.arcs[other].stamp != stamp || self.queue.of(other).time != next.time {
                    return None;
                }
                HitPartner::Ball(other)
            }
            What::Wall { wall } => HitPartner::Wall(wall as usize),
            What::Renew => return None,
        };
        Some(Due::new(ball, partner, next.time))
    }

    /// Whether a hit's balls can be landed with others and launched with them.
    fn is_plain(&self, hit: &Due, rolls: bool) -> bool {
        hit.landed().iter().all(|landed| {
            let (ball, arc) = (&self.balls[landed.ball], &self.arcs[landed.ball]);
            arc.path == Path::Curved && ball.body.rolls == rolls && !arc.driven && hit.event > arc.start
        })
    }

    /// Keeps a landed hit; returns its place.
    fn keep(&mut self, hit: &Due) -> usize {
        let of = [0, 1].map(|k| hit.landed().get(k).map(|landed| self.origin(landed.ball)));
        let place = self.work.foresight.place_for(hit);
        let known = &mut self.work.foresight.list[place];
        (known.hit, known.of, known.launched) = (*hit, of, 0);
        place
    }

    /// Finds the orientations that balls come to the hits at `places` with.
    fn turn_ahead(&mut self, places: &[usize]) {
        let mut list = std::mem::take(&mut self.work.foresight.list);
        let (mut looks, mut of) = ([None; LANES_MAX], [(0, 0); LANES_MAX]);
        let mut count = 0;
        for place in places {
            let hit = &list[*place].hit;
            for (k, landed) in hit.landed().iter().enumerate() {
                let Arc { start, scale, turning, .. } = &self.arcs[landed.ball];
                looks[count] = Some((turning, hit.time.since(*start) / scale));
                of[count] = (*place, k);
                count += 1;
            }
        }
        let mut q = [[0.0; 4]; LANES_MAX];
        orientations(&looks[..count], &mut [], &mut q[..count]);
        for ((place, k), q) in of[..count].iter().zip(q) {
            list[*place].orientation[*k] = q;
        }
        self.work.foresight.list = list;
    }

    /// Launches what follows the hits at `places`, if that is told by the balls that meet alone.
    fn launch_ahead(&mut self, places: &[usize]) {
        let mut list = std::mem::take(&mut self.work.foresight.list);
        for place in places {
            let Foreseen { hit, next, launched, .. } = &mut list[*place];
            let Some(states) = self.outcome(hit) else { continue };
            *launched = hit.landed().len();
            for ((landed, state), next) in hit.landed().iter().zip(&states).zip(next) {
                self.note_start(next, landed.ball, hit.time, state);
            }
        }
        let here = list.iter_mut().enumerate().filter(|(place, _)| places.contains(place));
        self.compute(here.flat_map(|(_, foreseen)| &mut foreseen.next[..foreseen.launched]));
        self.work.foresight.list = list;
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::scene::{Accuracy, BallSpec, Floor, HIT_BUDGET, MotionLaw, Place, Scene, Wall};
    use nalgebra::Vector2;

    /// Balls in rows on a shallow bowl between walls, each with a velocity of its own.
    pub(in super::super) fn crowd(rows: usize) -> Scene {
        let wall = |x: f64, y: f64| {
            let normal = Vector2::new(-x, -y);
            Wall { point: -1.3 * normal, normal }
        };
        let ball = |k: usize| {
            let place = Vector2::new((k % rows) as f64, (k / rows) as f64).map(|x| 0.25 * x - 1.1);
            let [x, y] = [3, 7].map(|p| (k * k * p % 13) as f64 / 6.0 - 1.0);
            BallSpec {
                name: format!("{k:03}"),
                radius: 0.08,
                mass: 0.5 + (k % 3) as f64,
                inertia_factor: 0.4,
                place: Place::Center(place),
                velocity: Vector3::new(x, y, 0.0),
                spin: 0.1,
            }
        };
        Scene {
            floor: Floor::Polynomial {
                x: [-1.3, 1.3],
                y: [-1.3, 1.3],
                terms: vec![vec![0.0, 0.0, 0.05], vec![0.0; 3], vec![0.05, 0.0, 0.0]],
            },
            walls: [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)].map(|(x, y)| wall(x, y)).into(),
            balls: (0..rows * rows).map(ball).collect(),
            gravity: Vector3::new(0.0, 0.0, -9.81),
            motion: MotionLaw::Rolling,
            restitution: 0.97,
            accuracy: Accuracy::Tolerance(1e-9),
            hit_budget: HIT_BUDGET,
        }
    }

    #[test]
    fn foresight_changes_no_bit() {
        let mut with = Controller::new(&crowd(9)).expect("a scene");
        let mut without = with.clone();
        without.work.foresight = Foresight::new(0, 1);
        let mut foreseen = 0;
        for tick in 1..=120 {
            let time = Time::of_tick(tick, 60);
            for engine in [&mut with, &mut without] {
                if tick % 7 == 3 {
                    engine.push((tick * 5 % 81) as usize, Vector2::new(0.3, -0.5), 3.0);
                }
                engine.advance_to(time);
            }
            assert_eq!(with.state_hash(), without.state_hash(), "tick {tick}");
            assert_eq!(with.hits(), without.hits(), "tick {tick}");
            foreseen += with.work.foresight.events.iter().filter(|event| **event > time).count();
        }
        let wide = with.work.foresight.width > 2;
        assert!(!wide || foreseen > 60, "{foreseen}");
        assert!(with.report().collisions.ball_ball > 500);
    }
}
