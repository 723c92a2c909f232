//! Impulses of one impact: a single contact in closed form, several at once by generalised reflections.
//!
//! With M = (1+k) m, d the unit line of contact and P the tangent projector at each ball, a contact's impulse J
//! changes w by J P d/M: no impulse leaves the floor, and no energy is lost to it. Spin is unchanged.
//! Several elastic contacts at one instant are solved in turn where their order does not matter, and otherwise by reflecting the velocities about the set of violated ones,
//! v+ = v + (1+e)(proj v - v) in the kinetic metric, until none is violated (Smith et al., "Reflections on
//! simultaneous impact", 2012): exact for the cradle and for symmetric hits, and never gains energy, since the
//! smallest e of the violated set is used.

use super::in_turn::resolve_in_turn;
use crate::tolerance::{CLUSTER_SATISFIED, REFLECTIONS_MAX, REFLECTIONS_STUCK, REST_SPEED};
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// A ball in an impact.
#[derive(Clone, Copy, Debug)]
pub struct Member {
    /// Velocity of the centre, m/s.
    pub velocity: V3,
    /// Floor normal at the ball.
    pub normal: V3,
    /// 1/((1+k) m); 0 for a ball that is held.
    pub inverse_mass: f64,
}

/// A contact: the other side may be a wall.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// Place of the first ball among the members.
    pub a: usize,
    /// Place of the second; None for a wall.
    pub b: Option<usize>,
    /// Unit line of contact: from a to b, or from the ball into the wall.
    pub line: V3,
}

impl Member {
    /// P d.
    fn tangent(&self, line: &V3) -> V3 {
        line - self.normal * line.dot(&self.normal)
    }
}

impl Contact {
    /// Closing speed, positive while approaching, m/s.
    pub fn closing(&self, members: &[Member]) -> f64 {
        let other = self.b.map_or(0.0, |b| members[b].velocity.dot(&self.line));
        members[self.a].velocity.dot(&self.line) - other
    }

    /// Change of closing speed by a unit impulse, 1/kg.
    fn compliance(&self, members: &[Member]) -> f64 {
        let share = |m: &Member| m.tangent(&self.line).dot(&self.line) * m.inverse_mass;
        share(&members[self.a]) + self.b.map_or(0.0, |b| share(&members[b]))
    }

    /// Changes the closing speed by `wanted`. The same two balls meet with the same rounding of their masses each time,
    /// which would add up over millions of hits: the part of each product and quotient below rounding goes along.
    fn part(&self, members: &mut [Member], wanted: f64) {
        let share = |m: &Member| m.tangent(&self.line).dot(&self.line) * m.inverse_mass;
        let (x, y) = (share(&members[self.a]), self.b.map_or(0.0, |b| share(&members[b])));
        let compliance = x + y;
        let below = lost(x, y, compliance);
        let push = |m: &mut Member, wanted: f64| {
            let part = m.inverse_mass / compliance;
            let rest = ((-part).mul_add(compliance, m.inverse_mass) - part * below) / compliance;
            let main = wanted * part;
            let rest = wanted.mul_add(part, -main) + wanted * rest;
            let tangent = m.tangent(&self.line);
            for (v, t) in m.velocity.iter_mut().zip(tangent.iter()) {
                let (before, change) = (*v, t * main);
                *v += change;
                *v += lost(before, change, *v) + t * rest;
            }
        };
        push(&mut members[self.a], -wanted);
        if let Some(b) = self.b {
            push(&mut members[b], wanted);
        }
    }

    fn apply(&self, members: &mut [Member], impulse: f64) {
        let a = &mut members[self.a];
        a.velocity -= a.tangent(&self.line) * (impulse * a.inverse_mass);
        if let Some(b) = self.b {
            let b = &mut members[b];
            b.velocity += b.tangent(&self.line) * (impulse * b.inverse_mass);
        }
    }
}

/// What rounding took from `sum` = x + y (Knuth's two-sum).
fn lost(x: f64, y: f64, sum: f64) -> f64 {
    let added = sum - x;
    (x - (sum - added)) + (y - added)
}

/// Resolves one contact with restitution `e`; returns the impulse, N s (0 when the balls do not approach).
pub fn resolve_one(members: &mut [Member], contact: &Contact, e: f64) -> f64 {
    let closing = contact.closing(members);
    let compliance = contact.compliance(members);
    if closing <= 0.0 || compliance <= 0.0 {
        return 0.0;
    }
    let wanted = (1.0 + e) * closing;
    contact.part(members, wanted);
    wanted / compliance
}

