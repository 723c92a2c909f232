//! Rapier in both precisions.

/// In f32.
pub mod single {
    const ENGINE: &str = "Rapier f32";
    use super::super::contestant::{Entry, World};
    use super::super::knobs::Knobs;
    use super::super::problem::{Ball, Ground, Problem, Sample, Triple, Truth};
    use rapier3d::na::Unit;
    use rapier3d::prelude::*;
    include!("rapier_world.rs");

    fn real(x: f64) -> Real {
        x as Real
    }
}

/// In f64.
pub mod double {
    const ENGINE: &str = "Rapier f64";
    use super::super::contestant::{Entry, World};
    use super::super::knobs::Knobs;
    use super::super::problem::{Ball, Ground, Problem, Sample, Triple, Truth};
    use rapier3d_f64::na::Unit;
    use rapier3d_f64::prelude::*;
    include!("rapier_world.rs");

    fn real(x: f64) -> Real {
        x
    }
}
