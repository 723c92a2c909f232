//! The engine's moving parts as plain words.
//!
//! Every type that changes while a run goes on lists all its fields once, in two groups: the seeds, from which the future
//! follows, and what follows from them and from the scene. A checkpoint keeps the seeds, and the state hash reads them. A
//! field in neither group does not compile.

use super::{Ball, Drive};
use crate::diagnostics::{Collisions, Report};
use crate::motion::arc::{Arc, Path};
use crate::motion::body::{Body, Stepping};
use crate::motion::rotation::Turning;
use crate::schedule::event::{Next, What};
use crate::schedule::time::Time;
use nalgebra::{Vector2, Vector3};

/// Words being read. Behind the last come zeros.
pub(super) struct Reader<'a> {
    words: std::slice::Iter<'a, u64>,
    failed: bool,
}

impl<'a> Reader<'a> {
    pub(super) fn new(words: &'a [u64]) -> Self {
        Self { words: words.iter(), failed: false }
    }

    fn word(&mut self) -> u64 {
        let word = self.words.next().copied();
        self.failed |= word.is_none();
        word.unwrap_or(0)
    }

    /// `value`, or the read has failed and `instead` stands in.
    fn check<T>(&mut self, value: Option<T>, instead: T) -> T {
        self.failed |= value.is_none();
        value.unwrap_or(instead)
    }

    /// Whether a word was missing or meant nothing.
    pub(super) const fn failed(&self) -> bool {
        self.failed
    }
}