/// Working memory of a cluster, kept between impacts so that a tick does not allocate.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    matrix: Vec<f64>,
    factor: Vec<f64>,
    impulse: Vec<f64>,
    residual: Vec<f64>,
    trial: Vec<f64>,
    active: Vec<usize>,
    violated: Vec<usize>,
    pub(super) start: Vec<V3>,
    pub(super) backward: Vec<V3>,
}

impl Scratch {
    /// Room for `contacts` at once.
    pub fn with_room(contacts: usize) -> Self {
        let numbers = || Vec::with_capacity(contacts);
        let square = || Vec::with_capacity(contacts * contacts);
        Self {
            matrix: square(),
            factor: square(),
            impulse: numbers(),
            residual: numbers(),
            trial: numbers(),
            active: Vec::with_capacity(contacts),
            violated: Vec::with_capacity(contacts),
            start: Vec::with_capacity(contacts + 1),
            backward: Vec::with_capacity(contacts + 1),
        }
    }
}

/// Resolves contacts that happen at one instant. `restitution(i, closing)` is contact i's e at a closing speed.
/// `totals[i]` receives contact i's impulse, N s. Returns false if the reflections had to be cut short by a
/// projection (e = 0).
pub fn resolve_cluster(
    members: &mut [Member],
    contacts: &[Contact],
    restitution: impl Fn(f64) -> f64,
    totals: &mut [f64],
    scratch: &mut Scratch,
) -> bool {
    totals.fill(0.0);
    let fastest = members.iter().map(|m| m.velocity.norm()).fold(0.0, f64::max);
    let satisfied = CLUSTER_SATISFIED * fastest;
    // What closes slowly gains and loses nothing worth the name.
    let counts = |closing: &f64| *closing > satisfied.max(REST_SPEED);
    let elastic = contacts.iter().map(|c| c.closing(members)).filter(counts).all(|x| restitution(x) == 1.0);
    if elastic && resolve_in_turn(members, contacts, satisfied, totals, scratch) {
        return true;
    }
    let (mut best, mut since_best) = (f64::INFINITY, 0);
    for round in 0..=REFLECTIONS_MAX {
        let mut fastest_closing = 0.0_f64;
        scratch.violated.clear();
        let (mut e, mut dead) = (1.0_f64, false);
        for (i, contact) in contacts.iter().enumerate() {
            let closing = contact.closing(members);
            if closing > satisfied && contact.compliance(members) > 0.0 {
                fastest_closing = fastest_closing.max(closing);
                let rebound = restitution(closing);
                if rebound > 0.0 {
                    scratch.violated.push(i);
                    e = e.min(rebound);
                }
                dead |= rebound <= 0.0;
            }
        }
        if scratch.violated.is_empty() {
            if !dead {
                return true;
            }
            // Contacts without rebound wait until no other closes: one that closes by rounding must not take theirs.
            e = 0.0;
        }
        if fastest_closing < best {
            (best, since_best) = (fastest_closing, 0);
        }
        since_best += 1;
        let stuck = round == REFLECTIONS_MAX || since_best > 2 * contacts.len() + REFLECTIONS_STUCK;
        if stuck {
            e = 0.0;
        }
        if e == 0.0 {
            // Without rebound nothing is gained by going round: all contacts at once.
            scratch.violated.clear();
            scratch.violated.extend(0..contacts.len());
        }
        project(members, contacts, scratch);
        for (place, i) in scratch.violated.iter().enumerate() {
            let impulse = (1.0 + e) * scratch.impulse[place];
            if impulse != 0.0 {
                contacts[*i].apply(members, impulse);
                totals[*i] += impulse;
            }
        }
        if stuck {
            return false;
        }
    }
    false
}

/// Parts two bodies pressed together at `speed`: the last resort when slow hits pile up on a moving ball.
pub fn hop(members: &mut [Member], contact: &Contact, speed: f64) {
    let compliance = contact.compliance(members);
    let lacking = contact.closing(members) + speed;
    if compliance > 0.0 && lacking > 0.0 {
        contact.apply(members, lacking / compliance);
    }
}

