//! `metrics`: what a server says of itself, for Prometheus.

use super::connection::{ANSWER_TIMEOUT, Connection};
use super::sight::{Lookout, Sight};
use ballroom_client::Abort;
use std::fmt::Write as _;
use std::io::Write;

/// Print the figures of all arenas in the text format of Prometheus
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  ballroom metrics
  ballroom metrics > /var/lib/node_exporter/ballroom.prom     for the textfile collector")]
pub struct Metrics {
    #[command(flatten)]
    connection: Connection,
}

impl Metrics {
    pub fn run(self) -> anyhow::Result<()> {
        let client = self.connection.open(Abort::default(), ANSWER_TIMEOUT)?;
        let sights = Lookout::new(client).look()?;
        write!(std::io::stdout().lock(), "{}", exposition(&sights))?;
        Ok(())
    }
}

/// Samples of one metric: labels beside the arena's, and the value.
type Samples = Vec<(String, f64)>;

/// A metric: name, type, help, and its samples for an arena.
type Metric = (&'static str, &'static str, &'static str, fn(&Sight) -> Samples);

/// Counters begin anew with the epoch or the arena, as a scraper expects of a restart.
const METRICS: [Metric; 17] = [
    ("ballroom_tick", "counter", "Ticks of the epoch", |s| one(s.row.tick as f64)),
    ("ballroom_balls", "gauge", "Balls", |s| one(s.row.balls as f64)),
    ("ballroom_state", "gauge", "0 stopped, 1 playing, 2 paused, 3 quitting", |s| {
        one(f64::from(s.row.state.number()))
    }),
    ("ballroom_real_time_factor", "gauge", "Simulated seconds per wall second", |s| {
        one(s.stats.real_time_factor)
    }),
    ("ballroom_speed_factor", "gauge", "The same, as wanted", |s| one(s.stats.speed_factor)),
    ("ballroom_tick_seconds", "gauge", "How long a tick takes, over the last second", |s| {
        let names = ["0.5", "0.99", "1"];
        let labels = names.map(|quantile| format!("quantile=\"{quantile}\""));
        labels.into_iter().zip(s.stats.tick_micros.map(|micros| micros / 1e6)).collect()
    }),
    ("ballroom_overruns", "counter", "Ticks that ended after their deadline", |s| {
        one(s.stats.overruns as f64)
    }),
    ("ballroom_energy_joules", "gauge", "Total energy", |s| one(s.stats.energy_j[0])),
    ("ballroom_error_metres", "gauge", "Estimated error of the balls that are followed, the largest", |s| {
        s.stats.error_estimate.map_or_else(Samples::new, |estimate| one(estimate.error_m))
    }),
    ("ballroom_shards", "gauge", "Threads that share the run", |s| {
        one(s.stats.division.map_or(1.0, |division| f64::from(division.shards)))
    }),
    ("ballroom_shared_phases", "counter", "Phases of a run that threads share", |s| {
        let division = s.stats.division.unwrap_or_default();
        let phases = [("kept", division.kept), ("undone", division.undone), ("in_one", division.in_one)];
        phases.map(|(result, count)| (label("result", result), count as f64)).into()
    }),
    ("ballroom_hits", "counter", "Hits of the epoch", |s| {
        let hits = s.stats.collisions;
        vec![
            ("of=\"ball_ball\"".into(), hits.ball_ball as f64),
            ("of=\"ball_wall\"".into(), hits.ball_wall as f64),
        ]
    }),
    ("ballroom_commands", "counter", "Commands since the arena began", |s| {
        let (obeyed, refused) = (s.stats.commands_accepted as f64, s.stats.commands_refused as f64);
        vec![("result=\"obeyed\"".into(), obeyed), ("result=\"refused\"".into(), refused)]
    }),
    ("ballroom_stream_messages_per_second", "gauge", "Messages published", |s| {
        s.stats.streams.named().map(|(name, stream)| (label("stream", name), stream.messages_per_s)).into()
    }),
    ("ballroom_stream_bytes_per_second", "gauge", "Bytes of payload published", |s| {
        s.stats.streams.named().map(|(name, stream)| (label("stream", name), stream.bytes_per_s)).into()
    }),
    ("ballroom_client_age_seconds", "gauge", "Age of states on arrival, median of the last second", |s| {
        let ages = s.clients.iter().filter_map(|c| Some((client(c), c.report.age_ms?[0] / 1e3)));
        ages.collect()
    }),
    ("ballroom_client_lost_states", "counter", "States that did not arrive", |s| {
        s.clients.iter().filter_map(|c| Some((client(c), c.report.lost? as f64))).collect()
    }),
];

fn one(value: f64) -> Samples {
    vec![(String::new(), value)]
}

/// Names on the wire hold nothing that would have to be escaped.
fn label(name: &str, value: &str) -> String {
    format!("{name}=\"{value}\"")
}

fn client(row: &protocol::report::ClientRow) -> String {
    format!("{},{}", label("role", row.role.chunk()), label("id", row.id.as_str()))
}

/// The text format, version 0.0.4.
fn exposition(sights: &[Sight]) -> String {
    let mut text = String::new();
    for (name, kind, help, samples) in METRICS {
        // A text takes every byte.
        let _ = writeln!(text, "# HELP {name} {help}\n# TYPE {name} {kind}");
        for sight in sights {
            for (labels, value) in samples(sight) {
                let more = if labels.is_empty() { String::new() } else { format!(",{labels}") };
                let _ = writeln!(text, "{name}{{arena=\"{}\"{more}}} {value}", sight.row.arena);
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::top::table::tests::sight;

    #[test]
    fn each_metric_is_declared_once_and_has_a_sample_an_arena() {
        let text = exposition(&[sight("left"), sight("right")]);
        for (name, kind, _, _) in METRICS {
            assert_eq!(text.matches(&format!("# TYPE {name} {kind}\n")).count(), 1);
            for arena in ["left", "right"] {
                assert!(text.contains(&format!("\n{name}{{arena=\"{arena}\"")), "{name} {arena}: {text}");
            }
        }
        assert!(text.contains("ballroom_client_lost_states{arena=\"left\",role=\"viewer\",id=\"v1\"} 7\n"));
        assert!(text.contains("ballroom_shards{arena=\"left\"} 2\n"), "{text}");
        assert!(text.contains("ballroom_shared_phases{arena=\"right\",result=\"undone\"} 4\n"), "{text}");
        assert!(text.contains("ballroom_commands{arena=\"left\",result=\"refused\"} 5\n"), "{text}");
    }
}
