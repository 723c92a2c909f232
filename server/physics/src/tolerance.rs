//! Every threshold, with its unit and its reason: why not more, why not less. Nothing else in the engine
//! compares against a number of its own.

use crate::scene::Accuracy;
use crate::schedule::time::QUANTUM;

/// Time over which an error of velocity becomes one of position when errors are weighed, s. A ball on a floor
/// with curvature near 1/m swings at about 3 rad/s, which turns dv into dv/3; more overrates, less hides.
pub const ERROR_TIME: f64 = 0.35;

/// Largest number in an arc: its square and its cube are still finite, and no honest scene comes near.
pub const SANE: f64 = 1e15;

/// Longest step, s. Longer ones are refused by the error estimate on any floor worth the name.
pub const STEP_MAX: f64 = 0.5;
/// Shortest step, s: 2^-20. Below it the estimate is rounding, and halving would not end.
pub const STEP_MIN: f64 = 1.0 / 1_048_576.0;
/// First step tried, s; ten halvings lie between it and the shortest that scenes need.
pub const STEP_FIRST: f64 = 0.0625;
/// Part of the length that would use up what is allowed that is tried: more is refused more often, less takes more steps.
pub const STEP_MARGIN: f64 = 0.9;
/// Most that a step may be longer than the one before. Where a path turns back the estimate passes through zero, and twice the
/// length would be taken on trust: the worst of the references then errs by a third more. Less is slow to grow after a hard place.
pub const GROWTH_MAX: f64 = 1.25;
/// Most that a step may be shorter than the one that was refused.
pub const SHRINK_MAX: f64 = 0.25;
/// Part of the wanted error that the steps of one second may use up. Floors pay back what neighbouring paths part, a pit
/// forty times as much as a bowl: with this part, from 1e-6 to 1e-12 m on every reference, what is obtained lies between
/// 0.01 and 0.9 times what is asked for.
pub const ERROR_PER_SECOND: f64 = 0.045;

/// Error one step of `h` seconds may have when `tolerance` metres are wanted, m.
pub fn allowed_error(tolerance: f64, h: f64) -> f64 {
    ERROR_PER_SECOND * tolerance * h
}

/// Part of the wanted position error by which turns may shift a point of a ball's surface in one second: no more than
/// the tolerance in 10 s.
pub const TURN_ERROR_PER_SECOND: f64 = 0.1;
/// Least rotation worth keeping, rad: rounding. Also for schemes of fixed step, whose own order shall show.
pub const TURN_LEAST: f64 = 1e-15;

/// Rotation that the turn of an arc of `h` seconds may leave out for a ball of `radius`, rad.
pub fn turn_left_out(accuracy: Accuracy, h: f64, radius: f64) -> f64 {
    match accuracy {
        Accuracy::Tolerance(tolerance) => (TURN_ERROR_PER_SECOND * tolerance * h / radius).max(TURN_LEAST),
        Accuracy::Fixed(..) => TURN_LEAST,
    }
}

/// Angle of one piece of a turn, rad. More takes many terms, less takes many pieces; the minimum is flat.
pub const TURN_PIECE: f64 = 1.0;
/// Terms of one piece: the last of a turn of degree 7 may be 7 rad long, and (7/2)^32/32! is below 1e-17.
pub const TURN_TERMS_MAX: usize = 33;
/// Magnus steps that cost as much as one piece of a series: four are computed side by side.
pub const TURN_STEPS_PER_SERIES: u32 = 12;
/// Bound of what a Magnus step of a turn leaves out, over the size of the terms it is made of. Measured on turns of every
/// size by the test `magnus_steps_and_series_leave_out_what_they_may`: a third of it.
pub const TURN_REMAINDER: f64 = 1.0;
/// Weight of one bracket more: Bernoulli numbers over factorials fall by about 2 pi.
pub const TURN_BRACKET: f64 = 1.0 / 6.0;
/// Most pieces of one turn: a ball that spins at 2000 rad/s for a second.
pub const TURN_PIECES_MAX: f64 = 4096.0;
/// Longest parabola of a rolling ball under force, s: its orientation is followed from the start.
pub const TURN_MAX: f64 = 64.0 * QUANTUM;

