//! Where the time goes: what a run counts, each at the cost that its work has outside the engine, beside the whole as it was
//! measured. See [`super::replay`].

use super::clock::cost;
use super::numbers::{self, plain};
use super::replay::{self, Costs, Seen};
use super::section::{Table, table};
use super::subject::{RATE_HZ, Subject, tick};
use super::{Options, ReportError};
use ballroom_physics::Report;
use maud::{Markup, html};
use serde_json::{Value, json};

/// Parts that are together more than the whole by more than this were not timed alike.
const HOLDS: f64 = 0.1;
/// Parts, and by what they are counted.
const PARTS: [(&str, &str); 5] = [
    ("arcs", "steps, or hits on a plane"),
    ("broad phase", "searches"),
    ("roots", "walls and pairs looked at"),
    ("impacts", "hits"),
    ("queue", "searches"),
];

/// What a scene's time is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Phases {
    /// Simulated seconds that were counted and timed.
    span_s: f64,
    balls: usize,
    /// CPU time of the run, s.
    whole_s: f64,
    counted: Report,
    /// CPU time of each part by its counts, s.
    parts: [f64; PARTS.len()],
    /// How often each part's work came up.
    counts: [f64; PARTS.len()],
}

/// Runs the scene, and does parts of its work again.
pub fn measure(subject: &Subject, options: &Options) -> Result<Phases, ReportError> {
    let seconds = match (subject.balls(), options.quick) {
        (0..100, true) => 5,
        (0..100, false) => 20,
        (_, true) => 1,
        (_, false) => 3,
    };
    let ticks = seconds * RATE_HZ as usize;
    let start = subject.start(subject.own())?;
    let mut counted = Report::default();
    let whole_s = cost(
        || start.clone(),
        |run| {
            (1..=ticks).for_each(|n| {
                run.advance_to(tick(n));
            });
            counted = run.report().since(&start.report());
        },
    );
    let (costs, seen) = replay::measure(subject, ticks, if options.quick { 2 } else { 4 })?;
    let (parts, counts) = parts(&counted, &costs, &seen);
    Ok(Phases {
        span_s: seconds as f64,
        balls: subject.balls(),
        whole_s: whole_s.seconds,
        counted,
        parts,
        counts,
    })
}

/// Counts times costs, and the counts.
fn parts(counted: &Report, costs: &Costs, seen: &Seen) -> ([f64; PARTS.len()], [f64; PARTS.len()]) {
    let [of_two, of_wall, searches, pairs, steps] = [
        counted.collisions.ball_ball,
        counted.collisions.ball_wall,
        counted.searches,
        counted.pairs[0],
        counted.steps,
    ]
    .map(|count| count as f64);
    let hits = of_two + of_wall;
    // Steps after hits cost what arcs after hits do; the others are computed side by side where that pays.
    let steps_an_arc = seen.steps as f64 / seen.arcs.max(1) as f64;
    let undisturbed = (steps - steps_an_arc * (2.0 * of_two + of_wall)).max(0.0);
    let parts = [
        of_two * costs.arcs_of_two + of_wall * costs.arc_of_one + undisturbed * costs.step,
        searches * costs.search,
        searches * costs.walls + pairs * costs.pair,
        of_two * costs.hit_of_two + of_wall * costs.hit_of_wall,
        searches * costs.queue,
    ];
    (parts, [if steps > 0.0 { steps } else { hits }, searches, searches + pairs, hits, searches])
}

impl Phases {
    /// Hits on balls and walls a simulated second.
    pub fn hits_per_second(&self) -> f64 {
        let hits = self.counted.collisions;
        (hits.ball_ball + hits.ball_wall) as f64 / self.span_s
    }

    fn ball_seconds(&self) -> f64 {
        self.balls as f64 * self.span_s
    }

    /// What the parts leave of the whole, s; below zero where they are more.
    fn rest(&self) -> f64 {
        self.whole_s - self.parts.iter().sum::<f64>()
    }

    /// Microseconds a ball-second.
    fn micros(&self, seconds: f64) -> f64 {
        1e6 * seconds / self.ball_seconds()
    }

    /// CPU time of one of a part, ns; nothing where there is none.
    fn nanos_each(&self, part: usize) -> f64 {
        if self.counts[part] == 0.0 { 0.0 } else { 1e9 * self.parts[part] / self.counts[part] }
    }

    /// The part of the page.
    pub fn show(&self) -> Markup {
        let share = |seconds: f64| format!("{:.0} %", 100.0 * seconds / self.whole_s).replace('-', "−");
        let mut rows: Vec<_> = PARTS
            .iter()
            .enumerate()
            .map(|(part, (name, counted_by))| {
                vec![
                    (*name).to_owned(),
                    (*counted_by).to_owned(),
                    plain(self.counts[part] / self.ball_seconds()),
                    plain(self.nanos_each(part)),
                    plain(self.micros(self.parts[part])),
                    share(self.parts[part]),
                ]
            })
            .collect();
        let rest = self.rest();
        let last = |words: &str| [words, "", "", ""].map(str::to_owned).to_vec();
        rows.push([last("what they leave"), vec![signed(self.micros(rest)), share(rest)]].concat());
        let whole = vec![plain(self.micros(self.whole_s)), share(self.whole_s)];
        rows.push([last("the run, measured"), whole].concat());
        html! {
            h3 { "Where the time goes" }
            p {
                "The engine counts and has no clock. Its run over " (plain(self.span_s)) " s was stopped at a few moments, and what it would do "
                "from there was done by its own kernels outside of it, kind by kind and all balls at once; a part is that cost times "
                "how often it came up in the run. What the parts leave is the bookkeeping of events and hits, rare cases, and that memory is colder in a run. "
                "Of the pairs looked at the engine formed a distance polynomial of " (plain(100.0 * self.formed())) " %."
            }
            (table(&["part", "counted by", "a ball-second", "ns each", "µs a ball-second", "share"], &rows))
            @if rest < -HOLDS * self.whole_s {
                p {
                    "The parts are " (share(self.whole_s - rest)) " of the whole: the machine was not equally calm while they and the "
                    "run were timed, or the moments do not stand for the run."
                }
            }
        }
    }

