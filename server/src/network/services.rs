//! Commands and questions coming in. Callbacks run on Zenoh's receiving threads: they check, and pass on to the inbox
//! or to the answering thread; none waits for the simulation or for a client. Only what is refused holds up its own link.

use super::answers::{Answer, Answers, BYTES_A_SAVED_BALL};
use super::budget::{ANSWERS_PER_S, Budget, PRESSES_PER_S, Source};
use super::link::Link;
use super::{Latest, NetworkError, WHOLE_BYTES_PER_S, throttle};
use crate::checker::Checker;
use crate::inbox::{Inbox, Refused, Request};
use crate::players::Players;
use crate::ready::Ready;
use crate::workshop::{self, Job, Workshop};
use protocol::codec::{MAX_COMMAND_BYTES, MAX_REQUEST_BYTES};
use protocol::command::{Command, Refusal, Reply, code};
use protocol::keys::{Keys, Name};
use protocol::listing::Selection;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use zenoh::pubsub::Subscriber;
use zenoh::query::{Query, Queryable};
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

/// Declarations that live as long as this.
pub struct Services {
    _queryables: Vec<Queryable<()>>,
    _presses: Subscriber<()>,
    _reports: Subscriber<()>,
}

impl Services {
    /// Declares the commands and the questions of an arena.
    pub fn declare(
        link: &Link,
        keys: &Keys,
        gate: &Arc<Gate>,
        latest: &Arc<Latest>,
    ) -> Result<Self, NetworkError> {
        let session = link.session();
        let mut queryables = vec![
            commands(session, &keys.srv_command(), gate.clone())?,
            checks(session, &keys.srv_check(), gate.clone(), link.checker().clone())?,
        ];
        let mut declare = |key: String, make: fn(&Query) -> Result<Answer, String>| {
            let gate = gate.clone();
            let declared = session.declare_queryable(key).callback(move |query| {
                let answer = gate
                    .spend(&Source::Questions)
                    .and_then(|()| make(&query).map_err(|why| gate.refuse(code::MALFORMED, why)))
                    .and_then(|answer| gate.afford(answer.bytes_a_ball()).map(|()| answer));
                gate.answers.give(query, answer.unwrap_or_else(Answer::Fault));
            });
            declared.wait().map(|queryable| queryables.push(queryable))
        };
        declare(keys.srv_snapshot(), world)?;
        declare(keys.srv_scene(), |_| Ok(Answer::Scene))?;
        declare(keys.srv_parameters(), |_| Ok(Answer::Parameters))?;
        declare(keys.srv_stats(), |_| Ok(Answer::Stats))?;
        declare(keys.srv_info(), |_| Ok(Answer::Info))?;
        declare(keys.srv_clients(), |_| Ok(Answer::Clients))?;
        declare(keys.srv_state(), |_| Ok(Answer::State))?;
        declare(keys.srv_features(), |_| Ok(Answer::Features))?;
        declare(keys.srv_scenes(), |_| Ok(Answer::Scenes))?;
        declare(keys.srv_players(), |_| Ok(Answer::Players))?;
        declare(keys.srv_balls(), |query| Selection::parse(query.parameters().as_str()).map(Answer::Balls))?;
        declare(keys.srv_slots(), |_| Ok(Answer::Slots))?;
        queryables.push(checkpoints(session, keys.srv_checkpoint(), gate.clone())?);
        let reports = reports(session, keys.clone(), latest.clone())?;
        let presses = presses(session, keys.clone(), gate.clone())?;
        Ok(Self { _queryables: queryables, _presses: presses, _reports: reports })
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
        let text = query.payload().map(|payload| payload.to_bytes().into_owned()).unwrap_or_default();
        let way_back = gate.clone();
        let answer: crate::inbox::Answer = Box::new(move |reply| way_back.reply(query, reply.clone()));
        if let Err((Some(answer), why)) = gate.pass(text, &Source::Commands, MAX_REQUEST_BYTES, Some(answer))
        {
            answer(&why.into());
        }
    };
    Ok(session.declare_queryable(key.to_owned()).callback(callback).wait()?)
}

