//! Who drives which ball. It all happens before the simulation: what reaches the tick loop is plain steering, so that a
//! run stays a function of scene, seed and commands by tick. No tick waits for anything here.
//!
//! A claim begins and ends with a steering command that stops its ball, and its answer: whoever steered the ball before
//! has acted by then, and when it is free again, whatever the last player sent has acted or was refused.
//!
//! | file | what |
//! |---|---|
//! | `balls` | which ball a claim means, and why it cannot be had |
//! | `held` | one claim: which commands have come, and what became of them |
//! | `tally` | which numbered messages have come |

mod balls;
mod held;
mod tally;

use crate::inbox::{Answer, Inbox, Refused, Request};
use crate::ready::Ready;
use crate::simulation::{NumberedHit, Stage};
use crate::wanted::When;
use ballroom_physics::HitPartner;
use balls::{free_ball, holder, is_players, players_balls, taken, wanted_ball};
use held::Held;
use protocol::command::{Command, Direction, DirectionName, Refusal, Reply, SteerMode, code};
use protocol::keys::Name;
use protocol::player::{
    Ack, Acted, Claim, Claimed, Drive, LEASE_MILLIS, MAX_PLAYERS, PlayerRow, Players as Listing, Release,
    Sent, Token,
};
use protocol::snapshot::Roster;
use std::cmp::{Ordering, Reverse};
use std::collections::BTreeMap;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Messages under one player's name a second, and at once.
pub const MESSAGES_PER_S: f64 = 1000.0;
/// Commands of one player a second, and at once; what comes beyond waits with the player.
pub const DRIVES_PER_S: f64 = 120.0;
/// Time between two looks at who is silent.
pub const LOOK_EVERY: Duration = Duration::from_millis(100);
/// Looks that find no message until a player has lost its ball. Looks are counted, not time: a server that was held up
/// does not take that for the silence of its players.
const LEASE_LOOKS: u32 = (LEASE_MILLIS / LOOK_EVERY.as_millis() as u64) as u32;

/// How the answer to a claim reaches whoever asked.
pub type OnClaimed = Box<dyn FnOnce(Claimed) + Send>;

/// All claims of an arena.
pub struct Players {
    inbox: Arc<Inbox>,
    claims: Mutex<Claims>,
    news: Condvar,
}

#[derive(Default)]
struct Claims {
    held: BTreeMap<Name, Held>,
    /// How many there have been.
    count: u64,
    /// Last acknowledgements still to be sent.
    farewells: Vec<(Name, Ack)>,
    closed: bool,
}

impl Claims {
    fn get(&mut self, player: &Name, claim: u64) -> Option<&mut Held> {
        self.held.get_mut(player).filter(|held| held.id == claim)
    }

    /// The claim of a player who proves it.
    fn proven(&mut self, player: &Name, token: &Token) -> Result<&mut Held, Refusal> {
        let held = self.held.get_mut(player).filter(|held| held.ending.is_none() && held.is_given(token));
        held.ok_or_else(|| not_held(player))
    }
}

fn not_held(player: &Name) -> Refusal {
    Refusal::new(code::NOT_FOUND, format!("{player} holds no ball by this token: claim one"))
}

