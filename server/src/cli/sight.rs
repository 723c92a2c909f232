//! All that a server says of itself at a moment: its arenas, their statistics, their readers.

use ballroom_client::{Client, ClientError};
use protocol::arenas::ArenaRow;
use protocol::report::ClientRow;
use protocol::stats::Stats;
use serde::Serialize;
use std::collections::BTreeMap;

/// One arena.
#[derive(Clone, Debug, Serialize)]
pub struct Sight {
    /// As it is listed.
    #[serde(flatten)]
    pub row: ArenaRow,
    /// Over the last second; the clock of `row` is newer.
    pub stats: Stats,
    /// Who reads its states.
    pub clients: Vec<ClientRow>,
}

/// Looks at a server again and again over one session.
pub struct Lookout {
    client: Client,
    arenas: BTreeMap<String, Client>,
}

impl Lookout {
    /// Over a session with any of its arenas.
    pub const fn new(client: Client) -> Self {
        Self { client, arenas: BTreeMap::new() }
    }

    /// Every arena as it is now. One that ends meanwhile is left out.
    pub fn look(&mut self) -> Result<Vec<Sight>, ClientError> {
        let rows = self.client.arenas()?.arenas;
        self.arenas.retain(|name, _| rows.iter().any(|row| row.arena == *name));
        let mut sights = Vec::with_capacity(rows.len());
        for row in rows {
            let Some(client) = self.client_of(&row.arena)? else { continue };
            if let (Ok(stats), Ok(clients)) = (client.stats(), client.clients()) {
                sights.push(Sight { row, stats, clients: clients.clients });
            }
        }
        Ok(sights)
    }

    /// The session with one of them; none when its name is none.
    pub fn client_of(&mut self, arena: &str) -> Result<Option<Client>, ClientError> {
        let Ok(name) = arena.parse() else { return Ok(None) };
        if !self.arenas.contains_key(arena) {
            self.arenas.insert(arena.to_owned(), self.client.of_arena(&name)?);
        }
        Ok(self.arenas.get(arena).cloned())
    }
}
