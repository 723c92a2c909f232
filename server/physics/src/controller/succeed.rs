//! A run goes on as another scene: with other balls, on another floor, under other laws, from one instant to the next.
//!
//! What is long about it is made ready beside the run, from scenes alone: a [`Successor`]. At the instant the balls that
//! stay bring their arcs, steps, held forces, orientations and next events along, so that one that nobody new meets keeps
//! every bit; only where the floor, gravity or the accuracy changes are they set on new arcs.

use super::load::{check_numbers, largest_radius, net_of};
use super::reseat::{SeatFault, Seated};
use super::{Ball, Controller};
use crate::motion::law::{State, velocity};
use crate::scene::{Scene, SceneFault};
use crate::schedule::event::{Next, What};
use crate::schedule::time::Time;
use crate::surface::certify::certify_for;
use crate::surface::place;

/// What a run can go on as.
#[derive(Clone, Debug)]
pub struct Successor {
    /// Every ball where its scene puts it, not yet on its way.
    controller: Controller,
    /// For each id, the id that the ball has had so far; none for one that comes.
    was: Vec<Option<usize>>,
    /// Whether the floor is the same, and whether arcs are.
    keeps: Keeps,
}

/// What stays as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Keeps {
    /// Every arc.
    Arcs,
    /// Where balls touch the floor.
    Contacts,
    /// x and y of the centres.
    Centers,
}

impl Successor {
    /// The scene's balls where it puts them: a controller to be given a checkpoint, or to read places from. It does not
    /// run: it has not been asked whether the balls have room.
    pub const fn at_start(&self) -> &Controller {
        &self.controller
    }

    /// For each id, the id that the ball has had so far; none for one that comes.
    pub fn was(&self) -> &[Option<usize>] {
        &self.was
    }
}

impl Controller {
    /// Makes ready what a run of the scene `was` can go on as. `self` stands at the start of `was`; `kept` says of each
    /// place in the new scene's list which place the same ball has in that of `was`, if it is there.
    pub fn successor(
        &self,
        was: &Scene,
        scene: &Scene,
        kept: &[Option<usize>],
    ) -> Result<Successor, SceneFault> {
        check_numbers(scene)?;
        let keeps = if was.floor != scene.floor || was.walls != scene.walls || was.motion != scene.motion {
            Keeps::Centers
        } else if was.gravity != scene.gravity || was.accuracy != scene.accuracy {
            Keeps::Contacts
        } else {
            Keeps::Arcs
        };
        let proved = keeps == Keeps::Arcs && largest_radius(scene) <= largest_radius(was);
        let (patch, certificate) = if proved {
            (self.patch.clone(), self.certificate)
        } else {
            let patch = net_of(&scene.floor)?;
            let certificate = certify_for(&patch, &-scene.gravity, largest_radius(scene));
            (patch, certificate)
        };
        let mut id_of = vec![None; was.balls.len()];
        for (id, place) in self.scene_index.iter().enumerate() {
            id_of[*place] = Some(id);
        }
        let old = |place: usize| kept.get(place).copied().flatten().and_then(|place| *id_of.get(place)?);
        let stands = |place: usize| {
            let id = old(place).filter(|_| keeps != Keeps::Centers)?;
            let mut ball = self.balls[id];
            ball.body.applied = scene.gravity;
            ball.stepping.try_s = super::load::first_step(scene.accuracy);
            Some((ball, self.arcs[id].state))
        };
        let controller = Self::standing(scene, patch, &certificate, stands)?;
        let was = controller.scene_index.iter().map(|place| old(*place)).collect();
        Ok(Successor { controller, was, keeps })
    }

