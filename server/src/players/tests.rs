use super::*;
use crate::scene_file::SceneText;
use crate::simulation::Simulation;
use crate::wanted::Moment;
use protocol::player::{Grant, MAX_WINDOW};
use std::sync::mpsc::{Receiver, channel};

const TWO: &str = r#"
version = 1
name = "two"
floor.polynomial = { x_m = [-9.0, 9.0], y_m = [-9.0, 9.0] }
ball = [
  { name = "zebra", radius_m = 0.5, mass_kg = 1.0, center_m = [0.0, 0.0], player = true },
  { name = "red", radius_m = 0.5, mass_kg = 1.0, center_m = [3.0, 0.0], player = true },
  { name = "plain", radius_m = 0.5, mass_kg = 1.0, center_m = [-3.0, 0.0] },
]
"#;

/// Players in front of an inbox, and in place of the tick loop something that notes what reaches it.
struct Table {
    players: Arc<Players>,
    inbox: Arc<Inbox>,
    stage: Stage,
    now: Moment,
    /// Tick, ball and mode of every steering command but stops.
    steered: Vec<(u64, String)>,
    stopped: Vec<String>,
}

impl Table {
    fn new() -> Self {
        let loaded = SceneText::new("two", TWO.to_owned()).load().unwrap();
        let stage = Simulation::new(Arc::new(loaded), 60, 1).unwrap().stage();
        let inbox = Arc::new(Inbox::default());
        let players = Arc::new(Players::new(inbox.clone()));
        let mut table = Self {
            players,
            inbox,
            stage,
            now: Moment { epoch: 1, tick: 100 },
            steered: Vec::new(),
            stopped: Vec::new(),
        };
        table.boundary();
        table
    }

    /// What the tick loop does between two ticks.
    fn boundary(&mut self) {
        let mut due = Vec::new();
        self.inbox.drain_into(&mut due, self.now);
        for request in due {
            let Command::Steer { ball: Some(ball), direction, .. } = request.command else { panic!() };
            if direction == Direction::Named(DirectionName::Stop) {
                self.stopped.push(ball);
            } else {
                self.steered.push((self.now.tick, ball));
            }
            let reply = Reply::of(Ok(()), self.now.tick, self.now.epoch);
            request.answer.into_iter().for_each(|tell| tell(&reply));
        }
    }

    fn tick(&mut self) {
        self.now.tick += 1;
        self.boundary();
    }

    fn ask(&self, player: &str, ball: Option<&str>) -> Receiver<Claimed> {
        let (sender, claimed) = channel();
        let claim = Claim { player: name(player), ball: ball.map(str::to_owned) };
        self.players.claim(claim, &self.stage, Box::new(move |answer| sender.send(answer).unwrap()));
        claimed
    }

    fn claim(&mut self, player: &str, ball: Option<&str>) -> Result<Seat, Reply> {
        let claimed = self.ask(player, ball);
        self.boundary();
        let Claimed { reply, grant } = claimed.try_recv().unwrap();
        grant.map(|grant| Seat { grant, number: 0 }).ok_or(reply)
    }

    fn release(&mut self, seat: &Seat) -> Reply {
        let (sender, replied) = channel();
        let release = Release { player: seat.grant.player.clone(), token: seat.grant.token.clone() };
        self.players.release(&release, Box::new(move |reply| sender.send(reply.clone()).unwrap()));
        self.boundary();
        replied.try_recv().unwrap()
    }

    /// The newest acknowledgement of a player.
    fn ack(&self, player: &str) -> Ack {
        let acks = self.players.acks(Instant::now()).unwrap();
        acks.into_iter().rfind(|(who, _)| who.as_str() == player).unwrap().1
    }

    fn look(&self, times: u32) {
        (0..times).for_each(|_| self.players.look(|| self.stage.clone()));
    }
}

/// A player as a client is one.
struct Seat {
    grant: Grant,
    number: u64,
}

impl Seat {
    fn message(&mut self, acked: u64, sent: &[(u64, Option<u64>)]) -> Vec<u8> {
        self.number += 1;
        let up = Direction::Named(DirectionName::Up);
        let sent = sent.iter().map(|&(seq, tick)| Sent {
            seq,
            tick,
            epoch: None,
            direction: up,
            mode: SteerMode::Impulse,
        });
        let token = self.grant.token.clone();
        let drive = Drive { token, number: self.number, acked, latency_ms: None, sent: sent.collect() };
        serde_json::to_vec(&drive).unwrap()
    }

    fn drive(&mut self, table: &Table, acked: u64, sent: &[(u64, Option<u64>)]) -> Result<(), Refusal> {
        let message = self.message(acked, sent);
        table.players.drive(&self.grant.player, &message)
    }
}

fn name(text: &str) -> Name {
    text.parse().unwrap()
}

fn ticks(acked: &Ack) -> Vec<(u64, u64)> {
    acked.acted.iter().map(|acted| (acted.seq, acted.tick)).collect()
}

