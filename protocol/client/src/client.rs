//! Commands, questions, presses.

use crate::feed::{Feed, Presences};
use crate::follow::Follower;
use crate::options::{ClientOptions, Patience};
use protocol::arenas::{ArenaCommand, Arenas, COMMAND_KEY, LIST_KEY};
use protocol::check::Check;
use protocol::codec::{self, CodecError};
use protocol::command::{Command, CommandFault, Reply, code};
use protocol::event::Events;
use protocol::keys::{Keys, Name, Role};
use protocol::listing::{Balls, Features, Scenes, Selection};
use protocol::parameter::Parameters;
use protocol::player::Players;
use protocol::report::Clients;
use protocol::scene::Scene;
use protocol::snapshot::{Snapshot, World};
use protocol::state::State;
use protocol::stats::Stats;
use protocol::timeline::{SavedState, Timeline};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};
use zenoh::Wait;
use zenoh::bytes::Encoding;
use zenoh::liveliness::LivelinessToken;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::Querier;

/// Pause before a server that has too much to do is asked again.
const WHEN_BUSY: Duration = Duration::from_millis(10);
/// First pause between two attempts to reach a server, and the longest.
const RETRY: [Duration; 2] = [Duration::from_millis(100), Duration::from_millis(500)];
/// Pause between two looks at whether anybody takes commands.
const LOOK_AGAIN: Duration = Duration::from_millis(10);
/// Answers looked at for one question; more than one server is already one too many.
const MAX_ANSWERS: usize = 16;

