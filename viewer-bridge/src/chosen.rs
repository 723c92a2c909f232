//! Which balls get details: all where they are few, chosen ones where they are many.

use protocol::snapshot::Roster;

/// Up to so many balls every one gets details.
pub const FEW: usize = 64;
/// Of more balls so many, so that a crowd costs no more for them than a handful.
pub const OF_MANY: usize = 16;

/// Up to `most` balls: the one that is followed, then players, then by name.
pub fn chosen(roster: &Roster, followed: Option<usize>, most: usize) -> Vec<usize> {
    let mut balls: Vec<usize> = (0..roster.names.len()).collect();
    balls.sort_by_key(|ball| (followed != Some(*ball), !roster.player[*ball]));
    balls.truncate(most);
    balls
}

/// The balls that get details.
pub fn detailed(roster: &Roster, followed: Option<usize>) -> Vec<usize> {
    chosen(roster, followed, if roster.names.len() <= FEW { FEW } else { OF_MANY })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn roster(count: usize) -> Roster {
        Roster {
            names: (0..count).map(|i| format!("b{i:04}")).collect(),
            player: (0..count).map(|i| i == 9).collect(),
            ..Roster::default()
        }
    }

    #[test]
    fn few_balls_are_all_detailed_and_of_many_the_followed_and_the_players_first() {
        assert_eq!(detailed(&roster(FEW), None).len(), FEW);
        let of_many = detailed(&roster(FEW + 1), Some(33));
        assert_eq!((of_many.len(), &of_many[..4]), (OF_MANY, &[33, 9, 0, 1][..]));
    }
}
