//! Elastic contacts of one instant resolved one after the other, where their order does not matter.
//!
//! Equal balls in a row, a corner of 90 or 60 degrees and contacts that have nothing to do with each other end with the
//! same velocities whichever pair hits first: the limit of hits that are ever less apart in time is then well defined,
//! and it is the answer. Reflections about the whole set of contacts are exact for symmetric impacts only.

use super::impact::{Contact, Member, Scratch, resolve_one};
use crate::tolerance::{IN_TURN_HITS_MAX, SAME_OUTCOME};

/// Resolves elastic contacts in their order and in the opposite one. True if both end alike; otherwise nothing is changed.
pub fn resolve_in_turn(
    members: &mut [Member],
    contacts: &[Contact],
    satisfied: f64,
    totals: &mut [f64],
    scratch: &mut Scratch,
) -> bool {
    let Scratch { start, backward, .. } = scratch;
    start.clear();
    start.extend(members.iter().map(|m| m.velocity));
    if !take_turns(members, contacts, satisfied, totals, true) {
        restore(members, totals, start);
        return false;
    }
    backward.clear();
    backward.extend(members.iter().map(|m| m.velocity));
    restore(members, totals, start);
    let fastest = start.iter().map(nalgebra::Vector3::norm_squared).fold(0.0, f64::max);
    let alike = take_turns(members, contacts, satisfied, totals, false)
        && members
            .iter()
            .zip(backward.iter())
            .all(|(m, other)| (m.velocity - other).norm_squared() <= SAME_OUTCOME * SAME_OUTCOME * fastest);
    if !alike {
        restore(members, totals, start);
    }
    alike
}

fn restore(members: &mut [Member], totals: &mut [f64], start: &[nalgebra::Vector3<f64>]) {
    totals.fill(0.0);
    for (member, velocity) in members.iter_mut().zip(start) {
        member.velocity = *velocity;
    }
}

/// Resolves the first contact that closes, or the last, again and again; false if that does not end soon.
fn take_turns(
    members: &mut [Member],
    contacts: &[Contact],
    satisfied: f64,
    totals: &mut [f64],
    backward: bool,
) -> bool {
    for _ in 0..IN_TURN_HITS_MAX {
        let closes = |i: &usize| contacts[*i].closing(members) > satisfied;
        let mut places = 0..contacts.len();
        let Some(i) = (if backward { places.rfind(closes) } else { places.find(closes) }) else {
            return true;
        };
        let impulse = resolve_one(members, &contacts[i], 1.0);
        if impulse == 0.0 {
            return false;
        }
        totals[i] += impulse;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn flat(velocity: [f64; 2]) -> Member {
        Member {
            velocity: Vector3::new(velocity[0], velocity[1], 0.0),
            normal: Vector3::z(),
            inverse_mass: 1.0,
        }
    }

    fn solve(members: &mut [Member], contacts: &[Contact]) -> bool {
        let mut totals = vec![0.0; contacts.len()];
        resolve_in_turn(members, contacts, 1e-14, &mut totals, &mut Scratch::default())
    }

    #[test]
    fn equal_balls_in_a_row_leave_in_the_order_of_their_speeds() {
        let contacts: Vec<Contact> =
            (0..3).map(|i| Contact { a: i, b: Some(i + 1), line: Vector3::x() }).collect();
        let mut members = [2.0, 0.0, -1.0, -1.5].map(|v| flat([v, 0.5]));
        assert!(solve(&mut members, &contacts));
        for (member, exact) in members.iter().zip([-1.5, -1.0, 0.0, 2.0]) {
            assert!((member.velocity - Vector3::new(exact, 0.5, 0.0)).norm() < 1e-15, "{member:?}");
        }
    }

    #[test]
    fn impacts_that_depend_on_the_order_are_left_alone() {
        let line = |sign: f64| Vector3::new(0.75_f64.sqrt(), 0.5 * sign, 0.0);
        let contacts =
            [Contact { a: 0, b: Some(1), line: line(1.0) }, Contact { a: 0, b: Some(2), line: line(-1.0) }];
        let mut members = [[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]].map(flat);
        assert!(!solve(&mut members, &contacts));
        assert_eq!(members[0].velocity, Vector3::x());
    }

    #[test]
    fn a_corner_of_60_degrees_turns_a_velocity_as_its_mirrors_do() {
        // Three reflections about lines through a point, 60 degrees apart, are one about the line halfway.
        let (s, c) = (0.75_f64.sqrt(), 0.5);
        let wall = |x, y| Contact { a: 0, b: None, line: Vector3::new(x, y, 0.0) };
        let mut members = [flat([-0.9, -0.3])];
        assert!(solve(&mut members, &[wall(0.0, -1.0), wall(-s, c)]));
        let axis = Vector3::new(s, c, 0.0);
        let before = Vector3::new(-0.9, -0.3, 0.0);
        let exact = before - axis * (2.0 * before.dot(&axis));
        assert!((members[0].velocity - exact).norm() < 1e-15, "{members:?} for {exact}");
    }
}
