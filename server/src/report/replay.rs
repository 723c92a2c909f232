//! A scene's work done again outside the engine, kind by kind, so that each kind can be timed by itself.
//!
//! The engine has no clock, and a sampling profile sees little of loops that are inlined. So its run is stopped at a few moments,
//! its balls are laid out on a bench, and what the engine would do from there is done with the engine's own kernels over
//! all balls at once: launch, search, look at pairs, land and resolve. Counts of the run weigh what one of each costs.

use super::clock::cost;
use super::subject::Subject;
use super::{ReportError, subject};
use ballroom_physics::detect::ball_ball::{self, Approach, Standing};
use ballroom_physics::detect::ball_wall::{self, Plane, room_between};
use ballroom_physics::detect::broad_phase::{BroadPhase, is_within, swept_bounds, travel, window};
use ballroom_physics::motion::arc::Arc;
use ballroom_physics::motion::body::{Body, Stepping};
use ballroom_physics::motion::together::{self, Landing, Launch, Seat};
use ballroom_physics::resolve::impact::{Contact, Member, resolve_one};
use ballroom_physics::schedule::event::{Next, What};
use ballroom_physics::schedule::queue::Queue;
use ballroom_physics::surface::chart::Surface;
use ballroom_physics::tolerance::STEP_FIRST;
use ballroom_physics::{Accuracy, BallSpec, Controller, MotionLaw, Time};
use nalgebra::Vector3;
use std::hint::black_box;

/// Balls are visited so many ids apart: events do not come by id, and memory knows.
const STRIDE: usize = 7919;
/// Balls below which the engine computes no arcs ahead of their time, and so none side by side.
const GROUPED_FROM: usize = 8;
/// Balls below which the engine computes no hits ahead of their time.
const FORESEEN_FROM: usize = 16;
/// Most balls that any machine computes side by side.
const LANES: usize = 8;

/// CPU time of one of each kind of work, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Costs {
    /// Arcs of two balls that hit each other.
    pub arcs_of_two: f64,
    /// The arc of one ball that hit a wall.
    pub arc_of_one: f64,
    /// An integration step of a ball whose arc ended.
    pub step: f64,
    /// Filing a ball's bounds and finding whose meet them.
    pub search: f64,
    /// A ball's window, and its walls in it.
    pub walls: f64,
    /// Whether and when two balls meet.
    pub pair: f64,
    /// Landing on the hit of two balls, looking who else touches, and the impulse.
    pub hit_of_two: f64,
    /// The same for a ball and a wall.
    pub hit_of_wall: f64,
    /// Changing a ball's place in the queue.
    pub queue: f64,
}

/// How often each came up on the bench.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Searches.
    pub searches: u64,
    /// Pairs looked at, and pairs whose distance polynomial was formed.
    pub pairs: [u64; 2],
    /// Arcs launched.
    pub arcs: u64,
    /// Steps they took.
    pub steps: u64,
}

/// What does not change while the scene runs, by id.
struct Bench {
    surface: Surface,
    accuracy: Accuracy,
    restitution: f64,
    walls: Vec<Plane>,
    bodies: Vec<Body>,
    inverse_masses: Vec<f64>,
    /// Ids in the order in which they are visited.
    order: Vec<usize>,
    /// The floor's bounds, m.
    bounds: [f64; 4],
}

/// The balls at one moment of a run, each at the start of an arc and of a window.
struct Moment {
    time: Time,
    steppings: Vec<Stepping>,
    arcs: Vec<Arc>,
    broad_phase: BroadPhase,
    bounds: Vec<[f64; 4]>,
    /// Whose bounds meet, by the first ball's place in the order.
    pairs: Vec<(usize, usize)>,
}

/// Stops a run of `ticks` at `moments` times evenly spread, and measures there. The means over all of them.
pub fn measure(subject: &Subject, ticks: usize, moments: usize) -> Result<(Costs, Seen), ReportError> {
    let mut run = subject.start(subject.own())?;
    let bench = Bench::new(subject, &run);
    let (mut costs, mut seen) = (Costs::default(), Seen::default());
    for moment in 1..=moments {
        run.advance_to(subject::tick(ticks * moment / (moments + 1)));
        bench.lay_out(&run).measure(&bench, 1.0 / moments as f64, &mut costs, &mut seen);
    }
    Ok((costs, seen))
}

