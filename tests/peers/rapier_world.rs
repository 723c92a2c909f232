// One problem in Rapier. Included once beside Rapier's names in f32 and once in f64, which are crates of their own.

use std::sync::atomic::{AtomicU64, Ordering};

/// A problem in Rapier.
pub struct Rapier {
    world: PhysicsWorld,
    balls: Vec<RigidBodyHandle>,
    steps: u64,
    rate_hz: u64,
    sample_hz: u64,
    rolls: bool,
    counter: Option<Counter>,
    turns: Option<Turns>,
}

/// An entry that runs a problem with these settings.
pub fn entry(knobs: Knobs) -> Entry {
    let make = move |problem: &Problem, counting: bool| -> Box<dyn World> {
        Box::new(Rapier::new(problem, &knobs, counting))
    };
    Entry { engine: ENGINE, setting: knobs.words(), make: Box::new(make) }
}

impl Rapier {
    fn new(problem: &Problem, knobs: &Knobs, counting: bool) -> Self {
        let mut world = PhysicsWorld::new();
        world.integration_parameters = parameters(problem, knobs);
        let on_line = matches!(problem.truth, Truth::Velocities(..));
        add_ground(&mut world, problem, knobs);
        add_walls(&mut world, problem);
        let events = counting && !on_line;
        let balls =
            problem.balls.iter().map(|ball| add_ball(&mut world, problem, ball, knobs, events)).collect();
        Self {
            world,
            balls,
            steps: 0,
            rate_hz: u64::from(knobs.rate_hz),
            sample_hz: u64::from(problem.sample_hz),
            rolls: problem.rolls,
            counter: events.then(Counter::default),
            turns: (counting && on_line).then(Turns::default),
        }
    }
}

impl World for Rapier {
    fn go_to(&mut self, sample: u64) {
        // The first step at or after the sample; rates are chosen so that it is at the sample.
        let target = (sample * self.rate_hz).div_ceil(self.sample_hz);
        while self.steps < target {
            match &self.counter {
                Some(counter) => self.world.step_with_events(&(), counter),
                None => self.world.step(),
            }
            if let Some(turns) = &mut self.turns {
                turns.see(self.world.bodies[self.balls[0]].linvel().x);
            }
            self.steps += 1;
        }
    }

    fn look(&self) -> Sample {
        let bodies = || self.balls.iter().map(|ball| &self.world.bodies[*ball]);
        Sample {
            centers: bodies().map(|body| triple(body.translation())).collect(),
            velocities: bodies().map(|body| triple(body.linvel())).collect(),
            omegas: bodies().filter(|_| self.rolls).map(|body| triple(body.angvel())).collect(),
        }
    }

    fn hits(&self) -> Option<u64> {
        let begun = self.counter.as_ref().map(|counter| counter.begun.load(Ordering::Relaxed));
        begun.or(self.turns.as_ref().map(|turns| turns.count))
    }
}

fn parameters(problem: &Problem, knobs: &Knobs) -> IntegrationParameters {
    let mut parameters = IntegrationParameters {
        dt: real(1.0 / f64::from(knobs.rate_hz)),
        num_solver_iterations: knobs.iterations[0],
        num_internal_pgs_iterations: knobs.iterations[1],
        normalized_prediction_distance: real(knobs.prediction),
        normalized_max_linear_velocity: Real::MAX,
        max_ccd_substeps: knobs.ccd,
        min_ccd_dt: real(0.01 / f64::from(knobs.rate_hz)),
        contact_recycling: knobs.recycling,
        ..IntegrationParameters::default()
    };
    if let Some(part) = knobs.stiffness {
        let stiff = SpringCoefficients::new(real(part * f64::from(knobs.rate_hz)), 1.0);
        parameters.contact_softness = stiff;
        parameters.static_contact_softness = stiff;
    }
    if problem.rolls {
        parameters.friction_model = FrictionModel::Coulomb;
    }
    parameters
}

fn add_ground(world: &mut PhysicsWorld, problem: &Problem, knobs: &Knobs) {
    let Ground::Bowl(c) = problem.ground else {
        world.gravity = Vector::ZERO;
        return;
    };
    world.gravity = vector([0.0, 0.0, -problem.gravity]);
    let half = problem.half;
    let collider =
        if knobs.height_field { height_field(c, half, knobs.cells) } else { mesh(c, half, knobs.cells) };
    world.insert(RigidBodyBuilder::fixed(), surface_of(collider, problem));
}

/// A mesh whose inner edges are mended, so that a ball does not stumble over them.
fn mesh(c: f64, half: f64, cells: usize) -> ColliderBuilder {
    let side = cells + 1;
    let at = |k: usize| half * (2.0 * k as f64 / cells as f64 - 1.0);
    let vertices = (0..side * side).map(|n| {
        let [x, y] = [at(n % side), at(n / side)];
        vector([x, y, c * (x * x + y * y)])
    });
    let corner = |i: usize, j: usize| (j * side + i) as u32;
    let triangles = (0..cells * cells).flat_map(|n| {
        let [i, j] = [n % cells, n / cells];
        let [a, b] = [corner(i, j), corner(i + 1, j)];
        let [c, d] = [corner(i, j + 1), corner(i + 1, j + 1)];
        [[a, b, d], [a, d, c]]
    });
    let flags = TriMeshFlags::FIX_INTERNAL_EDGES;
    ColliderBuilder::trimesh_with_flags(vertices.collect(), triangles.collect(), flags)
        .expect("a regular mesh")
}

