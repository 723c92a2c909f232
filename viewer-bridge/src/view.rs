//! All that is shown of an arena, in one recording: the order in which news become rows.

use crate::blueprint;
use crate::drawn::Drawn;
use crate::named_view::NamedView;
use crate::plots::Plots;
use crate::recording::{Moment, Recording};
use crate::slot::News;
use protocol::snapshot::{Snapshot, World};
use rerun::components::TextLogLevel;
use rerun::{RecordingStreamResult, TextLog};
use std::time::Instant;

/// Entity of the lines of text.
pub const LOG: &str = "log";

/// An arena being drawn into a recording.
pub struct View {
    rec: Recording,
    first: NamedView,
    drawn: Option<Drawn>,
    epoch: u64,
    plots: Plots,
    moment: Moment,
    /// Added to the server's clock so that wall time never goes back, also where another server's clock is behind.
    ahead_ns: u64,
    /// When the moment was set, to date what happens while no state comes.
    set_at: Instant,
}

impl View {
    /// Starts to draw into a recording; its layout opens with the `first` view.
    pub fn new(rec: Recording, first: NamedView) -> Self {
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
        let moment = Moment { wall_ns: now.as_nanos() as u64, ..Moment::default() };
        Self {
            rec,
            first,
            drawn: None,
            epoch: 0,
            plots: Plots::default(),
            moment,
            ahead_ns: 0,
            set_at: Instant::now(),
        }
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
            news.hits.iter().filter(|hit| hit.epoch == self.epoch).for_each(|hit| drawn.add(hit));
        }
        if let Some(state) = &news.state {
            self.state(state, news)?;
        }
        if let Some(stats) = news.stats.as_ref().filter(|_| self.drawn.is_some()) {
            Plots::log_stats(&self.rec, stats)?;
        }
        for note in &news.notes {
            self.note(note.warning, &note.text)?;
        }
        Ok(())
    }

    /// A new epoch, or a late start into one.
    fn start_from(&mut self, world: &World) -> RecordingStreamResult<()> {
        let fresh = self.epoch != world.snapshot.epoch || self.drawn.is_none();
        let earliest = if self.epoch == 0 { 0 } else { self.now().wall_ns };
        self.ahead_ns = earliest.saturating_sub(world.snapshot.wall_ns);
        self.move_to(&world.snapshot);
        self.epoch = world.snapshot.epoch;
        if !self.drawn.as_ref().is_some_and(|drawn| drawn.shows(world)) {
            self.draw(world)?;
        }
        let Some(drawn) = &mut self.drawn else { return Ok(()) };
        if fresh {
            drawn.clear(&self.rec)?;
            self.plots.clear();
            let balls = world.roster.names.len();
            self.note(
                false,
                &format!("scene {} begins with {balls} balls (epoch {})", world.scene.name, self.epoch),
            )?;
        }
        Ok(())
    }

    /// A scene or a roster that was not drawn before.
    fn draw(&mut self, world: &World) -> RecordingStreamResult<()> {
        let before = self.drawn.take();
        let drawn = match Drawn::of(world, &self.first) {
            Ok(drawn) => drawn,
            Err(fault) => return self.note(true, &fault.to_string()),
        };
        if !before.as_ref().is_some_and(|before| drawn.looks_like(before)) {
            blueprint::send(&mut self.rec, drawn.sights(), &self.first, before.is_some())?;
        }
        if before.is_none() {
            Plots::log_names(&self.rec)?;
        }
        drawn.log(&self.rec, before.as_ref())?;
        if let Some(name) = self.first.missing(&world.roster) {
            let names = world.roster.names.iter().take(8).map(String::as_str).collect::<Vec<_>>().join(", ");
            let text = format!("no ball is named {name}: another one is followed; there are {names}");
            tracing::warn!("{text}");
            self.note(true, &text)?;
        }
        let plan = drawn.tessellation();
        let (triangles, sagitta) = (plan.triangles(), plan.sagitta_m * 1e3);
        let text = format!("floor drawn with {triangles} triangles, within {sagitta:.3} mm of the surface");
        self.note(
            plan.bounded,
            &if plan.bounded { text + " (coarser than wanted: too many triangles)" } else { text },
        )?;
        self.drawn = Some(drawn);
        Ok(())
    }

    fn state(&mut self, state: &Snapshot, news: &News) -> RecordingStreamResult<()> {
        let Some(drawn) = &mut self.drawn else { return Ok(()) };
        if state.epoch != self.epoch || !drawn.fits(state) {
            // Another epoch's state belongs to a world that is still to come.
            return Ok(());
        }
        self.moment = following(self.moment, state, self.ahead_ns);
        self.set_at = Instant::now();
        self.rec.at(self.moment);
        drawn.log_state(&self.rec, state)?;
        self.plots.log_state(&self.rec, state, news.counts)
    }

    fn move_to(&mut self, state: &Snapshot) {
        self.moment = Moment { wall_ns: state.wall_ns + self.ahead_ns, ..Moment::from(state) };
        self.set_at = Instant::now();
        self.rec.at(self.moment);
    }

    /// A line of text, dated now.
    fn note(&self, warning: bool, text: &str) -> RecordingStreamResult<()> {
        self.rec.at(self.now());
        let level = if warning { TextLogLevel::WARN } else { TextLogLevel::INFO };
        let logged = self.rec.log(LOG, &TextLog::new(text).with_level(level));
        self.rec.at(self.moment);
        logged
    }

    /// The last state's moment, with the wall time that went by since.
    fn now(&self) -> Moment {
        Moment { wall_ns: self.moment.wall_ns + self.set_at.elapsed().as_nanos() as u64, ..self.moment }
    }
}