/// States as files: what a slot holds, or the present one, which the tick thread has to write.
fn checkpoints(session: &Session, key: String, gate: Arc<Gate>) -> Result<Queryable<()>, NetworkError> {
    let callback = move |query: Query| {
        let allowed = gate.spend(&Source::Questions).and_then(|()| gate.afford(BYTES_A_SAVED_BALL));
        if let Err(refusal) = allowed {
            return gate.give(query, Answer::Fault(refusal));
        }
        let slot = match slot_of(&query) {
            Ok(slot) => slot,
            Err(why) => {
                let refusal = gate.refuse(code::MALFORMED, why);
                return gate.give(query, Answer::Fault(refusal));
            }
        };
        let way_back = gate.clone();
        let told: workshop::Told = Box::new(move |saved| {
            let answer = saved.map(|saved| Answer::Saved(Box::new(saved)));
            way_back.give(query, answer.unwrap_or_else(Answer::Fault));
        });
        gate.workshop.save(slot, told);
    };
    Ok(session.declare_queryable(key).callback(callback).wait()?)
}

/// `slot=NAME`, or nothing.
fn slot_of(query: &Query) -> Result<Option<String>, String> {
    let words = query.parameters().as_str();
    let Some(name) = words.strip_prefix("slot=") else {
        return if words.is_empty() { Ok(None) } else { Err(format!("{words:?} is unknown: use slot=NAME")) };
    };
    let name: Name = name.parse().map_err(|bad| format!("slot: {bad}"))?;
    Ok(Some(name.as_str().to_owned()))
}

/// Scenes to be checked, beside what runs.
fn checks(
    session: &Session,
    key: &str,
    gate: Arc<Gate>,
    checker: Checker,
) -> Result<Queryable<()>, NetworkError> {
    let callback = move |query: Query| {
        let text = query.payload().map(|payload| payload.to_bytes()).unwrap_or_default();
        let read = gate.spend(&Source::Questions).and_then(|()| {
            if text.len() > MAX_REQUEST_BYTES {
                let why = format!("{} bytes are too many: at most {MAX_REQUEST_BYTES}", text.len());
                return Err(gate.refuse(code::TOO_LONG, why));
            }
            let text = std::str::from_utf8(&text);
            text.map(str::to_owned).map_err(|e| gate.refuse(code::MALFORMED, format!("no text: {e}")))
        });
        drop(text);
        let answers = gate.answers.clone();
        match read {
            Ok(toml) => checker.give(
                toml,
                Box::new(move |found| {
                    answers
                        .give(query, found.map_or_else(Answer::Fault, |check| Answer::Check(check.into())));
                }),
            ),
            Err(refusal) => answers.give(query, Answer::Fault(refusal)),
        }
    };
    Ok(session.declare_queryable(key.to_owned()).callback(callback).wait()?)
}

/// What readers say of themselves; nothing hangs on it, so that what is wrong is passed over.
fn reports(session: &Session, keys: Keys, latest: Arc<Latest>) -> Result<Subscriber<()>, NetworkError> {
    let anyone = keys.report_of_anyone();
    let subscriber = session.declare_subscriber(anyone).callback(move |sample| {
        let key = sample.key_expr().as_str();
        let reader = keys.reader_of(key).ok_or_else(|| "no reader of this name".to_owned());
        let heard = reader
            .and_then(|reader| latest.readers.hear(reader, &sample.payload().to_bytes(), Instant::now()));
        if let Err(why) = heard {
            tracing::debug!("{key} passed over: {why}");
            throttle::hold_up();
        }
    });
    Ok(subscriber.wait()?)
}

/// Commands that are not answered.
fn presses(session: &Session, keys: Keys, gate: Arc<Gate>) -> Result<Subscriber<()>, NetworkError> {
    let anyone = keys.cmd_of_anyone();
    let subscriber = session.declare_subscriber(anyone).callback(move |sample| {
        let passed = match keys.player_of(sample.key_expr().as_str()) {
            Some(player) if sample.kind() == SampleKind::Put => {
                let text = sample.payload().to_bytes().into_owned();
                gate.pass(text, &Source::Player(player), MAX_COMMAND_BYTES, None)
            }
            _ => Err((None, gate.refuse(code::MALFORMED, "no player of this name".into()))),
        };
        if let Err((_, why)) = passed {
            tracing::debug!("{} refused: {why}", sample.key_expr());
        }
    });
    Ok(subscriber.wait()?)
}