    fn formed(&self) -> f64 {
        let [looked_at, formed] = self.counted.pairs.map(|count| count as f64);
        if looked_at > 0.0 { formed / looked_at } else { 0.0 }
    }

    /// As rows.
    pub fn rows(&self, subject: &Subject) -> Table {
        let mut table = Table::new("phases", &["scene", "part", "count", "ns_each", "us_per_ball_second"]);
        for (part, (name, _)) in PARTS.iter().enumerate() {
            let numbers = [self.counts[part], self.nanos_each(part), self.micros(self.parts[part])];
            let [count, each, micros] = numbers.map(numbers::csv);
            table.push([subject.name.clone(), (*name).to_owned(), count, each, micros]);
        }
        let none = String::new;
        for (name, seconds) in [("rest", self.rest()), ("measured", self.whole_s)] {
            let micros = numbers::csv(self.micros(seconds));
            table.push([subject.name.clone(), name.to_owned(), none(), none(), micros]);
        }
        table
    }

    /// For programs.
    pub fn json(&self) -> Value {
        let part = |(part, (name, counted_by)): (usize, &(&str, &str))| {
            json!({
                "part": name,
                "counted_by": counted_by,
                "count": self.counts[part],
                "ns_each": self.nanos_each(part),
                "us_per_ball_second": self.micros(self.parts[part]),
            })
        };
        json!({
            "span_s": self.span_s,
            "measured_us_per_ball_second": self.micros(self.whole_s),
            "rest_us_per_ball_second": self.micros(self.rest()),
            "pairs_looked_at_and_formed": self.counted.pairs,
            "hits": self.counted.collisions.ball_ball + self.counted.collisions.ball_wall,
            "parts": PARTS.iter().enumerate().map(part).collect::<Vec<_>>(),
        })
    }
}

/// A number that may be below zero.
fn signed(x: f64) -> String {
    if x < 0.0 { format!("−{}", plain(-x)) } else { plain(x) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn phases(name: &str, ticks: usize) -> (Phases, Seen) {
        let subject = Subject::open(name).unwrap();
        let mut run = subject.start(subject.own()).unwrap();
        let before = run.report();
        run.advance_to(tick(ticks));
        let counted = run.report().since(&before);
        let (costs, seen) = replay::measure(&subject, ticks, 2).unwrap();
        let (parts, counts) = parts(&counted, &costs, &seen);
        let span_s = ticks as f64 / f64::from(RATE_HZ);
        (Phases { span_s, balls: subject.balls(), whole_s: 1.0, counted, parts, counts }, seen)
    }

    #[test]
    fn the_bench_looks_at_as_many_pairs_as_the_engine_but_for_the_partners_of_hits() {
        let (Phases { counted, .. }, seen) = phases("gas:500", 60);
        let of_engine = counted.pairs[0] as f64 / counted.searches as f64;
        // Two that have just hit each other search at once, each with the other beside it.
        let partners = 2.0 * counted.collisions.ball_ball as f64 / counted.searches as f64;
        let of_bench = partners + seen.pairs[0] as f64 / seen.searches as f64;
        assert!(
            (0.8..1.25).contains(&(of_bench / of_engine)),
            "{of_bench} pairs a search, engine {of_engine}"
        );
        let [of_engine, of_bench] =
            [counted.pairs, seen.pairs].map(|pairs| pairs[1] as f64 / pairs[0] as f64);
        assert!((0.5..2.0).contains(&(of_bench / of_engine)), "{of_bench} formed, engine {of_engine}");
    }

    #[test]
    fn parts_and_what_they_leave_are_the_whole_and_each_has_its_count() {
        let (phases, _) = phases("gas:200", 60);
        let sum = phases.parts.iter().sum::<f64>() + phases.rest();
        assert!((sum - phases.whole_s).abs() < 1e-12);
        assert!(phases.parts.iter().all(|part| *part > 0.0), "{:?}", phases.parts);
        for part in 0..PARTS.len() {
            let product = phases.counts[part] * phases.nanos_each(part) * 1e-9;
            assert!((product / phases.parts[part] - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_ball_alone_that_hits_nothing_takes_its_time_for_arcs_and_walls_only() {
        let (phases, seen) = phases("bicubic", 60);
        assert_eq!((phases.counts[3], phases.parts[3], seen.pairs), (0.0, 0.0, [0, 0]));
        assert!(phases.parts[0] > 0.0 && phases.parts[2] > 0.0);
    }
}
