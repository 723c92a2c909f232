//! A hit: land on it exactly, gather who touches, resolve, and put whoever was moved on a new arc.

use super::Controller;
use super::approach::{Due, Landed};
use crate::diagnostics::{Hit, HitPartner};
use crate::motion::arc::Path;
use crate::motion::law::State;
use crate::motion::together::Landing;
use crate::resolve::impact::{Contact, Member, hop, resolve_cluster, resolve_one};
use crate::schedule::time::{QUANTUM, Time};
use crate::tolerance::{
    CLUSTER_MAX, HOLD_SPEED, HOP_SPEED, POLISH, REST_HITS_MAX, REST_SPEED, SLOW_CLUSTER_MAX, TOUCH_CURVED,
    TOUCH_ULPS,
};
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// Whom a contact of the cluster joins, beside what the solver needs.
#[derive(Clone, Copy, Debug)]
struct Pair {
    ball: usize,
    partner: HitPartner,
}

/// The impact being resolved; its lists are reused.
#[derive(Clone, Debug, Default)]
pub(super) struct Cluster {
    landed: Vec<Landed>,
    members: Vec<Member>,
    before: Vec<V3>,
    pairs: Vec<Pair>,
    contacts: Vec<Contact>,
    impulses: Vec<f64>,
    /// Whether each member is to be held.
    held: Vec<bool>,
    found: Vec<usize>,
}

impl Cluster {
    /// With room for the largest impact, so that none allocates.
    pub(super) fn new() -> Self {
        let (balls, contacts) = (CLUSTER_MAX + 2, CLUSTER_MAX + 1);
        Self {
            landed: Vec::with_capacity(balls),
            members: Vec::with_capacity(balls),
            before: Vec::with_capacity(balls),
            pairs: Vec::with_capacity(contacts),
            contacts: Vec::with_capacity(contacts),
            impulses: Vec::with_capacity(contacts),
            held: Vec::with_capacity(balls),
            found: Vec::with_capacity(1024),
        }
    }

    fn clear(&mut self) {
        self.landed.clear();
        self.members.clear();
        self.pairs.clear();
        self.contacts.clear();
    }
}

impl Controller {
    /// Resolves a hit that is due.
    pub(super) fn collide(&mut self, hit: &mut Due) {
        self.land_on(hit);
        let (contact, depth) = self.contact(hit);
        self.report.deepest_penetration = self.report.deepest_penetration.max(depth);
        if !self.bounce(hit, &contact) {
            self.resolve_with_others(hit, contact);
        }
        self.close_foreseen();
    }

    /// Resolves a landed hit together with whatever else touches those who meet.
    #[inline(never)]
    fn resolve_with_others(&mut self, hit: &Due, contact: Contact) {
        let mut cluster = self.work.cluster.take().unwrap_or_default();
        cluster.clear();
        for landed in hit.landed() {
            self.enter(&mut cluster, *landed);
        }
        cluster.contacts.push(contact);
        cluster.pairs.push(Pair { ball: hit.ball, partner: hit.partner });
        self.resolve(cluster, hit.time, hit.event);
    }

    fn enter(&self, cluster: &mut Cluster, landed: Landed) {
        cluster.members.push(self.member(&landed));
        cluster.landed.push(landed);
    }