/// The state's moment, where a clock that is set back within an epoch stands still instead.
fn following(last: Moment, state: &Snapshot, ahead_ns: u64) -> Moment {
    Moment { wall_ns: (state.wall_ns + ahead_ns).max(last.wall_ns), ..Moment::from(state) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{SIM_TIME, TICK, WALL_TIME};
    use crate::slot::Counts;
    use crate::testing::{self, Ride};
    use crate::{ball_view, energy_plots, hit_view, net_view, overlay_view, plots, scene_view, trail_view};
    use protocol::event::{Event, Other};
    use protocol::scene::Floor;
    use protocol::stats::Stats;
    use rerun::RecordingStreamBuilder;
    use rerun::external::re_log_encoding::rrd::DecoderApp;
    use rerun::log::{Chunk, LogMsg};
    use std::collections::BTreeMap;
    use std::path::Path;
    use std::sync::Arc;

    /// Rows and chunks of each entity of a file's one recording.
    fn read_back(path: &Path) -> BTreeMap<String, Vec<Chunk>> {
        let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
        let mut entities: BTreeMap<String, Vec<Chunk>> = BTreeMap::new();
        for message in DecoderApp::decode_lazy(file) {
            if let LogMsg::ArrowMsg(store, arrow) = message.unwrap() {
                let chunk = Chunk::from_arrow_msg(&arrow).unwrap();
                chunk.sanity_check().unwrap();
                if store.is_recording() {
                    entities.entry(chunk.entity_path().to_string()).or_default().push(chunk);
                }
            }
        }
        entities
    }

    fn rows(entities: &BTreeMap<String, Vec<Chunk>>, path: &str) -> usize {
        entities.get(&format!("/{path}")).map_or(0, |chunks| chunks.iter().map(Chunk::num_rows).sum())
    }

    fn news(state: Snapshot) -> News {
        News { state: Some(Arc::new(state)), ..News::default() }
    }

    /// Two epochs of `ticks` each, with hits and statistics on the way.
    fn ride(path: &Path, ticks: u64) {
        let stream = RecordingStreamBuilder::new("ballroom_test").save(path).unwrap();
        let mut view = View::new(Recording::new(stream), NamedView::default());
        let mut world = testing::original();
        for epoch in 1..=2 {
            world.snapshot.epoch = epoch;
            view.show(&News { world: Some(Arc::new(world.clone())), ..News::default() }).unwrap();
            let mut ride = Ride::new(&world);
            for tick in 1..ticks {
                let mut state = ride.state(tick);
                state.epoch = epoch;
                state.wall_ns += epoch * 60_000_000_000;
                let mut news = news(state);
                let count = tick + (epoch - 1) * ticks;
                news.counts = Counts { received: count, shown: count, ..Counts::default() };
                if tick % 25 == 0 || tick == 235 {
                    news.hits.push(Event {
                        epoch,
                        sequence: tick,
                        time_s: tick as f64 / 60.0,
                        ball: "a".into(),
                        other: Other::Wall(0),
                        point_m: news.state.as_ref().unwrap().center_m[0],
                        impulse_n_s: 20.0,
                    });
                }
                if tick % 60 == 0 {
                    let tick_micros = [40.0, 90.0, 300.0 + tick as f64];
                    news.stats = Some(Stats {
                        tick_micros,
                        real_time_factor: 1.0,
                        speed_factor: 1.0,
                        ..Stats::default()
                    });
                }
                view.show(&news).unwrap();
            }
        }
        view.recording().stream().flush_blocking().unwrap();
    }

    #[test]
    fn a_recorded_ride_reads_back_with_every_entity_row_and_timeline() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("ride.rrd");
        let ticks = 240;
        ride(&path, ticks);
        let entities = read_back(&path);
        for once in [scene_view::FLOOR, scene_view::FLOOR_LINES, scene_view::WALLS, net_view::NET] {
            assert_eq!(rows(&entities, once), 1, "{once}: an unchanged scene is logged once");
            assert!(entities[&format!("/{once}")][0].is_static());
        }
        // Three colours: three groups, each with a static mesh and a pose for every state of both epochs.
        for group in 0..3 {
            let path = format!("{}/{group}", ball_view::BALLS);
            assert_eq!(rows(&entities, &path), 1 + 2 * ticks as usize, "{path}");
        }
        for path in [overlay_view::CONTACTS, overlay_view::VELOCITIES, overlay_view::REACTIONS] {
            // Once more for the epoch in which the roster was cleared.
            assert!((2 * ticks as usize..=1 + 2 * ticks as usize).contains(&rows(&entities, path)), "{path}");
        }
        let tracks = rows(&entities, trail_view::TRAILS);
        assert!((60..100).contains(&tracks), "tracks are logged ten times a second: {tracks}");
        assert!(rows(&entities, hit_view::HITS) > 100);
        for plot in [plots::ENERGY, plots::HITS, plots::TICK_TIME, plots::SPEED, plots::BRIDGE, LOG]
            .into_iter()
            .chain([energy_plots::PARTS, energy_plots::SPIN, energy_plots::REACTION])
        {
            assert!(rows(&entities, plot) > 2, "{plot}");
        }
        for chunk in entities.values().flatten().filter(|chunk| !chunk.is_static()) {
            if chunk.entity_path().to_string().starts_with("/world") {
                for timeline in [TICK, SIM_TIME, WALL_TIME] {
                    assert!(
                        chunk.timelines().contains_key(&timeline.into()),
                        "{} lacks {timeline}",
                        chunk.entity_path()
                    );
                }
                assert!(chunk.timelines()[&WALL_TIME.into()].is_sorted(), "wall time goes back");
            }
        }
    }

    #[test]
    fn states_of_an_unknown_epoch_or_of_another_roster_are_not_drawn() {
        let (rec, storage) = testing::recording();
        let mut view = View::new(rec, NamedView::default());
        let world = testing::original();
        view.show(&News { world: Some(Arc::new(world.clone())), ..News::default() }).unwrap();
        view.recording().stream().flush_blocking().unwrap();
        storage.take();
        let mut other_epoch = world.snapshot.clone();
        other_epoch.epoch = 7;
        let mut short = world.snapshot;
        short.center_m.pop();
        view.show(&news(other_epoch)).unwrap();
        view.show(&news(short)).unwrap();
        view.recording().stream().flush_blocking().unwrap();
        assert_eq!(storage.take().len(), 0);
    }

    #[test]
    fn another_scene_replaces_the_drawn_one() {
        let (rec, storage) = testing::recording();
        let mut view = View::new(rec, NamedView::default());
        let mut world = testing::original();
        view.show(&News { world: Some(Arc::new(world.clone())), ..News::default() }).unwrap();
        world.snapshot.epoch = 2;
        world.roster.color_rgb = vec![[9, 9, 9]; 3];
        world.roster.player = vec![false; 3];
        view.show(&News { world: Some(Arc::new(world)), ..News::default() }).unwrap();
        view.recording().stream().flush_blocking().unwrap();
        let chunks = storage.take().into_iter().filter_map(|message| match message {
            LogMsg::ArrowMsg(store, arrow) if store.is_recording() => {
                Some(Chunk::from_arrow_msg(&arrow).unwrap())
            }
            _ => None,
        });
        let mut static_rows: BTreeMap<String, usize> = BTreeMap::new();
        for chunk in chunks.filter(Chunk::is_static) {
            *static_rows.entry(chunk.entity_path().to_string()).or_default() += chunk.num_rows();
        }
        // One group now; the meshes of the two others are replaced by empty ones.
        let groups: Vec<usize> =
            (0..3).map(|group| static_rows[&format!("/{}/{group}", ball_view::BALLS)]).collect();
        assert_eq!(groups, [2, 2, 2]);
        assert_eq!(static_rows[&format!("/{}", scene_view::FLOOR)], 1, "the floor is the same");
    }

    #[test]
    fn an_edited_floor_is_seen_under_the_same_eyes_and_another_scene_gets_its_own() {
        let (rec, storage) = testing::recording();
        let mut view = View::new(rec, NamedView::default());
        let mut world = testing::original();
        let mut show = |world: &World| {
            view.show(&News { world: Some(Arc::new(world.clone())), ..News::default() }).unwrap();
            view.recording().stream().flush_blocking().unwrap();
            let (mut replaced, mut drawn) = (vec![], vec![]);
            for message in storage.take() {
                match message {
                    LogMsg::BlueprintActivationCommand(command) => replaced.push(command.make_active),
                    LogMsg::ArrowMsg(store, arrow) if store.is_recording() => {
                        let chunk = Chunk::from_arrow_msg(&arrow).unwrap();
                        drawn.extend(chunk.is_static().then(|| chunk.entity_path().to_string()));
                    }
                    _ => {}
                }
            }
            (replaced, drawn)
        };
        let (replaced, _) = show(&world);
        assert_eq!(replaced, [false], "a user's own layout survives a reconnect");

        let Floor::Grid { control_heights_m, .. } = &mut world.scene.floor else { panic!() };
        control_heights_m[5][7] += 1.0;
        world.snapshot.epoch += 1;
        let (replaced, drawn) = show(&world);
        assert_eq!(replaced.len(), 0);
        for edited in [scene_view::FLOOR, scene_view::FLOOR_LINES, net_view::NET, net_view::NET_POINTS] {
            assert!(drawn.contains(&format!("/{edited}")), "{edited} is not in {drawn:?}");
        }
        assert!(
            !drawn.iter().any(|path| path.starts_with("/world/balls")),
            "the balls are the same: {drawn:?}"
        );

        world.scene.name = "another".into();
        world.snapshot.epoch += 1;
        assert_eq!(show(&world).0, [true]);
    }

    #[test]
    fn wall_time_goes_on_with_another_servers_clock_an_hour_behind() {
        let (rec, _storage) = testing::recording();
        let mut view = View::new(rec, NamedView::default());
        let mut world = testing::original();
        view.show(&News { world: Some(Arc::new(world.clone())), ..News::default() }).unwrap();
        let before = view.moment.wall_ns;
        world.snapshot.epoch += 1;
        world.snapshot.wall_ns -= 3_600_000_000_000;
        view.show(&News { world: Some(Arc::new(world.clone())), ..News::default() }).unwrap();
        let restarted = view.moment.wall_ns;
        world.snapshot.wall_ns += 16_666_667;
        view.show(&news(world.snapshot)).unwrap();
        assert!(before <= restarted && view.moment.wall_ns == restarted + 16_666_667);
    }
}
