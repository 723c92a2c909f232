//! How the states of an arena reach those who read them: each reader says so once a second.
//!
//! Every message on `state`, `event`, `stats` and `meta/scene` carries a [`Stamp`] as its attachment. Its number tells a
//! reader what was published and did not arrive; its time tells how old the message is. Ages compare the wall clocks of
//! two machines: on one machine they are true to the microsecond, else as good as the clocks are set. Jitter and losses
//! depend on no clock.

use crate::keys::{Name, Role};
use serde::{Deserialize, Serialize};

/// Length of a [`Stamp`].
pub const STAMP_BYTES: usize = 16;
/// Longest report.
pub const MAX_REPORT_BYTES: usize = 512;
/// Most readers remembered.
pub const MAX_READERS: usize = 256;
/// Time between two reports of a reader.
pub const REPORT_EVERY: std::time::Duration = std::time::Duration::from_secs(1);
/// Silence after which a reader is forgotten, in [`REPORT_EVERY`].
pub const FORGOTTEN_AFTER: u32 = 5;

/// What a message carries beside its payload: two unsigned numbers of 64 bits, little endian.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stamp {
    /// Number of the message on its key since the arena was started; what nobody reads is not published nor counted.
    pub sequence: u64,
    /// When what it tells was so, ns since 1970.
    pub wall_ns: u64,
}

impl Stamp {
    /// As it travels.
    pub fn to_bytes(self) -> [u8; STAMP_BYTES] {
        let mut bytes = [0; STAMP_BYTES];
        bytes[..8].copy_from_slice(&self.sequence.to_le_bytes());
        bytes[8..].copy_from_slice(&self.wall_ns.to_le_bytes());
        bytes
    }

    /// None when it is no stamp.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (sequence, wall_ns) = bytes.split_at_checked(8)?;
        Some(Self {
            sequence: u64::from_le_bytes(sequence.try_into().ok()?),
            wall_ns: u64::from_le_bytes(wall_ns.try_into().ok()?),
        })
    }
}

/// What a reader says of the states it got over the last second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Report {
    /// States that came, a second.
    pub states_per_s: f64,
    /// Their bytes, a second.
    pub bytes_per_s: f64,
    /// Age on arrival, median and largest; none when none came.
    pub age_ms: Option<[f64; 2]>,
    /// Mean difference between the ages of two states that came one after the other.
    pub jitter_ms: Option<f64>,
    /// States that came since the reader began.
    pub received: u64,
    /// States that were published since then and did not arrive; none when the reader cannot tell these from those that
    /// it was too slow for.
    pub lost: Option<u64>,
    /// States that were overtaken by a newer one before they were read; with `lost` unknown, those too.
    pub overtaken: u64,
}

impl Report {
    /// Whether its numbers are such that a clock and a counter may say.
    pub fn is_sane(&self) -> bool {
        let rates = [self.states_per_s, self.bytes_per_s];
        let times = self.age_ms.into_iter().flatten().chain(self.jitter_ms);
        rates.iter().all(|rate| (0.0..=1e12).contains(rate))
            && times.into_iter().all(|time| time.abs() <= 1e15)
    }
}

/// Who reads, in the order of role and id.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Clients {
    /// One by one.
    pub clients: Vec<ClientRow>,
}

/// One reader.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClientRow {
    /// What it is.
    pub role: Role,
    /// Which.
    pub id: Name,
    /// How long ago it said so.
    pub heard_ms: f64,
    /// What it said.
    #[serde(flatten)]
    pub report: Report,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stamp_survives_its_bytes_and_others_are_none() {
        let stamp = Stamp { sequence: 7, wall_ns: u64::MAX - 1 };
        assert_eq!(Stamp::from_bytes(&stamp.to_bytes()), Some(stamp));
        for length in [0, 7, 8, 15, 17] {
            assert_eq!(Stamp::from_bytes(&[1; 32][..length]), None);
        }
    }

    #[test]
    fn a_report_with_absurd_numbers_is_not_believed() {
        let good = Report { age_ms: Some([-3.0, 4.0]), jitter_ms: Some(0.5), ..Report::default() };
        assert!(good.is_sane());
        for bad in [
            Report { states_per_s: -1.0, ..good },
            Report { bytes_per_s: f64::NAN, ..good },
            Report { age_ms: Some([0.0, f64::INFINITY]), ..good },
            Report { jitter_ms: Some(1e16), ..good },
        ] {
            assert!(!bad.is_sane(), "{bad:?}");
        }
    }
}
