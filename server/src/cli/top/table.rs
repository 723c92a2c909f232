//! What is seen as lines of text.

use crate::cli::sight::Sight;
use protocol::report::ClientRow;
use protocol::stats::{Division, ErrorEstimate};

/// A column of a table.
struct Column<'a, T> {
    heading: String,
    /// Characters: of text from the left, of a number from the right.
    width: Width,
    /// Where there is no room, columns of the highest rank are left out first; those of rank 0 stay.
    rank: u8,
    value: &'a dyn Fn(&T) -> String,
}

#[derive(Clone, Copy)]
enum Width {
    Text(usize),
    Number(usize),
}

impl Width {
    fn cell(self, text: &str) -> String {
        match self {
            Self::Text(width) => format!(" {:width$}", cut(text, width)),
            Self::Number(width) => format!(" {text:>width$}"),
        }
    }

    const fn characters(self) -> usize {
        match self {
            Self::Text(width) | Self::Number(width) => 1 + width,
        }
    }
}

impl<'a, T> Column<'a, T> {
    fn text(heading: &str, width: usize, rank: u8, value: &'a dyn Fn(&T) -> String) -> Self {
        Self { heading: heading.to_owned(), width: Width::Text(width), rank, value }
    }

    fn number(heading: &str, width: usize, rank: u8, value: &'a dyn Fn(&T) -> String) -> Self {
        Self { heading: heading.to_owned(), width: Width::Number(width), rank, value }
    }
}

