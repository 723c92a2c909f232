//! Players behind a bad line. Zenoh runs over TCP and loses nothing by itself, so a relay between two routers does: it
//! drops in bursts, delays and duplicates, and thereby reorders, in both directions, from a seed that it prints.

use super::PATIENCE;
use super::players::{row, serve_two, until};
use ballroom_client::{Client, ClientOptions, DriveFault, Driver, Patience, Wanted};
use protocol::command::{Command, Direction, SteerMode};
use protocol::player::Acted;
use server::recording::{Line, Reader};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use zenoh::qos::CongestionControl;
use zenoh::{Session, Wait};

/// Share of messages that come twice.
const TWICE: f64 = 0.15;
/// A quarter is lost in the long run, about four in a row: once lost, the next is lost too with 3/4, and once passed
/// with 0.0884. Ten in a row are half a second of silence; four times that would be the dead-man's.
const STAYS_BAD: f64 = 0.75;
const TURNS_BAD: f64 = 0.0884;
const LONGEST_BURST: u32 = 10;
/// Delay and its spread, ms.
const DELAY_MS: [f64; 2] = [250.0, 33.0];
/// Commands each player sends.
const COMMANDS: usize = 200;

/// Marsaglia's xorshift.
struct Dice(u64);

impl Dice {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// What a line did.
#[derive(Default)]
struct Counts {
    passed: AtomicU64,
    dropped: AtomicU64,
    doubled: AtomicU64,
    overtaken: AtomicU64,
}

/// One direction of the bad line: from a key of one session to the same key of the other.
fn bad_line(from: &Session, to: &Session, keys: &str, seed: u64) -> Arc<Counts> {
    let counts = Arc::new(Counts::default());
    let (sender, came) = channel::<(String, Vec<u8>)>();
    let sender = Mutex::new(sender);
    let subscriber = from.declare_subscriber(keys.to_owned()).callback(move |sample| {
        let message = (sample.key_expr().to_string(), sample.payload().to_bytes().into_owned());
        drop(sender.lock().unwrap().send(message));
    });
    subscriber.background().wait().unwrap();
    let (to, counted) = (to.clone(), counts.clone());
    std::thread::spawn(move || deliver(&came, &to, &mut Dice(seed), &counted));
    counts
}

fn deliver(came: &Receiver<(String, Vec<u8>)>, to: &Session, dice: &mut Dice, counts: &Counts) {
    let (mut burst, mut number, mut newest) = (0, 0_u64, 0);
    let mut on_the_way = BinaryHeap::<Reverse<(Instant, u64, String, Vec<u8>)>>::new();
    loop {
        let now = Instant::now();
        while on_the_way.peek().is_some_and(|Reverse((due, ..))| *due <= now) {
            let Some(Reverse((_, number, key, bytes))) = on_the_way.pop() else { break };
            if number < newest {
                counts.overtaken.fetch_add(1, Ordering::Relaxed);
            }
            newest = newest.max(number);
            to.put(key, bytes).congestion_control(CongestionControl::Block).wait().unwrap();
        }
        let wait = on_the_way.peek().map_or(Duration::from_millis(100), |Reverse((due, ..))| *due - now);
        let (key, bytes) = match came.recv_timeout(wait) {
            Ok(message) => message,
            Err(RecvTimeoutError::Timeout) => continue,
            Err(RecvTimeoutError::Disconnected) => return,
        };
        number += 1;
        let is_lost = dice.unit() < if burst > 0 { STAYS_BAD } else { TURNS_BAD };
        burst = if is_lost && burst < LONGEST_BURST { burst + 1 } else { 0 };
        if burst > 0 {
            counts.dropped.fetch_add(1, Ordering::Relaxed);
            continue;
        }
        let copies = if dice.unit() < TWICE { 2 } else { 1 };
        counts.passed.fetch_add(1, Ordering::Relaxed);
        counts.doubled.fetch_add(copies - 1, Ordering::Relaxed);
        for _ in 0..copies {
            let millis = DELAY_MS[0] + DELAY_MS[1] * (2.0 * dice.unit() - 1.0);
            let due = Instant::now() + Duration::from_secs_f64(millis * 1e-3);
            on_the_way.push(Reverse((due, number, key.clone(), bytes.clone())));
        }
    }
}

/// A router of its own, which passes questions on faithfully and messages of players badly.
struct Relay {
    endpoint: String,
    lines: [Arc<Counts>; 2],
    _near: Session,
}

impl Relay {
    fn start(server: &Client, seed: u64) -> Self {
        let mut config = zenoh::Config::default();
        for (key, value) in [
            ("mode", "\"router\""),
            ("scouting/multicast/enabled", "false"),
            ("scouting/gossip/enabled", "false"),
            ("listen/endpoints", "[\"tcp/127.0.0.1:0\"]"),
        ] {
            config.insert_json5(key, value).unwrap();
        }
        let near = zenoh::open(config).wait().unwrap();
        let endpoint = near.info().locators().wait()[0].to_string();
        let far = server.session().clone();
        let lines = [
            bad_line(&near, &far, "ballroom/v1/main/drive/*", seed),
            bad_line(&far, &near, "ballroom/v1/main/ack/*", seed ^ 0x5555),
        ];
        let questions = near.declare_queryable("ballroom/v1/main/srv/*").callback(move |query| {
            let far = far.clone();
            // Not on Zenoh's receiving thread: it waits for the answer.
            std::thread::spawn(move || {
                let mut question = far.get(query.selector().into_owned()).timeout(PATIENCE);
                if let Some(payload) = query.payload() {
                    question = question.payload(payload.clone());
                }
                let reply = question.wait().unwrap().recv().unwrap().into_result().unwrap();
                query.reply(query.key_expr().clone(), reply.payload().clone()).wait().unwrap();
            });
        });
        questions.background().wait().unwrap();
        Self { endpoint, lines, _near: near }
    }

