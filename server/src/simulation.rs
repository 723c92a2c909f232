//! One world: commands in, ticks on, states out. No clock and no I/O: a run is a function of the scene and of the
//! commands by tick.

mod moment;

pub use moment::{Ground, Moment};

use crate::change::{Change, meant};
use crate::crew::Crew;
use crate::scene_file::{LoadedScene, SceneError};
use crate::world::{Present, World};
use ballroom_physics::{BallState, Controller, Drive, Hit, Observer, Seat, Time};
use nalgebra::{Vector2, Vector3};
use protocol::command::{Direction, Refusal, Scope, SteerMode, code};
use protocol::listing::Selection;
use protocol::scene::Scene;
use protocol::snapshot::{Collisions, Roster, Snapshot};
use protocol::stats::{Division, Stats};
use std::collections::BTreeMap;
use std::sync::Arc;

/// How long a held force lasts without being renewed, in simulated seconds: a lost release must not drive for ever.
pub const FORCE_TIMEOUT_S: f64 = 0.5;

/// How near to a whole number of ticks a time must be to mean it.
const ON_TICK: f64 = 1e-9;

/// What the states of an epoch and those after it belong to.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The first of its epochs.
    pub epoch: u64,
    /// The scene as served.
    pub scene: Arc<Scene>,
    /// Who the balls are.
    pub roster: Arc<Roster>,
}

/// A scene being run.
pub struct Simulation {
    world: Arc<World>,
    /// The same for others to see.
    present: Arc<Present>,
    controller: Controller,
    crew: Crew,
    tick_rate_hz: u32,
    epoch: u64,
    tick: u64,
    energy_at_start: f64,
    /// Balls held by a force, and the tick that lets them go.
    held: BTreeMap<usize, u64>,
}

impl Simulation {
    /// Sets the scene up at tick 0 of `epoch`, with `tick_rate_hz` ticks a simulated second.
    pub fn new(loaded: Arc<LoadedScene>, tick_rate_hz: u32, epoch: u64) -> Result<Self, SceneError> {
        let world = Arc::new(World::new(loaded)?);
        let controller = world.start().clone();
        let energy_at_start = controller.energy();
        Ok(Self {
            present: Arc::new(Present::new(world.clone())),
            world,
            controller,
            crew: Crew::default(),
            tick_rate_hz,
            epoch,
            tick: 0,
            energy_at_start,
            held: BTreeMap::new(),
        })
    }

    /// Runs on the threads of `crew` from now on, as far as the scene is large enough for them. They change no bit.
    #[must_use]
    pub fn run_by(self, crew: Crew) -> Self {
        Self { crew, ..self }
    }

    /// The same scene from its start or from a part of it; as the next epoch, unless the clock goes on. What was spawned is
    /// not taken away here: that is a [`Change`].
    pub fn reset(&mut self, scope: Scope) -> Result<(), Refusal> {
        match scope {
            Scope::All => {
                self.enter(self.world.origin());
                self.controller.clone_from(self.world.start());
            }
            Scope::Time => self.controller = self.controller.at_time_zero(self.world.start()),
            Scope::State => {
                let done = self.controller.set_as_in(self.world.start());
                done.map_err(|fault| self.world.refusal(&fault))?;
            }
            Scope::Spawned => return Ok(()),
        }
        self.held.clear();
        if matches!(scope, Scope::All | Scope::Time) {
            self.energy_at_start = self.controller.energy();
            self.epoch += 1;
            self.tick = 0;
        }
        Ok(())
    }

    /// Goes on in a changed world, as the next epoch whose clock goes on; what was goes there. Refused as a whole where
    /// balls have no room, or where the change was made for another world.
    pub fn change(&mut self, change: &mut Change) -> Result<(), Refusal> {
        self.hold_to(&change.from)?;
        let went_on = self.controller.go_on_as(&mut change.successor);
        went_on.map_err(|fault| change.to.refusal(&fault))?;
        let was = change.successor.was().iter().enumerate();
        let held = was.filter_map(|(id, was)| Some((id, *self.held.get(was.as_ref()?)?)));
        self.held = held.collect();
        self.enter(change.to.clone());
        self.epoch += 1;
        Ok(())
    }

