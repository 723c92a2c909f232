//! What the codec promises, over random values and random bytes.

use super::*;
use crate::snapshot::Roster;
use proptest::prelude::*;

fn number() -> impl Strategy<Value = f64> {
    proptest::num::f64::NORMAL | proptest::num::f64::ZERO | proptest::num::f64::SUBNORMAL
}

/// Numbers an f32 holds, so that a state frame gives them back unchanged.
fn single() -> impl Strategy<Value = f64> {
    (proptest::num::f32::NORMAL | proptest::num::f32::ZERO).prop_map(f64::from)
}

fn snapshot(balls: usize) -> impl Strategy<Value = Snapshot> {
    let arrays = (
        proptest::collection::vec(proptest::array::uniform2(number()), balls),
        proptest::collection::vec(proptest::array::uniform3(number()), balls),
        proptest::collection::vec(proptest::array::uniform3(single()), balls),
        proptest::collection::vec(proptest::array::uniform3(single()), balls),
        proptest::collection::vec(proptest::array::uniform4(single()), balls),
    );
    let heads = (any::<[u64; 6]>(), any::<bool>(), number(), (number(), number()));
    (heads, arrays).prop_map(
        |(
            (whole, paused, time_s, (energy_j, steering_work_j)),
            (uv, center, velocity, omega, orientation),
        )| Snapshot {
            epoch: whole[0],
            tick: whole[1],
            time_s,
            wall_ns: whole[2],
            paused,
            energy_j,
            steering_work_j,
            collisions: Collisions { ball_ball: whole[3], ball_wall: whole[4] },
            state_hash: whole[5],
            uv,
            center_m: center,
            velocity_m_per_s: velocity,
            omega_rad_per_s: omega,
            orientation_xyzw: orientation,
        },
    )
}

fn world_of(snapshot: Snapshot) -> World {
    let n = snapshot.center_m.len();
    let scene = crate::scene_text::parse(
        "test.toml",
        "version = 1\nname = \"t\"\n[floor.polynomial]\nx_m = [-1.0, 1.0]\ny_m = [-1.0, 1.0]\nterms = [{ px = 2, c = 0.1 }]\n\
         [[ball]]\nname = \"a\"\nradius_m = 0.1\nmass_kg = 1.0\ncenter_m = [0.0, 0.5]\n\
         [[cloud]]\nname = \"c\"\ncount = 3\nradius_m = [0.1, 0.2]\ndensity_kg_per_m3 = 1.0\nwithin_m = 0.5\n",
    )
    .unwrap();
    World {
        scene,
        roster: Roster {
            names: (0..n).map(|i| format!("ball-{i}")).collect(),
            radius_m: vec![0.1; n],
            mass_kg: vec![1.0; n],
            inertia_factor: vec![0.4; n],
            color_rgb: vec![[1, 2, 3]; n],
            player: vec![false; n],
            tags: [("even".to_owned(), (0..n).step_by(2).collect())].into(),
            spawned: (0..n).skip(1).collect(),
        },
        tick_rate_hz: 60,
        snapshot,
    }
}

