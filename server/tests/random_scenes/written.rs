//! A case written out: the scene as a file that `ballroom simulate` takes, and the run with its commands as a recording that
//! `ballroom replay` runs.

use crate::generate::{BEATS, Case};
use crate::script::{Act, Deed};
use ballroom_physics::BallState;
use protocol::command::{BallSetting, Command, Direction, DirectionName, SteerMode};
use protocol::scene::Motion;
use server::SceneText;
use server::recording::{RecordOptions, Recorder, Tape};
use server::simulation::Simulation;
use server::workshop::Bench;
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;

/// Ticks of 1/60 s a beat.
const TICKS: u64 = 2;
/// Beats after which a held force is renewed: sooner than it ends by itself, after half a second.
const RENEW: u64 = 10;

fn path(seed: u64, ending: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("random-{seed}.{ending}"))
}

/// The scene as `simulate` takes it; as comments what happened, what players do, and how to see it again.
pub fn write_scene(seed: u64, case: &Case, failure: &str) -> PathBuf {
    let again = format!(
        "again: BALLROOM_SEED={seed} BALLROOM_SCENES=1 cargo test --release -p server --test random_scenes"
    );
    let replay =
        format!("with its commands, if they can be obeyed to the end: ballroom replay random-{seed}.mcap");
    let mut text = String::new();
    let script = case.script.iter().map(ToString::to_string);
    for line in failure.lines().map(str::to_owned).chain([again, replay]).chain(script) {
        text.extend(["# ", &line, "\n"]);
    }
    text.push_str(&toml::to_string(&case.scene).unwrap_or_default());
    let file = path(seed, "toml");
    std::fs::write(&file, text).expect("the test's own directory takes a file");
    file
}

/// The run as `replay` takes it, as far as it goes without a panic, and the balls at its end. Why not, if it
/// cannot be recorded.
pub fn write_run(seed: u64, case: &Case) -> Result<(PathBuf, Vec<BallState>), String> {
    fn say(error: impl Display) -> String {
        error.to_string()
    }
    let file = path(seed, "mcap");
    if file.exists() {
        std::fs::remove_file(&file).map_err(say)?;
    }
    let text = toml::to_string(&case.scene).map_err(say)?;
    let loaded = SceneText::new(format!("random-{seed}.toml"), text).load().map_err(say)?;
    let mut simulation = Simulation::new(Arc::new(loaded), 60, 0).map_err(say)?;
    let (recorder, mut tape) =
        Recorder::create(&RecordOptions::new(file.clone()), &simulation).map_err(say)?;
    let recorder = std::thread::spawn(move || recorder.run());
    let mut last = vec![];
    // What was recorded before a panic is what is wanted.
    let run = catch_unwind(AssertUnwindSafe(|| {
        let mut player = Player::new(case, &simulation);
        for beat in 0..BEATS {
            player.play(beat, &mut simulation, &mut tape);
            for _ in 0..TICKS {
                simulation.advance();
                tape.ticked(&simulation, false);
            }
        }
        tape.end(&simulation);
        last.extend((0..case.scene.balls.len()).map(|id| simulation.ball_state(id)));
    }));
    drop(tape);
    recorder.join().map_err(|_| "the recorder panics".to_owned())?;
    run.map_err(|_| "it panics, and the recording ends there".to_owned())?;
    Ok((file, last))
}

/// Does by commands what a script says.
struct Player<'a> {
    case: &'a Case,
    bench: Bench,
    /// Balls by place in the list held by a force, what holds them, and since when.
    held: Vec<(usize, Command, u64)>,
}

impl<'a> Player<'a> {
    fn new(case: &'a Case, simulation: &Simulation) -> Self {
        Self { case, bench: Bench::new(simulation), held: vec![] }
    }