/// A command that was not passed on: whom to tell, and why.
type Unpassed = (Option<crate::inbox::Answer>, Refusal);

/// What everything that comes in has to pass.
pub struct Gate {
    inbox: Arc<Inbox>,
    budget: Mutex<Budget>,
    answers: Answers<Answer>,
    replies: Answers<Reply>,
    workshop: Workshop,
    pub(super) players: Arc<Players>,
    pub(super) latest: Arc<Latest>,
}

impl Gate {
    /// In front of an arena.
    pub fn new(
        inbox: &Arc<Inbox>,
        answers: Answers<Answer>,
        replies: Answers<Reply>,
        workshop: Workshop,
        players: &Arc<Players>,
        latest: &Arc<Latest>,
    ) -> Arc<Self> {
        Arc::new(Self {
            inbox: inbox.clone(),
            budget: Mutex::default(),
            answers,
            replies,
            workshop,
            players: players.clone(),
            latest: latest.clone(),
        })
    }

    /// Passes a command on to the inbox, or to the workshop where it needs more than a look.
    fn pass(
        &self,
        text: Vec<u8>,
        source: &Source,
        most_bytes: usize,
        answer: Option<crate::inbox::Answer>,
    ) -> Result<(), Unpassed> {
        // The budget first: refusing must be cheap.
        if let Err(why) = self.spend(source) {
            return Err((answer, why));
        }
        if text.len() > most_bytes {
            let why = format!("{} bytes are too many: at most {most_bytes}", text.len());
            return Err((answer, self.refuse(code::TOO_LONG, why)));
        }
        let job = if text.len() > MAX_COMMAND_BYTES {
            Job::Text(text)
        } else {
            match workshop::read(&text) {
                Ok(command) if command.needs_preparing() => Job::Command(command),
                Ok(command) => {
                    if let Command::Steer { ball, .. } = &command
                        && let Err(why) = self.players.allow_anyone(ball.as_deref(), || self.latest.stage())
                    {
                        return Err((answer, self.refuse(why.code, why.why)));
                    }
                    return self.offer(Request { command, ready: Ready::Nothing, answer });
                }
                Err(why) => return Err((answer, self.refuse(why.code, why.why))),
            }
        };
        self.workshop.give(job, answer).inspect_err(|_| self.has_refused())
    }

    pub(super) fn spend(&self, source: &Source) -> Result<(), Refusal> {
        if self.budget.lock().unwrap_or_else(PoisonError::into_inner).allows(source, Instant::now()) {
            return Ok(());
        }
        let why = match source {
            Source::Questions => {
                format!("too many questions: all who ask together may send {ANSWERS_PER_S} a second")
            }
            Source::Commands => {
                format!("too many commands: all who ask together may send {ANSWERS_PER_S} a second")
            }
            Source::Player(_) => format!("too many presses: send at most {PRESSES_PER_S} a second"),
        };
        Err(self.refuse(code::TOO_MANY, why))
    }

    /// Whether an answer of so many bytes a ball may be given now.
    fn afford(&self, bytes_a_ball: f64) -> Result<(), Refusal> {
        let bytes = bytes_a_ball * self.latest.stage().roster.names.len() as f64;
        if self.latest.may_take(bytes) {
            return Ok(());
        }
        let why = format!(
            "whole worlds are asked for too often: all together may take {WHOLE_BYTES_PER_S} bytes a second"
        );
        Err(self.refuse(code::TOO_MANY, why))
    }

    /// Whoever is refused has to wait.
    pub(super) fn refuse(&self, code: u16, why: String) -> Refusal {
        self.has_refused();
        Refusal { code, why }
    }

    fn has_refused(&self) {
        self.inbox.count_refused();
        throttle::hold_up();
    }

    fn offer(&self, request: Request) -> Result<(), Unpassed> {
        self.inbox.offer(request).map_err(|Refused { answer, why }| {
            self.has_refused();
            (answer, why)
        })
    }

    pub(super) fn reply(&self, query: Query, reply: Reply) {
        self.replies.give(query, reply);
    }

    pub(super) fn give(&self, query: Query, answer: Answer) {
        self.answers.give(query, answer);
    }
}
