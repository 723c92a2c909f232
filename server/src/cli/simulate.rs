//! `simulate`: a scene as fast as it goes, without a network.

use super::ball_count::BallCount;
use super::dial::Dial;
use super::exit::Interrupted;
use super::lines::{Format, Lines};
use super::signals::abort_on_signal;
use ballroom_physics::Time;
use indicatif::{ProgressBar, ProgressStyle};
use protocol::snapshot::Snapshot;
use server::checkpoint_file;
use server::crew::{Crew, all_cores};
use server::simulation::Simulation;
use std::path::PathBuf;
use std::sync::Arc;

/// Longest advance between two looks at signals and the progress bar, simulated s. It changes no bit of the result.
const CHUNK_S: f64 = 0.25;
/// How near to a whole number of ticks a time must be to mean it.
const ON_TICK: f64 = 1e-9;

/// Run a scene as fast as it goes and print states: at the start, every --every seconds, and at the end
#[derive(clap::Args)]
#[command(after_help = "\
The same scene always gives the same bits, whatever --every and --rate are; --rate only numbers the ticks. Times that
are whole ticks are exactly the ticks of `serve` at that rate. A run that is saved, loaded and continued gives the bits of
the run that never stopped.

Examples:
  ballroom simulate original --until 60
  ballroom simulate thousand --until 10 --every 1 --json > states.jsonl
  ballroom simulate gas --balls 10000 --until 1
  ballroom simulate bicubic --until 10 --tolerance 1e-6
  ballroom simulate original --until 600 --save ten_minutes.json
  ballroom simulate original --load ten_minutes.json --until 660 --every 1 --csv
  ballroom simulate bowl --until 2.135585674238 --csv")]
pub struct Simulate {
    /// Name of a built-in scene, or a file ending in .toml
    scene: String,
    #[command(flatten)]
    count: BallCount,
    #[command(flatten)]
    dial: Dial,
    /// Simulated seconds to run
    #[arg(long, value_name = "T", value_parser = seconds)]
    until: f64,
    /// Simulated seconds between states; without it only the first and the last are printed
    #[arg(long, value_name = "S", value_parser = seconds)]
    every: Option<f64>,
    /// Ticks a simulated second, for the tick numbers
    #[arg(long, value_name = "HZ", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rate: u32,
    /// Threads for a large scene [default: all cores]; they change no bit
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,
    /// Keep the end of the run in a new file, to go on from later
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
    /// Go on from the end that a run of the same scene has kept; times still count from the scene's start
    #[arg(long, value_name = "FILE")]
    load: Option<PathBuf>,
    #[command(flatten)]
    format: Format,
}

impl Simulate {
    pub fn run(self) -> anyhow::Result<()> {
        let loaded = Arc::new(self.dial.of(self.count.open(&self.scene)?).load()?);
        let crew = Crew::of(self.threads.map_or_else(all_cores, |threads| threads as usize))?;
        let mut simulation = Simulation::new(loaded, self.rate, 0)?;
        if let Some(file) = self.save.as_ref().filter(|file| file.exists()) {
            anyhow::bail!("{} is there already: name a new file to save to", file.display());
        }
        if let Some(file) = &self.load {
            checkpoint_file::load(&mut simulation, file)?;
        }
        let mut simulation = simulation.run_by(crew);
        let abort = abort_on_signal()?;
        let bar = progress_bar();
        let mut lines = Lines::new(self.format)?;
        let mut state = Snapshot::default();
        let end = multiple(1, self.until, self.rate);
        let start = simulation.time();
        if start > end {
            anyhow::bail!(
                "the run that was loaded stands at {} s, after --until {}",
                start.seconds(),
                self.until
            );
        }
        let mut now = start;
        // The first state is the present one, the last at the end; without --every there is none between.
        let before = self.every.map_or(0, |every| (start.seconds() / every) as u64);
        for sample in before.. {
            let target = match self.every {
                _ if sample == before => start,
                Some(every) => multiple(sample, every, self.rate).min(end),
                None => end,
            };
            if target < now {
                continue;
            }
            while now < target {
                if abort.is_aborted() {
                    return Err(Interrupted.into());
                }
                now = now.after(CHUNK_S).min(target);
                simulation.advance_to(now);
                bar.set_position((now.seconds() / self.until * 1000.0) as u64);
            }
            simulation.write_snapshot(&mut state);
            bar.suspend(|| lines.write(simulation.roster(), &state))?;
            if now >= end {
                break;
            }
        }
        bar.finish_and_clear();
        if let Some(file) = &self.save {
            checkpoint_file::save(&simulation, file)?;
        }
        Ok(())
    }
}

/// `count` times `interval`: as ticks when the interval is a whole number of them, otherwise rounded once.
fn multiple(count: u64, interval: f64, rate_hz: u32) -> Time {
    let ticks = interval * f64::from(rate_hz);
    if (ticks - ticks.round()).abs() <= ON_TICK * ticks.max(1.0) && ticks.round() >= 1.0 {
        Time::of_tick(count * ticks.round() as u64, rate_hz)
    } else {
        Time::of_seconds(count as f64 * interval)
    }
}

/// Shown on stderr, and only when that is a terminal.
fn progress_bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {elapsed} gone, {eta} to go");
    ProgressBar::new(1000).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|e| format!("{e}"))?;
    if (1e-6..=1e9).contains(&seconds) {
        Ok(seconds)
    } else {
        Err("use 0.000001 to 1000000000 seconds".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_ticks_are_the_ticks_of_the_server() {
        for k in 0..1000 {
            assert_eq!(multiple(k, 0.1, 60), Time::of_tick(6 * k, 60));
            assert_eq!(multiple(k, 1.0 / 60.0, 60), Time::of_tick(k, 60));
        }
        assert_eq!(multiple(1, 2.135_585_674_238, 60), Time::of_seconds(2.135_585_674_238));
    }
}
