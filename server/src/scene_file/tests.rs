//! What scene files promise.

use super::*;
use ballroom_physics::Place;

const HEAD: &str = "version = 1\nname = \"t\"\n[floor.polynomial]\nx_m = [-5.0, 5.0]\ny_m = [-5.0, 5.0]\n";
const BALL: &str = "[[ball]]\nname = \"a\"\nradius_m = 0.5\nmass_kg = 1.0\ncenter_m = [0.0, 0.0]\n";

fn fault(text: String) -> String {
    SceneText::new("t.toml", text).load().unwrap_err().to_string()
}

#[test]
fn every_built_in_scene_loads_under_its_own_name() {
    for name in built_in_names() {
        let loaded = SceneText::open(name).unwrap().load().unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(loaded.scene().name, name);
        assert!(!loaded.scene().description.is_empty(), "{name} says what to look for");
        let players = loaded.cards.iter().filter(|card| card.player).count();
        assert_eq!(players, if name == "derby" { 4 } else { 1 }, "players of {name}");
    }
}

#[test]
fn every_built_in_scene_is_accepted_by_the_engine() {
    for name in built_in_names() {
        let loaded = SceneText::open(name).unwrap().load().unwrap();
        let controller = loaded.controller().unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(controller.balls().len(), loaded.physics().balls.len(), "{name}");
    }
}

#[test]
fn the_original_has_the_numbers_of_its_ancestor() {
    let loaded = SceneText::open("original").unwrap().load().unwrap();
    let physics::Floor::Bezier(patch) = &loaded.physics().floor else {
        panic!("the original floor is a net")
    };
    assert_eq!(patch.degree(), [10, 10]);
    for i in 0..11 {
        for j in 0..11 {
            let z = if [i, j] == [3, 5] {
                -70.0
            } else if [i, j] == [7, 5] {
                40.0
            } else {
                0.0
            };
            let expected = Vector3::new(2.0 * i as f64 - 10.0, 2.0 * j as f64 - 10.0, z);
            assert_eq!(patch.point(i, j), expected);
        }
    }
    assert_eq!(loaded.physics().gravity, Vector3::new(0.0, 0.0, -9.8));
    assert_eq!(loaded.physics().walls.len(), 4);
}

#[test]
fn a_thousand_balls_do_not_overlap_and_a_seed_repeats() {
    let text = SceneText::open("thousand").unwrap();
    let [one, two] = [text.load().unwrap(), text.load().unwrap()];
    assert_eq!(one.physics().balls, two.physics().balls);
    let discs: Vec<_> = one
        .physics()
        .balls
        .iter()
        .map(|ball| match ball.place {
            Place::Center(xy) => (xy, ball.radius),
            _ => panic!("clouds are placed by centre"),
        })
        .collect();
    assert_eq!(discs.len(), 1000);
    for (i, (a, r)) in discs.iter().enumerate() {
        for (b, s) in &discs[..i] {
            assert!((a - b).norm() >= r + s);
        }
    }
    let other = include_str!("../../scenes/thousand.toml").replace("seed = 2016", "seed = 2017");
    let other = SceneText::new("other.toml", other).load().unwrap();
    assert_ne!(one.physics().balls, other.physics().balls);
}

#[test]
fn a_cloud_too_dense_says_so_instead_of_searching_for_ever() {
    let cloud = "[[cloud]]\nname = \"c\"\ncount = 400\nradius_m = [0.3, 0.3]\ndensity_kg_per_m3 = 1.0\nwithin_m = 3.0\n";
    let message = fault(format!("{HEAD}{cloud}"));
    assert!(message.starts_with("t.toml:11:1: cloud[0].within_m: only "), "{message}");
    // Hardly any try fails here, but each looks at all the others.
    let crowded = cloud.replace("400", "100000").replace("[0.3, 0.3]", "[1e-6, 1.0]");
    assert!(fault(format!("{HEAD}{crowded}")).contains("found room"));
    let huge = cloud.replace("400", "100001");
    assert!(
        fault(format!("{HEAD}{huge}")).contains("cloud[0].count: is 100001: use a number from 1 to 100000")
    );
}

