//! Motion of one ball against closed forms, quadratures and an independent integration in 30 digits.
//! Numbers: `python3 periods.py` and `python3 tables.py` in `tests/reference`.

use crate::scenes::{self, HOLLOW, SOLID, contact, graph, run, still};
use crate::tables;
use ballroom_physics::MotionLaw::{Frictionless, Rolling};
use ballroom_physics::{Accuracy, BallSpec, MotionLaw, Place, Scene, Scheme, Time};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// Rate of the tables, Hz.
const RATE_HZ: u32 = 20;

/// The largest error over all ticks: centre (m), velocity (m/s), angular velocity (rad/s).
fn assert_follows(scene: &Scene, table: &[[f64; 9]], bound: f64) {
    let mut worst = [0.0_f64; 3];
    run(scene, RATE_HZ, table.len() as u64 - 1, |tick, engine| {
        let ball = engine.balls()[0];
        let row = &table[tick as usize];
        let parts = [ball.center, ball.velocity, ball.omega];
        for (part, (own, exact)) in parts.iter().zip(row.chunks_exact(3)).enumerate() {
            // A sliding ball's rotation is its own affair.
            if part < 2 || scene.motion == Rolling {
                worst[part] = worst[part].max((own - Vector3::from_row_slice(exact)).norm());
            }
        }
    });
    let spin_scale = 1.0 / scene.balls[0].radius;
    assert!(
        worst[0] < bound && worst[1] < bound && worst[2] < bound * spin_scale,
        "errors of centre, velocity, angular velocity: {worst:?}"
    );
}

fn in_the_pit(motion: MotionLaw, k: f64) -> Scene {
    let border = [-10.0, 10.0];
    let mut scene = scenes::scene(scenes::pit_floor(false), border, border, motion);
    scene.gravity = Vector3::new(0.0, 0.0, -9.8);
    scene.balls = vec![BallSpec { inertia_factor: k, ..still("ball", 1.0, contact(-3.0, 0.0)) }];
    scene
}

fn one(scene: Scene, ball: BallSpec) -> Scene {
    Scene { balls: vec![ball], ..scene }
}

fn launched(radius: f64, k: f64, place: Place, velocity: [f64; 3], spin: f64) -> BallSpec {
    BallSpec { inertia_factor: k, velocity: velocity.into(), spin, ..still("ball", radius, place) }
}

/// Back at rest where it was released after a period: the time by which it misses rest is the period's error.
fn assert_period(scene: &Scene, period: f64, bound: f64) {
    let mut engine = scenes::load(scene);
    let start = engine.balls()[0];
    let step = 1e-3;
    engine.advance_to(Time::of_seconds(step));
    let acceleration = engine.balls()[0].velocity.norm() / step;
    // Early and late ticks between must not matter.
    engine.advance_to(Time::of_seconds(0.7 * period));
    engine.advance_to(Time::of_seconds(period));
    let ball = engine.balls()[0];
    let late = ball.velocity.norm() / acceleration;
    let away = (ball.center - start.center).norm();
    assert!(late < bound && away < bound, "off by {late} s and {away} m");
}

#[test]
fn a_sliding_ball_swings_in_the_pit_with_its_period() {
    assert_period(&in_the_pit(Frictionless, SOLID), 2.135_585_674_238_205, 1e-9);
    assert_follows(&in_the_pit(Frictionless, SOLID), &tables::PIT_SLIDING, 1e-10);
}

#[test]
fn a_solid_ball_swings_in_the_pit_with_its_period() {
    assert_period(&in_the_pit(Rolling, SOLID), 2.526_859_046_487_561_5, 1e-9);
    assert_follows(&in_the_pit(Rolling, SOLID), &tables::PIT_SOLID, 1e-10);
}