/// The heading and a line a row, in at most `width` characters as far as columns may be left out.
fn table<T>(columns: &[Column<'_, T>], rows: &[T], width: usize, mark: impl Fn(&T) -> char) -> Vec<String> {
    let mut shown: Vec<&Column<'_, T>> = columns.iter().collect();
    while 1 + shown.iter().map(|column| column.width.characters()).sum::<usize>() > width {
        let spare = shown.iter().enumerate().filter(|(_, column)| column.rank > 0);
        let Some((least, _)) = spare.max_by_key(|(_, column)| column.rank) else { break };
        shown.remove(least);
    }
    let heading: String = shown.iter().map(|column| column.width.cell(&column.heading)).collect();
    let line = |row: &T| {
        let cells: String = shown.iter().map(|column| column.width.cell(&(column.value)(row))).collect();
        format!("{}{cells}", mark(row))
    };
    std::iter::once(format!(" {heading}")).chain(rows.iter().map(line)).collect()
}

/// One line an arena, with its heading, in at most `width` characters; the chosen one is marked.
pub fn arenas(sights: &[Sight], chosen: Option<&str>, width: usize) -> Vec<String> {
    let target = |Sight { stats, .. }: &Sight| {
        if stats.as_fast_as_possible { "max".to_owned() } else { format!("{:.2}", stats.speed_factor) }
    };
    let columns: [Column<'_, Sight>; 13] = [
        Column::text("ARENA", 14, 0, &|sight| sight.row.arena.clone()),
        Column::text("STATE", 8, 0, &|sight| sight.row.state.name().to_owned()),
        Column::text("SCENE", 18, 0, &|sight| sight.row.scene.clone()),
        Column::number("BALLS", 6, 1, &|sight| sight.row.balls.to_string()),
        Column::number("TICK", 9, 4, &|sight| sight.row.tick.to_string()),
        Column::number("TIME s", 10, 0, &|sight| format!("{:.2}", sight.row.time_s)),
        Column::number("TARGET", 7, 2, &target),
        Column::number("ACTUAL", 6, 0, &|sight| format!("{:.2}", sight.stats.real_time_factor)),
        Column::number("p50 us", 8, 6, &|sight| format!("{:.1}", sight.stats.tick_micros[0])),
        Column::number("p99 us", 8, 0, &|sight| format!("{:.1}", sight.stats.tick_micros[1])),
        Column::number("MAX us", 8, 5, &|sight| format!("{:.1}", sight.stats.tick_micros[2])),
        Column::number("LATE", 5, 0, &|sight| sight.stats.overruns.to_string()),
        Column::number("REFUSED", 7, 3, &|sight| sight.stats.commands_refused.to_string()),
    ];
    table(&columns, sights, width, |sight| if chosen == Some(&sight.row.arena) { '>' } else { ' ' })
}

/// Streams and readers of one arena, in at most `width` characters.
pub fn details(Sight { row, stats, clients }: &Sight, width: usize) -> Vec<String> {
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
    lines.extend(readers(&row.arena, clients, width));
    if clients.is_empty() {
        lines.push("  nobody".to_owned());
    }
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
    let asked = asked_m.map_or(String::new(), |asked| format!(", asked {asked:.0e} m over 10 s"));
    format!("  ERROR ABOUT {error_m:.1e} m after {followed_s:.0} s{asked}; {balls} followed, {lost} lost")
}

fn readers(arena: &str, clients: &[ClientRow], width: usize) -> Vec<String> {
    // A session's own name is a long number; its beginning tells it from others.
    let name = |ClientRow { role, id, .. }: &ClientRow| format!("{} {}", role.chunk(), cut(id.as_str(), 12));
    let number = |number: Option<f64>| number.map_or("-".to_owned(), |number| format!("{number:.2}"));
    let age = |client: &ClientRow| number(client.report.age_ms.map(|ages| ages[0]));
    let oldest = |client: &ClientRow| number(client.report.age_ms.map(|ages| ages[1]));
    let jitter = |client: &ClientRow| number(client.report.jitter_ms);
    let lost = |client: &ClientRow| client.report.lost.map_or("-".to_owned(), |lost| lost.to_string());
    let columns: [Column<'_, ClientRow>; 8] = [
        Column::text(&format!("CLIENTS OF {arena}"), 22, 0, &name),
        Column::number("STATES/s", 9, 0, &|client| format!("{:.1}", client.report.states_per_s)),
        Column::number("BYTES/s", 9, 0, &|client| short(client.report.bytes_per_s)),
        Column::number("AGE ms", 9, 0, &age),
        Column::number("MAX ms", 9, 0, &oldest),
        Column::number("JITTER ms", 9, 2, &jitter),
        Column::number("LOST", 8, 0, &lost),
        Column::number("OVERTAKEN", 9, 1, &|client| client.report.overtaken.to_string()),
    ];
    table(&columns, clients, width, |_| ' ')
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
        let lines = arenas(&[sight("left"), sight("right")], Some("right"), usize::MAX);
        assert!(lines[1].starts_with("  left ") && lines[2].starts_with("> right "), "{lines:?}");
        for (heading, value) in [("TICK", "12"), ("TARGET", "2.00"), ("REFUSED", "5")] {
            let end = lines[0].find(heading).unwrap() + heading.len();
            assert!(lines[1][..end].ends_with(value), "{heading}: {lines:?}");
        }
        let lines = details(&sight("left"), usize::MAX);
        let reader = lines.last().unwrap();
        assert!(
            reader.contains("viewer v1") && reader.contains("40.00 k") && reader.contains("1.50"),
            "{reader}"
        );
        let error = "  ERROR ABOUT 4.2e-11 m after 8 s, asked 1e-9 m over 10 s; 3 followed, 0 lost";
        assert!(lines.iter().any(|line| line == error), "{lines:?}");
        let end = lines[lines.len() - 2].find("LOST").unwrap() + 4;
        assert!(reader[..end].ends_with('7'), "{lines:?}");
    }

    #[test]
    fn what_a_narrow_terminal_has_no_room_for_is_left_out_by_whole_columns() {
        let mut lines = arenas(&[sight("left")], None, 80);
        lines.extend(details(&sight("left"), 80));
        assert!(lines.iter().all(|line| line.chars().count() <= 80), "{lines:#?}");
        for kept in ["ARENA", "SCENE", "TIME s", "ACTUAL", "p99 us", "LATE"] {
            assert!(lines[0].contains(kept), "{kept}: {}", lines[0]);
        }
        assert!(!lines[0].contains("TICK") && !lines[0].contains("MAX"), "{}", lines[0]);
        assert_eq!(lines[0].chars().count(), lines[1].chars().count());
    }
}