impl Bench {
    fn new(subject: &Subject, run: &Controller) -> Self {
        let scene = subject.scene();
        let surface = Surface::new(&scene.floor, run.patch(), run.certificate().orientation);
        let wall = |wall: &ballroom_physics::Wall| Plane {
            normal: Vector3::new(wall.normal.x, wall.normal.y, 0.0),
            point: Vector3::new(wall.point.x, wall.point.y, 0.0),
        };
        let balls: Vec<&BallSpec> = run.scene_index().iter().map(|&place| &scene.balls[place]).collect();
        let rolls = scene.motion == MotionLaw::Rolling;
        let inertia_factor = |ball: &BallSpec| if rolls { ball.inertia_factor } else { 0.0 };
        let body = |ball: &&BallSpec| Body {
            radius: ball.radius,
            inertia_factor: inertia_factor(ball),
            rolls,
            applied: scene.gravity,
        };
        let stride = if balls.len().is_multiple_of(STRIDE) { 1 } else { STRIDE };
        let net = run.patch().net();
        let least = |axis: usize| net.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
        let most = |axis: usize| net.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
        Self {
            surface,
            accuracy: scene.accuracy,
            restitution: scene.restitution,
            walls: scene.walls.iter().map(wall).collect(),
            bodies: balls.iter().map(body).collect(),
            inverse_masses: balls.iter().map(|b| 1.0 / ((1.0 + inertia_factor(b)) * b.mass)).collect(),
            order: (0..balls.len()).map(|n| n * stride % balls.len()).collect(),
            bounds: [least(0), least(1), most(0), most(1)],
        }
    }

    /// Every ball on an arc that begins where the run is.
    fn lay_out(&self, run: &Controller) -> Moment {
        let (time, first) = (run.time(), Stepping { try_s: self.first_step(), steps: 0, forced: 0 });
        let mut arcs = Vec::with_capacity(self.bodies.len());
        let mut steppings = vec![first; self.bodies.len()];
        for ((ball, body), stepping) in run.balls().zip(&self.bodies).zip(&mut steppings) {
            let mut arc = Arc::empty(body.radius);
            let [p, q] = self.surface.chart([ball.uv.x, ball.uv.y]);
            let spin = if body.rolls { body.radius * ball.omega.dot(&ball.normal) } else { 0.0 };
            let state = [p, q, ball.velocity.x, ball.velocity.y, ball.velocity.z, spin];
            // Steps grow to what a run takes: shorter arcs would end its windows.
            let mut tried = 0.0;
            while stepping.try_s > tried {
                tried = stepping.try_s;
                body.launch(&self.surface, self.accuracy, (time, &state), stepping, &mut arc);
            }
            arc.window_end = time.after(self.window(&arc));
            arcs.push(arc);
        }
        let radii: Vec<f64> = self.bodies.iter().map(|body| body.radius).collect();
        let mut broad_phase = BroadPhase::new(&radii, self.bounds);
        let swept = |arc: &Arc| {
            let (center, velocity) = (arc.center_at(0.0), arc.velocity_at(0.0));
            swept_bounds(&center, &velocity, arc.acceleration_bound, arc.radius, arc.window_end.since(time))
        };
        let bounds: Vec<_> = arcs.iter().map(swept).collect();
        bounds.iter().enumerate().for_each(|(ball, bounds)| broad_phase.file(ball, *bounds));
        let mut pairs = Vec::new();
        self.order.iter().for_each(|&a| broad_phase.neighbours(a, |b| pairs.push((a, b))));
        Moment { time, steppings, arcs, broad_phase, bounds, pairs }
    }

    const fn first_step(&self) -> f64 {
        match self.accuracy {
            Accuracy::Tolerance(_) => STEP_FIRST,
            Accuracy::Fixed(_, step) => step,
        }
    }

    /// Length of the window that the engine opens at an arc's start, s.
    fn window(&self, arc: &Arc) -> f64 {
        let [width, depth] = [self.bounds[2] - self.bounds[0], self.bounds[3] - self.bounds[1]];
        let travel = travel(arc.radius, width.max(depth));
        window(travel, arc.velocity_at(0.0).norm(), arc.acceleration_bound).min(arc.length)
    }
}