#[test]
fn a_hollow_ball_swings_in_the_pit_with_its_period() {
    assert_period(&in_the_pit(Rolling, HOLLOW), 2.757_029_250_241_235_3, 1e-9);
    assert_follows(&in_the_pit(Rolling, HOLLOW), &tables::PIT_HOLLOW, 1e-10);
}

/// B0: z = 0.75 x, thrown across the slope, with spin that must not matter.
fn assert_incline(motion: MotionLaw, k: f64, spin: f64) {
    let slope = 0.75;
    let scene = graph(100.0, &[(1, 0, slope)], motion);
    let scene = one(scene, launched(0.5, k, contact(3.0, -7.0), [2.0, 3.0, 1.5], spin));
    let normal = Vector3::new(-slope, 0.0, 1.0).normalize();
    let downhill = Vector3::new(-1.0, 0.0, -slope).normalize();
    let k = if motion == Rolling { k } else { 0.0 };
    let acceleration = downhill * (9.81 * 0.6 / (1.0 + k));
    let start = Vector3::new(3.0, -7.0, 2.25) + 0.5 * normal;
    let velocity = Vector3::new(2.0, 3.0, 1.5);
    let mut worst = [0.0_f64; 2];
    run(&scene, 60, 180, |tick, engine| {
        let t = tick as f64 / 60.0;
        let ball = engine.balls()[0];
        let center = start + velocity * t + acceleration * (0.5 * t * t);
        worst[0] = worst[0].max((ball.center - center).norm());
        worst[1] = worst[1].max((ball.velocity - (velocity + acceleration * t)).norm());
        if motion == Rolling {
            let slip = ball.velocity - ball.omega.cross(&(0.5 * normal));
            assert!(slip.norm() < 1e-12 && (ball.omega.dot(&normal) - spin).abs() < 1e-12, "slips at {tick}");
        }
    });
    assert!(worst[0] < 1e-12 && worst[1] < 1e-12, "{worst:?}");
}

#[test]
fn a_sliding_ball_falls_along_an_incline_with_g_sin_alpha() {
    assert_incline(Frictionless, SOLID, 0.0);
}

#[test]
fn a_solid_ball_rolls_down_an_incline_with_five_sevenths_of_it() {
    assert_incline(Rolling, SOLID, 0.0);
    assert_incline(Rolling, SOLID, 12.0);
}

#[test]
fn a_hollow_ball_rolls_down_an_incline_with_three_fifths_of_it() {
    assert_incline(Rolling, HOLLOW, -5.0);
}

const PARABOLA: &[(usize, usize, f64)] = &[(2, 0, 0.75)];

/// When a ball that moves in and out is turned next near `guess`: a zero of c . w in the plane, by secants.
fn turn(scene: &Scene, guess: f64) -> f64 {
    let mut before = scenes::load(scene);
    before.advance_to(Time::of_seconds(guess - 0.05));
    let pace = |t: f64| {
        let mut engine = before.clone();
        engine.advance_to(Time::of_seconds(t));
        let ball = engine.balls()[0];
        ball.center.xy().dot(&ball.velocity.xy())
    };
    let (mut last, mut t) = (guess - 0.01, guess);
    let (mut slow, mut pace_now) = (pace(last), pace(t));
    for _ in 0..20 {
        if t == last || pace_now == slow {
            break;
        }
        let next = t - pace_now * (t - last) / (pace_now - slow);
        (last, slow) = (t, pace_now);
        (t, pace_now) = (next, pace(next));
    }
    t
}

/// The period of a bead is that of a ball of radius 0: extrapolated from five small radii, in which it is analytic.
fn assert_bead(scene: &Scene, period: f64) {
    let weights = [5.0, -10.0, 10.0, -5.0, 1.0];
    let bead: f64 = (1..)
        .zip(weights)
        .map(|(n, weight)| {
            let mut scene = scene.clone();
            scene.balls[0].radius = 1e-3 * f64::from(n);
            weight * turn(&scene, period)
        })
        .sum();
    assert!((bead - period).abs() < 1e-10, "{bead} for {period}");
}

