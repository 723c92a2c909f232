//! Everything that is answered, on threads of its own: a client that asks and stops reading holds up other answers for a moment
//! at most, and never a state or Zenoh's receiving threads.

use super::{CLOSE_TIMEOUT, Latest, MAX_SESSIONS};
use crate::history::Archive;
use crate::players::Players;
use protocol::check::Check;
use protocol::codec;
use protocol::command::{Refusal, Reply};
use protocol::listing::Selection;
use protocol::player::Claimed;
use protocol::timeline::SavedState;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};
use zenoh::Wait;
use zenoh::bytes::Encoding;
use zenoh::query::Query;

/// Answers that wait; a question beyond them is dropped, which whoever asked sees at once.
const MAX_WAITING: usize = 256;
/// How long the next waits for one that makes no way. One at a time is work for a core; more would take others from the tick.
const HOLDUP: Duration = Duration::from_millis(20);

/// What to answer.
pub enum Answer {
    /// What came of asking for a ball.
    Claimed(Claimed),
    /// Who drives which ball when the answer is made.
    Players,
    /// The world as it is when the answer is made.
    World {
        /// Rather than binary.
        as_json: bool,
    },
    /// Some or all balls as they are when the answer is made.
    Balls(Selection),
    /// What is supported.
    Features,
    /// The scenes that come with the program.
    Scenes,
    /// The scene as served.
    Scene,
    /// Its numbers.
    Parameters,
    /// What can be gone back to.
    Slots,
    /// A state as a file.
    Saved(Box<SavedState>),
    /// The newest statistics.
    Stats,
    /// Frames, units, versions.
    Info,
    /// What the clock does.
    State,
    /// What came of a check.
    Check(Box<Check>),
    /// Who reads the states.
    Clients,
    /// Why there is no answer.
    Fault(Refusal),
}

/// About what a ball takes in a saved state.
pub const BYTES_A_SAVED_BALL: f64 = 400.0;

impl Answer {
    /// About what a ball takes in answers that grow with the balls and are costly, 0 in others.
    pub const fn bytes_a_ball(&self) -> f64 {
        match self {
            Self::World { as_json: true } => 500.0,
            Self::World { as_json: false } => 160.0,
            _ => 0.0,
        }
    }
}

/// The way to an answering thread, which ends when all copies of it are gone.
pub struct Answers<A>(SyncSender<(Query, A)>);

impl<A> Clone for Answers<A> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<A: Send + 'static> Answers<A> {
    /// Starts the thread, which sends each answer by `send`; the receiver hears when it has ended.
    pub fn start(send: impl Fn(&Query, A) + Send + Sync + 'static) -> std::io::Result<(Self, Receiver<()>)> {
        let (queue, waiting) = sync_channel::<(Query, A)>(MAX_WAITING);
        let ended = one_by_one(waiting, move |(query, answer)| send(&query, answer))?;
        Ok((Self(queue), ended))
    }

    /// Has a query answered, without waiting; one too many stays unanswered, which whoever asked sees.
    pub fn give(&self, query: Query, answer: A) {
        if self.0.try_send((query, answer)).is_err() {
            tracing::debug!("a question stays unanswered: too many answers wait to be sent");
        }
    }
}

/// Works through what comes in on a thread of its own, one after another; what takes longer than [`HOLDUP`] goes on beside the
/// next. The receiver hears when all is done.
fn one_by_one<T: Send + 'static>(
    waiting: Receiver<T>,
    work: impl Fn(T) + Send + Sync + 'static,
) -> std::io::Result<Receiver<()>> {
    let hands = tokio::runtime::Builder::new_current_thread()
        .enable_time()
        .thread_name("answer")
        .max_blocking_threads(MAX_SESSIONS)
        .build()?;
    let (finished, ended) = sync_channel(1);
    let work = Arc::new(work);
    std::thread::Builder::new().name("answers".into()).spawn(move || {
        for item in waiting {
            let work = work.clone();
            let done = hands.spawn_blocking(move || work(item));
            // A panic in it has been printed, and leaves one unanswered.
            drop(hands.block_on(async { tokio::time::timeout(HOLDUP, done).await }));
        }
        hands.shutdown_timeout(CLOSE_TIMEOUT);
        drop(finished);
    })?;
    Ok(ended)
}

