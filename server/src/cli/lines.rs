//! States as lines: for people, as JSON, as CSV.

use protocol::snapshot::{Collisions, Roster, Snapshot};
use serde::Serialize;
use std::io::{BufWriter, Stdout, Write, stdout};

/// The choice on the command line.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Format {
    /// One JSON object a state, every number in full
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// One line a ball and state, with a header
    #[arg(long)]
    csv: bool,
}

/// Writes states to stdout.
pub enum Lines {
    /// A summary a state.
    Plain(BufWriter<Stdout>),
    /// JSON lines.
    Json(BufWriter<Stdout>),
    /// CSV.
    Csv(Box<csv::Writer<Stdout>>),
}

const CSV_HEADER: [&str; 23] = [
    "tick",
    "time_s",
    "energy_j",
    "ball_ball",
    "ball_wall",
    "state_hash",
    "name",
    "u",
    "v",
    "center_x_m",
    "center_y_m",
    "center_z_m",
    "velocity_x_m_per_s",
    "velocity_y_m_per_s",
    "velocity_z_m_per_s",
    "omega_x_rad_per_s",
    "omega_y_rad_per_s",
    "omega_z_rad_per_s",
    "orientation_x",
    "orientation_y",
    "orientation_z",
    "orientation_w",
    "radius_m",
];

#[derive(Serialize)]
struct StateLine<'a> {
    tick: u64,
    time_s: f64,
    energy_j: f64,
    collisions: Collisions,
    state_hash: String,
    balls: Vec<BallLine<'a>>,
}

#[derive(Serialize)]
struct BallLine<'a> {
    name: &'a str,
    uv: [f64; 2],
    center_m: [f64; 3],
    velocity_m_per_s: [f64; 3],
    omega_rad_per_s: [f64; 3],
    orientation_xyzw: [f64; 4],
}

impl Lines {
    /// A writer that has written its header, if it has one.
    pub fn new(format: Format) -> anyhow::Result<Self> {
        if format.csv {
            let mut writer = csv::Writer::from_writer(stdout());
            writer.write_record(CSV_HEADER)?;
            return Ok(Self::Csv(Box::new(writer)));
        }
        let out = BufWriter::new(stdout());
        Ok(if format.json { Self::Json(out) } else { Self::Plain(out) })
    }

    /// Writes one state and lets it out.
    pub fn write(&mut self, roster: &Roster, state: &Snapshot) -> anyhow::Result<()> {
        match self {
            Self::Plain(out) => {
                let Collisions { ball_ball, ball_wall } = state.collisions;
                let paused = if state.paused { "  paused" } else { "" };
                writeln!(
                    out,
                    "tick {:>8}  t {:>12.6} s  E {:>16.9} J  hits {ball_ball} balls {ball_wall} walls  {} balls{paused}",
                    state.tick,
                    state.time_s,
                    state.energy_j,
                    roster.names.len(),
                )?;
                out.flush()?;
            }
            Self::Json(out) => {
                serde_json::to_writer(&mut *out, &state_line(roster, state))?;
                out.write_all(b"\n")?;
                out.flush()?;
            }
            Self::Csv(out) => {
                for ball in 0..roster.names.len().min(state.center_m.len()) {
                    out.write_record(csv_record(roster, state, ball))?;
                }
                out.flush()?;
            }
        }
        Ok(())
    }
}

fn state_line<'a>(roster: &'a Roster, state: &Snapshot) -> StateLine<'a> {
    let balls = roster.names.iter().take(state.center_m.len()).enumerate().map(|(i, name)| BallLine {
        name,
        uv: state.uv[i],
        center_m: state.center_m[i],
        velocity_m_per_s: state.velocity_m_per_s[i],
        omega_rad_per_s: state.omega_rad_per_s[i],
        orientation_xyzw: state.orientation_xyzw[i],
    });
    StateLine {
        tick: state.tick,
        time_s: state.time_s,
        energy_j: state.energy_j,
        collisions: state.collisions,
        state_hash: format!("{:016x}", state.state_hash),
        balls: balls.collect(),
    }
}

fn csv_record(roster: &Roster, state: &Snapshot, i: usize) -> Vec<String> {
    let Collisions { ball_ball, ball_wall } = state.collisions;
    let mut record = vec![
        state.tick.to_string(),
        state.time_s.to_string(),
        state.energy_j.to_string(),
        ball_ball.to_string(),
        ball_wall.to_string(),
        format!("{:016x}", state.state_hash),
        roster.names[i].clone(),
    ];
    let numbers = state.uv[i].iter();
    let numbers = numbers.chain(&state.center_m[i]).chain(&state.velocity_m_per_s[i]);
    let numbers = numbers.chain(&state.omega_rad_per_s[i]).chain(&state.orientation_xyzw[i]);
    record.extend(numbers.chain(&roster.radius_m[i..=i]).map(f64::to_string));
    record
}