impl Players {
    /// Nobody, in front of an inbox.
    pub fn new(inbox: Arc<Inbox>) -> Self {
        Self { inbox, claims: Mutex::default(), news: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, Claims> {
        self.claims.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives a player a ball, once everything that steered it before has acted.
    pub fn claim(self: &Arc<Self>, claim: Claim, stage: &Stage, answer: OnClaimed) {
        let player = claim.player.clone();
        let (id, ball) = match self.enter(claim, stage) {
            Ok(entered) => entered,
            Err(why) => return answer(Claimed { reply: why.into(), grant: None }),
        };
        let players = self.clone();
        self.stop_ball(ball, Box::new(move |reply| answer(players.grant(&player, id, reply))));
    }

    /// Writes a claim down, if it can be granted.
    fn enter(&self, Claim { player, ball }: Claim, stage: &Stage) -> Result<(u64, String), Refusal> {
        let mut bits = [0; 16];
        getrandom::fill(&mut bits)
            .map_err(|e| Refusal::new(code::OPERATION_FAILED, format!("no token can be drawn: {e}")))?;
        let mut claims = self.lock();
        if let Some(held) = claims.held.get(&player) {
            let why =
                format!("{player} drives {:?} already: take another name, or release it first", held.ball);
            return Err(Refusal::new(code::INCORRECT_STATE, why));
        }
        if claims.held.len() >= MAX_PLAYERS {
            return Err(Refusal::new(code::TOO_MANY, format!("{MAX_PLAYERS} players play already")));
        }
        let ball = match ball {
            Some(ball) => wanted_ball(&claims.held, stage, ball)?,
            None => free_ball(&claims.held, stage)?,
        };
        claims.count += 1;
        let id = claims.count;
        let held = Held::new(id, ball.clone(), Token::from_bits(u128::from_ne_bytes(bits)), Instant::now());
        claims.held.insert(player, held);
        Ok((id, ball))
    }

    /// Completes a claim whose ball was stopped, or takes it back.
    fn grant(&self, player: &Name, id: u64, reply: &Reply) -> Claimed {
        let mut claims = self.lock();
        if !reply.ok {
            if claims.get(player, id).is_some() {
                claims.held.remove(player);
            }
            return Claimed { reply: reply.clone(), grant: None };
        }
        let grant = claims.get(player, id).map(|held| {
            held.silent_looks = 0;
            held.grant(player.clone())
        });
        Claimed { reply: reply.clone(), grant }
    }

    /// Takes a ball back from a player who gives it back; answered when it is free.
    pub fn release(self: &Arc<Self>, Release { player, token }: &Release, answer: Answer) {
        let id = self.lock().proven(player, token).map(|held| held.id);
        match id {
            Ok(id) => self.end(player, id, "released", Some(answer)),
            Err(why) => answer(&why.into()),
        }
    }

    /// A player's token of liveliness is gone.
    pub fn left(self: &Arc<Self>, player: &Name) {
        let id = self.lock().held.get(player).map(|held| held.id);
        if let Some(id) = id {
            self.end(player, id, "its session ended", None);
        }
    }

    /// Ends a claim: nothing more is taken, what waits is refused, the ball is stopped, and then free.
    fn end(self: &Arc<Self>, player: &Name, id: u64, why: &str, answer: Option<Answer>) {
        let ball = {
            let mut claims = self.lock();
            let Some(held) = claims.get(player, id).filter(|held| held.ending.is_none()) else {
                drop(claims);
                if let Some(answer) = answer {
                    answer(&not_held(player).into());
                }
                return;
            };
            held.ending = Some(why.to_owned());
            held.ball.clone()
        };
        tracing::info!("{player} no longer drives {ball:?}: {why}");
        for request in self.inbox.withdraw(id) {
            self.inbox.count_refused();
            if let Some(tell) = request.answer {
                tell(&Refusal::new(code::INTERRUPTED, why).into());
            }
        }
        let (players, player) = (self.clone(), player.clone());
        let done: Answer = Box::new(move |reply| {
            players.free(&player, id);
            if let Some(answer) = answer {
                answer(reply);
            }
        });
        self.stop_ball(ball, done);
    }

    fn free(&self, player: &Name, id: u64) {
        let mut claims = self.lock();
        if let Some(held) = claims.get(player, id) {
            let farewell = held.farewell();
            claims.held.remove(player);
            // Nobody waits for more of them than there can be players.
            if claims.farewells.len() < MAX_PLAYERS {
                claims.farewells.push((player.clone(), farewell));
            }
        }
        drop(claims);
        self.news.notify_one();
    }

    /// Ends a held force; `done` is told when, or why not, and then every earlier command has acted.
    fn stop_ball(&self, ball: String, done: Answer) {
        let stop = Direction::Named(DirectionName::Stop);
        let command = Command::Steer { ball: Some(ball), direction: stop, mode: SteerMode::Force };
        if let Err(Refused { answer, why }) =
            self.inbox.offer(Request { command, ready: Ready::Nothing, answer: Some(done) })
        {
            self.inbox.count_refused();
            if let Some(done) = answer {
                done(&why.into());
            }
        }
    }

    /// Takes a message of a player: what is new in it goes to its tick.
    pub fn drive(self: &Arc<Self>, player: &Name, bytes: &[u8]) -> Result<(), Refusal> {
        let now = Instant::now();
        // Before it is read: refusing must be cheap.
        let may_speak = self.lock().held.get_mut(player).map(|held| held.messages.take(now));
        if !may_speak.ok_or_else(|| not_held(player))? {
            let why = format!("too many messages: send at most {MESSAGES_PER_S} a second");
            return Err(Refusal::new(code::TOO_MANY, why));
        }
        let drive = Drive::from_json(bytes).map_err(|e| Refusal::new(code::MALFORMED, e.to_string()))?;
        let mut claims = self.lock();
        let held = claims.proven(player, &drive.token)?;
        held.hear(&drive);
        for sent in &drive.sent {
            match sent.seq.cmp(&held.next_seq) {
                Ordering::Less => {}
                // Something is missing before it, or there is no room: it will be sent again.
                Ordering::Greater => break,
                Ordering::Equal if !held.has_room(now) => break,
                Ordering::Equal => {
                    if !self.pass_on(player, held, sent) {
                        break;
                    }
                }
            }
        }
        drop(claims);
        self.news.notify_one();
        Ok(())
    }

    /// Passes the expected command on to its tick, or refuses it for good; false when there is no room at present.
    fn pass_on(self: &Arc<Self>, player: &Name, held: &mut Held, sent: &Sent) -> bool {
        let Sent { seq, tick, epoch, direction, mode } = *sent;
        let (players, id, player) = (self.clone(), held.id, player.clone());
        let answer: Answer = Box::new(move |reply| players.acted(&player, id, Acted::of(seq, reply)));
        let command = Command::Steer { ball: Some(held.ball.clone()), direction, mode };
        let request = Request { command, ready: Ready::Nothing, answer: Some(answer) };
        match self.inbox.offer_at(id, When { tick, epoch }, request) {
            Ok(()) => held.take_next(),
            Err(why) if why.code == code::TOO_MANY => return false,
            Err(why) => {
                self.inbox.count_refused();
                held.refuse_next(Acted::of(seq, &why.into()));
            }
        }
        true
    }

    fn acted(&self, player: &Name, id: u64, acted: Acted) {
        if let Some(held) = self.lock().get(player, id) {
            held.acted(acted);
        }
        self.news.notify_one();
    }

    /// Whether a ball may be steered by anybody, and why not. Without a name the scene's first player's ball is meant.
    pub fn allow_anyone(&self, ball: Option<&str>, stage: impl FnOnce() -> Stage) -> Result<(), Refusal> {
        let claims = self.lock();
        if claims.held.is_empty() {
            return Ok(());
        }
        let first = if ball.is_none() { players_balls(&stage()).into_iter().next() } else { None };
        let Some(ball) = ball.or(first.as_deref()) else { return Ok(()) };
        holder(&claims.held, ball).map_or(Ok(()), |player| Err(taken(ball, player)))
    }

    /// Counts hits of claimed balls.
    pub fn count_hits(&self, hits: &[NumberedHit], roster: &Roster) {
        let mut claims = self.lock();
        let mut claimed: Vec<(usize, &mut Held)> = claims
            .held
            .values_mut()
            .filter_map(|held| Some((roster.names.binary_search(&held.ball).ok()?, held)))
            .collect();
        claimed.sort_unstable_by_key(|(ball, _)| *ball);
        let mut count = |ball: usize, partner: HitPartner| {
            if let Ok(i) = claimed.binary_search_by_key(&ball, |(ball, _)| *ball) {
                let hits = &mut claimed[i].1.hits;
                match partner {
                    HitPartner::Ball(_) => hits.ball_ball += 1,
                    HitPartner::Wall(_) => hits.ball_wall += 1,
                }
            }
        };
        for NumberedHit { hit, .. } in hits {
            count(hit.ball, hit.partner);
            if let HitPartner::Ball(other) = hit.partner {
                count(other, hit.partner);
            }
        }
    }

    /// Who plays.
    pub fn listing(&self) -> Listing {
        let claims = self.lock();
        let look_s = LOOK_EVERY.as_secs_f64();
        let mut players: Vec<PlayerRow> =
            claims.held.iter().map(|(player, held)| held.row(player.clone(), look_s)).collect();
        drop(claims);
        let mut hits: Vec<u64> = players.iter().map(|row| row.hits.ball_ball).collect();
        hits.sort_unstable_by_key(|hits| Reverse(*hits));
        for row in &mut players {
            row.rank = 1 + hits.partition_point(|more| *more > row.hits.ball_ball);
        }
        Listing { players }
    }

    /// Takes the ball from everyone who has been silent for too long or whose ball is gone; to be called every
    /// [`LOOK_EVERY`].
    pub fn look(self: &Arc<Self>, stage: impl FnOnce() -> Stage) {
        let mut claims = self.lock();
        if claims.held.is_empty() {
            return;
        }
        let roster = stage().roster;
        let mut over = Vec::new();
        for (player, held) in claims.held.iter_mut().filter(|(_, held)| held.ending.is_none()) {
            held.silent_looks += 1;
            if held.silent_looks >= LEASE_LOOKS {
                over.push((player.clone(), held.id, format!("silent for {LEASE_MILLIS} ms")));
            } else if !is_players(&roster, &held.ball) {
                over.push((player.clone(), held.id, "the ball is gone".to_owned()));
            }
        }
        drop(claims);
        for (player, id, why) in over {
            self.end(&player, id, &why, None);
        }
    }

    /// Ends waiting for acknowledgements, for ever.
    pub fn close(&self) {
        self.lock().closed = true;
        self.news.notify_all();
    }

    /// Acknowledgements that are due, waiting for one until `deadline`; none once closed.
    pub fn acks(&self, deadline: Instant) -> Option<Vec<(Name, Ack)>> {
        let mut claims = self.lock();
        loop {
            if claims.closed {
                return None;
            }
            let mut acks = std::mem::take(&mut claims.farewells);
            let due = |(player, held): (&Name, &mut Held)| Some((player.clone(), held.take_ack()?));
            acks.extend(claims.held.iter_mut().filter_map(due));
            let left = deadline.saturating_duration_since(Instant::now());
            if !acks.is_empty() || left == Duration::ZERO {
                return Some(acks);
            }
            claims = self.news.wait_timeout(claims, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

#[cfg(test)]
mod tests;
