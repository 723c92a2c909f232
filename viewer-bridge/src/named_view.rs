//! Views with a name: where the eye stands, and what is shown from there.

use crate::scene_view::Extent;
use crate::{ball_view, net_view, overlay_view};
use nalgebra::Vector3;
use protocol::snapshot::Roster;
use rerun::external::re_sdk_types::blueprint::archetypes::EyeControls3D;
use std::str::FromStr;

/// Direction from the middle of the box to the eye: from the south-east, well above the walls.
const EYE_DIRECTION: [f64; 3] = [0.42, -0.80, 0.72];
/// Distance of the eye in diagonals of the box: all of it is seen in a view that is a little wider than high.
const EYE_DISTANCE: f64 = 0.87;
/// The eye looks in front of the middle by this part of the floor's diagonal, for what is near takes up more of the view.
const LOOK_NEARER: f64 = 0.075;
/// Direction to an eye that sees a tall box whole: lower, so that the box does not come near at its upper end.
const LOW_DIRECTION: [f64; 3] = [0.42, -0.80, 0.30];
/// Half of what a view shows upwards, in distances from the eye, less a margin: the viewer's angle is 55 degrees.
const HALF_VIEW: f64 = 0.47;
/// Distance of an eye that looks straight at a side of the box, in lengths of that side.
const STRAIGHT_DISTANCE: f64 = 1.1;
/// Distance of the eye that follows a ball, in radii.
const FOLLOW_RADII: f64 = 14.0;

/// A view to open with.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum NamedView {
    /// All of the box, from a corner.
    #[default]
    Overview,
    /// From straight above, north up.
    Top,
    /// From the south.
    Side,
    /// Behind a ball: the one named, else the first player's, else the first.
    Follow(Option<String>),
    /// The overview with contact points, velocities, reactions and names.
    Vectors,
    /// The floor's control net.
    Net,
}

/// A ball that is followed.
#[derive(Clone, Debug, PartialEq)]
pub struct Followed {
    /// Its name.
    pub name: String,
    /// Its centre now, m.
    pub center_m: [f64; 3],
    /// Its radius, m.
    pub radius_m: f64,
}

/// What the eyes look at.
#[derive(Clone, Debug, PartialEq)]
pub struct Sights {
    /// The box that holds all that is drawn, but for the control net.
    pub room: Extent,
    /// The box that holds the control net.
    pub net: Extent,
    /// The ball that is followed.
    pub followed: Option<Followed>,
}

/// Every view a layout has, in the order of its tabs.
const ALL: [NamedView; 6] = [
    NamedView::Overview,
    NamedView::Top,
    NamedView::Side,
    NamedView::Follow(None),
    NamedView::Vectors,
    NamedView::Net,
];

impl FromStr for NamedView {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':').unwrap_or((text, "")) {
            ("overview", "") => Ok(Self::Overview),
            ("top", "") => Ok(Self::Top),
            ("side", "") => Ok(Self::Side),
            ("follow", "") => Ok(Self::Follow(None)),
            ("follow", name) => Ok(Self::Follow(Some(name.to_owned()))),
            ("vectors", "") => Ok(Self::Vectors),
            ("net", "") => Ok(Self::Net),
            _ => Err(format!(
                "{text} is no view: use overview, top, side, vectors, net, follow or follow:BALL"
            )),
        }
    }
}

impl NamedView {
    /// The views of a layout with these sights.
    pub fn all(sights: &Sights) -> impl Iterator<Item = Self> {
        let follows = sights.followed.is_some();
        ALL.into_iter().filter(move |view| follows || !matches!(view, Self::Follow(_)))
    }