/// Centre travel in one detection window, in radii. More makes windows rarer and neighbours more; 2 is near
/// the minimum for a gas that covers a fifth of the floor, and the minimum is flat.
pub const WINDOW_TRAVEL: f64 = 2.0;
/// The same over the floor's longer side, where that is more: a grain of dust would open a window every micrometre.
/// More lets a crowd on a vast floor look at many neighbours, less makes dust slow.
pub const WINDOW_FLOOR_SHARE: f64 = 1.0 / 65_536.0;
/// Significant bits of a window's length: eight lengths an octave come within a sixteenth of the travel, and are exact
/// fractions of a second.
pub const WINDOW_BITS: u32 = 4;
/// Longest window, s.
pub const WINDOW_MAX: f64 = 1.0;
/// Shortest window, s: 2^-40.
pub const WINDOW_MIN: f64 = 1.0 / 1_099_511_627_776.0;

/// Normal speed below which a hit is taken without rebound, m/s. It costs less than 1e-12 J/kg a hit; a larger
/// one is felt in grazing hits, a smaller one lets bouncing balls hit without end.
pub const REST_SPEED: f64 = 1e-6;
/// Slow hits of one ball within a quantum before something must give: it is held until the quantum ends, or
/// hops. Honest sequences of slow hits are shorter; a pile makes any number.
pub const REST_HITS_MAX: u32 = 16;
/// Speed up to which a ball in a pile is held, m/s: what it loses then is about 1e-3 J/kg. A faster one keeps
/// its motion and hops.
pub const HOLD_SPEED: f64 = 5e-2;
/// Speed at which a hop parts two bodies pressed together, m/s: 50 hits a second under 1 m/s^2, at most
/// 5e-5 J/kg. A tenth of it costs ten times the hits.
pub const HOP_SPEED: f64 = 1e-2;
/// Closing speed of a contact that is rounding, relative to the speeds it is the difference of.
pub const CLOSING_NOISE: f64 = 4e-15;
/// The same for bodies that have just come to rest beside faster ones, m/s: an impact of a metre a second
/// leaves as much. Overlap grows by it no faster than 4e-11 m an hour.
pub const CLOSING_NOISE_SPEED: f64 = 1e-14;

/// Finest and coarsest cell of the search for neighbours, over the reach of a ball's bounds: with finer ones a search
/// visits more than some twenty cells, with coarser ones it meets balls that are far.
pub const GRID_CELL_RADII: [f64; 2] = [0.75, 2.5];
/// Most cells a ball, rounded up to a power of two. Fewer let cells far apart share a list, more cost memory.
pub const GRID_CELLS_PER_BALL: usize = 2;

/// Gap below which balls count as touching when one of them is hit, in ulps of the largest coordinate there and, on a plane,
/// where its arc begins.
pub const TOUCH_ULPS: f64 = 4.0;
/// The same on a curved floor, m per metre of coordinate: what integration leaves of an exact symmetry. A
/// larger one would merge hits that are truly apart.
pub const TOUCH_CURVED: f64 = 1e-13;
/// Overlap that a scene may start with, in ulps.
pub const OVERLAP_ULPS: f64 = 4.0;

/// What the search ahead leaves between a hit and the times at which another ball might touch as well, s: hits are moved by
/// less when they are landed on, and a smaller one would leave less than [`POLISH`] between balls.
pub const ALONE_MARGIN: f64 = 1.0 / 1_048_576.0;
/// Closing speed from which balls are surely apart a margin before they hit, m/s. Slower ones are looked at again.
pub const ALONE_CLOSING: f64 = 1.0 / 64.0;

/// Correction of a hit's place below which it is applied to first order, m.
pub const POLISH: f64 = 1e-9;
/// Farthest a hit may be moved, s; what asks for more is a graze that two readings of the path see differently.
pub const POLISH_SPAN: f64 = QUANTUM;
/// Corrections by integrating afresh before the rest is applied to first order.
pub const POLISH_ROUNDS: u32 = 4;

