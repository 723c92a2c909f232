//! What the process is asked: which arenas there are, and to start or stop one. Its keys are no arena's, and neither
//! are its threads, so that no arena is held up by it.

use super::answers::{Answers, refuse, send_json};
use super::budget::{ANSWERS_PER_S, Budget, Source};
use super::link::Link;
use super::{CLOSE_TIMEOUT, NetworkError, throttle};
use crate::inbox::Answer;
use protocol::arenas::{ArenaCommand, Arenas, COMMAND_KEY, LIST_KEY};
use protocol::codec::CodecError;
use protocol::command::{Refusal, Reply, code};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use zenoh::Wait;
use zenoh::query::{Query, Queryable};

/// Commands to the process that wait.
const MAX_WAITING: usize = 16;

/// A command to the process, and whom to answer.
pub(crate) type Job = (ArenaCommand, Answer);

/// What is sent back.
enum Said {
    Reply(Reply),
    List,
    Refusal(Refusal),
}

/// Declarations that live as long as this.
pub(crate) struct Doors {
    queryables: [Queryable<()>; 2],
    answered: Receiver<()>,
}

impl Doors {
    /// Declares what a process is asked; `list` is called for each question, and commands come out of the receiver.
    pub fn declare(
        link: &Link,
        list: impl Fn() -> Arenas + Send + Sync + 'static,
    ) -> Result<(Self, Receiver<Job>), NetworkError> {
        let (answers, answered) = Answers::start(move |query, said| match said {
            Said::Reply(reply) => send_json(query, &reply),
            Said::List => send_json(query, &list()),
            Said::Refusal(refusal) => refuse(query, refusal),
        })?;
        let (jobs, waiting) = sync_channel(MAX_WAITING);
        let budget = Arc::new(Mutex::new(Budget::default()));
        let commands = {
            let (answers, budget) = (answers.clone(), budget.clone());
            link.session().declare_queryable(COMMAND_KEY).callback(move |query| {
                let read = allow(&budget, &Source::Commands).and_then(|()| read(&query));
                pass(read, query, &jobs, &answers);
            })
        };
        let questions = link.session().declare_queryable(LIST_KEY).callback(move |query| {
            let refused = allow(&budget, &Source::Questions).inspect_err(|_| throttle::hold_up()).err();
            answers.give(query, refused.map_or(Said::List, Said::Refusal));
        });
        Ok((Self { queryables: [commands.wait()?, questions.wait()?], answered }, waiting))
    }

    /// Takes everything back once what was answered has been sent.
    pub fn close(self) {
        drop(self.queryables);
        if self.answered.recv_timeout(CLOSE_TIMEOUT) == Err(RecvTimeoutError::Timeout) {
            tracing::debug!("not everything was answered");
        }
    }
}

fn pass(read: Result<ArenaCommand, Refusal>, query: Query, jobs: &SyncSender<Job>, answers: &Answers<Said>) {
    let command = match read {
        Ok(command) => command,
        Err(refusal) => {
            throttle::hold_up();
            return answers.give(query, Said::Reply(refusal.into()));
        }
    };
    let way_back = answers.clone();
    let answer: Answer = Box::new(move |reply| way_back.give(query, Said::Reply(reply.clone())));
    if let Err(full) = jobs.try_send((command, answer)) {
        let (TrySendError::Full((_, answer)) | TrySendError::Disconnected((_, answer))) = full;
        throttle::hold_up();
        let why = format!("{MAX_WAITING} commands about arenas wait already: send fewer");
        answer(&Refusal::new(code::TOO_MANY, why).into());
    }
}

fn allow(budget: &Mutex<Budget>, source: &Source) -> Result<(), Refusal> {
    let allowed = budget.lock().unwrap_or_else(PoisonError::into_inner).allows(source, Instant::now());
    let why = || format!("too many requests: all who ask together may send {ANSWERS_PER_S} a second");
    if allowed { Ok(()) } else { Err(Refusal::new(code::TOO_MANY, why())) }
}

fn read(query: &Query) -> Result<ArenaCommand, Refusal> {
    let text = query.payload().map(|payload| payload.to_bytes()).unwrap_or_default();
    ArenaCommand::from_json(&text).map_err(|error| {
        let code = if matches!(error, CodecError::TooLong { .. }) { code::TOO_LONG } else { code::MALFORMED };
        Refusal::new(code, error.to_string())
    })
}