#[test]
fn a_ball_has_one_player_and_a_player_one_ball() {
    let mut table = Table::new();
    let ann = table.claim("ann", Some("red")).ok().unwrap();
    assert_eq!((ann.grant.ball.as_str(), ann.grant.lease_s), ("red", 2.0));
    let why = table.claim("bob", Some("red")).err().unwrap();
    assert_eq!((why.code, why.error.as_str()), (code::INCORRECT_STATE, "\"red\" is driven by ann"));
    let why = table.claim("ann", Some("zebra")).err().unwrap();
    assert!(why.error.contains("ann drives \"red\" already"), "{why:?}");
    for ball in ["plain", "ghost"] {
        let why = table.claim("bob", Some(ball)).err().unwrap();
        assert!(why.code == code::NOT_FOUND && why.error.ends_with("those are zebra, red"), "{why:?}");
    }
    // The first free one, in the scene's order.
    assert_eq!(table.claim("bob", None).ok().unwrap().grant.ball, "zebra");
    let why = table.claim("cy", None).err().unwrap();
    assert!(why.error.contains("no ball is free: \"red\" by ann, \"zebra\" by bob"), "{why:?}");
    assert!(table.release(&ann).ok);
    assert_eq!(table.claim("cy", None).ok().unwrap().grant.ball, "red");
}

#[test]
fn each_command_acts_once_in_order_at_its_tick_however_often_and_late_it_comes() {
    let mut table = Table::new();
    let mut ann = table.claim("ann", Some("red")).ok().unwrap();
    let (first, second) = (
        ann.message(0, &[(1, None), (2, Some(103))]),
        ann.message(0, &[(1, None), (2, Some(103)), (3, Some(102))]),
    );
    let player = name("ann");
    // The second message overtakes the first, and both come twice.
    for message in [&second, &first, &second, &first] {
        table.players.drive(&player, message).unwrap();
    }
    table.boundary();
    assert_eq!(ticks(&table.ack("ann")), [(1, 100)]);
    for _ in 0..5 {
        table.tick();
        table.players.drive(&player, &first).unwrap();
    }
    assert_eq!(table.steered, [(100, "red".into()), (103, "red".into()), (103, "red".into())]);
    let ack = table.ack("ann");
    assert_eq!((ticks(&ack), ack.next_seq), (vec![(1, 100), (2, 103), (3, 103)], 4));
    // What the player knows is not said again, even when an old message comes after that.
    ann.drive(&table, 2, &[(3, Some(102))]).unwrap();
    table.players.drive(&player, &first).unwrap();
    assert_eq!(ticks(&table.ack("ann")), [(3, 103)]);
    let row = &table.players.listing().players[0];
    assert_eq!((row.commands, row.refused, row.messages, row.lost, row.repeated), (3, 0, 3, 0, 8));
}

#[test]
fn a_gap_is_waited_for_and_what_is_too_far_ahead_is_refused() {
    let mut table = Table::new();
    let mut ann = table.claim("ann", Some("red")).ok().unwrap();
    ann.drive(&table, 0, &[(2, None)]).unwrap();
    table.boundary();
    assert!(table.steered.is_empty());
    ann.drive(&table, 0, &[(1, Some(9_999_999)), (2, None)]).unwrap();
    table.boundary();
    let ack = table.ack("ann");
    assert_eq!(
        (table.steered.len(), ack.acted[0].code, ack.acted[1].code),
        (1, code::OPERATION_FAILED, code::OK)
    );
    assert!(ack.acted[0].error.contains("too far ahead"), "{ack:?}");
}

#[test]
fn a_forged_token_drives_nothing_and_keeps_nobody_alive() {
    let mut table = Table::new();
    let ann = table.claim("ann", Some("red")).ok().unwrap();
    let token = Token::from_bits(12345);
    let mut forged = Seat { grant: Grant { token: token.clone(), ..ann.grant.clone() }, number: 0 };
    for _ in 0..LEASE_LOOKS {
        let why = forged.drive(&table, 0, &[(1, None)]).unwrap_err();
        assert_eq!(why.code, code::NOT_FOUND);
        table.look(1);
    }
    assert!(!table.release(&forged).ok);
    table.boundary();
    assert!(table.steered.is_empty() && table.players.listing().players.is_empty());
    let mut stranger = Seat { grant: Grant { player: name("bob"), token, ..ann.grant }, number: 0 };
    assert_eq!(stranger.drive(&table, 0, &[(1, None)]).unwrap_err().code, code::NOT_FOUND);
}

