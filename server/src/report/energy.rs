//! What becomes of the energy in a long run.

use super::numbers::{self, plain, rough};
use super::plot::{Axis, Curve, Ink, Plot};
use super::section::{Table, figure};
use super::subject::{Subject, words};
use super::{Options, ReportError};
use ballroom_physics::{Accuracy, Controller, Time};
use maud::{Markup, html};
use serde_json::{Value, json};

/// Points of a curve.
const SAMPLES: usize = 100;
/// Settings beside the scene's own.
const BESIDE: [Accuracy; 3] =
    [Accuracy::Tolerance(1e-6), Accuracy::Tolerance(1e-9), Accuracy::Tolerance(1e-12)];
/// What is exactly none stands at the bottom of a logarithmic axis.
const NONE: f64 = 1e-17;

/// The energy of one setting over time.
#[derive(Clone, Debug)]
pub struct Drift {
    setting: Accuracy,
    own: bool,
    /// Time, s, and change of the energy over the largest kinetic energy.
    points: Vec<[f64; 2]>,
}

/// The energy of a scene over time, by several settings. The first is its own.
pub fn measure(subject: &Subject, options: &Options) -> Result<Vec<Drift>, ReportError> {
    let span = span_s(subject, options);
    let mut settings = vec![subject.own()];
    if !subject.is_flat() {
        settings.extend(BESIDE.into_iter().filter(|&setting| setting != subject.own()));
    }
    settings.into_iter().enumerate().map(|(i, setting)| drift(subject, setting, i == 0, span)).collect()
}

fn drift(subject: &Subject, setting: Accuracy, own: bool, span: f64) -> Result<Drift, ReportError> {
    let mut run = subject.start(setting)?;
    let begin = run.energy();
    let mut liveliest = kinetic(subject, &run);
    let mut points = Vec::with_capacity(SAMPLES);
    for n in 1..=SAMPLES {
        run.advance_to(Time::of_seconds(span * n as f64 / SAMPLES as f64));
        liveliest = liveliest.max(kinetic(subject, &run));
        points.push([run.time().seconds(), (run.energy() - begin).abs()]);
    }
    for point in &mut points {
        point[1] /= liveliest;
    }
    Ok(Drift { setting, own, points })
}

/// Kinetic energy, J: the whole without that of height.
fn kinetic(subject: &Subject, run: &Controller) -> f64 {
    let scene = subject.scene();
    let heights = std::iter::zip(run.balls(), run.scene_index())
        .map(|(ball, &place)| scene.balls[place].mass * scene.gravity.dot(&ball.center));
    run.energy() + heights.sum::<f64>()
}

/// Simulated seconds followed.
fn span_s(subject: &Subject, options: &Options) -> f64 {
    match (subject.balls(), options.quick) {
        (0..100, true) => 60.0,
        (0..100, false) => 600.0,
        (100..3000, false) => 20.0,
        _ => 2.0,
    }
}

impl Drift {
    /// Largest change over the whole run, relative to the largest kinetic energy.
    pub fn largest(&self) -> f64 {
        self.points.iter().map(|point| point[1]).fold(0.0, f64::max)
    }

    fn span_s(&self) -> f64 {
        self.points.last().map_or(0.0, |point| point[0])
    }
}

/// The part of the page.
pub fn show(subject: &Subject, drifts: &[Drift]) -> Result<Markup, ReportError> {
    let curve = |(drift, ink): (&Drift, &Ink)| Curve {
        name: if drift.own { "own setting".to_owned() } else { words(drift.setting) },
        ink: *ink,
        points: drift.points.iter().map(|&[t, d]| [t, d.max(NONE)]).collect(),
        dots: false,
        dashed: false,
    };
    let plot = Plot {
        title: format!("Energy against time, {}", subject.name),
        x: Axis::linear("simulated time, s"),
        y: Axis::log("change of energy / largest kinetic"),
        curves: drifts.iter().zip(&Ink::ALL).map(curve).collect(),
        marks: Vec::new(),
    };
    let span = plain(drifts[0].span_s());
    let caption = html! {
        "Change of the total energy since the start over the largest kinetic energy of the run, at " (SAMPLES)
        " times of " (span) " s. Energy is no place: it keeps its meaning beyond the horizon."
    };
    let loses = subject.scene().restitution < 1.0;
    Ok(html! {
        p {
            "At its own setting the scene changes its energy by at most " (rough(drifts[0].largest())) " of the largest kinetic energy in "
            (span) " s."
            @if loses { " Its hits are not elastic (restitution " (subject.scene().restitution) "): most of the change is theirs." }
        }
        (figure(&plot.svg()?, &caption))
    })
}

/// All of it as rows.
pub fn rows(subject: &Subject, drifts: &[Drift]) -> Table {
    let mut table = Table::new("energy", &["scene", "setting", "own", "time_s", "relative_change"]);
    for drift in drifts {
        for [time, change] in drift.points.iter().skip(4).step_by(5) {
            let own = drift.own.to_string();
            let [time, change] = [*time, *change].map(numbers::csv);
            table.push([subject.name.clone(), words(drift.setting), own, time, change]);
        }
    }
    table
}

/// All of it for programs.
pub fn json(drifts: &[Drift]) -> Value {
    let one = |drift: &Drift| {
        json!({
            "setting": words(drift.setting),
            "own": drift.own,
            "span_s": drift.span_s(),
            "largest_relative_change": numbers::json(drift.largest()),
        })
    };
    drifts.iter().map(one).collect()
}
