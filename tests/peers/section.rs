//! The section of the page: a picture and a table a case, the ratios, and where a peer wins.

use super::measure::norm;
use super::others::Others;
use super::ours;
use super::problem::{Ground, Problem, Truth};
use super::rows::{self, Ratios, Row, TOUCH, Win};
use super::run::Measured;
use maud::{Markup, html};
use serde_json::{Value, json};
use server::report::ReportError;
use server::report::numbers::{csv, grouped, plain, rough};
use server::report::plot::{Axis, Curve, Ink, Plot};
use server::report::section::{Section, Table, figure, table};

/// Versions of the peers, from the lock file that they were built by.
const LOCK: &str = include_str!("../../Cargo.lock");

/// Makes the section.
pub fn section(measured: &[Measured], others: &Others) -> Result<Section, ReportError> {
    let mut section = Section::new("peers", "Other engines in the same run");
    let mut all = Table::new(
        "peers",
        &[
            "case",
            "engine",
            "setting",
            "cpu_s_per_s",
            "error",
            "energy_change",
            "overlap_radii",
            "hits",
            "hits_per_s",
        ],
    );
    let mut shown = vec![];
    for case in measured {
        for row in &case.rows {
            all.push(cells(&case.problem.id, row));
        }
        let svg = plot(case).svg()?;
        section.pictures.push((format!("peers_{}", case.problem.id.replace('-', "_")), svg.clone()));
        shown.push(show(case, &svg));
    }
    let wins: usize = measured.iter().map(|case| rows::wins(&case.rows, ours::ENGINE).len()).sum();
    section.summary = summary(measured, wins).into_string();
    section.html = html! {
        (introduction(others))
        h3 { "Where a peer wins" }
        (winners(measured))
        @for case in shown { (case) }
    }
    .into_string();
    section.tables = vec![all];
    section.json = json!({
        "cases": measured.iter().map(json_of).collect::<Vec<_>>(),
        "missing": others.missing,
    });
    Ok(section)
}

fn cells(case: &str, row: &Row) -> [String; 9] {
    [
        case.into(),
        row.engine.clone(),
        row.setting.clone(),
        csv(row.cost),
        csv(row.error),
        csv(row.energy_change),
        csv(row.overlap),
        row.hits.map_or_else(String::new, |hits| hits.to_string()),
        row.hits_per_second.map_or_else(String::new, csv),
    ]
}

fn version(package: &str) -> &'static str {
    let mut lines = LOCK.lines().skip_while(|line| *line != format!("name = \"{package}\""));
    lines
        .nth(1)
        .and_then(|line| line.strip_prefix("version = "))
        .map_or("", |version| version.trim_matches('"'))
}

fn introduction(others: &Others) -> Markup {
    html! {
        p {
            "The same balls, walls and floors are given to every engine, in one process and in turn; of each engine many "
            "settings are tried, and the table shows its most accurate and its cheapest. Rapier is " (version("rapier3d"))
            " in f32 and in f64, on one thread. On the plane Rapier gets neither floor nor gravity, and the height of its "
            "balls is locked, which is less work than a floor; in bowls it gets a mesh or a height field."
            @if !others.runs.is_empty() {
                " Engines that have Python packages ran in a process of their own just before or elsewhere, and were timed "
                "there in the same way; their hits are not counted."
            }
        }
        p {
            "These engines solve a more general problem: bodies of any shape, joints, stacks, floors that balls leave and "
            "come back to. In their gas on a bowl some balls fly after an oblique hit; ours stay on the floor always, on "
            "floors that are one patch without overhangs. Who needs the general problem wins with them whatever stands below."
        }
        @if !others.missing.is_empty() {
            p { "Not measured, because not installed here: " (others.missing.join(", ")) "." }
        }
    }
}

/// How often the aims are reached, from the ratios that were measured.
fn summary(measured: &[Measured], wins: usize) -> Markup {
    /// Times less CPU time at a peer's best error, and times less error at its CPU time.
    const AIMS: [f64; 2] = [10.0, 1e4];
    let all: Vec<Ratios> = measured.iter().flat_map(against).map(|(_, ratios)| ratios).collect();
    let reached = |of: fn(&Ratios) -> Option<f64>, aim| {
        all.iter().filter(|ratios| of(ratios).is_some_and(|ratio| ratio >= aim)).count()
    };
    html! {
        "Beside other engines: at a peer’s best error at least " (plain(AIMS[0])) " times less CPU time in "
        (reached(|r| r.less_cpu, AIMS[0])) " of " (all.len()) " comparisons, at its CPU time at least "
        (plain(AIMS[1])) " times less error in " (reached(|r| r.less_error, AIMS[1])) "; in " (wins)
        " things a peer wins, which are listed."
    }
}

fn times(ratio: f64) -> String {
    format!("{} times", if ratio.is_infinite() { "∞".into() } else { plain(ratio) })
}

/// Every peer at its best error, and how it compares.
fn against(case: &Measured) -> Vec<(&Row, Ratios)> {
    let ours = rows::of(&case.rows, ours::ENGINE);
    let peers = rows::engines(&case.rows).into_iter().filter(|engine| *engine != ours::ENGINE);
    peers
        .filter_map(|engine| rows::most_accurate(&rows::of(&case.rows, engine)))
        .map(|best| (best, rows::ratios(&ours, best)))
        .collect()
}

