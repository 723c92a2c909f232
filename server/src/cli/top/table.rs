//! What is seen as lines of text.

use crate::cli::sight::Sight;
use protocol::report::ClientRow;
use protocol::stats::{Division, ErrorEstimate};

/// One line an arena, with its heading; the chosen one is marked.
pub fn arenas(sights: &[Sight], chosen: Option<&str>) -> Vec<String> {
    let heading = format!(
        "  {:14} {:8} {:18} {:>6} {:>9} {:>10}  {:>6} {:>6}  {:>8} {:>8} {:>8}  {:>5} {:>7}",
        "ARENA",
        "STATE",
        "SCENE",
        "BALLS",
        "TICK",
        "TIME s",
        "TARGET",
        "ACTUAL",
        "p50 us",
        "p99 us",
        "MAX us",
        "LATE",
        "REFUSED"
    );
    let line = |Sight { row, stats, .. }: &Sight| {
        let mark = if chosen == Some(&row.arena) { '>' } else { ' ' };
        let target =
            if stats.as_fast_as_possible { "max".to_owned() } else { format!("{:.2}", stats.speed_factor) };
        let [median, late, worst] = stats.tick_micros;
        format!(
            "{mark} {:14} {:8} {:18} {:>6} {:>9} {:>10.2}  {target:>6} {:>6.2}  {median:>8.1} {late:>8.1} {worst:>8.1}  {:>5} {:>7}",
            cut(&row.arena, 14),
            row.state.name(),
            cut(&row.scene, 18),
            row.balls,
            row.tick,
            row.time_s,
            stats.real_time_factor,
            stats.overruns,
            stats.commands_refused
        )
    };
    std::iter::once(heading).chain(sights.iter().map(line)).collect()
}

/// Streams and readers of one arena.
pub fn details(Sight { row, stats, clients }: &Sight) -> Vec<String> {
    let mut lines = vec![
        String::new(),
        format!("  {:22} {:>9} {:>9}", format!("STREAMS OF {}", row.arena), "MSG/s", "BYTES/s"),
    ];
    for (name, stream) in stats.streams.named() {
        let unread = if stream.is_read { "" } else { "  nobody reads it" };
        let (messages, bytes) = (stream.messages_per_s, short(stream.bytes_per_s));
        lines.push(format!("  {name:22} {messages:>9.1} {bytes:>9}{unread}"));
    }
    lines.extend(stats.division.map(|division| shared(&division)));
    lines.extend(stats.error_estimate.map(|estimate| error(&estimate)));
    lines.push(String::new());
    lines.push(format!(
        "  {:22} {:>9} {:>9} {:>9} {:>9} {:>9} {:>8} {:>9}",
        format!("CLIENTS OF {}", row.arena),
        "STATES/s",
        "BYTES/s",
        "AGE ms",
        "MAX ms",
        "JITTER ms",
        "LOST",
        "OVERTAKEN"
    ));
    if clients.is_empty() {
        lines.push("  nobody".to_owned());
    }
    lines.extend(clients.iter().map(reader));
    lines
}

fn shared(division: &Division) -> String {
    let Division { shards, copies, kept, undone, in_one } = division;
    format!(
        "  {shards} THREADS SHARE IT, {copies} balls copied; phases: {kept} kept, {undone} undone, {in_one} in one piece"
    )
}

fn error(estimate: &ErrorEstimate) -> String {
    let ErrorEstimate { balls, error_m, followed_s, asked_m, lost, .. } = estimate;
    let asked = asked_m.map_or(String::new(), |asked| format!(", {asked:.0e} m asked for over 10 s"));
    format!(
        "  ERROR ABOUT {error_m:.1e} m after {followed_s:.0} s{asked}; {balls} balls followed, {lost} lost"
    )
}

fn reader(ClientRow { role, id, report, .. }: &ClientRow) -> String {
    // A session's own name is a long number; its beginning tells it from others.
    let name = format!("{} {}", role.chunk(), cut(id.as_str(), 12));
    let number = |number: Option<f64>| number.map_or("-".to_owned(), |number| format!("{number:.2}"));
    let [age, oldest] = report.age_ms.map_or([None; 2], |ages| ages.map(Some)).map(number);
    format!(
        "  {:22} {:>9.1} {:>9} {age:>9} {oldest:>9} {:>9} {:>8} {:>9}",
        cut(&name, 22),
        report.states_per_s,
        short(report.bytes_per_s),
        number(report.jitter_ms),
        report.lost.map_or("-".to_owned(), |lost| lost.to_string()),
        report.overtaken
    )
}

/// Its first characters: a column keeps its width.
fn cut(text: &str, width: usize) -> String {
    text.chars().take(width).collect()
}

/// With three figures and a prefix.
fn short(number: f64) -> String {
    match number {
        n if n >= 1e9 => format!("{:.2} G", n / 1e9),
        n if n >= 1e6 => format!("{:.2} M", n / 1e6),
        n if n >= 1e3 => format!("{:.2} k", n / 1e3),
        n => format!("{n:.0}"),
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use protocol::arenas::ArenaRow;
    use protocol::keys::Role;
    use protocol::report::Report;
    use protocol::state::RunState;
    use protocol::stats::Stats;

    /// An arena with one reader.
    pub fn sight(arena: &str) -> Sight {
        let report = Report { states_per_s: 60.0, bytes_per_s: 4.0e4, lost: Some(7), ..Report::default() };
        Sight {
            row: ArenaRow {
                arena: arena.into(),
                scene: "plane".into(),
                state: RunState::Paused,
                epoch: 1,
                tick: 12,
                time_s: 0.2,
                tick_rate_hz: 60,
                balls: 3,
                recorded: false,
            },
            stats: Stats {
                speed_factor: 2.0,
                commands_refused: 5,
                division: Some(Division { shards: 2, copies: 17, kept: 11, undone: 4, in_one: 1 }),
                error_estimate: Some(ErrorEstimate {
                    balls: 3,
                    error_m: 4.2e-11,
                    followed_s: 7.5,
                    asked_m: Some(1e-9),
                    ..ErrorEstimate::default()
                }),
                ..Stats::default()
            },
            clients: vec![ClientRow {
                role: Role::Viewer,
                id: "v1".parse().unwrap(),
                heard_ms: 10.0,
                report: Report { age_ms: Some([0.4, 1.5]), ..report },
            }],
        }
    }

    #[test]
    fn columns_stand_under_their_headings_and_the_chosen_arena_is_marked() {
        let lines = arenas(&[sight("left"), sight("right")], Some("right"));
        assert!(lines[1].starts_with("  left ") && lines[2].starts_with("> right "), "{lines:?}");
        for (heading, value) in [("TICK", "12"), ("TARGET", "2.00"), ("REFUSED", "5")] {
            let end = lines[0].find(heading).unwrap() + heading.len();
            assert!(lines[1][..end].ends_with(value), "{heading}: {lines:?}");
        }
        let lines = details(&sight("left"));
        let reader = lines.last().unwrap();
        assert!(
            reader.contains("viewer v1") && reader.contains("40.00 k") && reader.contains("1.50"),
            "{reader}"
        );
        let error = "  ERROR ABOUT 4.2e-11 m after 8 s, 1e-9 m asked for over 10 s; 3 balls followed, 0 lost";
        assert!(lines.iter().any(|line| line == error), "{lines:?}");
        let end = lines[lines.len() - 2].find("LOST").unwrap() + 4;
        assert!(reader[..end].ends_with('7'), "{lines:?}");
    }
}
