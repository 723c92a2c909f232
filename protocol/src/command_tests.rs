//! What commands promise: every form read, every number checked.

use super::*;

fn steer(direction: DirectionName, mode: SteerMode) -> Command {
    Command::Steer { ball: None, direction: Direction::Named(direction), mode }
}

fn saved_state() -> SavedState {
    SavedState {
        format: crate::timeline::SAVED_STATE_FORMAT.into(),
        version: crate::timeline::SAVED_STATE_VERSION,
        scene: "bowl".into(),
        held: vec![crate::timeline::HeldForce { ball: 1, until_tick: 90 }],
        ..SavedState::default()
    }
}

#[test]
fn long_and_short_forms_mean_the_same() {
    let up = steer(DirectionName::Up, SteerMode::Impulse);
    assert_eq!(Command::from_json(r#"{"cmd":"steer","direction":"up"}"#).unwrap(), up);
    assert_eq!(Command::from_json(r#"{"key":"up"}"#).unwrap(), up);
    let held = steer(DirectionName::Left, SteerMode::Force);
    assert_eq!(Command::from_json(r#"{"cmd":"steer","direction":"left","mode":"force"}"#).unwrap(), held);
    assert_eq!(Command::from_json(r#"{"key":"left","down":true}"#).unwrap(), held);
    let free = steer(DirectionName::Stop, SteerMode::Force);
    assert_eq!(Command::from_json(r#"{"key":"left","down":false}"#).unwrap(), free);
}

#[test]
fn every_command_survives_json() {
    let all = [
        steer(DirectionName::Stop, SteerMode::Impulse),
        Command::Steer {
            ball: Some("red".into()),
            direction: Direction::Vector([0.6, -0.8]),
            mode: SteerMode::Force,
        },
        Command::Pause {},
        Command::Resume {},
        Command::Step { ticks: 5 },
        Command::RunUntil { time_s: 2.5 },
        Command::Reset { scope: Scope::All, seed: None },
        Command::Reset { scope: Scope::Time, seed: Some(7) },
        Command::Speed { factor: SpeedFactor::Times(0.5) },
        Command::Speed { factor: SpeedFactor::Named(SpeedName::Max) },
        Command::set_balls(vec![BallSetting { name: "red".into(), ..BallSetting::default() }]),
        Command::set_balls(vec![BallSetting {
            name: "red".into(),
            center_m: Some([0.1, -0.2]),
            velocity_m_per_s: Some([1.0, 2.0, 0.0]),
            spin_rad_per_s: Some(-3.0),
        }]),
        Command::SetBalls {
            balls: vec![],
            select: Some(Selection { tag: Some("x".into()), ..Selection::default() }),
            velocity_m_per_s: Some([0.0; 3]),
            spin_rad_per_s: None,
        },
        Command::Delete(Selection { names: vec!["red".into()], ..Selection::default() }),
        Command::MoveControlPoints { points: vec![PointMove { row: 0, column: 2, to_m: [0.0, 1.0, -2.5] }] },
        Command::SetParameters {
            values: [
                ("restitution".to_owned(), Value::Number(0.9)),
                ("gravity_m_per_s2".to_owned(), Value::Vector([0.0, 0.0, -1.6])),
            ]
            .into(),
        },
        Command::SetState { state: RunState::Stopped },
        Command::SetState { state: RunState::Quitting },
        Command::LoadScene { name: Some("bowl".into()), toml: None, balls: Some(40) },
        Command::LoadScene { name: None, toml: Some("version = 1".into()), balls: None },
        Command::ReloadScene {},
        Command::Rewind(Rewind::by_seconds(600.0)),
        Command::Rewind(Rewind::to_tick(0)),
        Command::Rewind(Rewind { epoch: Some(7), ..Rewind::to_tick(3) }),
        Command::SaveState { slot: "a".into() },
        Command::LoadState { slot: Some("a".into()), state: None },
        Command::LoadState { slot: None, state: Some(Box::new(saved_state())) },
    ];
    for command in all {
        let text = serde_json::to_string(&command).unwrap();
        assert_eq!(Command::from_json(&text).unwrap(), command, "{text}");
    }
    let reads = |text: &str| Command::from_json(text).unwrap();
    let spawn = r#"{"cmd":"spawn","balls":[{"name":"b1","center_m":[0,0.5],"radius_m":0.1,"mass_kg":1,"inertia":"hollow","tags":["x"]}]}"#;
    assert_eq!(reads(&serde_json::to_string(&reads(spawn)).unwrap()), reads(spawn));
    assert_eq!(
        reads(r#"{"cmd":"delete","spawned":true,"within_m":[-1,-1,1,1]}"#),
        Command::Delete(Selection {
            spawned: Some(true),
            within_m: Some([-1.0, -1.0, 1.0, 1.0]),
            ..Selection::default()
        })
    );
    assert_eq!(reads(r#"{"cmd":"step"}"#), Command::Step { ticks: 1 });
    assert_eq!(reads(r#"{"cmd":"reset"}"#), Command::Reset { scope: Scope::All, seed: None });
}

#[test]
fn nonsense_is_refused() {
    for text in [
        "",
        "up",
        "{}",
        "[]",
        "null",
        r#"{"cmd":"fly"}"#,
        r#"{"cmd":"pause","now":true}"#,
        r#"{"cmd":"pause","key":"up"}"#,
        r#"{"cmd":"pause","cmd":"resume"}"#,
        r#"{"key":"sideways"}"#,
        r#"{"key":"up","up":true}"#,
        r#"{"cmd":"step","ticks":0}"#,
        r#"{"cmd":"step","ticks":1000001}"#,
        r#"{"cmd":"step","ticks":-1}"#,
        r#"{"cmd":"step","ticks":1.5}"#,
        r#"{"cmd":"speed","factor":0}"#,
        r#"{"cmd":"speed","factor":1e999}"#,
        r#"{"cmd":"speed","factor":"NaN"}"#,
        r#"{"cmd":"speed","factor":null}"#,
        r#"{"cmd":"speed","factor":"fast"}"#,
        r#"{"cmd":"run_until"}"#,
        r#"{"cmd":"run_until","time_s":-1}"#,
        r#"{"cmd":"run_until","time_s":1e10}"#,
        r#"{"cmd":"reset","scope":"some"}"#,
        r#"{"cmd":"reset","seed":-1}"#,
        r#"{"cmd":"set_balls","balls":[]}"#,
        r#"{"cmd":"set_balls","balls":[{"name":""}]}"#,
        r#"{"cmd":"set_balls","balls":[{"name":"a","mass_kg":1}]}"#,
        r#"{"cmd":"set_balls","balls":[{"name":"a","center_m":[0,0,0]}]}"#,
        r#"{"cmd":"set_balls","balls":[{"name":"a","center_m":[0,1e7]}]}"#,
        r#"{"cmd":"set_balls","select":{"tag":"x"}}"#,
        r#"{"cmd":"set_balls","select":{},"spin_rad_per_s":0}"#,
        r#"{"cmd":"set_balls","select":{"tag":"x"},"velocity_m_per_s":[0,0,1e7]}"#,
        r#"{"cmd":"set_balls","select":{"tag":"x"},"spin_rad_per_s":0,"balls":[{"name":"a"}]}"#,
        r#"{"cmd":"set_balls","balls":[{"name":"a"}],"spin_rad_per_s":0}"#,
        r#"{"cmd":"spawn","balls":[]}"#,
        r#"{"cmd":"spawn","balls":[{"name":"a"}]}"#,
        r#"{"cmd":"spawn","balls":[{"name":"","radius_m":1,"mass_kg":1}]}"#,
        r#"{"cmd":"delete"}"#,
        r#"{"cmd":"delete","name":"a"}"#,
        r#"{"cmd":"delete","tag":"A tag"}"#,
        r#"{"cmd":"delete","within_m":[1,0,0,1]}"#,
        r#"{"cmd":"delete","names":[""]}"#,
        r#"{"cmd":"move_control_points","points":[]}"#,
        r#"{"cmd":"move_control_points","points":[{"row":-1,"column":0,"to_m":[0,0,0]}]}"#,
        r#"{"cmd":"move_control_points","points":[{"row":0,"column":0,"to_m":[0,0,1e7]}]}"#,
        r#"{"cmd":"move_control_points","points":[{"row":0,"column":0,"to_m":[0,0,1]},{"row":0,"column":0,"to_m":[0,0,1]}]}"#,
        r#"{"cmd":"set_parameters","values":{}}"#,
        r#"{"cmd":"set_parameters","values":{"restitution":null}}"#,
        r#"{"cmd":"load_scene"}"#,
        r#"{"cmd":"load_scene","name":"gas","balls":100001}"#,
        r#"{"cmd":"reload_scene","name":"bowl"}"#,
        r#"{"cmd":"set_state"}"#,
        r#"{"cmd":"set_state","state":"no_world"}"#,
        r#"{"cmd":"load_scene","name":"bowl","toml":""}"#,
        r#"{"cmd":"rewind"}"#,
        r#"{"cmd":"rewind","seconds":-1}"#,
        r#"{"cmd":"rewind","seconds":1e10}"#,
        r#"{"cmd":"rewind","seconds":1,"tick":1}"#,
        r#"{"cmd":"rewind","epoch":1}"#,
        r#"{"cmd":"rewind","tick":-1}"#,
        r#"{"cmd":"rewind","tick":1,"line":2}"#,
        r#"{"cmd":"save_state"}"#,
        r#"{"cmd":"save_state","slot":""}"#,
        r#"{"cmd":"save_state","slot":"A/b"}"#,
        r#"{"cmd":"load_state"}"#,
        r#"{"cmd":"load_state","slot":"*"}"#,
        r#"{"cmd":"load_state","state":{"format":"x"}}"#,
        r#"{"cmd":"steer","direction":[1,1]}"#,
        r#"{"cmd":"steer","direction":[1e308,1e308]}"#,
        r#"{"cmd":"steer","direction":[1]}"#,
        r#"{"cmd":"steer","direction":[1,0,0]}"#,
        r#"{"cmd":"steer","direction":"up","ball":""}"#,
        r#"{"cmd":"pause"} {"cmd":"pause"}"#,
    ] {
        assert!(Command::from_json(text).is_err(), "{text}");
    }
    let nan = Command::Steer {
        ball: None,
        direction: Direction::Vector([f64::NAN, 0.0]),
        mode: SteerMode::Impulse,
    };
    assert!(nan.check().is_err());
    assert!(Command::Speed { factor: SpeedFactor::Times(f64::NAN) }.check().is_err());
    for wrong in [
        SavedState { version: 1, ..saved_state() },
        SavedState { format: "a song".into(), ..saved_state() },
        SavedState { time_s: f64::NAN, ..saved_state() },
    ] {
        assert!(Command::LoadState { slot: None, state: Some(Box::new(wrong)) }.check().is_err());
    }
}

#[test]
fn a_refusal_says_what_would_do() {
    let says = |text: &str| Command::from_json(text).unwrap_err().to_string();
    assert!(says(r#"{"cmd":"fly"}"#).contains("`pause`"), "{}", says(r#"{"cmd":"fly"}"#));
    assert!(says(r#"{"cmd":"steer","direction":"north"}"#).contains("\"left\""));
    assert!(says(r#"{"cmd":"speed","factor":1000}"#).contains("0.01 to 100"));
}
