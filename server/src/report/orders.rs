//! Observed orders of the schemes: how fast the error falls with the step.

use super::numbers::{self, rough};
use super::reference::Reference;
use super::section::{Table, table};
use super::subject::{Family, Subject, number, words};
use super::work_precision::{Run, WorkPrecision};
use ballroom_physics::Scheme;
use maud::{Markup, html};
use serde_json::{Value, json};

/// An error counts for an order when it is this many times the reference's own: below, rounding is what falls or not.
const ABOVE_FLOOR: f64 = 30.0;
/// And when it is below this part of the distance at which a place is lost: above, a ball is elsewhere.
const BELOW_LOST: f64 = 0.1;

/// The order of one scheme between two steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// Which scheme.
    pub scheme: Scheme,
    /// The two steps, the longer one first, s.
    pub steps_s: [f64; 2],
    /// Their errors, m.
    pub errors_m: [f64; 2],
    /// ln(error ratio) / ln(step ratio).
    pub order: f64,
}

/// What the books say.
pub const fn of_the_books(scheme: Scheme) -> u32 {
    match scheme {
        Scheme::Rk4 => 4,
        Scheme::Tsit5 => 5,
        Scheme::Dop853 => 8,
    }
}

/// Orders between all neighbouring steps whose errors say something.
pub fn observed(work: &WorkPrecision, truth: &Reference) -> Vec<Order> {
    let speaks =
        |run: &Run| run.error_m > ABOVE_FLOOR * truth.error() && run.error_m < BELOW_LOST * truth.lost_m;
    let between = |pair: &[Run]| {
        let Family::Fixed(scheme) = Family::of(pair[0].setting) else { return None };
        let same = Family::of(pair[1].setting) == Family::Fixed(scheme);
        let steps_s = [number(pair[0].setting), number(pair[1].setting)];
        let errors_m = [pair[0].error_m, pair[1].error_m];
        let order = (errors_m[0] / errors_m[1]).ln() / (steps_s[0] / steps_s[1]).ln();
        (same && pair.iter().all(speaks)).then_some(Order { scheme, steps_s, errors_m, order })
    };
    work.runs.windows(2).filter_map(between).collect()
}

/// The part of the page: a row a scheme, the finest steps that say something.
pub fn show(orders: &[Order]) -> Markup {
    let row = |scheme: Scheme| {
        let finest = orders.iter().rfind(|order| order.scheme == scheme);
        let name = Family::Fixed(scheme).name().to_owned();
        let books = of_the_books(scheme).to_string();
        match finest {
            Some(order) => {
                let step = |h| words(ballroom_physics::Accuracy::Fixed(scheme, h));
                let step =
                    |h| step(h).split_once("step ").map_or_else(String::new, |(_, step)| step.to_owned());
                let all = orders.iter().filter(|order| order.scheme == scheme);
                let all = all.map(|order| format!("{:.1}", order.order)).collect::<Vec<_>>().join(", ");
                let [from, to] = order.steps_s.map(step);
                let [before, after] = order.errors_m.map(rough);
                vec![
                    name,
                    books,
                    format!("{:.2}", order.order),
                    format!("from {from} to {to}"),
                    format!("from {before} to {after}"),
                    all,
                ]
            }
            None => {
                vec![name, books, "–".into(), "too few errors above rounding".into(), "–".into(), "–".into()]
            }
        }
    };
    let rows = [Scheme::Rk4, Scheme::Tsit5, Scheme::Dop853].map(row);
    html! {
        p {
            "The order between two steps is ln(error ratio) / ln(step ratio), with errors as above; only errors 30 times above the "
            "reference’s own and well below a lost place count. The third column is that of the two finest such steps."
        }
        (table(&["scheme", "order in the books", "observed", "steps", "errors, m", "all, coarse to fine"], &rows))
    }
}

/// All of them as rows.
pub fn rows(subject: &Subject, orders: &[Order]) -> Table {
    let mut table = Table::new(
        "orders",
        &["scene", "scheme", "step_s", "finer_step_s", "error_m", "finer_error_m", "order"],
    );
    for order in orders {
        let [coarse, fine] = order.steps_s.map(numbers::csv);
        let [before, after] = order.errors_m.map(numbers::csv);
        let scheme = Family::Fixed(order.scheme).name().to_owned();
        table.push([subject.name.clone(), scheme, coarse, fine, before, after, numbers::csv(order.order)]);
    }
    table
}

/// All of them for programs.
pub fn json(orders: &[Order]) -> Value {
    let one = |order: &Order| {
        json!({
            "scheme": Family::Fixed(order.scheme).name(),
            "steps_s": order.steps_s,
            "errors_m": order.errors_m,
            "order": order.order,
        })
    };
    orders.iter().map(one).collect()
}
