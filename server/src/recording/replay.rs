//! The run again, from the file alone and as fast as it goes, compared with what was recorded.

use super::{CommandLine, EndLine, HashLine, Line, Reader, RecordingFault};
use crate::history::{Chronicle, Settings};
use crate::scene_file::{SceneError, SceneText};
use crate::simulation::Simulation;
use crate::workshop::Bench;
use protocol::codec;
use protocol::command::Command;
use protocol::snapshot::Snapshot;
use serde::Serialize;
use std::io::Read;
use std::sync::Arc;

/// Why there is no verdict.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The file is not usable.
    #[error(transparent)]
    File(#[from] RecordingFault),
    /// Its scene is not.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// It was told to stop.
    #[error("stopped before the end")]
    Stopped,
}

/// How the file ends.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// With everything in it.
    Complete,
    /// The recorder gave up, and says why.
    Incomplete(String),
    /// In the middle: the server was killed, or the file was not copied whole.
    Cut,
}

/// Where the run and the recording part.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// Epoch of the first difference.
    pub epoch: u64,
    /// Its tick.
    pub tick: u64,
    /// In what: `hash`, `state`, `command`, `end`.
    pub what: &'static str,
    /// As recorded.
    pub recorded: String,
    /// As replayed.
    pub replayed: String,
}

/// What came of a replay.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// Ticks made.
    pub ticks: u64,
    /// Where it came to: the epoch,
    pub last_epoch: u64,
    /// and the tick of it.
    pub last_tick: u64,
    /// Commands applied.
    pub commands: u64,
    /// Hashes compared.
    pub hashes: u64,
    /// States compared.
    pub states: u64,
    /// How the file ends; none when the replay ended before, at a difference.
    pub ending: Option<Ending>,
    /// The first difference.
    pub difference: Option<Difference>,
    /// Version of the program that recorded.
    pub program: String,
}

/// Who sees a run again, and may slow it down.
pub trait Audience {
    /// A tick was made. False ends the replay.
    fn ticked(&mut self, simulation: &Simulation) -> bool;
    /// A command was obeyed.
    fn obeyed(&mut self, simulation: &Simulation);
    /// Whether to go on with the next message.
    fn goes_on(&mut self) -> bool;
}

/// Nobody looks; the replay goes on until this says stop.
impl<F: Fn() -> bool> Audience for F {
    fn ticked(&mut self, _: &Simulation) -> bool {
        true
    }

    fn obeyed(&mut self, _: &Simulation) {}

    fn goes_on(&mut self) -> bool {
        !self()
    }
}

/// The first state of a recording.
pub fn begin<R: Read>(reader: &mut Reader<R>) -> Result<Simulation, ReplayError> {
    let Some(Line::Scene(scene)) = reader.next_line()? else {
        return Err(RecordingFault::Damaged("it does not begin with a scene".to_owned()).into());
    };
    let loaded = SceneText::new(scene.file, scene.toml).with_balls(scene.balls).load()?;
    let head = reader.head();
    Ok(Simulation::new(Arc::new(loaded), head.tick_rate_hz, head.epoch)?)
}

/// Runs a recording again, up to its end or the first difference. `stop` is asked before every message.
pub fn replay<R: Read>(reader: &mut Reader<R>, stop: impl Fn() -> bool) -> Result<Verdict, ReplayError> {
    let simulation = begin(reader)?;
    Ok(replay_before(reader, simulation, stop)?.0)
}

/// The same from the recording's first state, before an audience; and the run where it came to.
pub fn replay_before<R: Read>(
    reader: &mut Reader<R>,
    simulation: Simulation,
    audience: impl Audience,
) -> Result<(Verdict, Simulation), ReplayError> {
    let head = reader.head();
    let mut run = Run {
        audience,
        bench: Bench::new(&simulation),
        chronicle: Chronicle::new(&simulation, Settings::REPLAY),
        simulation,
        longest_gap: head.hash_every_ticks,
        verdict: Verdict {
            ticks: 0,
            last_epoch: head.epoch,
            last_tick: 0,
            commands: 0,
            hashes: 0,
            states: 0,
            ending: None,
            difference: None,
            program: head.program.clone(),
        },
        state: Snapshot::default(),
        frame: Vec::new(),
    };
    while run.verdict.difference.is_none() {
        if !run.audience.goes_on() {
            return Err(ReplayError::Stopped);
        }
        let line = match reader.next_line() {
            Ok(Some(line)) if run.verdict.ending.is_none() => line,
            Ok(None) if run.verdict.ending.is_some() => break,
            Ok(_) => return Err(RecordingFault::Damaged("its end is not its last message".to_owned()).into()),
            Err(RecordingFault::Cut) => {
                run.verdict.ending = Some(Ending::Cut);
                break;
            }
            Err(fault) => return Err(fault.into()),
        };
        run.verdict.difference = run.compare(line)?;
        (run.verdict.last_epoch, run.verdict.last_tick) = (run.simulation.epoch(), run.simulation.tick());
    }
    Ok((run.verdict, run.simulation))
}

struct Run<A> {
    audience: A,
    simulation: Simulation,
    bench: Bench,
    chronicle: Chronicle,
    longest_gap: u64,
    verdict: Verdict,
    state: Snapshot,
    frame: Vec<u8>,
}

