//! Hard cases: what breaks typical engines, each with its exact answer. One family a file.

pub mod billiards;
pub mod bullet;
pub mod cradle;
pub mod crowds;
mod discs_table;
pub mod galperin;
pub mod guises;
pub mod inelastic;
pub mod instants;
pub mod long;
pub mod rack;
pub mod rods;
pub mod row;
pub mod smooth;

use crate::case::Case;

/// Every case of this room, family by family.
pub fn cases() -> Vec<Case> {
    [
        galperin::cases(),
        cradle::cases(),
        rack::cases(),
        bullet::cases(),
        billiards::cases(),
        row::cases(),
        inelastic::cases(),
        smooth::cases(),
        long::cases(),
        guises::cases(),
        crowds::cases(),
        instants::cases(),
    ]
    .into_iter()
    .flatten()
    .collect()
}
