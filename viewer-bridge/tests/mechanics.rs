//! What the bridge derives from a state, against the engine that computed it.

use nalgebra::Vector3;
use protocol::scene::Motion;
use protocol::snapshot::Snapshot;
use server::SceneText;
use server::simulation::Simulation;
use std::sync::Arc;
use viewer_bridge::mechanics::{Energy, Mechanics};
use viewer_bridge::surface::Surface;

const RATE_HZ: u32 = 1000;

/// Every tick of a scene's first seconds.
fn run(scene: &str, seconds: usize) -> (Simulation, Vec<Snapshot>) {
    let loaded = SceneText::open(scene).unwrap().load().unwrap();
    let mut simulation = Simulation::new(Arc::new(loaded), RATE_HZ, 1).unwrap();
    let mut states = Vec::new();
    for _ in 0..=seconds * RATE_HZ as usize {
        let mut state = Snapshot::default();
        simulation.write_snapshot(&mut state);
        states.push(state);
        simulation.advance();
    }
    (simulation, states)
}

#[test]
fn the_parts_of_all_balls_add_up_to_the_engines_energy() {
    for (scene, motion) in [("original", Motion::Rolling), ("original_frictionless", Motion::Frictionless)] {
        let (simulation, states) = run(scene, 4);
        let stage = simulation.stage();
        assert_eq!(stage.scene.motion, motion);
        let mechanics = Mechanics::of(&stage.scene);
        for state in states.iter().step_by(10) {
            let all: Energy =
                (0..stage.roster.names.len()).map(|b| mechanics.energy(&stage.roster, state, b)).sum();
            let error = (all.total_j() - state.energy_j).abs();
            assert!(error < 1e-12 * state.energy_j.abs(), "{scene} tick {}: {error:e}", state.tick);
        }
    }
}

#[test]
fn the_reaction_is_what_newtons_law_needs_for_the_motion_of_the_engine() {
    for scene in ["original", "original_frictionless"] {
        let (simulation, states) = run(scene, 4);
        let stage = simulation.stage();
        let (mechanics, roster) = (Mechanics::of(&stage.scene), &stage.roster);
        let surface = Surface::of(&stage.scene.floor).unwrap();
        let gravity = Vector3::from(stage.scene.gravity_m_per_s2);
        let (mut compared, mut least, mut most) = (0, f64::INFINITY, 0.0_f64);
        // Five ticks without a hit give the acceleration to the fourth order.
        for five in states.windows(5).filter(|five| five[0].collisions == five[4].collisions) {
            for ball in 0..roster.names.len() {
                let velocity = |i: usize| Vector3::from(five[i].velocity_m_per_s[ball]);
                let step_s = 1.0 / f64::from(RATE_HZ);
                let acceleration =
                    (velocity(0) - velocity(1) * 8.0 + velocity(3) * 8.0 - velocity(4)) / (12.0 * step_s);
                let [u, v] = five[2].uv[ball];
                let pressing = surface.frame(u, v).1.dot(&(acceleration - gravity));
                let newton_n = roster.mass_kg[ball] * pressing;
                let found_n = mechanics.reaction_n(&surface.jet(u, v), roster, &five[2], ball);
                let weight_n = roster.mass_kg[ball] * gravity.norm();
                assert!(
                    (found_n - newton_n).abs() < 1e-6 * weight_n,
                    "{scene} tick {} ball {ball}: {found_n} N, by Newton {newton_n} N",
                    five[2].tick
                );
                compared += 1;
                (least, most) = (least.min(found_n / weight_n), most.max(found_n / weight_n));
            }
        }
        // The floor is felt: in the pit much more than the weight, over the rim less.
        assert!(
            compared > 5000 && least < 0.8 && most > 2.0,
            "{scene}: {compared}, {least} to {most} weights"
        );
    }
}