/// Impulses (not negative) that bring the velocities to the nearest ones, in the kinetic metric, at which no
/// violated contact closes: a linear complementarity problem solved by Lawson and Hanson's active set.
fn project(members: &[Member], contacts: &[Contact], scratch: &mut Scratch) {
    let n = scratch.violated.len();
    let Scratch { matrix, factor, impulse, residual, trial, active, violated, .. } = scratch;
    matrix.clear();
    for r in violated.iter() {
        for s in violated.iter() {
            matrix.push(coupling(members, &contacts[*r], &contacts[*s]));
        }
    }
    impulse.clear();
    impulse.resize(n, 0.0);
    residual.clear();
    residual.extend(violated.iter().map(|i| contacts[*i].closing(members)));
    let scale = residual.iter().copied().fold(0.0, f64::max);
    active.clear();
    for _ in 0..3 * n + 3 {
        // The contact that still closes fastest; ties go to the smaller place.
        let mut worst = None;
        let mut most = 1e-15 * scale;
        for (i, x) in residual.iter().enumerate() {
            if *x > most && !active.contains(&i) {
                (worst, most) = (Some(i), *x);
            }
        }
        let Some(worst) = worst else { return };
        active.push(worst);
        active.sort_unstable();
        loop {
            if !solve_active(matrix, n, violated, members, contacts, active, factor, trial) {
                // A contact that others already hold adds nothing.
                active.retain(|i| *i != worst);
                return;
            }
            // Step towards the trial until an impulse would turn negative.
            let mut step = 1.0_f64;
            for (place, i) in active.iter().enumerate() {
                if trial[place] <= 0.0 {
                    step = step.min(impulse[*i] / (impulse[*i] - trial[place]));
                }
            }
            for (place, i) in active.iter().enumerate() {
                impulse[*i] += step * (trial[place] - impulse[*i]);
            }
            if step >= 1.0 {
                break;
            }
            let before = active.len();
            active.retain(|i| impulse[*i] > 0.0);
            for (i, x) in impulse.iter_mut().enumerate() {
                if !active.contains(&i) {
                    *x = 0.0;
                }
            }
            if active.is_empty() || active.len() == before {
                break;
            }
        }
        for (i, x) in residual.iter_mut().enumerate() {
            *x = contacts[violated[i]].closing(members);
            for (j, p) in impulse.iter().enumerate() {
                *x -= matrix[i * n + j] * p;
            }
        }
    }
}

/// Change of contact r's closing speed by a unit impulse in contact s (with the sign that lowers it).
fn coupling(members: &[Member], r: &Contact, s: &Contact) -> f64 {
    let sides = |c: &Contact| [(Some(c.a), 1.0), (c.b, -1.0)];
    let mut sum = 0.0;
    for (x, sx) in sides(r) {
        for (y, sy) in sides(s) {
            if let (Some(x), Some(y)) = (x, y)
                && x == y
            {
                let m = &members[x];
                sum += sx * sy * m.inverse_mass * m.tangent(&r.line).dot(&m.tangent(&s.line));
            }
        }
    }
    sum
}