impl<A: Audience> Run<A> {
    /// Goes to the moment of a message and does or compares what it says.
    fn compare(&mut self, line: Line) -> Result<Option<Difference>, ReplayError> {
        match line {
            Line::Scene(_) => Err(RecordingFault::Damaged("it holds a second scene".to_owned()).into()),
            Line::Command(line) => self.command(&line),
            Line::Hash(line) => {
                self.verdict.hashes += 1;
                self.hash("hash", line)
            }
            Line::State(frame) => self.state(&frame),
            Line::End(line) => self.end(line),
        }
    }

    fn command(&mut self, line: &CommandLine) -> Result<Option<Difference>, ReplayError> {
        let CommandLine { epoch, tick, order, command } = line;
        if *order != self.verdict.commands {
            let lost = format!("command {} is missing or out of order", self.verdict.commands);
            return Err(RecordingFault::Damaged(lost).into());
        }
        command.check().map_err(|fault| RecordingFault::Damaged(format!("command {order}: {fault}")))?;
        self.advance_to(*epoch, *tick)?;
        self.verdict.commands += 1;
        let refused = self.obey(command).err();
        self.audience.obeyed(&self.simulation);
        Ok(refused.map(|why| self.difference("command", "obeyed".to_owned(), format!("refused: {why}"))))
    }

    fn obey(&mut self, command: &Command) -> Result<(), String> {
        let Self { simulation, bench, chronicle, .. } = self;
        if command.needs_the_past() {
            return chronicle.obey(simulation, command).map_err(|refusal| refusal.to_string());
        }
        let at = (simulation.epoch(), simulation.tick());
        obey(simulation, bench, command)?;
        if !command.is_of_the_clock() {
            chronicle.obeyed(at, command.clone(), simulation);
        }
        Ok(())
    }

    fn hash(&mut self, what: &'static str, line: HashLine) -> Result<Option<Difference>, ReplayError> {
        self.advance_to(line.epoch, line.tick)?;
        let hashes = [line.state_hash, self.simulation.state_hash()];
        let [recorded, replayed] = hashes.map(|hash| format!("{hash:016x}"));
        Ok((hashes[0] != hashes[1]).then(|| self.difference(what, recorded, replayed)))
    }

    /// Byte by byte, but for what the wall clock and the pause say, which are no part of a run.
    fn state(&mut self, frame: &[u8]) -> Result<Option<Difference>, ReplayError> {
        let recorded = codec::decode_state(frame);
        let recorded = recorded.map_err(|e| RecordingFault::Damaged(format!("a state: {e}")))?;
        self.advance_to(recorded.epoch, recorded.tick)?;
        self.simulation.write_snapshot(&mut self.state);
        (self.state.wall_ns, self.state.paused) = (recorded.wall_ns, recorded.paused);
        codec::encode_state(&self.state, &mut self.frame);
        self.verdict.states += 1;
        let equal = self.frame == frame;
        Ok((!equal).then(|| self.difference("state", "another state".to_owned(), "this state".to_owned())))
    }

    fn end(&mut self, line: EndLine) -> Result<Option<Difference>, ReplayError> {
        let EndLine { epoch, tick, state_hash, .. } = line;
        let Verdict { commands, hashes, states, .. } = self.verdict;
        if [line.commands, line.hashes, line.states] != [commands, hashes, states] {
            return Err(RecordingFault::Damaged("messages are missing".to_owned()).into());
        }
        if !line.complete {
            self.verdict.ending = Some(Ending::Incomplete(line.why));
            return Ok(None);
        }
        self.verdict.ending = Some(Ending::Complete);
        self.hash("end", HashLine { epoch, tick, state_hash })
    }

    /// No record is further from the one before than two hashes are: nobody's file makes this run for ever.
    fn advance_to(&mut self, epoch: u64, tick: u64) -> Result<(), ReplayError> {
        let here = (self.simulation.epoch(), self.simulation.tick());
        let ticks = tick.checked_sub(here.1).filter(|ticks| epoch == here.0 && *ticks <= self.longest_gap);
        let Some(ticks) = ticks else {
            return Err(RecordingFault::Damaged(format!(
                "after tick {} of epoch {} it goes on at tick {tick} of epoch {epoch}",
                here.1, here.0
            ))
            .into());
        };
        for _ in 0..ticks {
            self.simulation.advance();
            self.verdict.ticks += 1;
            self.chronicle.ticked(&self.simulation);
            if !self.audience.ticked(&self.simulation) {
                return Err(ReplayError::Stopped);
            }
        }
        Ok(())
    }

    fn difference(&self, what: &'static str, recorded: String, replayed: String) -> Difference {
        let (epoch, tick) = (self.simulation.epoch(), self.simulation.tick());
        Difference { epoch, tick, what, recorded, replayed }
    }
}

/// What a command does to the world; the clock is none of a replay's. What needs making ready is made from the command
/// alone, as the server's workshop made it.
pub(crate) fn obey(simulation: &mut Simulation, bench: &Bench, command: &Command) -> Result<(), String> {
    let done = bench.prepare(command).and_then(|mut ready| ready.act(command, simulation));
    done.map_err(|refusal| refusal.to_string())
}
