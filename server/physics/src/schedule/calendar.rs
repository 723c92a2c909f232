//! Whose hit is due soon: balls by the day of their next event, where a day is about as long as a few hits take.
//!
//! A calendar forgets whom it has no room for, and does not learn that an event is void: it says whom to look at, not what
//! happens. Each day has one line of cache.

use super::time::{QUANTUM, Time};

/// Balls a day has room for.
const ROOM: usize = 12;
/// Hits a day should have.
const HITS_A_DAY: f64 = 4.0;
/// Hits after which the length of a day is looked at.
const HITS_LOOKED_AT: u32 = 256;
/// Days looked at for whom is due next.
const DAYS_AHEAD: i64 = 3;
/// Balls for each day: time enough for most predictions.
const BALLS_PER_DAY: usize = 8;
/// Fewest and most days a quantum: one lasts a second, or 15 ns.
const DAYS_A_QUANTUM: [f64; 2] = [1.0 / 64.0, 1_048_576.0];

#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Day {
    number: i64,
    count: u32,
    balls: [u32; ROOM],
}

const _: () = assert!(size_of::<Day>() == 64);

/// Balls by the day of their next hit.
#[derive(Clone, Debug)]
pub struct Calendar {
    days: Vec<Day>,
    /// A power of two.
    days_a_quantum: f64,
    /// The day of the last hit.
    today: i64,
    hits: u32,
    looked_at: Time,
}

impl Calendar {
    /// For so many balls.
    pub fn new(balls: usize) -> Self {
        let days = (balls / BALLS_PER_DAY).next_power_of_two().max(16);
        let nobody = Day { number: -1, count: 0, balls: [0; ROOM] };
        Self { days: vec![nobody; days], days_a_quantum: 1.0, today: 0, hits: 0, looked_at: Time::ZERO }
    }

    /// A ball's hit at `time` was found.
    pub fn note(&mut self, ball: usize, time: Time) {
        let number = self.day_of(time);
        let ahead = usize::try_from(number - self.today);
        if !ahead.is_ok_and(|ahead| ahead < self.days.len()) {
            return;
        }
        let place = self.place_of(number);
        let day = &mut self.days[place];
        if day.number != number {
            (day.number, day.count) = (number, 0);
        }
        if (day.count as usize) < ROOM {
            day.balls[day.count as usize] = ball as u32;
            day.count += 1;
        }
    }

    /// Whether `event` is on one of the days that [`Self::ahead`] looks at.
    pub fn is_soon(&self, event: Time) -> bool {
        self.day_of(event) < self.today + DAYS_AHEAD
    }

    /// Visits whom a hit was found for on the day of the last hit and the next days, until `visit` has had enough. Their
    /// hits may be others by now.
    pub fn ahead(&self, mut visit: impl FnMut(usize) -> bool) {
        for number in self.today..self.today + DAYS_AHEAD {
            let day = &self.days[self.place_of(number)];
            if day.number == number
                && !day.balls[..day.count as usize].iter().all(|ball| visit(*ball as usize))
            {
                return;
            }
        }
    }

    /// A hit happens at `time`: days become as long as a few of them.
    pub fn count(&mut self, time: Time) {
        self.today = self.day_of(time);
        self.hits += 1;
        if self.hits < HITS_LOOKED_AT {
            return;
        }
        let quanta = time.since(self.looked_at) / QUANTUM;
        (self.hits, self.looked_at) = (0, time);
        let wanted = f64::from(HITS_LOOKED_AT) / HITS_A_DAY / quanta;
        let mut days = self.days_a_quantum;
        while days < 0.5 * wanted && days < DAYS_A_QUANTUM[1] {
            days *= 2.0;
        }
        while days > 2.0 * wanted && days > DAYS_A_QUANTUM[0] {
            days *= 0.5;
        }
        if days != self.days_a_quantum {
            self.days_a_quantum = days;
            self.today = self.day_of(time);
            for day in &mut self.days {
                (day.number, day.count) = (-1, 0);
            }
        }
    }

    fn day_of(&self, time: Time) -> i64 {
        ((time.quantum() as f64 + time.offset() / QUANTUM) * self.days_a_quantum) as i64
    }

    const fn place_of(&self, number: i64) -> usize {
        number as usize & (self.days.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_hits_are_found_whatever_their_rate() {
        for rate in [30.0, 4e3, 5e5] {
            let mut calendar = Calendar::new(1000);
            let time = |hit: usize| Time::of_seconds(hit as f64 / rate);
            for hit in 0..5000 {
                calendar.note(hit + 40, time(hit + 40));
                calendar.count(time(hit));
                let (mut soon, mut seen) = (0, 0);
                calendar.ahead(|ball| {
                    soon += usize::from(ball > hit && ball < hit + 20);
                    seen += 1;
                    true
                });
                assert!(hit < 600 || soon >= 6, "{rate}: {soon} after {hit}");
                assert!(seen <= ROOM * DAYS_AHEAD as usize);
            }
        }
    }
}