#[test]
fn a_cloud_keeps_clear_of_walls_and_of_written_balls() {
    let cloud = "[[cloud]]\nname = \"c\"\ncount = 60\nradius_m = [0.2, 0.3]\ndensity_kg_per_m3 = 1.0\nwithin_m = 9.0\n";
    let loaded = SceneText::new("t.toml", format!("{HEAD}{BALL}{cloud}")).load().unwrap();
    for ball in &loaded.physics().balls[1..] {
        let Place::Center(xy) = ball.place else { panic!("clouds are placed by centre") };
        assert!(xy.norm() >= ball.radius + 0.5);
        assert!(xy.amax() + ball.radius <= 5.0);
    }
}

#[test]
fn what_is_wrong_is_named_by_file_line_and_field() {
    for (from, to, expected) in [
        ("radius_m = 0.5", "radius_m = -0.5", "t.toml:8:1: ball[0].radius_m: is -0.5: use a number from"),
        ("radius_m = 0.5", "radius_m = nan", "t.toml:8:1: ball[0].radius_m: is NaN"),
        ("mass_kg = 1.0", "mass_kg = inf", "t.toml:9:1: ball[0].mass_kg: is inf"),
        ("center_m = [0.0, 0.0]", "", "t.toml:6:1: ball[0]: has 0 places: give exactly one of"),
        (
            "center_m = [0.0, 0.0]",
            "center_m = [0.0, 0.0]\nuv = [0.5, 0.5]",
            "t.toml:6:1: ball[0]: has 2 places",
        ),
        ("center_m = [0.0, 0.0]", "uv = [0.5, 1.5]", "t.toml:10:12: ball[0].uv[1]: is 1.5"),
        ("mass_kg = 1.0", "mass_kg = 1.0\ncolor = \"red\"", "t.toml:10:1: ball[0].color: is \"red\""),
        ("name = \"t\"", "name = \"T\"", "t.toml:2:1: name: is \"T\""),
        (
            "name = \"t\"",
            "name = \"t\"\nrestitution = 1.5",
            "t.toml:3:1: restitution: is 1.5: use a number from 0 to 1",
        ),
        (
            "name = \"t\"",
            "name = \"t\"\ngravity_m_per_s2 = [0.0, 0.0, 9.8]",
            "t.toml:3:1: gravity_m_per_s2: must point down",
        ),
        ("x_m = [-5.0, 5.0]", "x_m = [5.0, -5.0]", "t.toml:4:1: floor.polynomial.x_m: goes from 5 to -5"),
        (
            "y_m = [-5.0, 5.0]",
            "y_m = [-5.0, 5.0]\nterms = [{ px = 13, c = 1.0 }]",
            "t.toml:6:12: floor.polynomial.terms[0].px: is 13",
        ),
        ("mass_kg = 1.0", "mass = 1.0", "t.toml:9:1: ball[0].mass: unknown field `mass`"),
    ] {
        let good = format!("{HEAD}{BALL}");
        assert!(good.contains(from), "{from}");
        let message = fault(good.replacen(from, to, 1));
        assert!(message.starts_with(expected), "{message}\nis not\n{expected}");
    }
    let twice = fault(format!("{HEAD}{BALL}{BALL}"));
    assert!(twice.starts_with("t.toml:12:1: ball[1].name: is \"a\" like ball[0]'s"), "{twice}");
}

#[test]
fn what_the_engine_refuses_is_named_by_file_line_and_field() {
    let overlapping = BALL.replace("\"a\"", "\"b\"").replace("[0.0, 0.0]", "[0.5, 0.0]");
    let loaded = SceneText::new("t.toml", format!("{HEAD}{BALL}{overlapping}")).load().unwrap();
    let message = loaded.controller().err().unwrap().to_string();
    assert!(message.starts_with("t.toml:"), "{message}");
    assert!(message.contains("overlaps"), "{message}");
    let outside = BALL.replace("[0.0, 0.0]", "[4.9, 0.0]");
    let loaded = SceneText::new("t.toml", format!("{HEAD}{outside}")).load().unwrap();
    let message = loaded.controller().err().unwrap().to_string();
    assert!(message.starts_with("t.toml:6:1: ball[0]: \"a\" reaches"), "{message}");
}