    /// Resolves the cluster around its first contact at `time`, which was predicted for `event`.
    fn resolve(&mut self, mut cluster: Box<Cluster>, time: Time, event: Time) {
        let now = time.max(event);
        self.now = self.now.max(now);
        let slow = cluster.contacts[0].closing(&cluster.members) <= REST_SPEED;
        if slow {
            self.report.rest_hits += 1;
        }
        self.gather(&mut cluster, time, if slow { SLOW_CLUSTER_MAX } else { CLUSTER_MAX });
        for landed in &cluster.landed {
            self.will_change(landed.ball);
            self.reads_neighbours(landed.ball);
        }
        if slow {
            // A slow hit does not move a ball that is held, be it hit itself or a neighbour.
            for (landed, member) in cluster.landed.iter().zip(&mut cluster.members) {
                if self.arcs[landed.ball].path == Path::Held {
                    member.inverse_mass = 0.0;
                }
            }
        }
        cluster.before.clear();
        cluster.before.extend(cluster.members.iter().map(|m| m.velocity));
        let elastic = if slow { 0.0 } else { self.restitution };
        cluster.held.clear();
        cluster.held.resize(cluster.members.len(), false);
        cluster.impulses.clear();
        cluster.impulses.resize(cluster.contacts.len(), 0.0);
        if cluster.contacts.len() == 1 {
            cluster.impulses[0] = resolve_one(&mut cluster.members, &cluster.contacts[0], elastic);
        } else {
            self.report.clusters += 1;
            let e = |closing: f64| if closing <= REST_SPEED { 0.0 } else { elastic };
            let Cluster { members, contacts, impulses, .. } = &mut *cluster;
            if !resolve_cluster(members, contacts, e, impulses, &mut self.work.scratch) {
                self.report.fallbacks += 1;
            }
        }
        self.record_all(&cluster, time);
        self.count_hits(&mut cluster, time, slow);
        self.relaunch_moved(&mut cluster, time, now);
        cluster.landed.iter().for_each(|landed| self.has_changed(landed.ball));
        self.work.cluster = Some(cluster);
    }

    /// Adds to the cluster every ball and wall that touches a member, and theirs, up to `most` contacts.
    fn gather(&self, cluster: &mut Cluster, time: Time, most: usize) {
        let mut place = 0;
        while place < cluster.landed.len() {
            let (ball, center) = (cluster.landed[place].ball, cluster.landed[place].at.center);
            let radius = self.balls[ball].body.radius;
            for (wall, plane) in self.walls.iter().enumerate() {
                let known =
                    cluster.pairs.iter().any(|p| p.ball == ball && p.partner == HitPartner::Wall(wall));
                if !known
                    && plane.distance(&center) - radius <= self.touch(ball, &center)
                    && cluster.contacts.len() < most
                {
                    cluster.contacts.push(Contact { a: place, b: None, line: -plane.normal });
                    cluster.pairs.push(Pair { ball, partner: HitPartner::Wall(wall) });
                }
            }
            let mut found = std::mem::take(&mut cluster.found);
            found.clear();
            self.broad_phase.neighbours(ball, |other| {
                let arc = &self.arcs[other];
                let apart = arc.center_at(time.since(arc.start)) - center;
                let reach = radius + arc.radius + POLISH;
                if apart.norm_squared() <= reach * reach {
                    found.push(other);
                }
            });
            found.sort_unstable();
            for other in &found {
                if cluster.contacts.len() < most {
                    self.join(cluster, place, *other, time);
                }
            }
            cluster.found = found;
            place += 1;
        }
    }

    /// Adds the contact of member `place` with ball `other` if they touch and it is new.
    fn join(&self, cluster: &mut Cluster, place: usize, other: usize, time: Time) {
        let (ball, center) = (cluster.landed[place].ball, cluster.landed[place].at.center);
        let known = cluster.landed.iter().position(|l| l.ball == other);
        if known.is_some_and(|k| k < place) {
            return;
        }
        let pair = Pair { ball: ball.min(other), partner: HitPartner::Ball(ball.max(other)) };
        if cluster.pairs.iter().any(|p| p.ball == pair.ball && p.partner == pair.partner) {
            return;
        }
        let landed = known.map_or_else(|| self.land(other, time), |k| cluster.landed[k]);
        let apart = landed.at.center - center;
        let reach = self.balls[ball].body.radius + self.balls[other].body.radius;
        let distance = apart.norm();
        if distance - reach > self.touch(ball, &center) {
            return;
        }
        let b = known.unwrap_or_else(|| {
            self.enter(cluster, landed);
            cluster.landed.len() - 1
        });
        // The line runs from the smaller id to the larger, so that sums do not depend on who was found first.
        let (a, b, sign) = if ball < other { (place, b, 1.0) } else { (b, place, -1.0) };
        cluster.contacts.push(Contact { a, b: Some(b), line: apart * (sign / distance) });
        cluster.pairs.push(pair);
    }