impl Moment {
    /// Adds the costs of this moment, each by `share`.
    fn measure(mut self, bench: &Bench, share: f64, costs: &mut Costs, seen: &mut Seen) {
        let balls = bench.bodies.len() as f64;
        let add = |sum: &mut f64, count: f64, work: &mut dyn FnMut()| {
            if count > 0.0 {
                *sum += share * cost(|| (), |()| work()).seconds / count;
            }
        };
        let mut steps = 0;
        add(&mut costs.arc_of_one, balls, &mut || steps = self.launch(bench, 1));
        let foreseen = if bench.bodies.len() < FORESEEN_FROM {
            2
        } else {
            together::width(&bench.surface, bench.accuracy).max(2)
        };
        add(&mut costs.arcs_of_two, (balls / 2.0).ceil(), &mut || steps = self.launch(bench, foreseen));
        let grouped = if bench.bodies.len() < GROUPED_FROM {
            1
        } else {
            together::width(&bench.surface, bench.accuracy)
        };
        add(&mut costs.step, steps as f64, &mut || steps = self.launch(bench, grouped));
        seen.arcs += balls as u64;
        seen.steps += steps;
        seen.searches += balls as u64;
        seen.pairs[0] += self.pairs.len() as u64;
        add(&mut costs.search, balls, &mut || self.search(bench));
        add(&mut costs.walls, balls, &mut || self.meet_walls(bench));
        let mut formed = 0;
        add(&mut costs.pair, self.pairs.len() as f64, &mut || formed = self.meet_pairs());
        seen.pairs[1] += formed;
        add(&mut costs.hit_of_two, (balls / 2.0).floor(), &mut || self.hit_balls(bench));
        if let Some(wall) = bench.walls.first() {
            add(&mut costs.hit_of_wall, balls, &mut || self.hit_wall(bench, wall));
        }
        let mut queue = Queue::new(bench.bodies.len());
        self.arcs.iter().enumerate().for_each(|(ball, arc)| {
            queue.set(ball, Next { time: arc.window_end, what: What::Renew });
        });
        let mut draw = 1_u32;
        add(&mut costs.queue, balls, &mut || {
            for _ in 0..bench.order.len() {
                // Who is first goes on to some time within the next window.
                draw = draw.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let (ball, first) = queue.first();
                let length =
                    self.arcs[ball].window_end.since(self.time) * f64::from(draw >> 8) / f64::from(1 << 24);
                let next = Next { time: first.time.after(length), what: What::Renew };
                queue.set(ball, next);
            }
        });
    }

    /// Launches every ball anew from where its arc begins, `width` at a time; how many steps that took. Of arcs
    /// that end by themselves the engine keeps the new arc elsewhere until it is due, and so do groups here.
    fn launch(&mut self, bench: &Bench, width: usize) -> u64 {
        match width {
            1 => bench.order.iter().map(|&ball| self.launch_one(bench, ball)).sum(),
            2 => bench.order.chunks(2).map(|pair| self.launch_two(bench, pair)).sum(),
            _ => bench.order.chunks(width).map(|group| self.launch_group(bench, group)).sum(),
        }
    }

    fn launch_one(&mut self, bench: &Bench, ball: usize) -> u64 {
        let (body, arc) = (&bench.bodies[ball], &mut self.arcs[ball]);
        close(body, arc);
        let mut stepping = self.steppings[ball];
        let (start, state) = (arc.start, arc.state);
        body.launch(&bench.surface, bench.accuracy, (start, &state), &mut stepping, arc);
        stepping.steps - self.steppings[ball].steps
    }

    fn launch_two(&mut self, bench: &Bench, pair: &[usize]) -> u64 {
        let &[a, b] = pair else { return self.launch_one(bench, pair[0]) };
        let mut steppings = [a, b].map(|ball| Stepping { steps: 0, ..self.steppings[ball] });
        let Ok([arc_a, arc_b]) = self.arcs.get_disjoint_mut([a, b]) else { return 0 };
        let [first, second] = &mut steppings;
        let mut wanted = [(a, first, arc_a), (b, second, arc_b)].map(|(ball, stepping, arc)| {
            close(&bench.bodies[ball], arc);
            Some(Launch { body: &bench.bodies[ball], stepping, arc })
        });
        together::launch(&bench.surface, bench.accuracy, &mut wanted);
        steppings.iter().map(|stepping| stepping.steps).sum()
    }

    fn launch_group(&mut self, bench: &Bench, group: &[usize]) -> u64 {
        let mut arcs: [Option<(usize, Stepping, Arc)>; LANES] = std::array::from_fn(|lane| {
            let ball = *group.get(lane)?;
            Some((ball, Stepping { steps: 0, ..self.steppings[ball] }, self.arcs[ball]))
        });
        let mut wanted = arcs.each_mut().map(|arc| {
            let (ball, stepping, arc) = arc.as_mut()?;
            close(&bench.bodies[*ball], arc);
            Some(Launch { body: &bench.bodies[*ball], stepping, arc })
        });
        together::launch(&bench.surface, bench.accuracy, &mut wanted[..group.len()]);
        let mut steps = 0;
        for (ball, stepping, arc) in arcs.iter().flatten() {
            steps += stepping.steps;
            self.arcs[*ball] = *arc;
        }
        steps
    }