    fn client(&self) -> Client {
        Client::open(ClientOptions {
            endpoints: vec![self.endpoint.clone()],
            patience: Patience::GiveUpAfter(PATIENCE),
            timeout: PATIENCE,
            ..ClientOptions::default()
        })
        .unwrap()
    }
}

/// A direction that tells which command it is; short, so that the ball stays far from the walls.
fn direction(i: usize) -> [f64; 2] {
    let sign = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    [sign * 1e-3 * (i + 1) as f64 / COMMANDS as f64, 0.0]
}

/// Sends numbered commands for the tick after next, and gives their wanted ticks and what became of them.
fn play(observer: &Client, driver: &Driver) -> (Vec<u64>, Vec<Acted>) {
    let (mut wanted, mut acted) = (Vec::new(), Vec::new());
    for i in 0..COMMANDS {
        let now = observer.snapshot().unwrap().snapshot;
        let at = Wanted::at(now.epoch, now.tick + 2);
        until("room for a command", || {
            match driver.drive_at(at, Direction::Vector(direction(i)), SteerMode::Impulse) {
                Ok(seq) => {
                    assert_eq!(seq, i as u64 + 1);
                    Some(())
                }
                Err(DriveFault::Full) => None,
                Err(fault) => panic!("command {i}: {fault}"),
            }
        });
        wanted.push(now.tick + 2);
        acted.extend(driver.acked());
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(driver.settle(PATIENCE), "{} are not acknowledged", driver.waiting());
    acted.extend(driver.acked());
    (wanted, acted)
}

/// What the recording holds for each ball, in order: tick and direction of every push.
fn pushes(file: &Path) -> BTreeMap<String, Vec<(u64, [f64; 2])>> {
    let mut reader = Reader::open(file).unwrap();
    let mut pushes = BTreeMap::<String, Vec<_>>::new();
    while let Some(line) = reader.next_line().unwrap() {
        if let Line::Command(line) = line
            && let Command::Steer { ball: Some(ball), direction: Direction::Vector(v), .. } = line.command
        {
            pushes.entry(ball).or_default().push((line.tick, v));
        }
    }
    pushes
}

#[test]
fn over_a_line_that_drops_delays_and_duplicates_every_command_acts_once_in_order_and_is_acknowledged() {
    let seed = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as u64 | 1;
    println!("seed {seed}");
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("ride.mcap");
    let server = serve_two(&["--record", file.to_str().unwrap()]);
    let observer = server.client();
    let relay = Relay::start(&observer, seed);

    let played = std::thread::scope(|scope| {
        let far = scope.spawn(|| {
            let driver = relay.client().claim(&"far".parse().unwrap(), Some("red")).unwrap();
            let played = play(&observer, &driver);
            (played, row(&observer, "far").unwrap())
        });
        let near = scope.spawn(|| {
            let driver = server.client().claim(&"near".parse().unwrap(), Some("blue")).unwrap();
            let played = play(&observer, &driver);
            (played, row(&observer, "near").unwrap())
        });
        [("red", far.join().unwrap()), ("blue", near.join().unwrap())]
    });
    let [_, (_, (_, near))] = &played;
    assert_eq!((near.lost, near.repeated), (0, 0), "the good line: {near:?}");
    let count =
        |of: fn(&Counts) -> &AtomicU64| relay.lines.each_ref().map(|line| of(line).load(Ordering::Relaxed));
    let told = [count(|l| &l.passed), count(|l| &l.dropped), count(|l| &l.doubled), count(|l| &l.overtaken)];
    println!("passed, dropped, doubled, overtaken: {told:?}");
    assert!(told.iter().flatten().all(|count| *count > 0), "{told:?}");
    assert!(server.end_in_order());

    let pushes = pushes(&file);
    for (ball, ((wanted, acted), row)) in &played {
        assert_eq!((row.commands, row.refused, row.waiting), (COMMANDS as u64, 0, 0), "{row:?}");
        // Acknowledged: each once, in order, done, and not before it was wanted.
        assert!(acted.iter().map(|acted| acted.seq).eq(1..=COMMANDS as u64), "{ball}");
        assert!(acted.iter().all(Acted::is_done) && acted.is_sorted_by_key(|acted| acted.tick), "{ball}");
        assert!(acted.iter().zip(wanted).all(|(acted, wanted)| acted.tick >= *wanted), "{ball}");
        // Done: the same, each once, by the recording.
        let told: Vec<(u64, [f64; 2])> =
            acted.iter().enumerate().map(|(i, acted)| (acted.tick, direction(i))).collect();
        assert_eq!(&told, &pushes[*ball], "{ball}");
    }
    let replayed = super::ballroom(&["replay", file.to_str().unwrap(), "--json"]);
    assert_eq!(replayed.code, 0, "{}{}", replayed.stdout, replayed.stderr);
}