fn on_the_parabola(motion: MotionLaw) -> Scene {
    one(graph(3.0, PARABOLA, motion), still("ball", 1.0, contact(0.8, 0.0)))
}

#[test]
fn a_bead_on_a_parabola_slides_with_its_elliptic_period() {
    assert_bead(&on_the_parabola(Frictionless), 2.123_572_137_222_319);
}

#[test]
fn a_bead_on_a_parabola_rolls_root_seven_fifths_slower() {
    assert_bead(&on_the_parabola(Rolling), 2.512_644_437_794_921);
}

#[test]
fn a_ball_slides_across_a_parabolic_cylinder() {
    let scene = one(graph(3.0, PARABOLA, Frictionless), still("ball", 0.2, contact(0.8, 0.0)));
    assert_period(&scene, 1.909_591_921_611_005_3, 1e-10);
    assert_follows(&scene, &tables::CYLINDER_SLIDING, 1e-10);
}

#[test]
fn a_ball_rolls_across_a_parabolic_cylinder() {
    let scene = one(graph(3.0, PARABOLA, Rolling), still("ball", 0.2, contact(0.8, 0.0)));
    assert_period(&scene, 2.259_459_632_282_643, 1e-10);
    assert_follows(&scene, &tables::CYLINDER_ROLLING, 1e-10);
}

#[test]
fn spin_and_axial_speed_trade_along_a_parabolic_cylinder() {
    let ball = launched(0.2, SOLID, contact(0.8, -1.5), [0.0, 0.5, 0.0], 7.0);
    let scene = one(graph(5.0, PARABOLA, Rolling), ball);
    assert_follows(&scene, &tables::CYLINDER_HELIX, 1e-10);
    // B8: with lambda^2 = k/(1+k), lambda sigma and the axial speed turn into each other with the slope angle.
    let lambda = (SOLID / (1.0 + SOLID)).sqrt();
    let mut first = None;
    run(&scene, 60, 240, |tick, engine| {
        let ball = engine.balls()[0];
        let theta = ball.normal.x.atan2(ball.normal.z);
        let sigma = 0.2 * ball.omega.dot(&ball.normal);
        let phase = (lambda * sigma).atan2(ball.velocity.y);
        let amplitude = (lambda * sigma).hypot(ball.velocity.y);
        let [rotated, length] = *first.get_or_insert([phase + lambda * theta, amplitude]);
        let [forth, back] = [phase + lambda * theta - rotated, phase - lambda * theta - rotated];
        assert!((amplitude - length).abs() < 1e-10, "tick {tick}: amplitude {amplitude} was {length}");
        assert!(forth.abs() < 1e-10, "tick {tick}: phase off by {forth} (other sense {back})");
    });
}

const BOWL: &[(usize, usize, f64)] = &[(2, 0, 0.25), (0, 2, 0.25)];

#[test]
fn a_ball_orbits_in_a_paraboloid() {
    let ball = launched(0.1, SOLID, contact(0.9, 0.0), [0.0, 1.1, 0.0], 0.0);
    assert_follows(&one(graph(3.0, BOWL, Frictionless), ball), &tables::BOWL_ORBIT_SLIDING, 1e-10);
}

#[test]
fn a_hollow_ball_with_spin_orbits_in_a_paraboloid() {
    let ball = launched(0.1, HOLLOW, contact(0.9, 0.0), [0.0, 1.1, 0.0], 11.0);
    assert_follows(&one(graph(3.0, BOWL, Rolling), ball), &tables::BOWL_ORBIT_ROLLING, 1e-10);
}

