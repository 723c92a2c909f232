//! Numbers of a scene that may be read, and which of them may be set while it runs.

use protocol::command::{Refusal, code};
use protocol::parameter::{Parameter, Value};
use protocol::scene::{Accuracy, Integrator, Motion, Scene};

/// One of them.
struct Row {
    name: &'static str,
    unit: &'static str,
    range: Option<[f64; 2]>,
    meaning: &'static str,
    /// What it is; none if the scene has no such thing.
    get: fn(&Scene) -> Option<Value>,
    set: Set,
}

/// How it is set.
enum Set {
    /// As a number in its range.
    Number(fn(&mut Scene, f64)),
    /// As three numbers, each in its range.
    Vector(fn(&mut Scene, [f64; 3])),
    /// Not while the scene runs, because of this.
    Never(&'static str),
}

const TABLE: [Row; 10] = [
    Row {
        name: "restitution",
        unit: "",
        range: Some([0.0, 1.0]),
        meaning: "coefficient of restitution of every hit",
        get: |scene| Some(Value::Number(scene.restitution)),
        set: Set::Number(|scene, e| scene.restitution = e),
    },
    Row {
        name: "gravity_m_per_s2",
        unit: "m/s^2",
        range: Some([-1e4, 1e4]),
        meaning: "gravity; its z points down; potential energy gained by a change counts as steering work",
        get: |scene| Some(Value::Vector(scene.gravity_m_per_s2)),
        set: Set::Vector(|scene, gravity| scene.gravity_m_per_s2 = gravity),
    },
    Row {
        name: "hit_budget",
        unit: "hits",
        range: Some([1.0, u32::MAX as f64]),
        meaning: "hits one ball may have within 1/64 s before it is held until they are over",
        get: |scene| Some(Value::Number(f64::from(scene.hit_budget))),
        set: Set::Number(|scene, hits| scene.hit_budget = hits as u32),
    },
    Row {
        name: "accuracy.tolerance_m",
        unit: "m",
        range: Some([1e-13, 1e-2]),
        meaning: "largest position error wanted over 10 s of smooth motion",
        get: |scene| match scene.accuracy {
            Accuracy::Tolerance { tolerance_m } => Some(Value::Number(tolerance_m)),
            Accuracy::Error { .. } | Accuracy::Budget { .. } | Accuracy::Fixed { .. } => None,
        },
        set: Set::Number(|scene, tolerance_m| scene.accuracy = Accuracy::Tolerance { tolerance_m }),
    },
    Row {
        name: "accuracy.integrator",
        unit: "",
        range: None,
        meaning: "scheme of a scene that names one",
        get: |scene| match scene.accuracy {
            Accuracy::Tolerance { .. } | Accuracy::Error { .. } | Accuracy::Budget { .. } => None,
            Accuracy::Fixed { integrator, .. } => Some(word(match integrator {
                Integrator::Rk4 => "rk4",
                Integrator::Tsit5 => "tsit5",
                Integrator::Dop853 => "dop853",
            })),
        },
        set: Set::Never("it is chosen by the scene: load another one"),
    },
    Row {
        name: "accuracy.step_s",
        unit: "s",
        range: None,
        meaning: "step of a scene that names its scheme",
        get: |scene| match scene.accuracy {
            Accuracy::Tolerance { .. } | Accuracy::Error { .. } | Accuracy::Budget { .. } => None,
            Accuracy::Fixed { step_s, .. } => Some(Value::Number(step_s)),
        },
        set: Set::Never("it is chosen by the scene: load another one"),
    },
    Row {
        name: "motion",
        unit: "",
        range: None,
        meaning: "how balls move on the floor: rolling or frictionless",
        get: |scene| {
            Some(word(match scene.motion {
                Motion::Rolling => "rolling",
                Motion::Frictionless => "frictionless",
            }))
        },
        set: Set::Never("balls that roll have spins that sliding ones have not: load another scene"),
    },
    Row {
        name: "steering.impulse_m_per_s",
        unit: "m/s",
        range: Some([0.0, 1e4]),
        meaning: "speed that one press adds",
        get: |scene| Some(Value::Number(scene.steering.impulse_m_per_s)),
        set: Set::Number(|scene, speed| scene.steering.impulse_m_per_s = speed),
    },
    Row {
        name: "steering.acceleration_m_per_s2",
        unit: "m/s^2",
        range: Some([0.0, 1e4]),
        meaning: "acceleration of a held force; one that is held keeps its own until it is renewed",
        get: |scene| Some(Value::Number(scene.steering.acceleration_m_per_s2)),
        set: Set::Number(|scene, acceleration| scene.steering.acceleration_m_per_s2 = acceleration),
    },
    Row {
        name: "steering.speed_limit_m_per_s",
        unit: "m/s",
        range: Some([0.0, 1e4]),
        meaning: "speed above which steering raises none; a held force keeps its own until it is renewed",
        get: |scene| Some(Value::Number(scene.steering.speed_limit_m_per_s)),
        set: Set::Number(|scene, speed| scene.steering.speed_limit_m_per_s = speed),
    },
];

fn word(word: &str) -> Value {
    Value::Word(word.to_owned())
}

/// All that a scene has, and the tick rate of the arena.
pub fn list(scene: &Scene, tick_rate_hz: u32) -> Vec<Parameter> {
    let rows = TABLE.iter().filter_map(|row| {
        Some(Parameter {
            name: row.name.to_owned(),
            value: (row.get)(scene)?,
            unit: row.unit.to_owned(),
            settable: !matches!(row.set, Set::Never(_)),
            range: row.range,
            meaning: row.meaning.to_owned(),
        })
    });
    let rate = Parameter {
        name: "tick_rate_hz".to_owned(),
        value: Value::Number(f64::from(tick_rate_hz)),
        unit: "Hz".to_owned(),
        settable: false,
        range: None,
        meaning: "ticks a simulated second; given when the server starts".to_owned(),
    };
    rows.chain([rate]).collect()
}

/// Sets one, or says why not.
pub fn set(scene: &mut Scene, name: &str, value: &Value) -> Result<(), Refusal> {
    let refuse = |code, why: String| Err(Refusal::new(code, format!("{name}: {why}")));
    let Some(row) = TABLE.iter().find(|row| row.name == name && (row.get)(scene).is_some()) else {
        let known = TABLE.iter().filter(|row| matches!(row.set, Set::Number(_) | Set::Vector(_)));
        let known: Vec<&str> = known.map(|row| row.name).collect();
        return refuse(
            code::NOT_FOUND,
            format!("this scene has no such parameter to be set; there may be {}", known.join(", ")),
        );
    };
    let [low, high] = row.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    // NaN is in no range.
    let is_fine = |x: &f64| (low..=high).contains(x);
    match (&row.set, value) {
        (Set::Never(why), _) => return refuse(code::FEATURE_UNSUPPORTED, (*why).to_owned()),
        (Set::Number(_), Value::Number(x)) if name == "hit_budget" && x.fract() != 0.0 => {
            return refuse(code::OPERATION_FAILED, format!("is {x}: use a whole number"));
        }
        (Set::Number(set), Value::Number(x)) if is_fine(x) => set(scene, *x),
        (Set::Vector(_), Value::Vector([.., z])) if *z >= 0.0 => {
            return refuse(code::OPERATION_FAILED, "must point down: its third number is below 0".into());
        }
        (Set::Vector(set), Value::Vector(xyz)) if xyz.iter().all(is_fine) => set(scene, *xyz),
        (Set::Number(_), _) => {
            return refuse(code::OPERATION_FAILED, format!("use a number from {low} to {high}"));
        }
        (Set::Vector(_), _) => {
            return refuse(code::OPERATION_FAILED, format!("use three numbers from {low} to {high}"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file::SceneText;

    #[test]
    fn what_is_listed_as_settable_takes_both_ends_of_its_range_and_nothing_beyond() {
        let mut scene = SceneText::built_in("original").unwrap().parse().unwrap();
        let mut settable = 0;
        for parameter in list(&scene, 60).into_iter().filter(|parameter| parameter.settable) {
            let (name, [low, high]) = (parameter.name.as_str(), parameter.range.unwrap());
            for (x, is_fine) in
                [(low, true), (high, true), (low - 1.0, false), (high + 1e9, false), (f64::NAN, false)]
            {
                // Gravity may point anywhere but up.
                let value = match parameter.value {
                    Value::Vector(_) => Value::Vector([x, x, -1.0]),
                    _ => Value::Number(x),
                };
                assert_eq!(set(&mut scene, name, &value).is_ok(), is_fine, "{name} = {x}");
                let now = list(&scene, 60).into_iter().find(|parameter| parameter.name == name).unwrap();
                assert_eq!(now.value == value, is_fine, "{name} = {x}");
            }
            assert!(set(&mut scene, name, &Value::Word("much".into())).is_err());
            settable += 1;
        }
        assert_eq!(settable, 7);
        assert!(set(&mut scene, "motion", &Value::Word("rolling".into())).is_err());
    }
}