/// Rapier's height fields rise along y: turned so that they rise along z. The bowl is the same from every side.
fn height_field(c: f64, half: f64, cells: usize) -> ColliderBuilder {
    let side = cells + 1;
    let at = |k: usize| half * (2.0 * k as f64 / cells as f64 - 1.0);
    let heights = (0..side * side).map(|n| real(c * (at(n % side).powi(2) + at(n / side).powi(2))));
    let heights = Array2::new(side, side, heights.collect());
    let scale = vector([2.0 * half, 1.0, 2.0 * half]);
    ColliderBuilder::heightfield_with_flags(heights, scale, HeightFieldFlags::FIX_INTERNAL_EDGES)
        .rotation(vector([std::f64::consts::FRAC_PI_2, 0.0, 0.0]))
}

/// Walls are half spaces: Rapier has no plane that is more exact.
fn add_walls(world: &mut PhysicsWorld, problem: &Problem) {
    let Some([x, y]) = problem.walls else { return };
    for (point, normal) in [
        ([x[0], 0.0, 0.0], [1.0, 0.0, 0.0]),
        ([x[1], 0.0, 0.0], [-1.0, 0.0, 0.0]),
        ([0.0, y[0], 0.0], [0.0, 1.0, 0.0]),
        ([0.0, y[1], 0.0], [0.0, -1.0, 0.0]),
    ] {
        let normal = Unit::new_unchecked(vector(normal));
        let wall = ColliderBuilder::halfspace(normal).translation(vector(point));
        world.insert(RigidBodyBuilder::fixed(), surface_of(wall, problem).friction(0.0));
    }
}

fn add_ball(
    world: &mut PhysicsWorld,
    problem: &Problem,
    ball: &Ball,
    knobs: &Knobs,
    events: bool,
) -> RigidBodyHandle {
    let mut body = RigidBodyBuilder::dynamic()
        .translation(vector(ball.center))
        .linvel(vector(ball.velocity))
        .can_sleep(false)
        .ccd_enabled(knobs.ccd > 0);
    if problem.rolls {
        body = body.angvel(vector(ball.omega));
    } else {
        let flat = if problem.ground == Ground::Plane {
            LockedAxes::TRANSLATION_LOCKED_Z
        } else {
            LockedAxes::empty()
        };
        body = body.locked_axes(LockedAxes::ROTATION_LOCKED | flat);
    }
    let inertia = ball.inertia_factor * ball.mass * ball.radius * ball.radius;
    let mass = MassProperties::new(Vector::ZERO, real(ball.mass), vector([inertia; 3]));
    let mut collider = surface_of(ColliderBuilder::ball(real(ball.radius)), problem).mass_properties(mass);
    if events {
        collider = collider.active_events(ActiveEvents::COLLISION_EVENTS);
    }
    world.insert(body, collider).0
}

/// Elastic where there is something to hit; without friction, or with more than rolling needs.
fn surface_of(collider: ColliderBuilder, problem: &Problem) -> ColliderBuilder {
    collider
        .restitution(if problem.has_hits() { 1.0 } else { 0.0 })
        .restitution_combine_rule(CoefficientCombineRule::Max)
        .friction(if problem.rolls { 10.0 } else { 0.0 })
        .friction_combine_rule(CoefficientCombineRule::Min)
}

fn vector(a: Triple) -> Vector {
    Vector::new(real(a[0]), real(a[1]), real(a[2]))
}

fn triple(v: Vector) -> Triple {
    [v.x, v.y, v.z].map(f64::from)
}

/// Counts contacts that begin.
#[derive(Default)]
struct Counter {
    begun: AtomicU64,
}

impl EventHandler for Counter {
    fn handle_collision_event(
        &self,
        _: &RigidBodySet,
        _: &ColliderSet,
        event: CollisionEvent,
        _: Option<&ContactPair>,
    ) {
        self.begun.fetch_add(u64::from(event.started()), Ordering::Relaxed);
    }

    fn handle_contact_force_event(
        &self,
        _: Real,
        _: &RigidBodySet,
        _: &ColliderSet,
        _: &ContactPair,
        _: Real,
    ) {
    }

    fn handle_soft_body_tear_event(&self, _: &SoftBodySet, _: &SoftBodyTearEvent) {}
}

/// Counts the hits of a ball that is pushed to the right and to the left in turn: a push of several steps is one, and what
/// changes its speed by less than a micrometre a second is none.
#[derive(Default)]
struct Turns {
    speed: Option<Real>,
    push: i8,
    count: u64,
}

impl Turns {
    fn see(&mut self, speed: Real) {
        let change = speed - self.speed.unwrap_or(0.0);
        self.speed = Some(speed);
        let push = if change.abs() < 1e-6 { 0 } else { change.signum() as i8 };
        self.count += u64::from(push != 0 && push != self.push);
        self.push = push;
    }
}