    fn play(&mut self, beat: u64, simulation: &mut Simulation, tape: &mut Tape) {
        for act in self.case.script.iter().filter(|act| act.beat == beat) {
            let command = self.command(act, simulation);
            self.obey(&command, simulation, tape);
            match act.deed {
                Deed::Drive { .. } => {
                    self.held.retain(|(ball, ..)| *ball != act.ball);
                    self.held.push((act.ball, command, beat));
                }
                Deed::Release => self.held.retain(|(ball, ..)| *ball != act.ball),
                Deed::Push { .. } | Deed::Set { .. } => {}
            }
        }
        let due: Vec<Command> = self
            .held
            .iter()
            .filter(|(_, _, since)| beat > *since && (beat - since).is_multiple_of(RENEW))
            .map(|(_, command, _)| command.clone())
            .collect();
        for command in due {
            self.obey(&command, simulation, tape);
        }
    }

    fn command(&self, act: &Act, simulation: &Simulation) -> Command {
        let ball = &self.case.scene.balls[act.ball];
        let name = ball.name.clone();
        let steer = |direction, mode| Command::Steer { ball: Some(name.clone()), direction, mode };
        match act.deed {
            Deed::Push { direction, .. } => steer(Direction::Vector(direction), SteerMode::Impulse),
            Deed::Drive { direction, .. } => steer(Direction::Vector(direction), SteerMode::Force),
            Deed::Release => steer(Direction::Named(DirectionName::Stop), SteerMode::Force),
            Deed::Set { by, velocity: [x, y], spin } => {
                let id = simulation.roster().place_of(&name).expect("the ball is in the scene");
                let center = simulation.ball_state(id).center;
                let rolls = self.case.scene.motion == Motion::Rolling;
                let setting = BallSetting {
                    name,
                    center_m: Some([center.x + by[0], center.y + by[1]]),
                    velocity_m_per_s: Some([x, y, 0.0]),
                    spin_rad_per_s: rolls.then_some(spin),
                };
                Command::SetBalls {
                    balls: vec![setting],
                    select: None,
                    velocity_m_per_s: None,
                    spin_rad_per_s: None,
                }
            }
        }
    }

    /// A command that is refused leaves no trace.
    fn obey(&self, command: &Command, simulation: &mut Simulation, tape: &mut Tape) {
        let at = (simulation.epoch(), simulation.tick());
        let ready = self.bench.prepare(command);
        if ready.and_then(|mut ready| ready.act(command, simulation)).is_ok() {
            tape.obeyed(at, command.clone(), simulation);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::case;
    use crate::physical::{self, Laws};
    use crate::script::bits;
    use server::recording::{Ending, Reader, replay};

    /// Scenes looked at, and how many of them must have run.
    const LOOKED_AT: std::ops::Range<u64> = 1..61;
    const RAN: u32 = 20;

    #[test]
    fn a_written_scene_runs_and_with_its_commands_it_is_the_run_that_was_tried() {
        let mut ran = 0;
        for seed in LOOKED_AT {
            let case = case(seed);
            let scene = write_scene(seed, &case, "two\nlines");
            let Ok(loaded) = SceneText::open(scene.to_str().unwrap()).unwrap().load() else { continue };
            assert_eq!(**loaded.scene(), case.scene, "scene {seed}");
            let Ok(start) = loaded.controller() else { continue };
            let Ok(run) = physical::hold(&Laws::of(&loaded, &start), &start, &case.script) else { continue };
            let (file, last) = write_run(seed, &case).unwrap();
            let same = last.iter().zip(&run.last).all(|(one, other)| bits(one) == bits(other));
            assert!(
                same && last.len() == run.last.len(),
                "scene {seed}: obeyed as commands it is another run"
            );
            let verdict = replay(&mut Reader::open(&file).unwrap(), || false).unwrap();
            assert_eq!(verdict.difference, None, "scene {seed}");
            assert_eq!((verdict.ticks, verdict.ending), (TICKS * BEATS, Some(Ending::Complete)));
            ran += u32::from(verdict.commands > 0);
            for written in [scene, file] {
                std::fs::remove_file(written).unwrap();
            }
        }
        assert!(ran >= RAN, "only {ran} scenes ran with commands");
    }
}
