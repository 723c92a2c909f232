//! Commands and questions coming in. Callbacks run on Zenoh's receiving threads: they check, and pass on to the inbox
//! or to the answering thread; none waits for the simulation or for a client.

use super::NetworkError;
use super::answers::{Answer, Answers};
use super::budget::{ANSWERS_PER_S, Budget, PRESSES_PER_S, Source};
use crate::inbox::{Inbox, Refused, Request};
use protocol::codec::{self, MAX_COMMAND_BYTES};
use protocol::command::{Command, Reply};
use protocol::keys::Keys;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use zenoh::bytes::ZBytes;
use zenoh::pubsub::Subscriber;
use zenoh::query::{Query, Queryable};
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

/// Declarations that live as long as this.
pub struct Services {
    _queryables: Vec<Queryable<()>>,
    _presses: Subscriber<()>,
}

impl Services {
    /// Declares the commands and the questions of an arena.
    pub fn declare(
        session: &Session,
        keys: &Keys,
        answers: &Answers,
        inbox: &Arc<Inbox>,
    ) -> Result<Self, NetworkError> {
        let gate =
            Arc::new(Gate { inbox: inbox.clone(), budget: Mutex::default(), answers: answers.clone() });
        let mut queryables = vec![commands(session, &keys.srv_command(), gate.clone())?];
        let mut declare = |key: String, make: fn(&Query) -> Result<Answer, String>| {
            let gate = gate.clone();
            let declared = session.declare_queryable(key).callback(move |query| {
                let answer = gate.spend(&Source::Questions).and_then(|()| {
                    let answer = make(&query);
                    answer.or_else(|why| gate.refuse(why))
                });
                gate.give(query, answer.unwrap_or_else(Answer::Fault));
            });
            declared.wait().map(|queryable| queryables.push(queryable))
        };
        declare(keys.srv_snapshot(), world)?;
        declare(keys.srv_scene(), |_| Ok(Answer::Scene))?;
        declare(keys.srv_stats(), |_| Ok(Answer::Stats))?;
        declare(keys.srv_info(), |_| Ok(Answer::Info))?;
        let presses = presses(session, keys.clone(), gate)?;
        Ok(Self { _queryables: queryables, _presses: presses })
    }
}

fn world(query: &Query) -> Result<Answer, String> {
    match query.parameters().get("format") {
        None | Some("cbor") => Ok(Answer::World { as_json: false }),
        Some("json") => Ok(Answer::World { as_json: true }),
        Some(other) => Err(format!("format {other:?} is unknown: use cbor or json")),
    }
}

/// Commands that are answered: when done, at which tick; when not, why not.
fn commands(session: &Session, key: &str, gate: Arc<Gate>) -> Result<Queryable<()>, NetworkError> {
    let callback = move |query: Query| {
        let empty = ZBytes::new();
        match gate.check(query.payload().unwrap_or(&empty), &Source::Commands) {
            Ok(command) => {
                let way_back = gate.clone();
                let answer: crate::inbox::Answer =
                    Box::new(move |reply| way_back.give(query, Answer::Reply(reply.clone())));
                let offered = gate.offer(Request { command, answer: Some(answer) });
                if let Err(Refused { request: Request { answer: Some(answer), .. }, why }) = offered {
                    answer(&refusal(why.into()));
                }
            }
            Err(why) => gate.give(query, Answer::Reply(refusal(why))),
        }
    };
    Ok(session.declare_queryable(key.to_owned()).callback(callback).wait()?)
}

/// Commands that are not answered.
fn presses(session: &Session, keys: Keys, gate: Arc<Gate>) -> Result<Subscriber<()>, NetworkError> {
    let anyone = keys.cmd_of_anyone();
    let subscriber = session.declare_subscriber(anyone).callback(move |sample| {
        let command = match keys.player_of(sample.key_expr().as_str()) {
            Some(player) if sample.kind() == SampleKind::Put => {
                gate.check(sample.payload(), &Source::Player(player))
            }
            _ => gate.refuse("no player of this name".into()),
        };
        match command {
            Ok(command) => drop(gate.offer(Request { command, answer: None })),
            Err(why) => tracing::debug!("{} refused: {why}", sample.key_expr()),
        }
    });
    Ok(subscriber.wait()?)
}

/// What everything that comes in has to pass.
struct Gate {
    inbox: Arc<Inbox>,
    budget: Mutex<Budget>,
    answers: Answers,
}

impl Gate {
    fn check(&self, payload: &ZBytes, source: &Source) -> Result<Command, String> {
        // The budget first: refusing must be cheap.
        self.spend(source)?;
        if payload.len() > MAX_COMMAND_BYTES {
            return self.refuse(format!("{} bytes are too many: at most {MAX_COMMAND_BYTES}", payload.len()));
        }
        codec::decode_command(&payload.to_bytes()).or_else(|e| self.refuse(e.to_string()))
    }

    fn spend(&self, source: &Source) -> Result<(), String> {
        if self.budget.lock().unwrap_or_else(PoisonError::into_inner).allows(source, Instant::now()) {
            return Ok(());
        }
        self.refuse(match source {
            Source::Questions => {
                format!("too many questions: all who ask together may send {ANSWERS_PER_S} a second")
            }
            Source::Commands => {
                format!("too many commands: all who ask together may send {ANSWERS_PER_S} a second")
            }
            Source::Player(_) => format!("too many presses: send at most {PRESSES_PER_S} a second"),
        })
    }

    fn refuse<T>(&self, why: String) -> Result<T, String> {
        self.inbox.count_refused();
        Err(why)
    }

    fn offer(&self, request: Request) -> Result<(), Refused> {
        let offered = self.inbox.offer(request);
        if offered.is_err() {
            self.inbox.count_refused();
        }
        offered
    }

    fn give(&self, query: Query, answer: Answer) {
        if !self.answers.give(query, answer) {
            tracing::debug!("a question stays unanswered: too many answers wait to be sent");
        }
    }
}

const fn refusal(error: String) -> Reply {
    Reply { ok: false, tick: 0, epoch: 0, error }
}