#[test]
fn a_silent_player_loses_its_ball_and_what_waits_never_acts() {
    let mut table = Table::new();
    let mut ann = table.claim("ann", Some("red")).ok().unwrap();
    ann.drive(&table, 0, &[(1, None), (2, Some(105))]).unwrap();
    table.boundary();
    table.look(LEASE_LOOKS - 1);
    assert!(ann.drive(&table, 0, &[]).is_ok(), "a word in time keeps it");
    table.look(LEASE_LOOKS - 1);
    assert_eq!(table.players.listing().players.len(), 1);
    table.look(1);
    assert!(ann.drive(&table, 0, &[(1, None), (2, None), (3, None)]).is_err());
    // Not free before it is stopped.
    assert!(table.ask("bob", Some("red")).try_recv().unwrap().grant.is_none());
    (0..9).for_each(|_| table.tick());
    assert_eq!((table.steered.len(), table.stopped.last().map(String::as_str)), (1, Some("red")));
    let ack = table.ack("ann");
    assert_eq!(ack.ended.as_deref(), Some("silent for 2000 ms"));
    let codes: Vec<(u64, u16)> = ack.acted.iter().map(|acted| (acted.seq, acted.code)).collect();
    assert_eq!(codes, [(1, code::OK), (2, code::INTERRUPTED)]);
    assert!(table.claim("bob", Some("red")).is_ok());
}

#[test]
fn a_player_who_goes_or_whose_ball_goes_loses_it_at_once() {
    let mut table = Table::new();
    let ann = table.claim("ann", Some("red")).ok().unwrap();
    table.players.left(&ann.grant.player);
    table.players.left(&ann.grant.player);
    table.boundary();
    assert_eq!(table.ack("ann").ended.as_deref(), Some("its session ended"));
    table.claim("ann", Some("red")).ok().unwrap();
    let loaded = SceneText::built_in("bowl").unwrap().load().unwrap();
    table.stage = Simulation::new(Arc::new(loaded), 60, 2).unwrap().stage();
    table.look(1);
    table.boundary();
    assert_eq!(table.ack("ann").ended.as_deref(), Some("the ball is gone"));
    assert!(table.players.listing().players.is_empty());
}

#[test]
fn a_claimed_ball_is_steered_by_its_player_only_and_others_stay_open() {
    let mut table = Table::new();
    let stage = table.stage.clone();
    let allowed = |table: &Table, ball: Option<&str>| table.players.allow_anyone(ball, || stage.clone());
    assert!(allowed(&table, None).is_ok() && allowed(&table, Some("red")).is_ok());
    table.claim("ann", Some("red")).ok().unwrap();
    assert_eq!(allowed(&table, Some("red")).unwrap_err().why, "\"red\" is driven by ann");
    assert!(allowed(&table, None).is_ok(), "the first player's ball is the zebra");
    table.claim("bob", Some("zebra")).ok().unwrap();
    assert_eq!(allowed(&table, None).unwrap_err().why, "\"zebra\" is driven by bob");
}

#[test]
fn a_flood_is_cut_and_nothing_in_it_is_lost() {
    let mut table = Table::new();
    let mut ann = table.claim("ann", Some("red")).ok().unwrap();
    let far: Vec<_> = (1..=MAX_WINDOW as u64).map(|seq| (seq, Some(200))).collect();
    ann.drive(&table, 0, &far).unwrap();
    // A window that waits is full, whatever the player makes up.
    let more: Vec<_> = (65..=128).map(|seq| (seq, Some(200))).collect();
    ann.drive(&table, 64, &more).unwrap();
    assert_eq!(table.ack("ann").next_seq, 65);
    table.now.tick = 200;
    table.boundary();
    assert_eq!(table.steered.len(), MAX_WINDOW);
    // The rest of a second's commands, and no more however often it is sent.
    (0..100).for_each(|_| drop(ann.drive(&table, 64, &more)));
    table.boundary();
    let taken = table.steered.len();
    assert!((120..=128).contains(&taken), "{taken}");
    assert_eq!(table.ack("ann").next_seq, taken as u64 + 1);
    let message = ann.message(0, &[]);
    let refused = (0..5000).filter(|_| table.players.drive(&ann.grant.player, &message).is_err()).count();
    assert!(refused > 0);
}

#[test]
fn hits_are_counted_for_both_balls_and_rank_the_players() {
    let mut table = Table::new();
    table.claim("ann", Some("red")).ok().unwrap();
    table.claim("bob", Some("zebra")).ok().unwrap();
    let id = |ball: &str| table.stage.roster.names.iter().position(|name| name == ball).unwrap();
    let hit = |ball: &str, partner: HitPartner| NumberedHit {
        epoch: 1,
        sequence: 0,
        hit: ballroom_physics::Hit {
            time: ballroom_physics::Time::of_tick(1, 60),
            ball: id(ball),
            partner,
            point: nalgebra::Vector3::zeros(),
            impulse: 1.0,
        },
    };
    let hits = [
        hit("plain", HitPartner::Ball(id("red"))),
        hit("red", HitPartner::Wall(0)),
        hit("zebra", HitPartner::Wall(1)),
        hit("plain", HitPartner::Wall(1)),
    ];
    table.players.count_hits(&hits, &table.stage.roster);
    let rows = table.players.listing().players;
    let counts: Vec<_> = rows
        .iter()
        .map(|row| (row.player.as_str(), row.hits.ball_ball, row.hits.ball_wall, row.rank))
        .collect();
    assert_eq!(counts, [("ann", 1, 1, 1), ("bob", 0, 1, 2)]);
}