    /// Goes on as `next` from the controller's time, or says why there is no room for its balls and goes on as before;
    /// ids in the fault are those of `next`. Afterwards `next` holds what was, or is of no more use. The energy that
    /// comes and goes with balls, floor and gravity counts as steering work. Returns how many of the balls that stay had
    /// one that leaves as their next partner: those look ahead anew, and may differ in their last bits from then on.
    pub fn go_on_as(&mut self, next: &mut Successor) -> Result<usize, SeatFault> {
        self.undivide();
        let now = self.now.max(self.time);
        let Successor { controller, was, keeps } = next;
        (controller.time, controller.now, controller.report) = (self.time, now, self.report);
        let mut new_id = vec![None; self.balls.len()];
        for (id, was) in was.iter().enumerate() {
            if let Some(old) = *was {
                new_id[old] = Some(id as u32);
            }
        }
        let (mut seated, mut alone) = (Vec::new(), Vec::new());
        for (id, was) in was.iter().enumerate() {
            match *was {
                Some(old) if *keeps == Keeps::Arcs => {
                    if !controller.carry_on(id, self, old, &new_id) {
                        alone.push(id);
                    }
                }
                Some(old) => seated.push(controller.set_over(id, self, old, *keeps)?),
                None => {
                    let state = controller.arcs[id].state;
                    seated.push(Seated { ball: id, state, center: controller.arcs[id].center[0] });
                }
            }
        }
        controller.find_room(&seated)?;
        for (old, new) in new_id.iter().enumerate() {
            if new.is_none() || *keeps != Keeps::Arcs {
                controller.close_books_of(self, old, now);
            }
        }
        for Seated { ball, state, .. } in &seated {
            controller.set_out(*ball, now, state);
        }
        for ball in alone.iter().copied().chain(seated.iter().map(|seated| seated.ball)) {
            controller.predict(ball, now);
        }
        std::mem::swap(self, controller);
        Ok(alone.len())
    }

    /// Takes over ball `old` of `run` as `id`, on its arc; false if its next partner does not come along.
    fn carry_on(&mut self, id: usize, run: &Self, old: usize, new_id: &[Option<u32>]) -> bool {
        self.balls[id] = run.balls[old];
        self.arcs[id] = run.arcs[old];
        self.broad_phase.file(id, *run.broad_phase.bounds_of(old));
        let next = *run.queue.of(old);
        let what = match next.what {
            What::Ball { other, stamp } => {
                let Some(other) = new_id[other as usize] else { return false };
                What::Ball { other, stamp }
            }
            What::Wall { .. } | What::Renew => next.what,
        };
        self.queue.set(id, Next { time: next.time, what });
        true
    }

    /// Where ball `old` of `run` comes to stand as `id` on another floor or under other laws: at the same contact, or
    /// with the same x and y of its centre.
    fn set_over(&mut self, id: usize, run: &Self, old: usize, keeps: Keeps) -> Result<Seated, SeatFault> {
        let mut state = run.state_of(old, self.now);
        if keeps == Keeps::Centers {
            let center = run.balls[old].body.seat(&run.surface, &state).0;
            let (xy, uv) = ([center.x, center.y], run.surface.uv([state[0], state[1]]));
            let q = place::contact_near(&self.surface, xy, run.balls[old].body.radius, uv);
            state[..2].copy_from_slice(&q.map_err(|why| SeatFault::OffFloor { ball: id, why })?);
        }
        let Ball { drive, hits, rest_hits, hits_quantum, free_omega, .. } = run.balls[old];
        let ball = &mut self.balls[id];
        *ball = Ball { hits, rest_hits, hits_quantum, drive, free_omega, ..*ball };
        let arc = &run.arcs[old];
        self.arcs[id].turning.start = arc.orientation_at(self.now.since(arc.start).max(0.0));
        let (center, n) = self.balls[id].body.seat(&self.surface, &state);
        let w = velocity(&state);
        state[2..5].copy_from_slice((w - n * w.dot(&n)).as_slice());
        Ok(Seated { ball: id, state, center })
    }

    /// The state of a ball at a time on its arc, integrated to it.
    fn state_of(&self, ball: usize, time: Time) -> State {
        let arc = &self.arcs[ball];
        arc.land(&self.balls[ball].body, &self.surface, self.accuracy, time.since(arc.start).max(0.0)).0
    }

    /// Ends the account of a ball of `run` that leaves, or leaves its arc.
    fn close_books_of(&mut self, run: &Self, old: usize, now: Time) {
        let arc = &run.arcs[old];
        let energy = run.energy_of(old, &run.state_of(old, now));
        self.report.steering_work += run.work_of_force(old, now) - energy;
        self.report.negative_reaction += arc.negative_reaction(now.since(arc.start).max(0.0));
    }

    /// Puts a ball on its first arc here, to be looked ahead for by the caller when all have set out.
    fn set_out(&mut self, ball: usize, now: Time, state: &State) {
        self.report.steering_work += self.energy_of(ball, state);
        if self.balls[ball].drive.is_some() {
            self.balls[ball].body.applied = self.applied(ball, state, now);
        }
        self.launch(ball, now, state);
        self.arcs[ball].window_end = now;
    }
}
