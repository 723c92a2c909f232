//! A fuzz target for every decoder of this crate. `cargo test` runs each for a bounded number of inputs and prints the
//! seed of one that fails; `cargo bolero test -p protocol --test fuzz TARGET` runs one for as long as wanted, led by coverage.

mod damage;

use damage::damaged;
use protocol::arenas::{ArenaCommand, Arenas};
use protocol::check::Check;
use protocol::codec::{self, CodecError};
use protocol::command::Reply;
use protocol::event::{Event, Events, Other};
use protocol::info::Info;
use protocol::keys::{Keys, Name};
use protocol::listing::{Balls, Features, Scenes, Selection};
use protocol::player::{Ack, Claim, Claimed, Drive, Players, Release};
use protocol::report::{Report, Stamp};
use protocol::scene::Scene;
use protocol::scene_text;
use protocol::snapshot::{Roster, Snapshot, World};
use protocol::state::State;
use protocol::stats::Stats;
use protocol::timeline::{HeldForce, SAVED_STATE_FORMAT, SAVED_STATE_VERSION, SavedState, Timeline};

/// Inputs a target in `cargo test`.
const ITERATIONS: usize = 20_000;
/// Longest input, bytes.
const MAX_LEN: usize = 256;

const SCENE: &str = r#"version = 1
name = "fuzz"
restitution = 0.9
[floor.polynomial]
x_m = [-1.0, 1.0]
y_m = [-1.0, 1.0]
terms = [{ px = 2, c = 0.1 }, { py = 2, c = 0.2 }]
[[walls.plane]]
point_m = [0.9, 0.0]
normal = [-1.0, 0.0]
[[ball]]
name = "a"
radius_m = 0.1
mass_kg = 1.0
center_m = [0.0, 0.5]
player = true
[[cloud]]
name = "c"
count = 3
radius_m = [0.05, 0.06]
density_kg_per_m3 = 1.0
within_m = 0.5
"#;

fn snapshot() -> Snapshot {
    Snapshot {
        tick: 7,
        time_s: 0.125,
        uv: vec![[0.25, 0.5]; 3],
        center_m: vec![[0.5, -1.0, 2.0]; 3],
        velocity_m_per_s: vec![[1.0, 0.0, -0.5]; 3],
        omega_rad_per_s: vec![[0.0, 3.0, 0.5]; 3],
        orientation_xyzw: vec![[0.0, 0.0, 0.0, 1.0]; 3],
        ..Snapshot::default()
    }
}

fn world() -> World {
    World {
        scene: scene_text::parse("fuzz.toml", SCENE).unwrap(),
        roster: Roster {
            names: ["a", "b", "c"].map(Into::into).into(),
            radius_m: vec![0.1; 3],
            mass_kg: vec![1.0; 3],
            inertia_factor: vec![0.4; 3],
            color_rgb: vec![[1, 2, 3]; 3],
            player: vec![true, false, false],
            tags: [("red".to_owned(), vec![0, 2])].into(),
            spawned: vec![1],
        },
        tick_rate_hz: 60,
        snapshot: snapshot(),
    }
}

/// Looks at everything valid, and at inputs made from it. A macro, since a target is found by the function it stands in.
macro_rules! fuzz {
    ($valid:expr, $look:expr) => {{
        let (valid, look): (Vec<Vec<u8>>, fn(&[u8])) = ($valid.into(), $look);
        for whole in &valid {
            look(whole);
        }
        bolero::check!()
            .with_iterations(ITERATIONS)
            .with_max_len(MAX_LEN)
            .for_each(move |input: &[u8]| look(&damaged(input, &valid)));
    }};
}

/// What was read is written and read again as the same bytes.
fn settles<T>(bytes: &[u8], decode: impl Fn(&[u8]) -> Result<T, CodecError>, encode: impl Fn(&T) -> Vec<u8>) {
    if let Ok(value) = decode(bytes) {
        let written = encode(&value);
        let again = decode(&written).expect("what is written can be read");
        assert_eq!(encode(&again), written);
    }
}

macro_rules! fuzz_json {
    ($kind:ty, $valid:expr) => {
        fuzz!([codec::encode_json::<$kind>($valid)], |bytes| settles::<$kind>(
            bytes,
            codec::decode_json,
            codec::encode_json
        ))
    };
}

fn encode_state(state: &Snapshot) -> Vec<u8> {
    let mut out = Vec::new();
    codec::encode_state(state, &mut out);
    out
}