    /// Refuses what was made ready for another world than the present one.
    fn hold_to(&self, world: &Arc<World>) -> Result<(), Refusal> {
        if Arc::ptr_eq(world, &self.world) {
            return Ok(());
        }
        let why = "the balls or the scene changed before it could act: ask again";
        Err(Refusal::new(code::INCORRECT_STATE, why))
    }

    /// Makes a world the present one.
    fn enter(&mut self, world: Arc<World>) {
        self.present.set(world.clone());
        self.world = world;
    }

    /// The change that removes the balls selected now.
    pub fn deletion(&self, selection: &Selection) -> Result<Change, Refusal> {
        let ids = meant(&self.world, selection, |ball| self.center_m(ball))?;
        Change::delete(&self.world, &ids)
    }

    fn center_m(&self, ball: usize) -> [f64; 2] {
        self.controller.ball(ball).center.xy().into()
    }

    /// Goes on as `next` from its start, as the next epoch; what was goes there.
    pub fn give_way_to(&mut self, next: &mut Self) {
        next.epoch = self.epoch + 1;
        std::mem::swap(self, next);
        std::mem::swap(&mut self.crew, &mut next.crew);
        // Who looks for the present world goes on looking here.
        std::mem::swap(&mut self.present, &mut next.present);
        self.present.set(self.world.clone());
    }

    /// Sets balls anew, all of them or none, whose places were found in `world`.
    pub fn set_balls(&mut self, world: &Arc<World>, seats: &[Seat]) -> Result<(), Refusal> {
        self.hold_to(world)?;
        self.controller.set_balls(seats).map_err(|fault| self.world.refusal(&fault))
    }

    /// Gives all balls that are selected now the same velocity or spin, or none of them.
    pub fn set_selected(
        &mut self,
        selection: &Selection,
        velocity: Option<Vector3<f64>>,
        spin: Option<f64>,
    ) -> Result<(), Refusal> {
        let balls = meant(&self.world, selection, |ball| self.center_m(ball))?;
        let seats: Vec<Seat> =
            balls.into_iter().map(|ball| Seat { ball, spot: None, velocity, spin }).collect();
        self.controller.set_balls(&seats).map_err(|fault| self.world.refusal(&fault))
    }

    /// The first tick at or after a simulated time.
    pub fn tick_at(&self, time_s: f64) -> u64 {
        let ticks = time_s * f64::from(self.tick_rate_hz);
        let whole = ticks.round();
        // A time that means a whole number of ticks may miss it by its rounding.
        (if (ticks - whole).abs() <= ON_TICK * ticks.max(1.0) { whole } else { ticks.ceil() }) as u64
    }

    /// Advances by one tick.
    pub fn advance(&mut self) {
        self.tick += 1;
        // The drive acts up to the tick that ends it.
        self.crew.advance(&mut self.controller, Time::of_tick(self.tick, self.tick_rate_hz));
        while let Some((&ball, _)) = self.held.iter().find(|&(_, &until)| until <= self.tick) {
            self.release(ball);
        }
    }

    /// Advances to any time, whether a tick or not; the tick is then the last one before or at it.
    pub fn advance_to(&mut self, time: Time) {
        // Held forces end at ticks.
        while !self.held.is_empty() && Time::of_tick(self.tick + 1, self.tick_rate_hz) <= time {
            self.advance();
        }
        self.crew.advance(&mut self.controller, time);
        while Time::of_tick(self.tick + 1, self.tick_rate_hz) <= time {
            self.tick += 1;
        }
    }

    /// Simulated time.
    pub const fn time(&self) -> Time {
        self.controller.time()
    }

    /// Steers a player's ball, or says why not.
    pub fn steer(&mut self, ball: Option<&str>, direction: Direction, mode: SteerMode) -> Result<(), String> {
        let ball = self.steered(ball)?;
        let Some([x, y]) = direction.vector() else {
            self.release(ball);
            return Ok(());
        };
        let direction = Vector2::new(x, y);
        let steering = self.world.loaded().scene().steering;
        let speed_limit = steering.speed_limit_m_per_s;
        match mode {
            SteerMode::Impulse => {
                self.controller.push(ball, direction * steering.impulse_m_per_s, speed_limit);
            }
            SteerMode::Force => {
                let acceleration = steering.acceleration_m_per_s2;
                self.controller.drive(ball, Some(Drive { direction, acceleration, speed_limit }));
                let ticks = (FORCE_TIMEOUT_S * f64::from(self.tick_rate_hz)).ceil() as u64;
                self.held.insert(ball, self.tick + ticks);
            }
        }
        Ok(())
    }

