//! All that is said of one scene.

use super::horizon::Horizon;
use super::numbers::plain;
use super::reference::Reference;
use super::section::Section;
use super::subject::{RATE_HZ, Subject, words};
use super::work_precision::WorkPrecision;
use super::{Options, Progress, ReportError, energy, orders, phases, scaling, ticks};
use maud::html;
use serde_json::json;

/// Simulated seconds over which errors are taken, where they have a meaning that long.
const SPAN_S: usize = 10;

/// Measures a scene.
pub fn measure(
    subject: &Subject,
    options: &Options,
    progress: &mut Progress<'_>,
) -> Result<Section, ReportError> {
    progress(&format!("{}: references", subject.name));
    let truth = Reference::new(subject, span(subject, options))?;
    let work = WorkPrecision::measure(subject, &truth, options, progress)?;
    let (work_html, work_svg) = work.show(subject, &truth)?;
    let horizon = Horizon::measure(subject, &truth)?;
    let observed = orders::observed(&work, &truth);
    progress(&format!("{}: energy", subject.name));
    let drifts = energy::measure(subject, options)?;
    let crowds = scaling::measure(subject, options, progress)?;
    progress(&format!("{}: ticks", subject.name));
    let ticks = ticks::measure(subject, options)?;
    progress(&format!("{}: where the time goes", subject.name));
    let phases = phases::measure(subject, options)?;
    let balls = if subject.balls() == 1 { "ball" } else { "balls" };
    let page = html! {
        p { (subject.description()) }
        p {
            (subject.balls()) " " (balls) ", own setting " (words(subject.own())) ", "
            (plain(phases.hits_per_second())) " hits a simulated second."
        }
        h3 { "Work and precision" }
        (work_html)
        h3 { "How long an error has a meaning" }
        (horizon.show(subject, &truth)?)
        @if work.matters() {
            h3 { "Orders" }
            (orders::show(&observed))
        }
        h3 { "Energy" }
        (energy::show(subject, &drifts)?)
        @if let Some(crowds) = &crowds { (crowds.show(subject)?) }
        (ticks.show())
        (phases.show())
        (ticks.show_hashes())
    };
    let mut section = Section::new(subject.id(), &subject.name);
    let summary = html! {
        (work.summary(subject, &truth)) (Horizon::summary(&truth))
        @if let Some(crowds) = &crowds { (crowds.summary()) }
    };
    section.summary = summary.into_string();
    section.html = page.into_string();
    section.tables = vec![
        work.table(subject),
        horizon.table(subject, &truth),
        orders::rows(subject, &observed),
        energy::rows(subject, &drifts),
        phases.rows(subject),
    ];
    section.tables.extend(ticks.tables(subject));
    section.tables.extend(crowds.iter().map(|crowds| crowds.rows(subject)));
    section.pictures =
        work_svg.into_iter().map(|svg| (format!("{}_work_precision", subject.id()), svg)).collect();
    section.json = json!({
        "scene": subject.name,
        "balls": subject.balls(),
        "own_setting": words(subject.own()),
        "tick_rate_hz": RATE_HZ,
        "work_precision": work.json(),
        "horizon": horizon.json(&truth),
        "orders": orders::json(&observed),
        "energy": energy::json(&drifts),
        "scaling": crowds.as_ref().map(scaling::Scaling::json),
        "ticks": ticks.json(),
        "phases": phases.json(),
    });
    Ok(section)
}

/// Ticks over which errors are taken at most: crowds forget their past sooner.
fn span(subject: &Subject, options: &Options) -> usize {
    let seconds = match subject.balls() {
        0..100 => SPAN_S,
        100..3000 if options.quick => SPAN_S / 5,
        100..3000 => 3 * SPAN_S / 10,
        _ => 1,
    };
    seconds * RATE_HZ as usize
}