#[test]
fn a_state_frame() {
    fuzz!([encode_state(&snapshot()), encode_state(&Snapshot::default())], |bytes| {
        settles(bytes, codec::decode_state, encode_state);
    });
}

#[test]
fn a_world_frame() {
    fuzz!([codec::encode_world(&world())], |bytes| {
        settles(bytes, codec::decode_world, codec::encode_world);
    });
}

#[test]
fn a_world_in_json() {
    fuzz_json!(World, &world());
}

#[test]
fn a_command() {
    let valid = [
        r#"{"key":"up","down":true}"#,
        r#"{"cmd":"steer","direction":[0.6,-0.8],"mode":"force","ball":"red"}"#,
        r#"{"cmd":"step","ticks":60}"#,
        r#"{"cmd":"run_until","time_s":2.5}"#,
        r#"{"cmd":"speed","factor":"max"}"#,
        r#"{"cmd":"reset","scope":"state","seed":7}"#,
        r#"{"cmd":"set_balls","balls":[{"name":"red","center_m":[0.5,-0.2],"velocity_m_per_s":[1,0,0],"spin_rad_per_s":0}]}"#,
        r#"{"cmd":"load_scene","toml":"version = 1"}"#,
    ];
    fuzz!(valid.map(|text| text.as_bytes().to_vec()), |bytes| {
        settles(bytes, codec::decode_command, codec::encode_json);
    });
}

#[test]
fn what_a_player_says() {
    let valid = [
        r#"{"token":"00112233445566778899aabbccddeeff","number":7,"acked":2,"latency_ms":12.5,"sent":[{"seq":3,"tick":9,"epoch":1,"direction":[0.6,-0.8],"mode":"force"},{"seq":4,"direction":"up"}]}"#,
        r#"{"player":"ann","ball":"red"}"#,
        r#"{"player":"ann","token":"00112233445566778899aabbccddeeff"}"#,
    ];
    fuzz!(valid.map(|text| text.as_bytes().to_vec()), |bytes| {
        settles(bytes, |bytes| Ok(Drive::from_json(bytes)?), codec::encode_json);
        settles(bytes, |bytes| Ok(Claim::from_json(bytes)?), codec::encode_json);
        settles(bytes, |bytes| Ok(Release::from_json(bytes)?), codec::encode_json);
    });
}

#[test]
fn an_acknowledgement() {
    let text = r#"{"claim":1,"heard":7,"next_seq":5,"acted":[{"seq":3,"tick":9,"epoch":1,"code":1}],"ended":"left"}"#;
    fuzz_json!(Ack, &codec::decode_json::<Ack>(text.as_bytes()).unwrap());
}

#[test]
fn the_answer_to_a_claim() {
    let text = r#"{"ok":true,"code":1,"tick":5,"epoch":6,"player":"ann","ball":"red","claim":3,"token":"00112233445566778899aabbccddeeff","lease_s":2.0}"#;
    fuzz_json!(Claimed, &codec::decode_json::<Claimed>(text.as_bytes()).unwrap());
}

#[test]
fn a_list_of_players() {
    let text = r#"{"players":[{"player":"ann","ball":"red","claim":1,"hits":{"ball_ball":3,"ball_wall":12},"rank":1,"commands":5,"refused":0,"waiting":0,"messages":118,"lost":2,"repeated":1,"latency_ms":null,"silent_s":0.1}]}"#;
    fuzz_json!(Players, &codec::decode_json::<Players>(text.as_bytes()).unwrap());
}

#[test]
fn events() {
    let event = |other| Event {
        epoch: 1,
        sequence: 2,
        time_s: 0.5,
        ball: "a".into(),
        other,
        point_m: [0.0, 1.0, 2.0],
        impulse_n_s: 0.25,
    };
    let events = Events { events: vec![event(Other::Ball("b".into())), event(Other::Wall(3))], dropped: 0 };
    fuzz!([codec::encode_json(&events)], |bytes| settles(bytes, codec::decode_events, codec::encode_json));
}

#[test]
fn a_reply() {
    fuzz_json!(Reply, &Reply::of(Ok(()), 5, 6));
}

#[test]
fn statistics() {
    fuzz_json!(Stats, &Stats::default());
}

#[test]
fn info() {
    fuzz_json!(Info, &Info::new("main", 60));
}

#[test]
fn a_list_of_features() {
    let limits = |name: &str| [(name.to_owned(), [("max_bytes".to_owned(), 512.0)].into())].into();
    let ros = [("SPAWNING".to_owned(), 0)].into();
    fuzz_json!(Features, &Features { commands: limits("steer"), questions: limits("balls"), ros });
}