    fn steered(&self, name: Option<&str>) -> Result<usize, String> {
        let Some(name) = name else {
            return self
                .world
                .first_player()
                .ok_or_else(|| "the scene has no player's ball to steer".to_owned());
        };
        let players = || self.roster().names.iter().zip(&self.roster().player).filter(|(_, player)| **player);
        match self.roster().names.binary_search_by(|known| known.as_str().cmp(name)) {
            Ok(ball) if self.roster().player[ball] => Ok(ball),
            Ok(_) => {
                let known: Vec<&str> = players().map(|(name, _)| name.as_str()).take(8).collect();
                Err(format!("{name:?} is no player's ball; those are {}", known.join(", ")))
            }
            Err(_) => {
                let known: Vec<&str> = players().map(|(name, _)| name.as_str()).take(8).collect();
                Err(format!("no ball is named {name:?}; players' balls are {}", known.join(", ")))
            }
        }
    }

    fn release(&mut self, ball: usize) {
        if self.held.remove(&ball).is_some() {
            self.controller.drive(ball, None);
        }
    }

    /// Writes the present state into a buffer, which keeps its room.
    pub fn write_snapshot(&self, out: &mut Snapshot) {
        self.begin_snapshot(out);
        for (id, ball) in self.controller.balls().enumerate() {
            self.add_to_snapshot(id, &ball, out);
        }
    }

    /// The same for who does so again and again, which is quicker.
    pub fn write_snapshot_for(&self, observer: &mut Observer, out: &mut Snapshot) {
        self.begin_snapshot(out);
        self.controller.observe(observer, |id, ball| self.add_to_snapshot(id, ball, out));
    }

    fn begin_snapshot(&self, out: &mut Snapshot) {
        let report = self.controller.report();
        out.epoch = self.epoch;
        out.tick = self.tick;
        out.time_s = self.controller.time().seconds();
        out.steering_work_j = self.controller.steering_work();
        out.collisions = collisions(report.collisions);
        out.state_hash = self.state_hash();
        out.energy_j = 0.0;
        for list in [&mut out.center_m, &mut out.velocity_m_per_s, &mut out.omega_rad_per_s] {
            list.clear();
        }
        out.uv.clear();
        out.orientation_xyzw.clear();
    }

    /// A ball's state, read once for itself and for its energy.
    fn add_to_snapshot(&self, id: usize, ball: &BallState, out: &mut Snapshot) {
        out.uv.push(ball.uv.into());
        out.center_m.push(ball.center.into());
        out.velocity_m_per_s.push(ball.velocity.into());
        out.omega_rad_per_s.push(ball.omega.into());
        out.orientation_xyzw.push(ball.orientation);
        out.energy_j += self.controller.energy_seen(id, ball);
    }

    /// What the engine counts, into the statistics.
    pub fn write_stats(&self, out: &mut Stats) {
        let report = self.controller.report();
        out.epoch = self.epoch;
        out.tick = self.tick;
        out.tick_rate_hz = self.tick_rate_hz;
        out.energy_j = [self.controller.energy(), self.energy_at_start];
        out.collisions = collisions(report.collisions);
        out.deepest_penetration_m = report.deepest_penetration;
        out.rest_hits = report.rest_hits;
        out.fallbacks = report.fallbacks;
        out.negative_reaction_s = report.negative_reaction;
        out.steps = report.steps;
        out.division = self.controller.division().map(|division| Division {
            shards: division.shards as u32,
            copies: division.copies as u64,
            kept: division.kept,
            undone: division.undone,
            in_one: division.in_one,
        });
    }

    /// Hash of everything that influences the future: the engine's, and which forces are held until when.
    pub fn state_hash(&self) -> u64 {
        self.controller.state_hash_with(self.held.iter().flat_map(|(ball, until)| [*ball as u64, *until]))
    }

    /// A ball at the present time, by id.
    pub fn ball_state(&self, ball: usize) -> BallState {
        self.controller.ball(ball)
    }

    /// Whether a force is held on any ball.
    pub fn is_any_driven(&self) -> bool {
        !self.held.is_empty()
    }

    /// Hits of the last advance.
    pub fn hits(&self) -> &[Hit] {
        self.controller.hits()
    }

    /// Who the balls are, by id.
    pub fn roster(&self) -> &Arc<Roster> {
        self.world.roster()
    }