/// Solves the active rows for impulses that stop them, by Cholesky; false if they depend on each other.
#[allow(clippy::too_many_arguments, reason = "the pieces of one scratch, borrowed apart")]
fn solve_active(
    matrix: &[f64],
    n: usize,
    violated: &[usize],
    members: &[Member],
    contacts: &[Contact],
    active: &[usize],
    factor: &mut Vec<f64>,
    out: &mut Vec<f64>,
) -> bool {
    let m = active.len();
    factor.clear();
    factor.resize(m * m, 0.0);
    for i in 0..m {
        for j in 0..=i {
            let mut sum = matrix[active[i] * n + active[j]];
            for k in 0..j {
                sum -= factor[i * m + k] * factor[j * m + k];
            }
            if i == j {
                if sum <= 1e-13 * matrix[active[i] * n + active[i]] {
                    return false;
                }
                factor[i * m + i] = sum.sqrt();
            } else {
                factor[i * m + j] = sum / factor[j * m + j];
            }
        }
    }
    out.clear();
    for i in 0..m {
        let mut sum = contacts[violated[active[i]]].closing(members);
        for k in 0..i {
            sum -= factor[i * m + k] * out[k];
        }
        out.push(sum / factor[i * m + i]);
    }
    for i in (0..m).rev() {
        let mut sum = out[i];
        for k in i + 1..m {
            sum -= factor[k * m + i] * out[k];
        }
        out[i] = sum / factor[i * m + i];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(x: f64, y: f64) -> Member {
        Member { velocity: V3::new(x, y, 0.0), normal: V3::z(), inverse_mass: 1.0 }
    }

    fn solve(members: &mut [Member], contacts: &[Contact], e: f64) -> Vec<f64> {
        let mut totals = vec![0.0; contacts.len()];
        assert!(resolve_cluster(members, contacts, |_| e, &mut totals, &mut Scratch::default()));
        totals
    }

    #[test]
    fn as_many_balls_leave_a_cradle_as_came_in() {
        let contacts: Vec<Contact> =
            (0..4).map(|i| Contact { a: i, b: Some(i + 1), line: V3::x() }).collect();
        for coming in 1..=3 {
            let mut members: Vec<Member> =
                (0..5).map(|i| flat(if i < coming { 1.0 } else { 0.0 }, 0.0)).collect();
            solve(&mut members, &contacts, 1.0);
            for (i, m) in members.iter().enumerate() {
                let want = if i >= 5 - coming { 1.0 } else { 0.0 };
                assert!((m.velocity.x - want).abs() < 1e-15, "{coming} in: ball {i} at {}", m.velocity.x);
            }
        }
    }

    #[test]
    fn a_ball_onto_two_touching_ones_rebounds_with_a_fifth() {
        let line = |sign: f64| V3::new(0.75_f64.sqrt(), 0.5 * sign, 0.0);
        let contacts =
            [Contact { a: 0, b: Some(1), line: line(1.0) }, Contact { a: 0, b: Some(2), line: line(-1.0) }];
        let mut members = [flat(1.0, 0.0), flat(0.0, 0.0), flat(0.0, 0.0)];
        solve(&mut members, &contacts, 1.0);
        assert!((members[0].velocity.x + 0.2).abs() < 1e-15);
        assert!((members[1].velocity.norm() - 2.0 * 3.0_f64.sqrt() / 5.0).abs() < 1e-15);
        assert!((members[1].velocity.y + members[2].velocity.y).abs() < 1e-15);
    }

    #[test]
    fn a_corner_turns_the_velocity_round() {
        let contacts = [Contact { a: 0, b: None, line: V3::x() }, Contact { a: 0, b: None, line: V3::y() }];
        let mut members = [flat(0.3, 0.7)];
        solve(&mut members, &contacts, 1.0);
        assert_eq!(members[0].velocity, V3::new(-0.3, -0.7, 0.0));
    }

    #[test]
    fn a_hit_on_a_slope_keeps_the_energy_and_the_tangent_plane() {
        let normal = V3::new(0.3, -0.2, 1.0).normalize();
        let other = V3::new(-0.1, 0.4, 1.0).normalize();
        let tangent = |v: V3, n: V3| v - n * v.dot(&n);
        let mut members = [
            Member { velocity: tangent(V3::new(1.0, 0.2, 0.0), normal), normal, inverse_mass: 0.7 },
            Member { velocity: tangent(V3::new(-0.5, 0.1, 0.0), other), normal: other, inverse_mass: 0.2 },
        ];
        let contact = Contact { a: 0, b: Some(1), line: V3::new(0.8, 0.1, 0.3).normalize() };
        let (before, closing) = (energy(&members), contact.closing(&members));
        assert!(resolve_one(&mut members, &contact, 1.0) > 0.0);
        // A dozen roundings of half an ulp.
        assert!((energy(&members) - before).abs() < 6.0 * f64::EPSILON * before);
        assert!((contact.closing(&members) + closing).abs() < 1e-15);
        assert!(members.iter().all(|m| m.velocity.dot(&m.normal).abs() < 1e-15));
    }

    fn energy(members: &[Member]) -> f64 {
        members.iter().map(|m| 0.5 * m.velocity.norm_squared() / m.inverse_mass).sum()
    }

    /// A light ball between a wall and one 1e12 times as heavy: the rounding of 1 + 1e-12 enters at every second hit.
    #[test]
    fn rounding_does_not_add_up_over_three_million_hits_of_the_same_two() {
        for light in [1.0, 1.0 / 1.4] {
            let heavy = Member { inverse_mass: 1e-12 * light, ..flat(-1.0, 0.0) };
            let mut members = [Member { inverse_mass: light, ..flat(0.0, 0.0) }, heavy];
            let wall = Contact { a: 0, b: None, line: -V3::x() };
            let ball = Contact { a: 0, b: Some(1), line: V3::x() };
            let before = energy(&members);
            let mut hits = 0;
            while resolve_one(&mut members, &ball, 1.0) > 0.0 {
                hits += 1 + i32::from(resolve_one(&mut members, &wall, 1.0) > 0.0);
            }
            let drift = energy(&members) / before - 1.0;
            assert_eq!(hits, 3_141_592);
            assert!(drift.abs() < 1e-12, "1/m = {light}: {drift:e}");
        }
    }

    #[test]
    fn unlike_restitutions_in_one_cluster_never_gain_energy() {
        // Two contacts 160 degrees apart, one elastic, one not: alternating them would gain energy.
        let (c, s) = (80.0_f64.to_radians().cos(), 80.0_f64.to_radians().sin());
        let contacts = [
            Contact { a: 0, b: None, line: V3::new(c, s, 0.0) },
            Contact { a: 0, b: None, line: V3::new(c, -s, 0.0) },
        ];
        let mut members = [flat(1.0, 0.05)];
        let mut totals = [0.0; 2];
        let e = |closing: f64| if closing > 0.2 { 1.0 } else { 0.0 };
        assert!(resolve_cluster(&mut members, &contacts, e, &mut totals, &mut Scratch::default()));
        assert!(members[0].velocity.norm_squared() <= 1.0 + 0.05 * 0.05);
    }
}
