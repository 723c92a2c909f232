//! What order every scheme of fixed step shows over all ticks, inside steps too, beside the reference `bumps-solid`; and
//! whether an error asked for is obtained, beside every reference without hits.

use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::references::{self, bumps_errors};
use crate::ride::Largest;
use ballroom_physics::{Accuracy, SceneFault, Scheme};

/// The scheme's order less those observed for centre, velocity, angular velocity and orientation, from a step to its half;
/// negative where more is seen.
fn missing(scheme: Scheme, order: f64, step: f64) -> Result<[f64; 4], SceneFault> {
    let coarse = bumps_errors(Accuracy::Fixed(scheme, step))?;
    let fine = bumps_errors(Accuracy::Fixed(scheme, 0.5 * step))?;
    Ok(std::array::from_fn(|part| order - (coarse[part] / fine[part]).log2()))
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let span = Span::Seconds(10.0);
    let mut cases = vec![];
    for (name, scheme, order, step) in [
        ("rk4", Scheme::Rk4, 4.0, 0.02),
        ("tsit5", Scheme::Tsit5, 5.0, 0.02),
        ("dop853", Scheme::Dop853, 8.0, 0.2),
    ] {
        let demand = |quantity| Demand {
            norm: "of the largest error over ticks, from a step to its half",
            ..Demand::over_ticks(quantity, "1", span, 0.5)
        };
        cases.push(Case::new(
            format!("O/{name}"),
            format!("the order of {name}, which is {order}"),
            [
                demand("order of the scheme less that of the centre"),
                demand("order of the scheme less that of the velocity"),
                demand("order of the scheme less that of the angular velocity"),
                demand("order of the scheme less that of the orientation"),
            ],
            move || missing(scheme, order, step),
        ));
    }
    cases.extend(references::smooth().map(|(name, is_flat, error)| asked(name, is_flat, error)));
    cases
}

/// What is asked for, m.
const TOLERANCES: [f64; 7] = [1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12];

/// Whether a reference is followed as exactly as asked for, and not much more exactly, which would cost steps; a flat floor
/// has none to spare, and is exact whatever is asked for.
fn asked(
    name: &str,
    is_flat: bool,
    error: impl Fn(Accuracy) -> Result<f64, SceneFault> + Send + Sync + 'static,
) -> Case {
    let over = |quantity, limit| Demand {
        norm: "largest over what is asked for, from 1e-6 to 1e-12 m",
        ..Demand::over_ticks(quantity, "1", Span::Seconds(10.0), limit)
    };
    Case::new(
        format!("O/asked/{name}"),
        "an error asked for is obtained, and no step wasted on a smaller one",
        [
            over("error obtained over error asked for", 1.0),
            over("error asked for over error obtained", 100.0),
        ],
        move || {
            let mut largest = [Largest::default(); 2];
            for tolerance in TOLERANCES {
                let obtained = error(Accuracy::Tolerance(tolerance))?;
                largest[0].see(obtained / tolerance);
                if !is_flat {
                    largest[1].see(tolerance / obtained);
                }
            }
            Ok(largest.map(Largest::value))
        },
    )
}
