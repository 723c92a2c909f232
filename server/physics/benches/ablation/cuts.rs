//! What is cut out of the engine for a scene that does not use it.

/// A feature, the scenes that have no use for it, and how its traces are taken out of the engine.
pub struct Cut {
    /// Which.
    pub feature: &'static str,
    /// The beginnings of the names of scenes that do not use it.
    pub unused_by: &'static [&'static str],
    /// File below `src/`, words there, words in their place.
    pub edits: &'static [(&'static str, &'static str, &'static str)],
}

const FLAT: &[&str] = &[
    "scene: a ball slides on a plane",
    "scene: a ball rolls on a plane",
    "scene: gas of 100 on a plane",
    "scene: cradle",
    "hit: a wall on a plane",
    "hit: two balls and walls on a plane",
];
const QUADRIC: &[&str] = &[
    "scene: a ball slides in a bowl",
    "scene: a ball rolls in a bowl",
    "scene: gas of 100 in a bowl",
    "hit: a wall in a bowl",
    "hit: two balls and walls in a bowl",
];
const SLIDING: &[&str] = &[
    "scene: a ball slides",
    "scene: gas of 100 on a plane",
    "scene: cradle",
    "hit: a wall on a plane",
    "hit: two balls and walls on a plane",
];
const LONE: &[&str] = &["scene: a ball", "hit: a wall"];
/// Hits of two bodies only, none of them slow.
const GASES: &[&str] = &["scene: gas", "scene: cradle with gaps", "hit"];
/// Nobody holds a force.
const UNDRIVEN: &[&str] = &["scene: a ball", "scene: original", "scene: gas", "scene: cradle", "hit"];

/// A choice of the floor's kernel with one answer.
const ONLY_FLAT: &str =
    "match $kernel { $crate::surface::chart::Kernel::Flat($chart) => $body, _ => unreachable!(),";
const ONLY_QUADRIC: &str =
    "match $kernel { $crate::surface::chart::Kernel::Quadric($chart) => $body, _ => unreachable!(),";

