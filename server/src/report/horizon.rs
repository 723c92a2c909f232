//! Until when an error has a meaning.

use super::numbers::{plain, rough};
use super::plot::{Axis, Curve, Ink, Plot};
use super::reference::Reference;
use super::section::{Table, figure};
use super::subject::{Subject, seconds};
use super::{ReportError, numbers};
use maud::{Markup, html};
use serde_json::{Value, json};

/// Fewer than 1e-16 m cannot be told from none on these lengths; a logarithm needs a place for none.
const NONE_M: f64 = 1e-17;

/// How errors grow.
#[derive(Clone, Debug)]
pub struct Horizon {
    /// Largest error of the scene's own setting up to each tick, m.
    own: Vec<f64>,
    /// First tick at which it has lost a place, if there is one.
    own_lost: Option<usize>,
}

impl Horizon {
    /// Follows the scene's own setting for as long as there is something to compare it with.
    pub fn measure(subject: &Subject, truth: &Reference) -> Result<Self, ReportError> {
        let own = truth.errors(&mut subject.start(subject.own())?, truth.ticks());
        let own_lost = own.iter().position(|&error| error.is_nan() || error > truth.lost_m);
        Ok(Self { own, own_lost })
    }

    /// The part of the page.
    pub fn show(&self, subject: &Subject, truth: &Reference) -> Result<Markup, ReportError> {
        let curve = |name: &str, ink, errors: &[f64]| Curve {
            name: name.into(),
            ink,
            points: errors.iter().enumerate().skip(1).map(|(n, &e)| [seconds(n), e.max(NONE_M)]).collect(),
            dots: false,
            dashed: false,
        };
        let lost = Curve {
            name: "a place is lost".into(),
            ink: Ink::Grey,
            points: vec![[0.0, truth.lost_m], [seconds(truth.ticks()), truth.lost_m]],
            dots: false,
            dashed: true,
        };
        let plot = Plot {
            title: format!("Error against time, {}", subject.name),
            x: Axis::linear("simulated time, s"),
            y: Axis::log("largest position error so far, m"),
            curves: vec![
                curve("own setting", Ink::Blue, &self.own),
                curve("last bit changed", Ink::Vermillion, &truth.sensitivity),
                curve("second reference", Ink::Green, &truth.disagreement),
                lost,
            ],
            marks: Vec::new(),
        };
        let caption = html! {
            "Distance from the reference, the largest of all balls and of all ticks so far. Blue is the scene’s own setting; "
            "red is the reference begun with its velocities changed by a few last bits; green is the second reference, "
            (truth.checked_by) ". Where all is equal to the last bit, a curve lies at the bottom."
        };
        Ok(html! {
            p {
                "The reference is " (Reference::setting()) ". It is compared with " (truth.checked_by)
                ": they agree to " (rough(truth.error())) " m over " (plain(truth.span_s())) " s, and errors here are taken over that span. "
                (self.verdict(truth))
            }
            (figure(&plot.svg()?, &caption))
        })
    }

    /// What the horizon is, said plainly.
    fn verdict(&self, truth: &Reference) -> Markup {
        let until = plain(seconds(truth.ticks()));
        html! {
            @if let Some(horizon) = truth.horizon {
                "Runs that differ only in their last bits lose each other after " (plain(seconds(horizon)))
                " s: by then some ball is " (rough(truth.lost_m)) " m (a tenth of the smallest radius) from where it would be. "
                "From there on no program of this precision can say where the balls are, and an error of position has no meaning; energy still has."
                @if let Some(tenfold) = truth.tenfold_s() {
                    " Errors grow tenfold in " (plain(tenfold)) " s, so a thousandth of the error buys "
                    (plain(3.0 * tenfold)) " s more."
                }
            } @else {
                "Within " (until) " s no place is lost, even when the starting velocities change in their last bits: an error has a meaning throughout."
            }
            @if let Some(lost) = self.own_lost {
                " The scene’s own setting follows the reference for " (plain(seconds(lost))) " s."
            }
        }
    }

    /// One sentence for the top of the page, where there is a horizon.
    pub fn summary(truth: &Reference) -> Markup {
        html! {
            @if let Some(horizon) = truth.horizon {
                " Its errors have a meaning for " (plain(seconds(horizon))) " s; they are taken over " (plain(truth.span_s())) " s."
            }
        }
    }

    /// Errors by tick.
    pub fn table(&self, subject: &Subject, truth: &Reference) -> Table {
        let mut table = Table::new(
            "divergence",
            &["scene", "time_s", "own_setting_m", "last_bit_changed_m", "second_reference_m"],
        );
        // Six a second say as much as sixty, in a tenth of the bytes.
        for n in (0..=truth.ticks()).step_by(10) {
            table.push([
                subject.name.clone(),
                numbers::csv(seconds(n)),
                numbers::csv(self.own[n]),
                numbers::csv(truth.sensitivity[n]),
                numbers::csv(truth.disagreement[n]),
            ]);
        }
        table
    }

    /// All of it for programs.
    pub fn json(&self, truth: &Reference) -> Value {
        json!({
            "reference": Reference::setting(),
            "checked_by": truth.checked_by,
            "reference_error_m": truth.error(),
            "span_s": truth.span_s(),
            "span_ticks": truth.span,
            "followed_s": seconds(truth.ticks()),
            "lost_m": truth.lost_m,
            "horizon_s": truth.horizon.map(seconds),
            "own_setting_horizon_s": self.own_lost.map(seconds),
            "tenfold_s": truth.tenfold_s(),
        })
    }
}