    /// Gap below which things count as touching a ball at `center`, m. A parabola is rounded where it begins as well.
    pub(super) fn touch(&self, ball: usize, center: &V3) -> f64 {
        let (size, ulp) = (center.amax(), TOUCH_ULPS * f64::EPSILON);
        if self.surface.is_flat() {
            return ulp * size.max(self.arcs[ball].center[0].amax());
        }
        (ulp * size).max(TOUCH_CURVED * (1.0 + size))
    }

    fn record_all(&mut self, cluster: &Cluster, time: Time) {
        for ((contact, pair), impulse) in cluster.contacts.iter().zip(&cluster.pairs).zip(&cluster.impulses) {
            let at = &cluster.landed[contact.a];
            let point = at.at.center + contact.line * self.balls[at.ball].body.radius;
            self.record(&Hit { time, ball: pair.ball, partner: pair.partner, point, impulse: *impulse });
        }
    }

    /// Relaunches the two of the first contact and whoever else was moved, and looks ahead from `now` for all of them.
    fn relaunch_moved(&mut self, cluster: &mut Cluster, time: Time, now: Time) {
        let hit = cluster.contacts[0];
        cluster.found.clear();
        let mut waiting = None;
        for (place, member) in cluster.members.iter().enumerate() {
            let first = place == hit.a || Some(place) == hit.b;
            if !first && member.velocity == cluster.before[place] {
                continue;
            }
            let Landed { ball, at: Landing { mut state, .. } } = cluster.landed[place];
            cluster.found.push(ball);
            if member.inverse_mass == 0.0 {
                // Held before, and still.
                continue;
            }
            if cluster.held[place] {
                state[2..5].copy_from_slice(member.velocity.as_slice());
                self.hold(ball, time, &state);
            } else {
                self.send_off(ball, time, (state, &member.velocity), &mut waiting);
            }
        }
        self.send_last(time, waiting);
        for ball in cluster.found.drain(..) {
            self.predict(ball, now);
        }
    }

    /// Counts the hit. Balls that had too many slow ones in this quantum are held if they are slow themselves; if
    /// one of the two is fast, the pair hops, so that a pressed ball keeps its way and its momentum. Too many of any
    /// kind hold it in any case: that bounds the work of a quantum.
    fn count_hits(&mut self, cluster: &mut Cluster, time: Time, slow: bool) {
        let (mut too_many_slow, mut too_many) = (false, false);
        for landed in &cluster.landed {
            let (hits, rest_hits) = self.balls[landed.ball].count_hit(time.quantum(), slow);
            too_many_slow |= slow && rest_hits > REST_HITS_MAX;
            too_many |= hits > self.hit_budget;
        }
        if !too_many_slow && !too_many {
            return;
        }
        let hit = cluster.contacts[0];
        let mut both = std::iter::once(hit.a).chain(hit.b);
        let calm = both.clone().all(|place| cluster.members[place].velocity.norm() <= HOLD_SPEED);
        if calm || too_many {
            both.by_ref().for_each(|place| cluster.held[place] = true);
        } else {
            self.report.fallbacks += 1;
            hop(&mut cluster.members, &cluster.contacts[0], HOP_SPEED);
        }
    }

    /// Lets a ball stand until the quantum ends. Its kinetic energy is lost; nothing is gained, nothing overlaps.
    fn hold(&mut self, ball: usize, time: Time, state: &State) {
        self.close_arc(ball, time);
        self.report.fallbacks += 1;
        let arc = &mut self.arcs[ball];
        let length = Time::of_quantum(time.quantum()).after(QUANTUM).since(time);
        let b = &mut self.balls[ball];
        arc.stamp = arc.stamp.wrapping_add(1);
        b.body.hold(&self.surface, (time, state), length, arc);
    }
}