    /// What of it no tick changes.
    pub const fn world(&self) -> &Arc<World> {
        &self.world
    }

    /// Where to see which world is the present one.
    pub const fn present(&self) -> &Arc<Present> {
        &self.present
    }

    /// What its states belong to.
    pub fn stage(&self) -> Stage {
        Stage { epoch: self.epoch, scene: self.world.loaded().scene().clone(), roster: self.roster().clone() }
    }

    /// The scene it runs.
    pub fn loaded(&self) -> &Arc<LoadedScene> {
        self.world.loaded()
    }

    /// Number of the last tick.
    pub const fn tick(&self) -> u64 {
        self.tick
    }

    /// Number of the epoch.
    pub const fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Ticks a simulated second.
    pub const fn tick_rate_hz(&self) -> u32 {
        self.tick_rate_hz
    }
}

const fn collisions(from: ballroom_physics::Collisions) -> Collisions {
    Collisions { ball_ball: from.ball_ball, ball_wall: from.ball_wall }
}

/// One hit as a listener needs it, small enough to be copied on the tick thread.
#[derive(Clone, Copy, Debug)]
pub struct NumberedHit {
    /// Epoch it belongs to.
    pub epoch: u64,
    /// Number since the epoch began.
    pub sequence: u64,
    /// The hit.
    pub hit: Hit,
}