#[test]
fn a_net_with_crooked_borders_needs_walls_of_its_own() {
    let net = |bend: f64| {
        format!(
            "version = 1\nname = \"t\"\n[floor.net]\ncontrol_points_m = [\n[[0.0, 0.0, 0.0], [1.0, {bend}, 0.0], [2.0, 0.0, 0.0]],\n\
             [[0.0, 2.0, 0.0], [1.0, 2.0, 0.0], [2.0, 2.0, 0.0]],\n]\n"
        )
    };
    let walls = SceneText::new("t.toml", net(0.0)).load().unwrap().physics().walls.clone();
    let normals: Vec<[f64; 2]> = walls.iter().map(|wall| wall.normal.into()).collect();
    assert_eq!(normals, [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]);
    assert!(fault(net(0.3)).contains("border v = 0 is no straight line"));
}

#[test]
fn an_unknown_scene_lists_the_known_ones() {
    let message = SceneText::open("moon").unwrap_err().to_string();
    assert!(message.contains("original, original_frictionless"), "{message}");
    assert!(SceneText::open("no/such/file").unwrap_err().to_string().contains("cannot be opened"));
}

#[test]
fn a_gas_of_any_number_covers_a_fifth_of_the_floor_and_rises_alike() {
    for count in [10, 1_000, 20_000] {
        let loaded = SceneText::open("gas").unwrap().with_balls(Some(count)).load().unwrap();
        let balls = &loaded.physics().balls;
        assert_eq!(balls.len(), count as usize);
        let protocol::scene::Floor::Polynomial { x_m: [west, east], terms, .. } = &loaded.scene().floor
        else {
            panic!("the gas rolls on a polynomial")
        };
        let discs: f64 = balls.iter().map(|ball| std::f64::consts::PI * ball.radius * ball.radius).sum();
        assert!((discs / (east - west).powi(2) - 0.2).abs() < 1e-4);
        assert!((terms[0].c * east * east - 0.06136).abs() < 1e-4);
        let mean_square = balls.iter().map(|b| b.velocity.norm_squared()).sum::<f64>() / f64::from(count);
        assert!((mean_square - 1.0).abs() < 2.0 / f64::from(count).sqrt(), "{mean_square}");
        loaded.controller().unwrap();
    }
}

#[test]
fn names_of_a_large_cloud_sort_as_their_numbers_do() {
    let loaded = SceneText::open("gas").unwrap().with_balls(Some(12_000)).load().unwrap();
    let names: Vec<&str> = loaded.physics().balls[1..].iter().map(|ball| ball.name.as_str()).collect();
    assert!(names.is_sorted());
    assert_eq!((names[0], names[11_998]), ("gas-00001", "gas-11999"));
}

#[test]
fn what_is_served_of_a_stretched_scene_is_all_of_it() {
    let loaded = SceneText::open("gas").unwrap().with_balls(Some(300)).load().unwrap();
    let saved = toml::to_string(&**loaded.scene()).unwrap();
    let again = SceneText::new("saved.toml", saved).load().unwrap();
    assert_eq!(again.scene(), loaded.scene());
    assert_eq!(again.physics().balls, loaded.physics().balls);
}

#[test]
fn only_a_scene_with_one_cloud_takes_a_number_of_balls() {
    let refusal = |name: &str, count| {
        SceneText::open(name).unwrap().with_balls(Some(count)).load().unwrap_err().to_string()
    };
    assert!(refusal("bowl", 7).contains("the scene has 0 clouds: only one with exactly one"));
    assert!(
        refusal("gas", 1).contains("cloud[0].count: 1 balls were asked for: this scene takes 2 to 100000")
    );
    assert!(refusal("gas", 100_001).contains("takes 2 to 100000"));
}