proptest! {
    #[test]
    fn a_state_survives_the_wire(state in (0_usize..20).prop_flat_map(snapshot)) {
        let mut bytes = vec![1, 2, 3];
        encode_state(&state, &mut bytes);
        prop_assert_eq!(decode_state(&bytes).unwrap(), state);
    }

    #[test]
    fn a_world_survives_the_wire_and_json(state in (0_usize..8).prop_flat_map(snapshot)) {
        let world = world_of(state);
        prop_assert_eq!(&decode_world(&encode_world(&world)).unwrap(), &world);
        let back: World = decode_json(&encode_json(&world)).unwrap();
        prop_assert_eq!(back.snapshot.state_hash, world.snapshot.state_hash);
        prop_assert_eq!(back.scene, world.scene);
    }

    #[test]
    fn arbitrary_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..2048)) {
        let _ = decode_state(&bytes);
        let _ = decode_world(&bytes);
        let _ = decode_command(&bytes);
        let _ = decode_events(&bytes);
    }

    #[test]
    fn a_damaged_frame_never_panics(
        state in (0_usize..6).prop_flat_map(snapshot),
        damage in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut frame = Vec::new();
        encode_state(&state, &mut frame);
        let mut world = encode_world(&world_of(state));
        for (place, byte) in damage {
            let i = place.index(frame.len());
            frame[i] = byte;
            let i = place.index(world.len());
            world[i] = byte;
        }
        let _ = decode_state(&frame);
        let _ = decode_world(&world);
        let _ = decode_state(&frame[..cut.index(frame.len())]);
        let _ = decode_world(&world[..cut.index(world.len())]);
    }

    #[test]
    fn arbitrary_text_is_no_reason_to_panic(text in "[{}\\[\\]\":,a-z0-9.e+-]{0,200}") {
        let _ = decode_command(text.as_bytes());
    }
}

fn one_ball() -> Snapshot {
    Snapshot {
        uv: vec![[0.5; 2]],
        center_m: vec![[0.0; 3]],
        velocity_m_per_s: vec![[0.0; 3]],
        omega_rad_per_s: vec![[0.0; 3]],
        orientation_xyzw: vec![[0.0, 0.0, 0.0, 1.0]],
        ..Snapshot::default()
    }
}

#[test]
fn the_version_is_the_first_thing_in_a_frame() {
    let mut bytes = Vec::new();
    encode_state(&one_ball(), &mut bytes);
    // A map of 15, then the text "v", then 1.
    assert_eq!(&bytes[..4], &[0xaf, 0x61, b'v', 0x01]);
    bytes[3] = 2;
    assert_eq!(decode_state(&bytes), Err(CodecError::Version(2)));
}

#[test]
fn trailing_bytes_unequal_arrays_and_nan_are_refused() {
    let mut bytes = Vec::new();
    encode_state(&one_ball(), &mut bytes);
    bytes.push(0);
    assert!(matches!(decode_state(&bytes), Err(CodecError::Malformed(_))));

    let mut uneven = one_ball();
    uneven.uv.clear();
    encode_state(&uneven, &mut bytes);
    assert!(matches!(decode_state(&bytes), Err(CodecError::Array { field: "uv", .. })));

    let mut nan = one_ball();
    nan.omega_rad_per_s[0][1] = f64::NAN;
    encode_state(&nan, &mut bytes);
    assert_eq!(decode_state(&bytes), Err(CodecError::NotFinite("omega_rad_per_s")));

    let mut world = world_of(one_ball());
    world.scene.floor = crate::scene::Floor::Grid {
        x_m: [0.0, f64::INFINITY],
        y_m: [0.0, 1.0],
        control_heights_m: vec![vec![0.0; 2]; 2],
    };
    assert_eq!(decode_world(&encode_world(&world)), Err(CodecError::NotFinite("scene")));
}

#[test]
fn a_length_that_lies_allocates_nothing_much() {
    // A map with a byte string that claims 2^60 bytes.
    let mut bytes = vec![0xaf, 0x62, b'u', b'v', 0xd8, 86, 0x5b];
    bytes.extend(&(1_u64 << 60).to_be_bytes());
    assert!(matches!(decode_state(&bytes), Err(CodecError::Malformed(_))));
    // An array header that claims 2^60 items.
    let mut bytes = vec![0x9b];
    bytes.extend(&(1_u64 << 60).to_be_bytes());
    assert!(decode_world(&bytes).is_err());
}

#[test]
fn nesting_is_bounded() {
    let deep = vec![0x81; 100_000];
    assert!(decode_world(&deep).is_err());
    let deep = "[".repeat(100_000);
    assert!(decode_json::<World>(deep.as_bytes()).is_err());
}