impl NumberedHit {
    /// In the words of the wire.
    pub fn to_event(self, roster: &Roster) -> protocol::event::Event {
        let name = |ball: usize| roster.names.get(ball).cloned().unwrap_or_default();
        let point: Vector3<f64> = self.hit.point;
        protocol::event::Event {
            epoch: self.epoch,
            sequence: self.sequence,
            time_s: self.hit.time.seconds(),
            ball: name(self.hit.ball),
            other: match self.hit.partner {
                ballroom_physics::HitPartner::Ball(other) => protocol::event::Other::Ball(name(other)),
                ballroom_physics::HitPartner::Wall(wall) => protocol::event::Other::Wall(wall as u32),
            },
            point_m: point.into(),
            impulse_n_s: self.hit.impulse,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file::SceneText;
    use protocol::command::DirectionName;

    fn original() -> Simulation {
        let loaded = SceneText::open("original").unwrap().load().unwrap();
        Simulation::new(Arc::new(loaded), 60, 7).unwrap()
    }

    fn state(simulation: &Simulation) -> Snapshot {
        let mut out = Snapshot::default();
        simulation.write_snapshot(&mut out);
        out
    }

    fn speed_of(simulation: &Simulation, name: &str) -> f64 {
        let ball = simulation.roster().names.iter().position(|n| n == name).unwrap();
        Vector3::from(state(simulation).velocity_m_per_s[ball]).norm()
    }

    const UP: Direction = Direction::Named(DirectionName::Up);
    const STOP: Direction = Direction::Named(DirectionName::Stop);

    #[test]
    fn the_same_commands_at_the_same_ticks_give_the_same_bits() {
        let run = || {
            let mut simulation = original();
            for tick in 0..300 {
                if tick % 50 == 20 {
                    simulation.steer(Some("player"), UP, SteerMode::Impulse).unwrap();
                }
                if tick == 100 {
                    simulation.steer(None, Direction::Vector([0.6, -0.8]), SteerMode::Force).unwrap();
                }
                simulation.advance();
            }
            state(&simulation)
        };
        assert_eq!(run(), run());
    }

    #[test]
    fn refused_steering_leaves_no_trace() {
        let (mut teased, mut twin) = (original(), original());
        for _ in 0..120 {
            assert!(
                teased.steer(Some("red"), UP, SteerMode::Impulse).unwrap_err().contains("no player's ball")
            );
            assert!(teased.steer(Some("ghost"), UP, SteerMode::Force).unwrap_err().contains("player"));
            teased.advance();
            twin.advance();
        }
        assert_eq!(state(&teased), state(&twin));
    }

    #[test]
    fn a_press_answers_and_never_exceeds_the_limit() {
        let mut simulation = original();
        let before = speed_of(&simulation, "player");
        simulation.steer(None, UP, SteerMode::Impulse).unwrap();
        let after = speed_of(&simulation, "player");
        assert!(after > before + 0.5, "{before} to {after}");
        for _ in 0..50 {
            simulation.steer(None, UP, SteerMode::Impulse).unwrap();
        }
        assert!(speed_of(&simulation, "player") <= 8.0 + 1e-12);
    }

    #[test]
    fn a_held_force_lets_go_after_half_a_second_without_renewal() {
        let hash_after = |stop_at: Option<u64>| {
            let mut simulation = original();
            simulation.steer(None, UP, SteerMode::Force).unwrap();
            for tick in 0..60 {
                if stop_at == Some(tick) {
                    simulation.steer(None, STOP, SteerMode::Force).unwrap();
                }
                simulation.advance();
            }
            state(&simulation).state_hash
        };
        // Letting go at tick 30 is what happens anyway; earlier makes a difference.
        assert_eq!(hash_after(None), hash_after(Some(30)));
        assert_ne!(hash_after(None), hash_after(Some(10)));
    }

    #[test]
    fn the_hash_sees_how_long_a_force_is_held() {
        let mut simulation = original();
        simulation.steer(None, UP, SteerMode::Force).unwrap();
        (0..10).for_each(|_| simulation.advance());
        let (before, ball) = (simulation.state_hash(), simulation.steered(None).unwrap());
        *simulation.held.get_mut(&ball).unwrap() += 1;
        assert_ne!(simulation.state_hash(), before);
    }

    #[test]
    fn a_reset_is_a_new_epoch_with_the_first_state() {
        let mut simulation = original();
        let first = state(&simulation);
        for _ in 0..100 {
            simulation.advance();
        }
        simulation.reset(Scope::All).unwrap();
        let again = state(&simulation);
        assert_eq!((again.epoch, again.tick), (8, 0));
        assert_eq!(Snapshot { epoch: 7, ..again }, first);
    }

    #[test]
    fn a_tick_is_the_same_state_at_any_tick_rate() {
        let loaded = Arc::new(SceneText::open("original").unwrap().load().unwrap());
        let hashes = [30, 60, 240].map(|rate| {
            let mut simulation = Simulation::new(loaded.clone(), rate, 0).unwrap();
            for _ in 0..10 * rate {
                simulation.advance();
            }
            state(&simulation).state_hash
        });
        assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{hashes:x?}");
    }

    #[test]
    fn a_held_force_stays_with_its_ball_when_others_come_before_it() {
        let guest = r#"[{"name":"a","uv":[0.05,0.95],"radius_m":0.2,"mass_kg":1}]"#;
        let balls: Vec<protocol::scene::Ball> = serde_json::from_str(guest).unwrap();
        let run = |guest_at: Option<u64>| {
            let mut simulation = original();
            simulation.steer(None, UP, SteerMode::Force).unwrap();
            for tick in 0..60 {
                if guest_at == Some(tick) {
                    let mut change = Change::spawn(simulation.world(), &balls).unwrap();
                    simulation.change(&mut change).unwrap();
                    assert!(simulation.change(&mut change).is_err(), "a change acts once");
                }
                simulation.advance();
            }
            assert!(simulation.held.is_empty(), "the force has run out");
            let player = simulation.world().ball("player").unwrap();
            (player, state(&simulation).center_m[player])
        };
        let ((alone, there), (beside, here)) = (run(None), run(Some(10)));
        assert_eq!((alone + 1, there), (beside, here));
    }

    #[test]
    fn a_state_reset_is_refused_where_what_was_spawned_takes_the_room() {
        let mut simulation = original();
        let start = state(&simulation).center_m[1];
        (0..120).for_each(|_| simulation.advance());
        let ball =
            format!(r#"[{{"name":"a","center_m":[{},{}],"radius_m":0.2,"mass_kg":1}}]"#, start[0], start[1]);
        let balls: Vec<protocol::scene::Ball> = serde_json::from_str(&ball).unwrap();
        simulation.change(&mut Change::spawn(simulation.world(), &balls).unwrap()).unwrap();
        let before = simulation.state_hash();
        let refused = simulation.reset(Scope::State).unwrap_err();
        assert!(refused.why.contains("\"a\" and \"player\" would overlap"), "{refused}");
        assert_eq!(simulation.state_hash(), before);
        let gone = simulation.deletion(&Selection { spawned: Some(true), ..Selection::default() });
        simulation.change(&mut gone.unwrap()).unwrap();
        simulation.reset(Scope::State).unwrap();
        assert_eq!(state(&simulation).center_m[1], start);
    }
}
