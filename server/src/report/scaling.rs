//! Cost and hits against the number of balls.

use super::clock::cost;
use super::fit::{Line, power_law};
use super::numbers::{self, grouped, plain};
use super::plot::{Axis, Curve, Ink, Plot};
use super::section::{Table, figure, table};
use super::subject::Subject;
use super::{Options, Progress, ReportError};
use ballroom_physics::{Report, Time};
use maud::{Markup, html};
use serde_json::{Value, json};

/// Simulated seconds before counting begins: the crowd mixes.
const WARM_UP_S: f64 = 0.25;

/// One crowd.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Crowd {
    balls: u32,
    /// Of CPU a simulated second.
    cpu_s: f64,
    /// Hits a simulated second.
    hits: f64,
    steps: f64,
}

/// Crowds of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Scaling {
    crowds: Vec<Crowd>,
    cost: Line,
    hits: Option<Line>,
}

/// Runs the same room, stretched, with more and more balls; none for a scene without a crowd.
pub fn measure(
    subject: &Subject,
    options: &Options,
    progress: &mut Progress<'_>,
) -> Result<Option<Scaling>, ReportError> {
    if !subject.is_crowd() {
        return Ok(None);
    }
    let counts: &[u32] = if options.quick {
        &[100, 300, 1000, 3000]
    } else {
        &[100, 300, 1000, 3000, 10_000, 30_000, 100_000]
    };
    let mut crowds = Vec::new();
    for &balls in counts {
        progress(&format!("{}: cost against number, {balls} balls", subject.name));
        crowds.push(crowd(&subject.with_balls(balls)?, balls)?);
    }
    let law = |f: fn(&Crowd) -> f64| {
        power_law(&crowds.iter().map(|c| [f64::from(c.balls), f(c)]).collect::<Vec<_>>())
    };
    let hits = law(|c| c.hits).filter(|law| law.offset.is_finite());
    Ok(law(|c| c.cpu_s).map(|cost| Scaling { cost, hits, crowds: crowds.clone() }))
}

fn crowd(subject: &Subject, balls: u32) -> Result<Crowd, ReportError> {
    let span_s = if balls > 3000 { 0.25 } else { 1.0 };
    let mut start = subject.start(subject.own())?;
    start.advance_to(Time::of_seconds(WARM_UP_S));
    let mut report = Report::default();
    let end = Time::of_seconds(WARM_UP_S + span_s);
    let cost = cost(|| start.clone(), |run| report = run.advance_to(end));
    let hits = report.collisions.ball_ball + report.collisions.ball_wall;
    Ok(Crowd {
        balls,
        cpu_s: cost.seconds / span_s,
        hits: hits as f64 / span_s,
        steps: report.steps as f64 / span_s,
    })
}

impl Scaling {
    /// One sentence for the top of the page.
    pub fn summary(&self) -> Markup {
        html! { " Cost grows as N^" (format!("{:.2}", self.cost.slope)) " up to " (grouped(self.largest())) " balls." }
    }

    fn largest(&self) -> f64 {
        self.crowds.iter().map(|crowd| f64::from(crowd.balls)).fold(0.0, f64::max)
    }

    /// The part of the page.
    pub fn show(&self, subject: &Subject) -> Result<Markup, ReportError> {
        let curve = |name: String, ink, f: &dyn Fn(f64, &Crowd) -> f64| Curve {
            name,
            ink,
            points: self.crowds.iter().map(|c| [f64::from(c.balls), f(f64::from(c.balls), c)]).collect(),
            dots: ink == Ink::Blue,
            dashed: ink == Ink::Grey,
        };
        let law = |n: f64, _: &Crowd| 10_f64.powf(self.cost.offset) * n.powf(self.cost.slope);
        let plot = Plot {
            title: format!("CPU time against the number of balls, {}", subject.name),
            x: Axis::log("balls"),
            y: Axis::log("CPU s for a simulated second"),
            curves: vec![
                curve(format!("N^{:.2}", self.cost.slope), Ink::Grey, &law),
                curve("measured".into(), Ink::Blue, &|_, crowd| crowd.cpu_s),
            ],
            marks: Vec::new(),
        };
        let caption = html! {
            "CPU time of stepping for a simulated second, after " (WARM_UP_S) " s of mixing; the room is stretched until each ball has as much "
            "of the floor as before. Below 1 the crowd runs in real time on one core."
        };
        let row = |c: &Crowd| {
            let balls = f64::from(c.balls);
            vec![
                grouped(balls),
                plain(c.cpu_s),
                plain(1e6 * c.cpu_s / balls),
                plain(c.hits),
                plain(1e6 * c.cpu_s / c.hits),
                plain(c.steps / balls),
            ]
        };
        let rows: Vec<_> = self.crowds.iter().map(row).collect();
        let off = |line: &Line| plain(100.0 * (10_f64.powf(line.residual) - 1.0));
        Ok(html! {
            h3 { "Cost against the number of balls" }
            p {
                "Least squares in logarithms: cost grows as N to the " (format!("{:.3}", self.cost.slope)) ", no point further than "
                (off(&self.cost)) " % off"
                @if let Some(hits) = &self.hits {
                    "; hits as N to the " (format!("{:.3}", hits.slope)) ", within " (off(hits)) " %"
                }
                "."
            }
            (figure(&plot.svg()?, &caption))
            (table(&["balls", "CPU s a simulated second", "µs a ball-second", "hits a second", "µs a hit, all included", "steps a ball-second"], &rows))
        })
    }

    /// As rows.
    pub fn rows(&self, subject: &Subject) -> Table {
        let mut table =
            Table::new("scaling", &["scene", "balls", "cpu_s_per_s", "hits_per_s", "steps_per_s"]);
        for c in &self.crowds {
            let [cpu, hits, steps] = [c.cpu_s, c.hits, c.steps].map(numbers::csv);
            table.push([subject.name.clone(), c.balls.to_string(), cpu, hits, steps]);
        }
        table
    }

    /// For programs.
    pub fn json(&self) -> Value {
        let crowd = |c: &Crowd| json!({ "balls": c.balls, "cpu_s_per_s": c.cpu_s, "hits_per_s": c.hits, "steps_per_s": c.steps });
        json!({
            "cost_exponent": self.cost.slope,
            "cost_residual_log10": self.cost.residual,
            "hits_exponent": self.hits.map(|line| line.slope),
            "crowds": self.crowds.iter().map(crowd).collect::<Vec<_>>(),
        })
    }
}
