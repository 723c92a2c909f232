//! A step of several balls side by side becomes an arc for each.
//!
//! Lanes hold one number of every ball, arcs all numbers of one ball. Four rows of lanes at a time are turned over in registers,
//! and every arc takes its four numbers in one piece: number by number a launch spends much of its time so.

use super::arc::{Arc, Path};
use super::law::ROLLING;
use super::rotation::Sizes;
use super::step::{Step, TERMS};
use crate::lanes::LANES_MAX;
use crate::number::{Number, Triple};
use crate::scene::Accuracy;
use crate::tolerance;
use pulp::bytemuck::cast_slice_mut;

/// Hands a step to the `arcs` of its balls, lane by lane: those that keep it, each of as many seconds as `lengths` says.
#[inline(always)]
pub(super) fn take_over<T: Number, const D: usize>(
    arcs: &mut [Option<&mut Arc>],
    lengths: &[f64],
    slope: &[T; D],
    step: &Step<T, D>,
    accuracy: Accuracy,
) {
    let mut bending = step.center[2].norm() * 2.0;
    for k in 3..TERMS {
        bending = bending + step.center[k].norm() * (k * (k - 1)) as f64;
    }
    let zero = bending.like(0.0);
    let rows = |of: &[T; D]| {
        let mut out = [zero; ROLLING];
        out[..D].copy_from_slice(of);
        out
    };
    let (slope, end) = (rows(slope), rows(&step.end));
    hand_out([slope[0], slope[1], slope[2], slope[3]], arcs, |arc, x| arc.slope[..4].copy_from_slice(x));
    hand_out([slope[4], slope[5], end[0], end[1]], arcs, |arc, x| {
        arc.slope[4..].copy_from_slice(&x[..2]);
        arc.end[..2].copy_from_slice(&x[2..]);
    });
    hand_out([end[2], end[3], end[4], end[5]], arcs, |arc, x| arc.end[2..].copy_from_slice(x));
    let mut dense = [[zero; ROLLING]; TERMS];
    for power in 0..TERMS {
        dense[power] = rows(&step.dense[power]);
    }
    hand_out_all(dense.as_flattened(), arcs, |arc| arc.dense.as_flattened_mut());
    hand_out_all(flat(&step.center).as_flattened(), arcs, |arc| cast_slice_mut(&mut arc.center));
    hand_out_all(flat(&step.turn).as_flattened(), arcs, |arc| cast_slice_mut(&mut arc.turning.turn));
    let [a, b, c] = step.reaction;
    hand_out([a, b, c, bending], arcs, |arc, x| {
        arc.reaction.copy_from_slice(&x[..3]);
        arc.acceleration_bound = x[3];
    });
    let mut sizes = [Sizes::NONE; LANES_MAX];
    if D == ROLLING {
        let Sizes { length, fastest, left_out, bend } = Sizes::of(&step.turn);
        T::turn_over([length, fastest, left_out, bend], |lane, x| {
            let [length, fastest, left_out, bend] = *x;
            sizes[lane] = Sizes { length, fastest, left_out, bend };
        });
    }
    for ((arc, h), sizes) in arcs.iter_mut().zip(lengths).zip(&sizes) {
        let Some(arc) = arc else { continue };
        let h = *h;
        arc.path = Path::Curved;
        arc.set_length(h);
        arc.scale = h;
        arc.acceleration_bound /= h * h;
        arc.turning.plan(sizes, tolerance::turn_left_out(accuracy, h, arc.radius));
    }
}

/// Rows of numbers without their names.
#[inline(always)]
fn flat<T: Number>(of: &[Triple<T>; TERMS]) -> [[T; 3]; TERMS] {
    let mut out = [of[0].0; TERMS];
    for i in 0..TERMS {
        out[i] = of[i].0;
    }
    out
}

/// Hands out rows of lanes, of which there are a multiple of four.
#[inline(always)]
fn hand_out_all<T: Number, A>(
    rows: &[T],
    targets: &mut [Option<&mut A>],
    place: impl Fn(&mut A) -> &mut [f64],
) {
    for (k, rows) in rows.chunks_exact(4).enumerate() {
        hand_out([rows[0], rows[1], rows[2], rows[3]], targets, |target, x| {
            place(target)[4 * k..4 * k + 4].copy_from_slice(x);
        });
    }
}

/// Gives every target its lane of four rows.
#[inline(always)]
fn hand_out<T: Number, A>(
    rows: [T; 4],
    targets: &mut [Option<&mut A>],
    mut put: impl FnMut(&mut A, &[f64; 4]),
) {
    T::turn_over(rows, |lane, x| {
        if let Some(Some(target)) = targets.get_mut(lane) {
            put(target, x);
        }
    });
}