/// Answers a question to an arena.
pub fn send(latest: &Latest, archive: &Archive, players: &Players, query: &Query, answer: Answer) {
    let (bytes, encoding) = match answer {
        Answer::Claimed(claimed) => json(&claimed),
        Answer::Players => json(&players.listing()),
        Answer::World { as_json: true } => json(&latest.world()),
        Answer::World { as_json: false } => (latest.world_frame(), Encoding::APPLICATION_CBOR),
        Answer::Balls(selection) => json(&selection.of(&latest.world())),
        Answer::Features => json(&crate::features::features()),
        Answer::Scenes => json(&crate::features::scenes()),
        Answer::Scene => json(&*latest.stage().scene),
        Answer::Parameters => json(&latest.parameters()),
        Answer::Slots => json(&archive.timeline()),
        Answer::Saved(saved) => json(&*saved),
        Answer::Stats => json(&latest.stats()),
        Answer::Info => json(&latest.info),
        Answer::State => json(&latest.state()),
        Answer::Check(check) => json(&check),
        Answer::Clients => json(&latest.readers.list(Instant::now())),
        Answer::Fault(refusal) => return refuse(query, refusal),
    };
    tell(query, query.reply(query.key_expr().clone(), bytes).encoding(encoding).wait());
}

/// Answers with JSON.
pub fn send_json<T: serde::Serialize>(query: &Query, value: &T) {
    let (bytes, encoding) = json(value);
    tell(query, query.reply(query.key_expr().clone(), bytes).encoding(encoding).wait());
}

/// Says why there is no answer, as a reply with its code.
pub fn refuse(query: &Query, refusal: Refusal) {
    let (bytes, encoding) = json(&Reply::from(refusal));
    tell(query, query.reply_err(bytes).encoding(encoding).wait());
}

fn json<T: serde::Serialize>(value: &T) -> (Vec<u8>, Encoding) {
    (codec::encode_json(value), Encoding::APPLICATION_JSON)
}

fn tell(query: &Query, sent: zenoh::Result<()>) {
    if let Err(e) = sent {
        tracing::debug!("{} could not be answered: {e}", query.key_expr());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;
    use std::sync::mpsc::channel;

    const PATIENCE: Duration = Duration::from_mins(1);

    #[test]
    fn an_answer_that_nobody_takes_holds_up_no_other() {
        let (queue, waiting) = sync_channel(MAX_WAITING);
        let (way_on, way) = channel::<()>();
        let (told, heard) = channel();
        let way = Mutex::new(way);
        let ended = one_by_one(waiting, move |number: usize| {
            if number.is_multiple_of(2) {
                way.lock().unwrap().recv_timeout(PATIENCE).unwrap();
            }
            told.send(number).unwrap();
        })
        .unwrap();
        (0..4).for_each(|number| queue.send(number).unwrap());
        // Those who take theirs have them while the others' are stuck.
        let quick = [heard.recv_timeout(PATIENCE).unwrap(), heard.recv_timeout(PATIENCE).unwrap()];
        assert_eq!(quick, [1, 3]);
        (0..2).for_each(|_| way_on.send(()).unwrap());
        let mut late = [heard.recv_timeout(PATIENCE).unwrap(), heard.recv_timeout(PATIENCE).unwrap()];
        late.sort_unstable();
        assert_eq!(late, [0, 2]);
        drop(queue);
        assert!(ended.recv_timeout(PATIENCE).is_err(), "it says nothing and ends");
    }
}