    fn search(&mut self, bench: &Bench) {
        let mut met = 0;
        for &ball in &bench.order {
            self.broad_phase.file(ball, self.bounds[ball]);
            self.broad_phase.neighbours(ball, |other| met += other);
        }
        black_box(met);
    }

    /// Bounds of every ball, and the walls of those that may come to one.
    fn meet_walls(&self, bench: &Bench) {
        let room = room_between(&bench.walls);
        for &ball in &bench.order {
            let arc = &self.arcs[ball];
            let duration = bench.window(arc);
            let standing = Standing::of(arc, self.time);
            let (center, velocity) = (&standing.center, &standing.velocity);
            let bounds = swept_bounds(center, velocity, arc.acceleration_bound, arc.radius, duration);
            if is_within(&black_box(bounds), &room) {
                continue;
            }
            for wall in &bench.walls {
                black_box(ball_wall::time_of_impact((arc, &standing), wall, self.time, duration, arc.radius));
            }
        }
    }

    /// How many distance polynomials were formed.
    fn meet_pairs(&self) -> u64 {
        let mut formed = 0;
        for &(a, b) in &self.pairs {
            let (a, b) = (&self.arcs[a], &self.arcs[b]);
            let duration = a.window_end.min(b.window_end).since(self.time);
            let [here, there] = [a, b].map(|arc| Standing::of(arc, self.time));
            let reach = a.radius + b.radius;
            let acceleration = a.acceleration_bound + b.acceleration_bound;
            if Approach::of(&here, &there, acceleration, reach, duration).stays_apart() {
                continue;
            }
            formed += 1;
            black_box(ball_ball::time_of_impact((a, b), (&here, &there), self.time, duration, reach));
        }
        formed
    }

    /// Lands balls halfway through the shorter of two windows, as many at once as the engine does, and lets each two collide
    /// as if they touched. Who else touches them the engine knows from its searches, all but sometimes.
    fn hit_balls(&self, bench: &Bench) {
        let width = together::width(&bench.surface, bench.accuracy).max(2);
        for group in bench.order.chunks(width) {
            let mut landings = [Landing::NOWHERE; LANES];
            let mut seats = [None; LANES];
            for (seats, pair) in seats.chunks_mut(2).zip(group.chunks_exact(2)) {
                let until = |ball: usize| self.arcs[ball].window_end;
                let dt = 0.5 * until(pair[0]).min(until(pair[1])).since(self.time);
                for (seat, &ball) in seats.iter_mut().zip(pair) {
                    *seat = Some(Seat { body: &bench.bodies[ball], arc: &self.arcs[ball], dt });
                }
            }
            let count = group.len() / 2 * 2;
            let mut wanted = landings.each_mut().map(Some);
            together::land(&bench.surface, bench.accuracy, &seats[..count], &mut wanted[..count]);
            for (pair, landed) in group.chunks_exact(2).zip(landings.chunks_exact(2)) {
                let mut members = [(pair[0], &landed[0]), (pair[1], &landed[1])].map(|(ball, landing)| {
                    let mut state = landing.state;
                    let (_, normal) = bench.bodies[ball].settle(&bench.surface, &mut state);
                    let velocity = Vector3::new(state[2], state[3], state[4]);
                    Member { velocity, normal, inverse_mass: bench.inverse_masses[ball] }
                });
                let line = (landed[1].center - landed[0].center).normalize();
                let contact = Contact { a: 0, b: Some(1), line };
                black_box(resolve_one(&mut members, &contact, bench.restitution));
            }
        }
    }

    /// The same of each ball with a wall.
    fn hit_wall(&self, bench: &Bench, wall: &Plane) {
        for &ball in &bench.order {
            let (arc, body) = (&self.arcs[ball], &bench.bodies[ball]);
            let dt = 0.5 * arc.window_end.since(self.time);
            let (mut state, _) = arc.land(body, &bench.surface, bench.accuracy, dt);
            let (_, normal) = body.settle(&bench.surface, &mut state);
            let velocity = Vector3::new(state[2], state[3], state[4]);
            let mut members = [Member { velocity, normal, inverse_mass: bench.inverse_masses[ball] }];
            let contact = Contact { a: 0, b: None, line: -wall.normal };
            black_box(resolve_one(&mut members, &contact, bench.restitution));
        }
    }
}

/// What an arc's end asks for, beside the next arc.
fn close(body: &Body, arc: &Arc) {
    if body.rolls {
        black_box(arc.orientation_at(arc.length.min(1.0)));
    }
    black_box(arc.negative_reaction(arc.length.min(1.0)));
}
