//! Who reads the states, as they say themselves: bounded, and forgotten when they fall silent.

use protocol::codec;
use protocol::keys::{Name, Role};
use protocol::report::{
    ClientRow, Clients, FORGOTTEN_AFTER, MAX_READERS, MAX_REPORT_BYTES, REPORT_EVERY, Report,
};
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Reports come this many times as often as they should before they are passed over.
const IMPATIENCE: u32 = 4;

/// The readers of an arena.
#[derive(Default)]
pub struct Readers(Mutex<BTreeMap<(Role, Name), (Report, Instant)>>);

impl Readers {
    /// Takes in a report, or says why not.
    pub fn hear(&self, reader: (Role, Name), bytes: &[u8], now: Instant) -> Result<(), String> {
        if bytes.len() > MAX_REPORT_BYTES {
            return Err(format!("{} bytes are too many: at most {MAX_REPORT_BYTES}", bytes.len()));
        }
        let mut known = self.lock();
        match known.get(&reader) {
            Some((_, heard)) if now.saturating_duration_since(*heard) < REPORT_EVERY / IMPATIENCE => {
                return Err("too many reports: send one a second".to_owned());
            }
            None if known.len() >= MAX_READERS => {
                known.retain(|_, (_, heard)| is_remembered(*heard, now));
                if known.len() >= MAX_READERS {
                    return Err(format!("{MAX_READERS} readers are known already"));
                }
            }
            _ => {}
        }
        let report: Report = codec::decode_json(bytes).map_err(|e| e.to_string())?;
        if !report.is_sane() {
            return Err("its numbers are absurd".to_owned());
        }
        known.insert(reader, (report, now));
        Ok(())
    }

    /// Those who have not fallen silent.
    pub fn list(&self, now: Instant) -> Clients {
        let mut known = self.lock();
        known.retain(|_, (_, heard)| is_remembered(*heard, now));
        let row = |((role, id), (report, heard)): (&(Role, Name), &(Report, Instant))| ClientRow {
            role: *role,
            id: id.clone(),
            heard_ms: now.saturating_duration_since(*heard).as_secs_f64() * 1e3,
            report: *report,
        };
        Clients { clients: known.iter().map(row).collect() }
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<(Role, Name), (Report, Instant)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn is_remembered(heard: Instant, now: Instant) -> bool {
    now.saturating_duration_since(heard) < REPORT_EVERY * FORGOTTEN_AFTER
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reader(i: usize) -> (Role, Name) {
        (Role::Tool, format!("r{i}").parse().unwrap())
    }

    #[test]
    fn readers_are_heard_once_a_second_and_forgotten_when_silent() {
        let (readers, start) = (Readers::default(), Instant::now());
        let report = codec::encode_json(&Report { received: 3, ..Report::default() });
        assert!(readers.hear(reader(1), &report, start).is_ok());
        assert!(readers.hear(reader(1), &report, start).is_err());
        assert!(readers.hear(reader(1), &report, start + REPORT_EVERY).is_ok());
        assert_eq!(readers.list(start + REPORT_EVERY).clients[0].report.received, 3);
        assert!(readers.list(start + REPORT_EVERY * (1 + FORGOTTEN_AFTER)).clients.is_empty());
    }

    #[test]
    fn what_is_no_report_leaves_nothing_and_the_memory_is_bounded() {
        let (readers, now) = (Readers::default(), Instant::now());
        for bad in [&b"{}"[..], b"null", &[b' '; MAX_REPORT_BYTES + 1], br#"{"states_per_s":-1}"#] {
            assert!(readers.hear(reader(0), bad, now).is_err());
        }
        assert!(readers.list(now).clients.is_empty());
        let report = codec::encode_json(&Report::default());
        assert!((0..MAX_READERS).all(|i| readers.hear(reader(i), &report, now).is_ok()));
        assert!(readers.hear(reader(MAX_READERS), &report, now).is_err());
        assert!(readers.hear(reader(MAX_READERS), &report, now + REPORT_EVERY * FORGOTTEN_AFTER).is_ok());
    }
}