/// Why a client could not do what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// Nobody there.
    #[error(
        "no server of arena {arena} at {whereabouts} within {} s: start `ballroom serve`, name its endpoint with -e, or its arena with --arena (`ballroom arenas` lists them)",
        .waited.as_secs_f64()
    )]
    NoServer {
        /// Which arena.
        arena: Name,
        /// Where it was looked for.
        whereabouts: String,
        /// How long.
        waited: Duration,
    },
    /// There, but silent.
    #[error("the server did not answer {question} within {} s", .waited.as_secs_f64())]
    NoAnswer {
        /// What was asked, by key.
        question: String,
        /// How long.
        waited: Duration,
    },
    /// There, and gone before it answered.
    #[error("the server went away before it answered {question}: whether it acted on it is unknown")]
    Lost {
        /// What was asked, by key.
        question: String,
    },
    /// The server refused the question itself.
    #[error("the server refused {question}: {why}")]
    Refused {
        /// What was asked, by key.
        question: String,
        /// In its words.
        why: String,
        /// One of [`code`](protocol::command::code).
        code: u16,
    },
    /// The configuration is unusable.
    #[error("Zenoh does not accept {what}: {why}")]
    Config {
        /// The file, or the setting.
        what: String,
        /// In its words.
        why: String,
    },
    /// A command that makes no sense is not sent.
    #[error(transparent)]
    Command(#[from] CommandFault),
    /// What came is not what was asked for.
    #[error("the answer cannot be read: {0}")]
    Codec(#[from] CodecError),
    /// Zenoh failed.
    #[error("Zenoh: {0}")]
    Zenoh(#[from] zenoh::Error),
    /// Waiting was ended from outside.
    #[error("ended while waiting")]
    Aborted,
}

impl ClientError {
    /// Whether a server was missing, so that a tool can say so in its exit code.
    pub const fn is_no_server(&self) -> bool {
        matches!(self, Self::NoServer { .. })
    }
}

/// A session with the server of one arena, shared by its clones.
#[derive(Clone)]
pub struct Client {
    session: zenoh::Session,
    keys: Keys,
    /// Knows whether anybody takes commands.
    commands: Arc<Querier<'static>>,
    options: ClientOptions,
    opened: Instant,
}

impl Client {
    /// Opens a session, waiting for something to connect to as the options say.
    pub fn open(options: ClientOptions) -> Result<Self, ClientError> {
        let config = options.zenoh_config()?;
        let opened = Instant::now();
        let mut pause = RETRY[0];
        // A client's first open fails at once when nobody listens; later losses Zenoh repairs by itself.
        let session = loop {
            if options.abort.is_aborted() {
                return Err(ClientError::Aborted);
            }
            match zenoh::open(config.clone()).wait() {
                Ok(session) => break session,
                Err(e) => tracing::debug!("cannot connect yet: {e}"),
            }
            if let Patience::GiveUpAfter(waited) = options.patience
                && opened.elapsed() + pause > waited
            {
                let whereabouts = options.whereabouts();
                return Err(ClientError::NoServer { arena: options.arena, whereabouts, waited });
            }
            std::thread::sleep(pause);
            pause = pause.mul_f64(1.5).min(RETRY[1]);
        };
        Self::of_session(session, options).map(|client| Self { opened, ..client })
    }

    fn of_session(session: zenoh::Session, options: ClientOptions) -> Result<Self, ClientError> {
        let keys = Keys::new(&options.arena);
        let commands = session.declare_querier(keys.srv_command()).timeout(options.timeout).wait()?;
        Ok(Self { session, keys, commands: Arc::new(commands), options, opened: Instant::now() })
    }

    /// The keys of this client's arena.
    pub const fn keys(&self) -> &Keys {
        &self.keys
    }

    /// How it was opened.
    pub const fn options(&self) -> &ClientOptions {
        &self.options
    }

    /// The session underneath.
    pub const fn session(&self) -> &zenoh::Session {
        &self.session
    }

    /// Sends a command and waits for the answer: done at which tick, or why not. It is sent once, as a second one would
    /// be obeyed a second time; again only when the server had too much to do to take it.
    pub fn command(&self, command: &Command) -> Result<Reply, ClientError> {
        command.check()?;
        let began = Instant::now();
        loop {
            let reply = self.command_once(command)?;
            if reply.code != code::TOO_MANY || began.elapsed() > self.options.timeout {
                return Ok(reply);
            }
            self.wait_for_server(WHEN_BUSY)?;
        }
    }

    fn command_once(&self, command: &Command) -> Result<Reply, ClientError> {
        while !self.commands.matching_status().wait()?.matching() {
            self.wait_for_server(LOOK_AGAIN)?;
        }
        let (answers, inbox) = sync_channel(MAX_ANSWERS);
        let question = self.commands.get().payload(codec::encode_json(command));
        question
            .encoding(Encoding::APPLICATION_JSON)
            .callback(move |reply| drop(answers.try_send(reply)))
            .wait()?;
        let key = self.keys.srv_command();
        let bytes = first_answer(&inbox, &key, self.options.timeout)?;
        Ok(codec::decode_json(&bytes.ok_or(ClientError::Lost { question: key })?)?)
    }

    /// The world as it is now, in full precision.
    pub fn snapshot(&self) -> Result<World, ClientError> {
        Ok(codec::decode_world(&self.ask(&self.keys.srv_snapshot())?)?)
    }

    /// The scene as served.
    pub fn scene(&self) -> Result<Scene, ClientError> {
        Ok(codec::decode_json(&self.ask(&self.keys.srv_scene())?)?)
    }

    /// The newest statistics.
    pub fn stats(&self) -> Result<Stats, ClientError> {
        Ok(codec::decode_json(&self.ask(&self.keys.srv_stats())?)?)
    }

    /// Numbers of the scene, and which of them may be set.
    pub fn parameters(&self) -> Result<Parameters, ClientError> {
        Ok(codec::decode_json(&self.ask(&self.keys.srv_parameters())?)?)
    }

    /// Some or all balls as they are now.
    pub fn balls(&self, selection: &Selection) -> Result<Balls, ClientError> {
        Ok(codec::decode_json(&self.ask(&format!("{}?{}", self.keys.srv_balls(), selection.words()))?)?)
    }

    /// The scenes that come with the server.
    pub fn scenes(&self) -> Result<Scenes, ClientError> {
        Ok(codec::decode_json(&self.ask(&self.keys.srv_scenes())?)?)
    }

    /// Who drives which ball.
    pub fn players(&self) -> Result<Players, ClientError> {
        Ok(codec::decode_json(&self.ask(&self.keys.srv_players())?)?)
    }

    /// What can be gone back to: how far the history reaches, and the slots.
    pub fn slots(&self) -> Result<Timeline, ClientError> {
        Ok(codec::decode_json(&self.ask(&self.keys.srv_slots())?)?)
    }

    /// The present state, or what a slot holds, as files keep it.
    pub fn checkpoint(&self, slot: Option<&str>) -> Result<SavedState, ClientError> {
        let words = slot.map_or(String::new(), |slot| format!("?slot={slot}"));
        Ok(codec::decode_saved_state(&self.ask(&format!("{}{words}", self.keys.srv_checkpoint()))?)?)
    }

    /// What the clock does.
    pub fn state(&self) -> Result<State, ClientError> {
        Ok(codec::decode_json(&self.ask(&self.keys.srv_state())?)?)
    }

    /// The arenas of the server's process.
    pub fn arenas(&self) -> Result<Arenas, ClientError> {
        Ok(codec::decode_json(&self.ask(LIST_KEY)?)?)
    }

    /// Starts or stops an arena of the server's process and waits until that is done. It is sent once.
    pub fn arena_command(&self, command: &ArenaCommand) -> Result<Reply, ClientError> {
        command.check()?;
        // Who answers this is there to be commanded.
        self.arenas()?;
        let (answers, inbox) = sync_channel(MAX_ANSWERS);
        let question = self.session.get(COMMAND_KEY).payload(codec::encode_json(command));
        let question = question.encoding(Encoding::APPLICATION_JSON).timeout(self.options.timeout);
        question.callback(move |reply| drop(answers.try_send(reply))).wait()?;
        let bytes = first_answer(&inbox, COMMAND_KEY, self.options.timeout)?;
        Ok(codec::decode_json(&bytes.ok_or(ClientError::Lost { question: COMMAND_KEY.into() })?)?)
    }

    /// The same session with another arena of the server.
    pub fn of_arena(&self, arena: &Name) -> Result<Self, ClientError> {
        let options = ClientOptions { arena: arena.clone(), ..self.options.clone() };
        Self::of_session(self.session.clone(), options)
    }

    /// Whether the text of a scene file could be run, without touching what runs.
    pub fn check(&self, toml: &str) -> Result<Check, ClientError> {
        let (answers, inbox) = sync_channel(MAX_ANSWERS);
        // Who answers this is there to be asked.
        self.state()?;
        let key = self.keys.srv_check();
        let question = self.session.get(&key).payload(toml).timeout(self.options.timeout);
        question.callback(move |reply| drop(answers.try_send(reply))).wait()?;
        let bytes = first_answer(&inbox, &key, self.options.timeout)?;
        Ok(codec::decode_json(&bytes.ok_or(ClientError::Lost { question: key })?)?)
    }

    /// Who reads the states, and how they come.
    pub fn clients(&self) -> Result<Clients, ClientError> {
        Ok(codec::decode_json(&self.ask(&self.keys.srv_clients())?)?)
    }

    /// What the server understands, with limits.
    pub fn features(&self) -> Result<Features, ClientError> {
        Ok(codec::decode_json(&self.ask(&self.keys.srv_features())?)?)
    }

    /// The newest statistics without waiting for a server to appear.
    pub(crate) fn stats_now(&self, timeout: Duration) -> Result<Stats, ClientError> {
        let key = self.keys.srv_stats();
        let bytes = self.ask_once(&key, timeout)?.ok_or_else(|| self.no_server(timeout))?;
        Ok(codec::decode_json(&bytes)?)
    }

    /// The world without waiting for a server to appear.
    pub(crate) fn snapshot_now(&self) -> Result<World, ClientError> {
        let timeout = self.options.timeout;
        let bytes =
            self.ask_once(&self.keys.srv_snapshot(), timeout)?.ok_or_else(|| self.no_server(timeout))?;
        Ok(codec::decode_world(&bytes)?)
    }

    /// Sends a command under a player's key and waits for nothing: a lost press is better than a late one.
    pub fn press(&self, player: &Name, command: &Command) -> Result<(), ClientError> {
        command.check()?;
        self.session
            .put(self.keys.cmd(player), codec::encode_json(command))
            .encoding(Encoding::APPLICATION_JSON)
            .priority(Priority::InteractiveHigh)
            .congestion_control(CongestionControl::Drop)
            .express(true)
            .wait()?;
        Ok(())
    }

    /// States, newest only: what is not read in time is overtaken by the next. While it is read, the server is told
    /// once a second how they come.
    pub fn subscribe_state(&self) -> Result<Feed<Snapshot>, ClientError> {
        let states = Feed::subscribe(&self.session, &self.keys.state(), 1, codec::decode_state)?;
        let own = || self.session.zid().to_string().parse().ok();
        match self.options.id.clone().or_else(own) {
            Some(id) => states.reporting(&self.session, self.keys.report(self.options.role, &id)),
            None => Ok(states),
        }
    }

    /// Hits. They are numbered, so a reader that falls far behind sees what it missed.
    pub fn subscribe_events(&self) -> Result<Feed<Events>, ClientError> {
        Feed::subscribe(&self.session, &self.keys.event(), 256, codec::decode_events)
    }

    /// Statistics, once a second.
    pub fn subscribe_stats(&self) -> Result<Feed<Stats>, ClientError> {
        Feed::subscribe(&self.session, &self.keys.stats(), 4, codec::decode_json)
    }

    /// Who of a role is there, and who comes and goes.
    pub fn watch(&self, role: Role) -> Result<Presences, ClientError> {
        Presences::watch(&self.session, &self.keys.alive_all(role))
    }

    /// Tells the others that someone is there, as long as the token is held.
    pub fn announce(&self, role: Role, id: &Name) -> Result<LivelinessToken, ClientError> {
        Ok(self.session.liveliness().declare_token(self.keys.alive(role, id)).wait()?)
    }

    /// The world and then its states, for ever.
    pub fn follow(&self) -> Result<Follower, ClientError> {
        Follower::new(self.clone())
    }

    fn ask(&self, key: &str) -> Result<Vec<u8>, ClientError> {
        self.ask_with(key, None)
    }

    /// Asks until somebody answers, as long as the client's patience lasts.
    pub(crate) fn ask_with(&self, key: &str, payload: Option<&[u8]>) -> Result<Vec<u8>, ClientError> {
        let began = Instant::now();
        loop {
            match self.ask_once_with(key, payload, self.options.timeout) {
                // Others ask too; whoever goes on asking has its turn.
                Err(ClientError::Refused { code: code::TOO_MANY, .. })
                    if began.elapsed() < self.options.timeout =>
                {
                    self.wait_for_server(WHEN_BUSY)?;
                    continue;
                }
                answer => {
                    if let Some(answer) = answer? {
                        return Ok(answer);
                    }
                }
            }
            // Nobody served it; just after the session opened the server's declarations may not have arrived yet.
            self.wait_for_server(RETRY[0])?;
        }
    }

    /// Sleeps before another attempt, unless there shall be none.
    fn wait_for_server(&self, pause: Duration) -> Result<(), ClientError> {
        let waited = self.opened.elapsed();
        if self.options.abort.is_aborted() {
            return Err(ClientError::Aborted);
        }
        if matches!(self.options.patience, Patience::GiveUpAfter(limit) if waited > limit) {
            return Err(self.no_server(waited));
        }
        std::thread::sleep(pause);
        Ok(())
    }

    fn ask_once(&self, key: &str, timeout: Duration) -> Result<Option<Vec<u8>>, ClientError> {
        self.ask_once_with(key, None, timeout)
    }

    /// One answer, or none when nobody serves this key.
    pub(crate) fn ask_once_with(
        &self,
        key: &str,
        payload: Option<&[u8]>,
        timeout: Duration,
    ) -> Result<Option<Vec<u8>>, ClientError> {
        // Dropping what does not fit keeps the session's receiving thread free whatever is sent.
        let (answers, inbox) = sync_channel(MAX_ANSWERS);
        let mut question = self.session.get(key).timeout(timeout);
        if let Some(payload) = payload {
            question = question.payload(payload).encoding(Encoding::APPLICATION_JSON);
        }
        question.callback(move |reply| drop(answers.try_send(reply))).wait()?;
        first_answer(&inbox, key, timeout)
    }

    fn no_server(&self, waited: Duration) -> ClientError {
        // Whole tenths read better than the clock's nanoseconds.
        let waited = Duration::from_millis(waited.as_millis() as u64 / 100 * 100);
        ClientError::NoServer {
            arena: self.options.arena.clone(),
            whereabouts: self.options.whereabouts(),
            waited,
        }
    }
}

/// The first answer to a question; none when it ended without one.
fn first_answer(
    inbox: &Receiver<zenoh::query::Reply>,
    key: &str,
    timeout: Duration,
) -> Result<Option<Vec<u8>>, ClientError> {
    let no_answer = || ClientError::NoAnswer { question: key.to_owned(), waited: timeout };
    match inbox.recv_timeout(timeout + RETRY[0]) {
        Ok(reply) => match reply.into_result() {
            Ok(sample) => Ok(Some(sample.payload().to_bytes().into_owned())),
            Err(error) => match error.payload().try_to_string() {
                Ok(why) if why == "Timeout" => Err(no_answer()),
                text => {
                    let text = text.map_or_else(|_| "no text".to_owned(), std::borrow::Cow::into_owned);
                    // What Zenoh itself says is no reply of the server.
                    let (why, code) = codec::decode_json(text.as_bytes())
                        .map_or((text, code::OPERATION_FAILED), |reply: Reply| (reply.error, reply.code));
                    Err(ClientError::Refused { question: key.to_owned(), why, code })
                }
            },
        },
        Err(RecvTimeoutError::Disconnected) => Ok(None),
        Err(RecvTimeoutError::Timeout) => Err(no_answer()),
    }
}