/// All of them.
pub const CUTS: &[Cut] = &[
    Cut {
        feature: "steering",
        unused_by: UNDRIVEN,
        edits: &[
            (
                "controller/advance.rs",
                "if self.arcs[ball].driven && time.offset() == 0.0 && self.steer_anew(ball, time) {",
                "if false {",
            ),
            ("controller/advance.rs", "if self.balls[ball].drive.is_some() {", "if false {"),
            ("controller/advance.rs", "let work = self.work_of_force(ball, time);", "let work = 0.0;"),
            ("controller/advance.rs", "arc.driven = b.drive.is_some();", ""),
            ("controller/predict.rs", "if arc.driven {", "if false {"),
        ],
    },
    Cut {
        feature: "rolling and spin",
        unused_by: SLIDING,
        edits: &[
            ("motion/body.rs", "if self.rolls {", "if false {"),
            ("motion/look.rs", "if seat.body.rolls {", "if false {"),
            ("controller/observe.rs", "if b.body.rolls {", "if false {"),
            ("controller/observe.rs", "if !b.body.rolls {", "if true {"),
            (
                "motion/take_over.rs",
                "arc.turning.plan(sizes, tolerance::turn_left_out(accuracy, h, arc.radius));",
                "let _ = (sizes, accuracy, tolerance::TURN_LEAST);",
            ),
            (
                "controller/advance.rs",
                "self.arcs[ball].turning.start = foreseen.unwrap_or_else(|| self.arcs[ball].orientation_at(dt));",
                "let _ = foreseen;",
            ),
        ],
    },
    Cut {
        feature: "curved floors",
        unused_by: FLAT,
        edits: &[
            (
                "motion/body.rs",
                "self.launch_step(surface, accuracy, state, stepping, arc);",
                "unreachable!();",
            ),
            ("controller/predict.rs", "if self.surface.is_flat() {", "if true {"),
            (
                "motion/together.rs",
                "if let Kernel::Flat(chart) = &surface.kernel {",
                "let Kernel::Flat(chart) = &surface.kernel else { unreachable!() }; if true {",
            ),
            ("motion/arc.rs", "if self.path != Path::Curved {", "if true {"),
            ("motion/arc.rs", "if self.path == Path::Curved {", "if false {"),
            ("motion/arc.rs", "Path::Curved => body.land(", "Path::Curved if false => body.land("),
            ("motion/arc.rs", "Path::Parabola | Path::Held => (self", "_ => (self"),
            ("detect/ball_ball.rs", "if both_parabolas {", "if true {"),
            ("detect/ball_wall.rs", "if arc.path != Path::Curved {", "if true {"),
            ("surface/chart.rs", "match $kernel {", ONLY_FLAT),
            ("motion/body.rs", "_ => self.seat_on_any(surface, state),", "_ => unreachable!(),"),
            ("controller/observe.rs", "_ => self.shown_on_curve(b, &seat),", "_ => unreachable!(),"),
        ],
    },
    Cut {
        feature: "several balls at once and ahead of time",
        unused_by: FLAT,
        edits: &[
            ("controller/foresee.rs", "if self.work.foresight.list.is_empty() || ", "if true || "),
            ("controller/foresee.rs", "if !self.list.is_empty() {", "if false {"),
            (
                "controller/foresee.rs",
                "let Some(Foreseen { next, launched, .. }) = list.get(*present) else { return false };",
                "let Some(Foreseen { next, launched, .. }) = list.get(*present).filter(|_| false) else { return false };",
            ),
            ("controller/foresee.rs", "list.get(*present)?;", "list.get(*present).filter(|_| false)?;"),
            ("controller/prepare.rs", "} else if !self.work.ahead.is_idle() && ", "} else if false && "),
            ("controller/prepare.rs", "if self.work.ahead.is_idle() || ", "if true || "),
            ("controller/foresee.rs", "if self.work.side_by_side {", "if false {"),
            ("controller/prepare.rs", "if self.work.side_by_side {", "if false {"),
            ("controller/bounce.rs", "if !self.work.side_by_side {", "if true {"),
        ],
    },
    Cut {
        feature: "other kinds of floor",
        unused_by: QUADRIC,
        edits: &[
            (
                "motion/body.rs",
                "if let Kernel::Flat(chart) = &surface.kernel {",
                "if let Kernel::Flat(chart) = &surface.kernel && false {",
            ),
            (
                "motion/together.rs",
                "if let Kernel::Flat(chart) = &surface.kernel {",
                "if let Kernel::Flat(chart) = &surface.kernel && false {",
            ),
            (
                "controller/observe.rs",
                "Kernel::Flat(chart) => self.shown_alone(b, &seat, look::on_plane(chart, &seat)),",
                "Kernel::Flat(_) => unreachable!(),",
            ),
            ("controller/predict.rs", "if self.surface.is_flat() {", "if false {"),
            ("surface/chart.rs", "match $kernel {", ONLY_QUADRIC),
            (
                "motion/body.rs",
                "Kernel::Flat(chart) => self.seat_on(chart, state),",
                "Kernel::Flat(_) => unreachable!(),",
            ),
        ],
    },
    Cut {
        feature: "other balls",
        unused_by: LONE,
        edits: &[
            ("controller/predict.rs", "let has_others = self.balls.len() > 1;", "let has_others = false;"),
            (
                "detect/broad_phase.rs",
                "pub fn file(&mut self, ball: usize, bounds: Bounds) {",
                "pub fn file(&mut self, ball: usize, bounds: Bounds) { self.filed[ball].bounds = bounds; return;",
            ),
        ],
    },
    Cut {
        feature: "impacts of more than two bodies",
        unused_by: GASES,
        edits: &[
            ("controller/bounce.rs", " || !self.is_clear_of_others(hit) {", " {"),
            ("controller/predict.rs", "if approach.stays_clear() {", "if approach.stays_apart() {"),
            (
                "controller/predict.rs",
                "if comes_briskly(here, there, acceleration, reach, t) {",
                "if false {",
            ),
            (
                "controller/predict.rs",
                "} else if parts_briskly(here, there, acceleration, duration) {",
                "} else if false {",
            ),
        ],
    },
    Cut {
        feature: "holding balls whose hits pile up",
        unused_by: GASES,
        edits: &[
            ("controller/bounce.rs", " || self.is_piling_up(hit)", ""),
            ("controller/bounce.rs", "self.balls[landed.ball].count_hit(hit.time.quantum(), false);", ""),
        ],
    },
    Cut {
        feature: "the list of hits",
        unused_by: GASES,
        edits: &[("controller/bounce.rs", "if self.hits_are_full() {", "if true {")],
    },
    Cut {
        feature: "other integrators and fixed steps",
        unused_by: UNDRIVEN,
        edits: &[
            (
                "motion/body.rs",
                "Accuracy::Fixed(scheme, h) => {",
                "Accuracy::Fixed(scheme, h) => { if true { unreachable!() }",
            ),
            ("motion/body.rs", "Accuracy::Tolerance(_) | Accuracy::Fixed(Scheme::Dop853, _) => {", "_ => {"),
        ],
    },
    Cut {
        feature: "the warning where a floor would have to pull",
        unused_by: &["scene: gas", "scene: a ball", "scene: cradle", "hit"],
        edits: &[("controller/advance.rs", "let pulled = arc.negative_reaction(dt);", "let pulled = 0.0;")],
    },
    Cut {
        feature: "notes for shards that are undone",
        unused_by: UNDRIVEN,
        edits: &[("controller/advance.rs", "self.will_change(ball);", "")],
    },
];