#[test]
fn a_bead_on_a_paraboloid_turns_with_its_elliptic_radial_period() {
    // B3: kappa 1.5, at 0.9 m across with 1.1 m/s.
    let ball = launched(1.0, SOLID, contact(0.9, 0.0), [0.0, 1.1, 0.0], 0.0);
    let floor = graph(3.0, &[(2, 0, 0.75), (0, 2, 0.75)], Frictionless);
    assert_bead(&one(floor, ball), 1.146_682_140_637_624_2);
}

/// B4: a horizontal circle. `spin` is the angular velocity about the normal.
fn assert_circle(motion: MotionLaw, k: f64, spin: f64) {
    let (kappa, r, g, tangent) = (0.5_f64, 0.2, 9.81, 0.45_f64);
    let theta = tangent.atan();
    let (sin, cos) = theta.sin_cos();
    let contact_radius = tangent / kappa;
    let rho = contact_radius - r * sin;
    let height = tangent * tangent / (2.0 * kappa) + r * cos;
    let omega = match motion {
        Frictionless => (g * kappa / (1.0 - r * kappa * cos)).sqrt(),
        Rolling => {
            // (1+k) rho cos W^2 + k sigma sin W - g sin = 0.
            let [a, b, c] = [(1.0 + k) * rho * cos, k * r * spin * sin, -g * sin];
            (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)
        }
    };
    let ball = launched(r, k, contact(contact_radius, 0.0), [0.0, omega * rho, 0.0], spin);
    let mut worst = [0.0_f64; 3];
    run(&one(graph(2.0, BOWL, motion), ball), 60, 300, |tick, engine| {
        let angle = omega * tick as f64 / 60.0;
        let ball = engine.balls()[0];
        let center = Vector3::new(rho * angle.cos(), rho * angle.sin(), height);
        let velocity = Vector3::new(-angle.sin(), angle.cos(), 0.0) * (rho * omega);
        worst[0] = worst[0].max((ball.center - center).norm());
        worst[1] = worst[1].max((ball.velocity - velocity).norm());
        if motion == Rolling {
            worst[2] = worst[2].max((ball.omega.dot(&ball.normal) - spin).abs() * r);
        }
    });
    assert!(worst.iter().all(|error| *error < 1e-10), "{worst:?}");
}

#[test]
fn a_sliding_ball_keeps_its_horizontal_circle() {
    assert_circle(Frictionless, SOLID, 0.0);
}

#[test]
fn a_rolling_ball_keeps_its_horizontal_circle() {
    assert_circle(Rolling, SOLID, 0.0);
    assert_circle(Rolling, HOLLOW, 0.0);
}

#[test]
fn spin_changes_the_pace_of_a_horizontal_circle() {
    assert_circle(Rolling, SOLID, 20.0);
    assert_circle(Rolling, HOLLOW, -13.0);
}

const BUMPS: &[(usize, usize, f64)] =
    &[(2, 0, 0.2), (0, 2, 0.15), (1, 1, 0.05), (3, 0, -0.03), (1, 2, 0.02), (2, 2, 0.01), (0, 4, 0.004)];

#[test]
fn a_ball_rolls_over_a_floor_without_symmetry() {
    let ball = launched(0.25, SOLID, contact(1.2, -0.7), [-0.4, 1.3, 0.0], -9.0);
    let scene = one(graph(3.0, BUMPS, Rolling), ball);
    assert_follows(&scene, &tables::BUMPS_ROLLING, 1e-10);
    assert_follows(&scenes::as_net(&scene), &tables::BUMPS_ROLLING, 1e-10);
}

#[test]
fn a_ball_rolls_over_a_saddle() {
    let ball = launched(0.15, SOLID, contact(0.5, 0.1), [0.0, 0.3, 0.0], 3.0);
    let floor = &[(2, 0, 0.25), (0, 2, -0.125), (0, 4, 0.125)];
    assert_follows(&one(graph(2.0, floor, Rolling), ball), &tables::SADDLE_ROLLING, 1e-10);
}

