//! All that is shown of an arena, in one recording: the order in which news become rows.

use crate::ball_view::{BallView, Ring};
use crate::blueprint;
use crate::feed::News;
use crate::hit_view::HitView;
use crate::plots::Plots;
use crate::recording::{Moment, Recording};
use crate::scene_view::SceneView;
use crate::trail_view::TrailView;
use protocol::scene::Scene;
use protocol::snapshot::{Roster, Snapshot, World};
use rerun::components::TextLogLevel;
use rerun::{RecordingStreamResult, TextLog};
use std::time::Instant;

/// Entity of the lines of text.
pub const LOG: &str = "log";

/// An arena being drawn into a recording.
pub struct View {
    rec: Recording,
    drawn: Option<Drawn>,
    epoch: u64,
    plots: Plots,
    moment: Moment,
    /// When the moment was set, to date what happens while no state comes.
    set_at: Instant,
}

struct Drawn {
    scene: Scene,
    roster: Roster,
    floor: SceneView,
    balls: BallView,
    trails: TrailView,
    hits: HitView,
}

impl View {
    /// Starts to draw into a recording.
    pub fn new(rec: Recording) -> RecordingStreamResult<Self> {
        Plots::log_names(&rec)?;
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
        let moment = Moment { wall_ns: now.as_nanos() as u64, ..Moment::default() };
        Ok(Self { rec, drawn: None, epoch: 0, plots: Plots::default(), moment, set_at: Instant::now() })
    }

    /// The recording it draws into.
    pub const fn recording(&self) -> &Recording {
        &self.rec
    }

    /// Logs news: the world first, then hits, then the state that shows them.
    pub fn show(&mut self, news: &News) -> RecordingStreamResult<()> {
        if let Some(world) = &news.world {
            self.start_from(world)?;
            self.state(&world.snapshot, news)?;
        }
        if let Some(drawn) = &mut self.drawn {
            news.hits.iter().filter(|hit| hit.epoch == self.epoch).for_each(|hit| drawn.hits.add(hit));
        }
        if let Some(state) = &news.state {
            self.state(state, news)?;
        }
        if let Some(stats) = news.stats.as_ref().filter(|_| self.drawn.is_some()) {
            self.rec.at(self.now());
            Plots::log_stats(&self.rec, stats)?;
        }
        for note in &news.notes {
            self.note(note.warning, &note.text)?;
        }
        Ok(())
    }

    /// A new epoch, or a late start into one.
    fn start_from(&mut self, world: &World) -> RecordingStreamResult<()> {
        let same = |drawn: &Drawn| drawn.scene == world.scene && drawn.roster == world.roster;
        let fresh = self.epoch != world.snapshot.epoch || self.drawn.is_none();
        self.move_to(&world.snapshot);
        self.epoch = world.snapshot.epoch;
        if !self.drawn.as_ref().is_some_and(same) {
            self.draw(world)?;
        }
        let Some(drawn) = &mut self.drawn else { return Ok(()) };
        if fresh {
            drawn.trails.clear(&self.rec)?;
            drawn.hits.clear(&self.rec)?;
            self.plots.clear();
            let balls = world.roster.names.len();
            self.note(false, &format!("epoch {}: scene {}, {balls} balls", self.epoch, world.scene.name))?;
        }
        Ok(())
    }

    /// A scene or a roster that was not drawn before.
    fn draw(&mut self, world: &World) -> RecordingStreamResult<()> {
        let stale = self.drawn.take().map_or(0, |drawn| drawn.balls.groups());
        let floor = match SceneView::of(&world.scene, &world.roster) {
            Ok(floor) => floor,
            Err(fault) => return self.note(true, &fault.to_string()),
        };
        floor.log(&self.rec)?;
        let balls = BallView::of(&world.roster);
        balls.log_roster(&self.rec, &world.roster, stale)?;
        blueprint::send(&self.rec, floor.extent())?;
        let plan = floor.tessellation();
        let (triangles, sagitta) = (plan.triangles(), plan.sagitta_m * 1e3);
        let text = format!("floor drawn with {triangles} triangles, within {sagitta:.3} mm of the surface");
        self.note(plan.bounded, &if plan.bounded { text + " (coarser than wanted: too many triangles)" } else { text })?;
        self.drawn = Some(Drawn {
            scene: world.scene.clone(),
            roster: world.roster.clone(),
            trails: TrailView::of(&world.roster),
            hits: HitView::of(&world.roster),
            floor,
            balls,
        });
        Ok(())
    }

    fn state(&mut self, state: &Snapshot, news: &News) -> RecordingStreamResult<()> {
        let Some(drawn) = &mut self.drawn else { return Ok(()) };
        let count = drawn.roster.names.len();
        let lengths = [state.uv.len(), state.center_m.len(), state.orientation_xyzw.len()];
        if state.epoch != self.epoch || lengths != [count; 3] {
            // Another epoch's state belongs to a world that is still to come.
            return Ok(());
        }
        self.moment = after(self.moment, state);
        self.set_at = Instant::now();
        self.rec.at(self.moment);
        let floor = &drawn.floor;
        let ring = |ball: usize| {
            let [u, v] = state.uv[ball];
            Ring { center: floor.above([u, v]), normal: floor.normal([u, v]) }
        };
        drawn.balls.log_state(&self.rec, state, ring)?;
        drawn.trails.log_state(&self.rec, state, |uv| floor.above(uv))?;
        drawn.hits.log_state(&self.rec, state)?;
        self.plots.log_state(&self.rec, state, news.counts)
    }

    fn move_to(&mut self, state: &Snapshot) {
        self.moment = after(self.moment, state);
        self.set_at = Instant::now();
        self.rec.at(self.moment);
    }

    /// A line of text, dated now.
    fn note(&self, warning: bool, text: &str) -> RecordingStreamResult<()> {
        self.rec.at(self.now());
        let level = if warning { TextLogLevel::WARN } else { TextLogLevel::INFO };
        self.rec.log(LOG, &TextLog::new(text).with_level(level))
    }

    /// The last state's moment, with the wall time that went by since.
    fn now(&self) -> Moment {
        Moment { wall_ns: self.moment.wall_ns + self.set_at.elapsed().as_nanos() as u64, ..self.moment }
    }
}

/// The state's moment; wall time never goes back, also where another server's clock is behind.
fn after(last: Moment, state: &Snapshot) -> Moment {
    let moment = Moment::from(state);
    Moment { wall_ns: moment.wall_ns.max(last.wall_ns), ..moment }
}