fn show(case: &Measured, svg: &str) -> Markup {
    let caption = html! {
        "Error against CPU time of stepping: down and to the left is better. The error is the " (norm(&case.problem))
        ". A dot is a setting that no other of the same engine beats in both; what is off the bottom stands on it."
    };
    let compared = against(case).into_iter().map(|(best, ratios)| {
        let ratio = |ratio: Option<f64>| ratio.map_or_else(|| "none of ours".into(), times);
        vec![best.engine.clone(), ratio(ratios.less_cpu), ratio(ratios.less_error)]
    });
    let compared: Vec<_> = compared.collect();
    html! {
        h3 { (case.problem.title) }
        p { (told(&case.problem)) }
        (figure(svg, &caption))
        (table(
            &["engine", "", "setting", "CPU, µs/s", "error", "energy change", "overlap, radii", "hits/s"],
            &bests(case),
        ))
        (table(&["peer at its best error", "our CPU is less by", "at its CPU our error is less by"], &compared))
    }
}

/// What is particular about a case.
fn told(problem: &Problem) -> String {
    let floor = match problem.ground {
        Ground::Plane => String::new(),
        Ground::Bowl(c) => format!(" The floor is z = {} (x² + y²).", plain(c)),
    };
    let exact = match &problem.truth {
        Truth::Velocities(_, hits) => format!(" {hits} hits are exact; a peer’s are counted by its pushes."),
        Truth::Centers(_) => " The reference is exact, or a trajectory in more digits than f64.".into(),
        Truth::Energy => " Places mean nothing in chaos: energy is compared.".into(),
    };
    format!("Compared at {} Hz.{floor}{exact}", problem.sample_hz)
}

/// The most accurate and the cheapest row of every engine.
fn bests(case: &Measured) -> Vec<Vec<String>> {
    let mut shown = vec![];
    for engine in rows::engines(&case.rows) {
        let of = rows::of(&case.rows, engine);
        let (Some(best), Some(cheap)) = (rows::most_accurate(&of), rows::cheapest(&of)) else { continue };
        let line = |what: &str, row: &Row| {
            vec![
                row.engine.clone(),
                what.into(),
                row.setting.clone(),
                plain(row.cost * 1e6),
                rough(row.error),
                rough(row.energy_change),
                if row.overlap > TOUCH { rough(row.overlap) } else { "none".into() },
                row.hits_per_second.map_or_else(|| "–".into(), |hits| grouped(hits.round())),
            ]
        };
        if std::ptr::eq(best, cheap) {
            shown.push(line("both", best));
        } else {
            shown.extend([line("most accurate", best), line("cheapest", cheap)]);
        }
    }
    shown
}

fn plot(case: &Measured) -> Plot {
    /// Below this a difference is rounding, and 0 has no place on a logarithmic axis.
    const BOTTOM: f64 = 1e-16;
    let curve = |(engine, ink): (&str, &Ink)| Curve {
        name: engine.into(),
        ink: *ink,
        points: front(&rows::of(&case.rows, engine))
            .iter()
            .map(|r| [r.cost * 1e6, r.error.max(BOTTOM)])
            .collect(),
        dots: true,
        dashed: false,
    };
    Plot {
        title: format!("Error against CPU time, {}", case.problem.title),
        x: Axis::log("CPU time, µs for a simulated second"),
        y: Axis::log(match case.problem.truth {
            Truth::Centers(_) => "error, m",
            Truth::Velocities(..) => "error of velocities, relative",
            Truth::Energy => "change of energy, relative",
        }),
        curves: rows::engines(&case.rows).into_iter().zip(Ink::ALL.iter().cycle()).map(curve).collect(),
        marks: vec![],
    }
}

/// Rows that no other beats in cost and error, from the cheapest on.
fn front<'a>(rows: &[&'a Row]) -> Vec<&'a Row> {
    let mut rows = rows.to_vec();
    rows.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut least = f64::INFINITY;
    rows.retain(|row| {
        let better = row.error < least;
        least = least.min(row.error);
        better
    });
    rows
}

fn winners(measured: &[Measured]) -> Markup {
    let wins = |case: &Measured| rows::wins(&case.rows, ours::ENGINE);
    let items: Vec<Markup> = measured
        .iter()
        .flat_map(|case| {
            wins(case).into_iter().map(|win| html! { li { (case.problem.title) ": " (words(&win)) } })
        })
        .collect();
    html! {
        @if items.is_empty() {
            p { "In none of the cases measured, in cost, error or overlap." }
        } @else {
            p { "By what was measured, in cost, error or overlap:" }
            ul { @for item in items { (item) } }
        }
    }
}

fn words(win: &Win) -> String {
    let of = |row: &Row| format!("{} ({})", row.engine, row.setting);
    let at = |row: &Row| format!("{} µs/s with an error of {}", plain(row.cost * 1e6), rough(row.error));
    match win {
        Win::Cost { row, ours } => {
            format!(
                "{} is cheaper than any setting of ours, {}; our least is {} µs/s.",
                of(row),
                at(row),
                plain(ours * 1e6)
            )
        }
        Win::Error { row, ours } => {
            format!(
                "{} is more accurate than any setting of ours, {}; our least error is {}.",
                of(row),
                at(row),
                rough(*ours)
            )
        }
        Win::Both { row } => {
            format!("{}, {}, has no setting of ours that is as cheap and as accurate.", of(row), at(row))
        }
        Win::Overlap { row, ours } => {
            format!(
                "{} lets balls overlap by {} radii at the most, ours by {}.",
                of(row),
                rough(row.overlap),
                rough(*ours)
            )
        }
    }
}

fn json_of(case: &Measured) -> Value {
    let ratios = against(case).into_iter().map(|(best, ratios)| json!({ "peer": best, "ratios": ratios }));
    json!({
        "id": case.problem.id,
        "title": case.problem.title,
        "norm": norm(&case.problem),
        "seconds": case.problem.seconds,
        "balls": case.problem.balls.len(),
        "rows": case.rows,
        "at_their_best_error": ratios.collect::<Vec<_>>(),
        "wins": rows::wins(&case.rows, ours::ENGINE),
    })
}