/// Something that is so many words, always as many.
pub(super) trait Plain: Sized {
    /// Every word.
    fn all(&self, keep: &mut impl FnMut(u64));
    /// The words that the future follows from.
    fn seeds(&self, keep: &mut impl FnMut(u64)) {
        self.all(keep);
    }
    /// Takes over the seeds; the rest stays.
    fn sow(&mut self, from: &mut Reader<'_>) {
        *self = Self::read(from);
    }
    /// The same thing again.
    fn read(from: &mut Reader<'_>) -> Self;
}

macro_rules! plain {
    ($type:ty: $($seed:ident)*; $($rest:ident)*) => {
        impl Plain for $type {
            fn all(&self, keep: &mut impl FnMut(u64)) {
                let Self { $($seed,)* $($rest,)* } = self;
                $($seed.all(keep);)*
                $($rest.all(keep);)*
            }

            fn seeds(&self, _keep: &mut impl FnMut(u64)) {
                let Self { $($seed,)* $($rest: _,)* } = self;
                $($seed.seeds(_keep);)*
            }

            fn sow(&mut self, from: &mut Reader<'_>) {
                $(self.$seed.sow(from);)*
            }

            fn read(from: &mut Reader<'_>) -> Self {
                $(let $seed = Plain::read(from);)*
                $(let $rest = Plain::read(from);)*
                Self { $($seed,)* $($rest,)* }
            }
        }
    };
}

plain!(Ball: body stepping drive hits rest_hits hits_quantum; mass inverse_mass free_omega);
plain!(Body: applied; radius inertia_factor rolls);
plain!(Stepping: try_s; steps forced);
plain!(Drive: direction acceleration speed_limit;);
plain!(
    Arc: start window_end stamp length path state turning;
    scale radius acceleration_bound endless driven slope center dense end reaction
);
plain!(Turning: start; turn pieces magnus doublings left_out);
plain!(Next: time what;);
plain!(
    Report: collisions;
    deepest_penetration rest_hits clusters fallbacks negative_reaction steering_work steps searches pairs
    hits_dropped
);
plain!(Collisions: ball_ball ball_wall;);

impl Plain for u64 {
    fn all(&self, keep: &mut impl FnMut(u64)) {
        keep(*self);
    }
    fn read(from: &mut Reader<'_>) -> Self {
        from.word()
    }
}

impl Plain for i64 {
    fn all(&self, keep: &mut impl FnMut(u64)) {
        keep(self.cast_unsigned());
    }
    fn read(from: &mut Reader<'_>) -> Self {
        from.word().cast_signed()
    }
}

impl Plain for u32 {
    fn all(&self, keep: &mut impl FnMut(u64)) {
        keep(u64::from(*self));
    }
    fn read(from: &mut Reader<'_>) -> Self {
        let word = from.word();
        from.check(word.try_into().ok(), 0)
    }
}

impl Plain for bool {
    fn all(&self, keep: &mut impl FnMut(u64)) {
        keep(u64::from(*self));
    }
    fn read(from: &mut Reader<'_>) -> Self {
        let word = from.word();
        from.check((word < 2).then_some(word == 1), false)
    }
}

impl Plain for f64 {
    fn all(&self, keep: &mut impl FnMut(u64)) {
        keep(self.to_bits());
    }
    fn read(from: &mut Reader<'_>) -> Self {
        Self::from_bits(from.word())
    }
}

impl<T: Plain, const N: usize> Plain for [T; N] {
    fn all(&self, keep: &mut impl FnMut(u64)) {
        for x in self {
            x.all(keep);
        }
    }
    fn read(from: &mut Reader<'_>) -> Self {
        std::array::from_fn(|_| T::read(from))
    }
}

impl<A: Plain, B: Plain> Plain for (A, B) {
    fn all(&self, keep: &mut impl FnMut(u64)) {
        self.0.all(keep);
        self.1.all(keep);
    }
    fn read(from: &mut Reader<'_>) -> Self {
        (A::read(from), B::read(from))
    }
}

impl Plain for Vector2<f64> {
    fn all(&self, keep: &mut impl FnMut(u64)) {
        for x in self {
            x.all(keep);
        }
    }
    fn read(from: &mut Reader<'_>) -> Self {
        <[f64; 2]>::read(from).into()
    }
}

impl Plain for Vector3<f64> {
    fn all(&self, keep: &mut impl FnMut(u64)) {
        for x in self {
            x.all(keep);
        }
    }
    fn read(from: &mut Reader<'_>) -> Self {
        <[f64; 3]>::read(from).into()
    }
}

/// As long when it is empty.
impl Plain for Option<Drive> {
    fn all(&self, keep: &mut impl FnMut(u64)) {
        self.is_some().all(keep);
        let none = Drive { direction: Vector2::zeros(), acceleration: 0.0, speed_limit: 0.0 };
        self.unwrap_or(none).all(keep);
    }
    fn read(from: &mut Reader<'_>) -> Self {
        let some = bool::read(from);
        let drive = Drive::read(from);
        some.then_some(drive)
    }
}

impl Plain for Time {
    fn all(&self, keep: &mut impl FnMut(u64)) {
        self.quantum().all(keep);
        self.offset().all(keep);
    }
    fn read(from: &mut Reader<'_>) -> Self {
        let (quantum, offset) = (i64::read(from), f64::read(from));
        from.check(Self::of_parts(quantum, offset), Self::ZERO)
    }
}

impl Plain for Path {
    fn all(&self, keep: &mut impl FnMut(u64)) {
        keep(*self as u64);
    }
    fn read(from: &mut Reader<'_>) -> Self {
        let word = from.word();
        let path = [Self::Curved, Self::Parabola, Self::Held].into_iter().find(|path| *path as u64 == word);
        from.check(path, Self::Held)
    }
}

impl Plain for What {
    fn all(&self, keep: &mut impl FnMut(u64)) {
        match *self {
            Self::Ball { other, stamp } => [0, other, stamp],
            Self::Wall { wall } => [1, wall, 0],
            Self::Renew => [2, 0, 0],
        }
        .all(keep);
    }
    fn read(from: &mut Reader<'_>) -> Self {
        match <[u32; 3]>::read(from) {
            [0, other, stamp] => Self::Ball { other, stamp },
            [1, wall, 0] => Self::Wall { wall },
            other => from.check((other == [2, 0, 0]).then_some(Self::Renew), Self::Renew),
        }
    }
}
