//! Energy in its parts and the floor's reaction over time: the whole arena, and ball by ball for the first few.

use crate::mechanics::{Energy, Mechanics};
use crate::palette;
use crate::recording::Recording;
use crate::surface::Surface;
use protocol::snapshot::{Roster, Snapshot};
use rerun::{RecordingStreamResult, Scalars, SeriesLines};

/// Energy of all balls, J: kinetic, spin, potential, total.
pub const PARTS: &str = "plots/energy_parts";
/// Energy of the centre's motion, ball by ball, J.
pub const KINETIC: &str = "plots/balls/kinetic";
/// Energy of the rotation, ball by ball, J.
pub const SPIN: &str = "plots/balls/spin";
/// Energy of the height, ball by ball, J.
pub const POTENTIAL: &str = "plots/balls/potential";
/// Reaction of the floor, ball by ball, N.
pub const REACTION: &str = "plots/balls/reaction";

/// At most so many balls have lines of their own; more could not be told apart.
pub const MAX_BALLS: usize = 12;
/// Wall time between two points, ns.
const LOG_EVERY_NS: u64 = 100_000_000;

/// State behind these plots.
pub struct EnergyPlots {
    mechanics: Mechanics,
    balls: Vec<usize>,
    logged_ns: Option<u64>,
}

impl EnergyPlots {
    /// Plots for a roster; `balls` are those that get lines of their own, the first of them.
    pub fn of(mechanics: Mechanics, mut balls: Vec<usize>) -> Self {
        balls.truncate(MAX_BALLS);
        Self { mechanics, balls, logged_ns: None }
    }

    /// Names and colours of all lines, for all time.
    pub fn log_names(&self, rec: &Recording, roster: &Roster) -> RecordingStreamResult<()> {
        let parts = SeriesLines::new()
            .with_names(["kinetic", "spin", "potential", "total"])
            .with_colors([0xE45C_5CFF_u32, 0x5C9E_E4FF, 0x6FCF_7FFF, 0xF4A6_3AFF])
            .with_widths([1.5; 4]);
        rec.log_static(PARTS, &parts)?;
        let balls = SeriesLines::new()
            .with_names(self.balls.iter().map(|ball| roster.names[*ball].as_str()))
            .with_colors(self.balls.iter().map(|ball| palette::color(roster.color_rgb[*ball])))
            .with_widths(self.balls.iter().map(|_| 1.5));
        [KINETIC, SPIN, POTENTIAL, REACTION].into_iter().try_for_each(|path| rec.log_static(path, &balls))
    }

    /// Logs what a state tells, ten times a second.
    pub fn log_state(
        &mut self,
        rec: &Recording,
        surface: &Surface,
        roster: &Roster,
        state: &Snapshot,
    ) -> RecordingStreamResult<()> {
        if self.logged_ns.is_some_and(|last| state.wall_ns.abs_diff(last) < LOG_EVERY_NS) {
            return Ok(());
        }
        self.logged_ns = Some(state.wall_ns);
        let energy = |ball: usize| self.mechanics.energy(roster, state, ball);
        let all: Energy = (0..roster.names.len()).map(energy).sum();
        rec.log(PARTS, &Scalars::new([all.kinetic_j, all.spin_j, all.potential_j, all.total_j()]))?;
        if self.balls.is_empty() {
            return Ok(());
        }
        let lines = |value: &dyn Fn(usize) -> f64| Scalars::new(self.balls.iter().map(|ball| value(*ball)));
        rec.log(KINETIC, &lines(&|ball| energy(ball).kinetic_j))?;
        rec.log(SPIN, &lines(&|ball| energy(ball).spin_j))?;
        rec.log(POTENTIAL, &lines(&|ball| energy(ball).potential_j))?;
        let jet = |ball: usize| surface.jet(state.uv[ball][0], state.uv[ball][1]);
        rec.log(REACTION, &lines(&|ball| self.mechanics.reaction_n(&jet(ball), roster, state, ball)))
    }
}
