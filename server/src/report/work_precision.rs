//! Error against cost, for every integrator and setting.

use super::clock::{Cost, cost};
use super::numbers::{plain, rough};
use super::plot::{Axis, Curve, Ink, Mark, Plot};
use super::reference::Reference;
use super::section::{Table, figure, table};
use super::subject::{Family, Subject, number, tick, words};
use super::{Options, Progress, ReportError, numbers, ticks};
use ballroom_physics::Accuracy;
use maud::{Markup, html};
use serde_json::{Value, json};

/// What a setting costs and how exact it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// The setting.
    pub setting: Accuracy,
    /// Largest error over all ticks of the span, m; not a number if a place was none.
    pub error_m: f64,
    /// CPU time of stepping a ball for a simulated second, s.
    pub cost: Cost,
    /// The same in µs.
    pub micros: f64,
    /// Integration steps for a ball and a simulated second.
    pub steps: f64,
}

/// All settings of a scene.
#[derive(Clone, Debug)]
pub struct WorkPrecision {
    /// Family by family, coarse to fine.
    pub runs: Vec<Run>,
    /// The scene's own setting.
    pub own: Run,
    /// CPU time of reading the states of all ticks of the span, beyond that of stepping, µs a ball and simulated second.
    pub reading_micros: f64,
    /// The reference's own error, m: smaller ones say nothing.
    pub floor_m: f64,
}

/// Errors that a cheapest setting is named for, m.
const WANTED: [f64; 5] = [1e-3, 1e-6, 1e-9, 1e-11, 1e-12];

impl WorkPrecision {
    /// Runs them all.
    pub fn measure(
        subject: &Subject,
        truth: &Reference,
        options: &Options,
        progress: &mut Progress<'_>,
    ) -> Result<Self, ReportError> {
        let mut runs = Vec::new();
        for family in Family::ALL {
            for setting in family.settings(options.quick) {
                progress(&format!("{}: work and precision, {}", subject.name, words(setting)));
                runs.push(run(subject, truth, setting)?);
            }
        }
        let own = run(subject, truth, subject.own())?;
        let start = subject.start(subject.own())?;
        let ticked = cost(
            || start.clone(),
            |run| {
                for n in 1..=truth.span {
                    run.advance_to(tick(n));
                    ticks::read(run);
                }
            },
        );
        let reading_micros = 1e6 * (ticked.seconds - own.cost.seconds) / ball_seconds(subject, truth);
        Ok(Self { runs, own, reading_micros: reading_micros.max(0.0), floor_m: truth.error() })
    }

    /// The cheapest run whose error is at most `wanted` m; none if the reference itself is not known that well.
    pub fn cheapest(&self, wanted: f64) -> Option<&Run> {
        let known = self.floor_m <= wanted;
        let exact = self.runs.iter().chain([&self.own]).filter(|run| known && run.error_m <= wanted);
        exact.min_by(|a, b| a.micros.total_cmp(&b.micros))
    }

    /// Whether the settings make a difference at all.
    pub fn matters(&self) -> bool {
        self.runs.iter().any(|run| run.error_m != self.runs[0].error_m)
    }