#[test]
fn an_error_asked_for_is_an_error_kept() {
    let ball = launched(0.25, SOLID, contact(1.2, -0.7), [-0.4, 1.3, 0.0], -9.0);
    let mut scene = one(graph(3.0, BUMPS, Rolling), ball);
    for tolerance in [1e-4, 1e-6, 1e-9, 1e-12] {
        scene.accuracy = Accuracy::Tolerance(tolerance);
        let mut worst = 0.0_f64;
        run(&scene, RATE_HZ, tables::BUMPS_ROLLING.len() as u64 - 1, |tick, engine| {
            let exact = Vector3::from_row_slice(&tables::BUMPS_ROLLING[tick as usize][..3]);
            worst = worst.max((engine.balls()[0].center - exact).norm());
        });
        assert!(worst < tolerance, "asked {tolerance}, got {worst}");
    }
}

/// Largest error over all ticks on the bumps with a scheme and a step, m.
fn error_of(scheme: Scheme, step: f64) -> f64 {
    let ball = launched(0.25, SOLID, contact(1.2, -0.7), [-0.4, 1.3, 0.0], -9.0);
    let mut scene = one(graph(3.0, BUMPS, Rolling), ball);
    scene.accuracy = Accuracy::Fixed(scheme, step);
    let mut worst = 0.0_f64;
    run(&scene, RATE_HZ, tables::BUMPS_ROLLING.len() as u64 - 1, |tick, engine| {
        let exact = Vector3::from_row_slice(&tables::BUMPS_ROLLING[tick as usize][..3]);
        worst = worst.max((engine.balls()[0].center - exact).norm());
    });
    worst
}

/// The order holds at every tick, inside steps too: what the dense output is worth.
#[test]
fn every_scheme_chosen_by_name_shows_its_order() {
    for (scheme, step, order) in
        [(Scheme::Rk4, 0.02, 4.0), (Scheme::Tsit5, 0.02, 5.0), (Scheme::Dop853, 0.11, 8.0)]
    {
        let (coarse, fine) = (error_of(scheme, step), error_of(scheme, 0.5 * step));
        let observed = (coarse / fine).log2();
        println!("{scheme:?}: {coarse:e} m at {step} s, {fine:e} m at half of it, order {observed:.2}");
        assert!(observed > order - 0.8, "{scheme:?}: {coarse:e} to {fine:e}, order {observed}");
        assert!(fine < 1e-5, "{scheme:?}: {fine:e}");
    }
}

/// The quaternion equation integrated from the published angular velocity alone, by Magnus steps of order 4 on a
/// tick of 8000 Hz.
#[test]
fn orientation_follows_the_angular_velocity() {
    let ball = launched(0.25, SOLID, contact(1.2, -0.7), [-0.4, 1.3, 0.0], -9.0);
    let mut engine = scenes::load(&one(graph(3.0, BUMPS, Rolling), ball));
    let half = 0.5 / 8000.0;
    let mut omega = engine.balls()[0].omega;
    let mut q = UnitQuaternion::identity();
    let mut turned = 0.0;
    for tick in 1..=40_000 {
        engine.advance_to(Time::of_tick(2 * tick - 1, 16_000));
        let middle = engine.balls()[0].omega;
        engine.advance_to(Time::of_tick(2 * tick, 16_000));
        let end = engine.balls()[0].omega;
        let mean = (omega + middle * 4.0 + end) * (half / 3.0);
        q = UnitQuaternion::from_scaled_axis(mean + end.cross(&omega) * (half * half / 3.0)) * q;
        turned += mean.norm();
        omega = end;
        let [x, y, z, w] = engine.balls()[0].orientation;
        let published = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        assert!((x * x + y * y + z * z + w * w - 1.0).abs() < 1e-14);
        assert!(q.angle_to(&published) < 1e-10, "tick {tick}: {:e} rad off", q.angle_to(&published));
    }
    assert!(turned > 20.0, "the ball turned {turned} rad");
}