#[test]
fn a_list_of_scenes() {
    let text = r#"{"scenes":[{"name":"bowl","description":"solid beside hollow"}]}"#;
    fuzz_json!(Scenes, &codec::decode_json::<Scenes>(text.as_bytes()).unwrap());
}

#[test]
fn a_list_of_balls() {
    fuzz_json!(Balls, &Selection::default().of(&world()));
}

#[test]
fn a_command_to_the_process() {
    let valid = [
        r#"{"cmd":"start","arena":"left","scene":"gas","balls":40,"tick_rate_hz":120,"paused":true,"record":true}"#,
        r#"{"cmd":"start","arena":"right","toml":"version = 1"}"#,
        r#"{"cmd":"stop","arena":"left"}"#,
    ];
    fuzz!(valid.map(|text| text.as_bytes().to_vec()), |bytes| {
        settles(bytes, ArenaCommand::from_json, codec::encode_json);
    });
}

#[test]
fn a_list_of_arenas() {
    let row = r#"{"name":"main","scene":"bowl","state":"playing","tick_rate_hz":60,"record":null}"#;
    let text = format!(r#"{{"arenas":[{row}],"max_arenas":32}}"#);
    fuzz!([text.into_bytes()], |bytes| settles::<Arenas>(bytes, codec::decode_json, codec::encode_json));
}

#[test]
fn what_a_reader_reports() {
    let report =
        Report { age_ms: Some([0.5, 2.0]), jitter_ms: Some(0.1), lost: Some(3), ..Report::default() };
    fuzz_json!(Report, &report);
}

#[test]
fn what_stands_beside_a_message() {
    fuzz!([Stamp { sequence: 7, wall_ns: 8 }.to_bytes().to_vec()], |bytes| {
        if let Some(stamp) = Stamp::from_bytes(bytes) {
            assert_eq!(stamp.to_bytes()[..], *bytes);
        }
    });
}

#[test]
fn what_a_check_found() {
    let fault = r#"{"ok":false,"fault":{"line":3,"column":1,"field":"floor","message":"m","text":"t"}}"#;
    fuzz!([fault.as_bytes().to_vec()], |bytes| {
        settles::<Check>(bytes, codec::decode_json, codec::encode_json);
    });
}

#[test]
fn the_state_of_the_clock() {
    let text = r#"{"state":"paused","number":2,"epoch":1,"tick":2,"time_s":0.5}"#;
    fuzz!([text.as_bytes().to_vec()], |bytes| {
        settles::<State>(bytes, codec::decode_json, codec::encode_json);
    });
}

#[test]
fn how_far_back_one_can_go() {
    fuzz_json!(Timeline, &Timeline::default());
}

#[test]
fn a_saved_state() {
    let saved = SavedState {
        format: SAVED_STATE_FORMAT.into(),
        version: SAVED_STATE_VERSION,
        held: vec![HeldForce { ball: 1, until_tick: 2 }],
        words: "AAAA".into(),
        ..SavedState::default()
    };
    fuzz!([codec::encode_json(&saved)], |bytes| {
        settles(bytes, codec::decode_saved_state, codec::encode_json);
    });
}

#[test]
fn a_scene_in_json() {
    fuzz_json!(Scene, &world().scene);
}

#[test]
fn a_scene_file() {
    fuzz!([SCENE.as_bytes().to_vec()], |bytes| {
        if let Ok(text) = std::str::from_utf8(bytes) {
            drop(scene_text::parse("fuzz.toml", text));
        }
    });
}

#[test]
fn the_words_behind_a_question() {
    let valid = ["name=red;player=true;within=-1,-1,1,1", "name=a&name=b&player=false"];
    fuzz!(valid.map(|words| words.as_bytes().to_vec()), |bytes| {
        let words = String::from_utf8_lossy(bytes);
        if let Ok(selection) = Selection::parse(&words) {
            let again = Selection::parse(&selection.words()).expect("what is written can be read");
            assert_eq!(again.words(), selection.words());
            drop(selection.of(&world()));
        }
    });
}

#[test]
fn the_key_of_a_command() {
    fuzz!([b"ballroom/v1/main/cmd/player-1".to_vec()], |bytes| {
        let key = String::from_utf8_lossy(bytes);
        let keys = Keys::new(&"main".parse().unwrap());
        if let Some(player) = keys.player_of(&key) {
            assert_eq!(keys.cmd(&player), key);
        }
        if let Ok(name) = key.parse::<Name>() {
            assert_eq!(name.as_str(), key);
        }
    });
}