    fn why_none(&self, wanted: f64) -> &'static str {
        if self.floor_m > wanted { "the reference is not known that well" } else { "none of those tried" }
    }

    fn plot(&self, subject: &Subject, truth: &Reference) -> Plot {
        // What agrees with the reference to the last bit has no place on a logarithmic axis: it stands on the floor.
        let floor = truth.error().max(1e-16);
        let at = |run: &Run| [run.micros, if run.error_m < floor { floor } else { run.error_m }];
        let curve = |(family, ink): (Family, &Ink)| Curve {
            name: family.name().to_owned(),
            ink: *ink,
            points: down_to(floor, self.of(family).map(at)),
            dots: true,
            dashed: false,
        };
        let mut curves: Vec<Curve> = Family::ALL.into_iter().zip(&Ink::ALL).map(curve).collect();
        let costs = || self.runs.iter().map(|run| run.micros);
        let ends = [costs().fold(f64::INFINITY, f64::min), costs().fold(0.0, f64::max)];
        curves.push(Curve {
            name: "error of the reference".into(),
            ink: Ink::Grey,
            points: ends.map(|x| [x, floor]).into(),
            dots: false,
            dashed: true,
        });
        Plot {
            title: format!("Error against CPU time, {}", subject.name),
            x: Axis::log("CPU time, µs for a ball and a simulated second"),
            y: Axis::log("largest position error, m"),
            curves,
            marks: vec![Mark { at: at(&self.own), name: "the scene’s own".into() }],
        }
    }

    fn of(&self, family: Family) -> impl Iterator<Item = &Run> {
        self.runs.iter().filter(move |run| Family::of(run.setting) == family)
    }

    /// One sentence for the top of the page.
    pub fn summary(&self, subject: &Subject, truth: &Reference) -> Markup {
        let own = &self.own;
        html! {
            code { (subject.name) } " at its own setting (" (words(own.setting)) "): "
            @if self.matters() { (error_words(own.error_m, truth)) } @else { "a closed form, which no setting changes," }
            " for " (plain(own.micros)) " µs a ball-second"
            @if self.matters() {
                @if let Some(run) = self.cheapest(1e-9) {
                    "; cheapest for 1e-9 m: " (words(run.setting)) ", " (plain(run.micros)) " µs"
                }
            }
            "."
        }
    }

    /// The part of the page, and the picture where there is something to see.
    pub fn show(
        &self,
        subject: &Subject,
        truth: &Reference,
    ) -> Result<(Markup, Option<String>), ReportError> {
        let reading = html! {
            p {
                "Reading the states of all ticks comes to " (plain(self.reading_micros))
                " µs a ball-second more, at " (super::subject::RATE_HZ) " ticks a second."
            }
        };
        if !self.matters() {
            let markup = html! {
                p {
                    "Every setting gives the same bits: on a plane, motion is a closed form. What is left is the cost of hits, "
                    (plain(self.own.micros)) " µs a ball-second over " (plain(truth.span_s())) " s."
                }
                (reading)
            };
            return Ok((markup, None));
        }
        let svg = self.plot(subject, truth).svg()?;
        let caption = html! {
            "Largest distance of any ball’s centre from the reference over all "
            (truth.span) " ticks of " (plain(truth.span_s())) " s, against CPU time of stepping: down and to the left "
            "is better. A dot is a run, and a curve ends where the reference is known no better; the ring is the scene’s own setting, "
            (words(self.own.setting)) ". The dashed line is how well the reference is known."
        };
        let columns = ["wanted", "cheapest setting", "error, m", "µs a ball-second", "steps a ball-second"];
        let markup = html! {
            (figure(&svg, &caption))
            (table(&columns, &WANTED.map(|wanted| self.cheapest_row(wanted))))
            (reading)
        };
        Ok((markup, Some(svg)))
    }

    fn cheapest_row(&self, wanted: f64) -> Vec<String> {
        let (setting, numbers) = match self.cheapest(wanted) {
            Some(run) => (words(run.setting), [rough(run.error_m), plain(run.micros), plain(run.steps)]),
            None => (self.why_none(wanted).to_owned(), ["–"; 3].map(str::to_owned)),
        };
        [format!("{wanted:.0e} m"), setting].into_iter().chain(numbers).collect()
    }

    /// All runs as rows of a table.
    pub fn table(&self, subject: &Subject) -> Table {
        let mut table = Table::new(
            "work_precision",
            &[
                "scene",
                "balls",
                "setting",
                "number_m_or_s",
                "own",
                "error_m",
                "cpu_us_per_ball_second",
                "steps_per_ball_second",
                "repetitions",
            ],
        );
        for (run, own) in self.runs.iter().map(|run| (run, false)).chain([(&self.own, true)]) {
            table.push([
                subject.name.clone(),
                subject.balls().to_string(),
                Family::of(run.setting).name().into(),
                numbers::csv(number(run.setting)),
                own.to_string(),
                numbers::csv(run.error_m),
                numbers::csv(run.micros),
                numbers::csv(run.steps),
                run.cost.repetitions.to_string(),
            ]);
        }
        table
    }

    /// All of it for programs.
    pub fn json(&self) -> Value {
        let run = |run: &Run| {
            json!({
                "setting": Family::of(run.setting).name(),
                "number_m_or_s": number(run.setting),
                "error_m": numbers::json(run.error_m),
                "cpu_us_per_ball_second": run.micros,
                "steps_per_ball_second": run.steps,
                "repetitions": run.cost.repetitions,
            })
        };
        let cheapest =
            WANTED.map(|wanted| json!({ "error_m": wanted, "run": self.cheapest(wanted).map(run) }));
        json!({
            "runs": self.runs.iter().map(run).collect::<Vec<_>>(),
            "own": run(&self.own),
            "cheapest": cheapest,
            "reading_us_per_ball_second": self.reading_micros,
        })
    }
}

/// Points up to the first that stands on the floor: what costs more than that is no longer seen to be better.
fn down_to(floor: f64, points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let mut points: Vec<_> = points.collect();
    if let Some(first) = points.iter().position(|point| point[1] <= floor) {
        points.truncate(first + 1);
    }
    points
}

/// An error in words, which ends where the reference's own begins.
fn error_words(error: f64, truth: &Reference) -> String {
    if error <= truth.error() {
        format!("at most {} m, as far as the reference is known,", rough(truth.error().max(1e-16)))
    } else {
        format!("{} m", rough(error))
    }
}

fn ball_seconds(subject: &Subject, truth: &Reference) -> f64 {
    subject.balls() as f64 * truth.span_s()
}

fn run(subject: &Subject, truth: &Reference, setting: Accuracy) -> Result<Run, ReportError> {
    let start = subject.start(setting)?;
    let error_m = truth.errors(&mut start.clone(), truth.span)[truth.span];
    let mut steps = 0;
    let cost = cost(|| start.clone(), |run| steps = run.advance_to(tick(truth.span)).steps);
    let ball_seconds = ball_seconds(subject, truth);
    Ok(Run {
        setting,
        error_m,
        cost,
        micros: 1e6 * cost.seconds / ball_seconds,
        steps: steps as f64 / ball_seconds,
    })
}