    /// Whether it is the same tab.
    pub fn same_tab(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other)
    }

    /// What stands on its tab.
    pub fn title(&self, sights: &Sights) -> String {
        match self {
            Self::Overview => "Overview".into(),
            Self::Top => "Top".into(),
            Self::Side => "Side".into(),
            Self::Follow(_) => {
                format!("Follow {}", sights.followed.as_ref().map_or("", |ball| ball.name.as_str()))
            }
            Self::Vectors => "Vectors".into(),
            Self::Net => "Control net".into(),
        }
    }

    /// Entities that are there but not seen until someone switches them on.
    pub fn hidden(&self) -> &'static [&'static str] {
        match self {
            Self::Vectors => &[net_view::NET],
            Self::Net => &[overlay_view::OVERLAYS],
            _ => &[net_view::NET, overlay_view::OVERLAYS],
        }
    }

    /// The ball that this view follows, of a roster: the one it names, else the first player's, else the first.
    pub fn followed(&self, roster: &Roster) -> Option<usize> {
        let named = match self {
            Self::Follow(Some(name)) => roster.names.iter().position(|other| other == name),
            _ => None,
        };
        let player = || roster.player.iter().position(|player| *player);
        named.or_else(player).or_else(|| (!roster.names.is_empty()).then_some(0))
    }

    /// The name it asks for and a roster lacks.
    pub fn missing<'a>(&'a self, roster: &Roster) -> Option<&'a str> {
        match self {
            Self::Follow(Some(name)) if !roster.names.contains(name) => Some(name),
            _ => None,
        }
    }

    /// Where its eye stands and looks.
    pub fn eye(&self, sights: &Sights) -> EyeControls3D {
        let middle = Vector3::from(sights.room.middle());
        let size = Vector3::from(sights.room.highest) - Vector3::from(sights.room.lowest);
        let (eye, target, up) = match self {
            Self::Overview | Self::Vectors => corner(sights.room),
            Self::Net => whole(sights.net),
            Self::Top => {
                let above = sights.room.highest[2] + STRAIGHT_DISTANCE * size.x.max(size.y);
                (Vector3::new(middle.x, middle.y, above), middle, Vector3::y())
            }
            Self::Side => {
                let before = sights.room.lowest[1] - STRAIGHT_DISTANCE * size.x.max(size.z);
                (Vector3::new(middle.x, before, middle.z), middle, Vector3::z())
            }
            Self::Follow(_) => {
                let ball = sights.followed.as_ref();
                let center = ball.map_or(middle, |ball| Vector3::from(ball.center_m));
                let distance = FOLLOW_RADII * ball.map_or(1.0, |ball| ball.radius_m);
                (center + Vector3::from(EYE_DIRECTION).normalize() * distance, center, Vector3::z())
            }
        };
        let eye = EyeControls3D::new()
            .with_position(crate::single(eye))
            .with_look_target(crate::single(target))
            .with_eye_up(crate::single(up));
        if matches!(self, Self::Follow(_)) { eye.with_tracking_entity(ball_view::FOLLOWED) } else { eye }
    }
}

/// Eye, what it looks at, and what is up, for a box seen whole from a corner.
fn corner(extent: Extent) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
    let direction = Vector3::from(EYE_DIRECTION).normalize();
    let middle = Vector3::from(extent.middle());
    let across = f64::hypot(extent.highest[0] - extent.lowest[0], extent.highest[1] - extent.lowest[1]);
    let nearer = Vector3::new(direction.x, direction.y, 0.0) * (LOOK_NEARER * across);
    (middle + direction * (EYE_DISTANCE * extent.diagonal_m()), middle + nearer, Vector3::z())
}

/// The same for a box however tall: far enough for each of its corners to be seen.
fn whole(extent: Extent) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
    let (back, up) = (Vector3::from(LOW_DIRECTION).normalize(), Vector3::z());
    let right = up.cross(&back).normalize();
    let above = back.cross(&right);
    let middle = Vector3::from(extent.middle());
    let distance = extent.corners().map(|corner| {
        let from = corner - middle;
        // Where it is as far off the axis as is still seen, or nearer to it.
        from.dot(&back) + from.dot(&right).abs().max(from.dot(&above).abs()) / HALF_VIEW
    });
    (middle + back * distance.into_iter().fold(0.0, f64::max), middle, up)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn a_tall_net_is_seen_whole_and_fills_the_view() {
        for (low, high) in [(-70.0, 40.0), (-1.0, 1.0), (0.0, 500.0)] {
            let net = Extent { lowest: [-10.0, -10.0, low], highest: [10.0, 10.0, high] };
            let (eye, target, up) = whole(net);
            let ahead = (target - eye).normalize();
            let right = ahead.cross(&up).normalize();
            let above = right.cross(&ahead);
            let off = net.corners().map(|corner| {
                let from = corner - eye;
                from.dot(&right).abs().max(from.dot(&above).abs()) / from.dot(&ahead)
            });
            let farthest = off.into_iter().fold(0.0, f64::max);
            assert!((farthest - HALF_VIEW).abs() < 1e-9, "{farthest} from {low} to {high}");
        }
    }

    #[test]
    fn a_view_is_named_as_on_the_command_line() {
        assert_eq!("top".parse(), Ok(NamedView::Top));
        assert_eq!("follow".parse(), Ok(NamedView::Follow(None)));
        assert_eq!("follow:a:b".parse(), Ok(NamedView::Follow(Some("a:b".into()))));
        for wrong in ["", "above", "top:a"] {
            assert!(wrong.parse::<NamedView>().unwrap_err().contains("use overview"), "{wrong}");
        }
    }

    #[test]
    fn the_named_ball_is_followed_else_the_players_else_the_first() {
        let mut roster = testing::original().roster;
        assert_eq!(NamedView::Follow(Some("b".into())).followed(&roster), Some(1));
        let moon = NamedView::Follow(Some("moon".into()));
        assert_eq!((moon.followed(&roster), moon.missing(&roster)), (Some(2), Some("moon")));
        roster.player = vec![false; 3];
        assert_eq!(NamedView::Overview.followed(&roster), Some(0));
        assert_eq!(NamedView::Overview.followed(&Roster::default()), None);
    }
}