/// Contacts solved as one impact; more are solved one after the other in order of their ids.
pub const CLUSTER_MAX: usize = 128;
/// Contacts solved as one slow impact: enough for a row of balls that settle together, few enough for a pile.
pub const SLOW_CLUSTER_MAX: usize = 16;
/// Reflections of a cluster before it is projected instead: a chain of n balls needs at most n^2/4.
pub const REFLECTIONS_MAX: usize = 4096;
/// Reflections beyond two for each contact without a fall of the fastest closing speed before a cluster counts as
/// stuck. An impulse that travels along a chain keeps its speed for as many reflections as there are contacts.
pub const REFLECTIONS_STUCK: usize = 64;
/// Closing speed below which a contact of a cluster counts as satisfied, relative to the fastest ball.
pub const CLUSTER_SATISFIED: f64 = 1e-14;

/// Sure advances towards a hit before it is isolated instead: five reach the last bit unless the balls graze.
pub const ADVANCES_MAX: u32 = 8;
/// Hits of one elastic impact resolved in turn before it counts as depending on their order: a row of 64 equal balls
/// that all reverse needs 2016.
pub const IN_TURN_HITS_MAX: usize = 2048;
/// Difference of two outcomes that is rounding, relative to the fastest ball. Orders that matter differ by parts of 1.
pub const SAME_OUTCOME: f64 = 1e-12;

/// Halvings of an interval before a root is taken as a touch without crossing.
pub const ROOT_DEPTH_MAX: u32 = 48;
/// Intervals looked at for one root. A graze to the last bit needs some hundred; noise would need any number.
pub const ROOT_INTERVALS_MAX: u32 = 1024;
/// Newton and bisection steps of one root.
pub const ROOT_STEPS_MAX: u32 = 80;

/// Largest certified curvature times radius that a floor may have: the equations divide by 1 minus it.
pub const CURVATURE_MAX: f64 = 0.999;

/// Relative width at which a certified bracket is tight enough. Less costs boxes, more refuses balls that fit.
pub const BRACKET_WIDTH: f64 = 2e-4;
/// Curvature times the floor's size below which a floor counts as flat: a bracket around 0 has no relative width, and a
/// ball ten thousand times the floor's size lies on none. A hundredth of it costs a plane in a curved chart a hundred
/// times the boxes.
pub const BRACKET_FLAT: f64 = 1e-4;
/// Boxes looked at in one certified search, some half a second at degree 10 x 10; usual floors need hundreds. A search
/// that runs out returns the wider bracket it has.
pub const BRACKET_BOXES_MAX: usize = 60_000;
/// Relative width at which the bracket of the reach is tight enough; a pair of places costs more than one place.
pub const REACH_WIDTH: f64 = 1e-3;
/// Pairs of boxes looked at for the reach, a second or so: a ball of 0.95 of the radius of curvature in a bent chart needs
/// some 300 000 of them, usual floors need hundreds.
pub const REACH_PAIRS_MAX: usize = 500_000;

/// Width of the halo around a shard's strip, in reaches of the largest ball's bounds: radius and travel, three radii. Less
/// lets phases fail whose balls come from afar or whose cut is old, more has shards run more copies.
pub const HALO: f64 = 6.0;
/// Most phases run in one piece after one that was undone: a scene that never divides then loses little.
pub const PHASES_APART_MAX: u32 = 64;

/// Hits kept for the caller of an advance.
pub const HITS_KEPT: usize = 65_536;

const _: () = assert!(STEP_MIN < STEP_FIRST && STEP_FIRST <= STEP_MAX);
/// A step that is refused grows shorter even by the least part, and one that may grow does.
const _: () = assert!(STEP_MARGIN < 1.0 && SHRINK_MAX < STEP_MARGIN && GROWTH_MAX >= 17.0 / 16.0);
const _: () = assert!(WINDOW_MIN < WINDOW_MAX);
const _: () = assert!(TOUCH_CURVED < POLISH);
/// A hit may be moved by half the margin, and what is left is more than anything that counts as touching.
const _: () = assert!(0.5 * ALONE_MARGIN * ALONE_CLOSING > 4.0 * POLISH);
const _: () = assert!(REST_SPEED < HOP_SPEED && HOP_SPEED < HOLD_SPEED);
