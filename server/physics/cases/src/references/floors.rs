//! The floors of the references; their twins stand in `generators/floors.py`.

use super::charts::{Shape, bent, leaning};
use ballroom_physics::Floor;
use ballroom_physics::surface::bezier::BezierPatch;

/// A plane, on which arcs are parabolas.
pub const INCLINE: Shape = Shape::Terms(&[(1, 0, 0.25)]);
/// B1, B2, B8: a parabolic cylinder.
pub const PARABOLA: Shape = Shape::Terms(&[(2, 0, 0.75)]);
/// B3, B4: a paraboloid.
pub const BOWL: Shape = Shape::Terms(&[(2, 0, 0.25), (0, 2, 0.25)]);
/// A bowl without symmetry.
pub const BUMPS: Shape = Shape::Terms(&[
    (2, 0, 0.2),
    (0, 2, 0.15),
    (1, 1, 0.05),
    (3, 0, -0.03),
    (1, 2, 0.02),
    (2, 2, 0.01),
    (0, 4, 0.004),
]);
/// Two wells and the saddle between them.
pub const SADDLE: Shape = Shape::Terms(&[(2, 0, 0.25), (0, 2, -0.125), (0, 4, 0.125)]);
/// A monkey saddle, x^3 - 3 x y^2, in a quartic bowl that keeps the ball.
pub const MONKEY: Shape =
    Shape::Terms(&[(3, 0, 0.25), (1, 2, -0.75), (4, 0, 0.125), (2, 2, 0.25), (0, 4, 0.125)]);
/// (x^2 + y^2)^2 / 2 with a dent that takes its symmetry: 70 degrees near 1.11 m.
pub const STEEP: Shape = Shape::Terms(&[(4, 0, 0.5), (2, 2, 1.0), (0, 4, 0.5), (2, 1, 0.125)]);

/// The pit of the program this one grew out of, degree 10 x 10.
pub fn pit() -> Shape {
    let mut heights = vec![vec![0.0; 11]; 11];
    heights[3][5] = -70.0;
    Shape::Net(10.0, heights)
}

/// A bumpy bicubic.
pub fn bicubic() -> Shape {
    let rows = [
        [1751.0, 28.0, 790.0, 1083.0],
        [567.0, 81.0, -381.0, 623.0],
        [461.0, 987.0, 194.0, 592.0],
        [1157.0, 512.0, 413.0, 1129.0],
    ];
    Shape::Net(1.5, rows.map(|row| row.map(|h| h / 1024.0).to_vec()).to_vec())
}

/// Degree 12 x 12: a bowl with bumps at every control point; the numbers are anything that repeats late.
pub fn twelve() -> Shape {
    let height = |i: i32, j: i32| {
        let bump = (7 * i * i + 5 * i * j + 11 * j * j + 3 * i) % 17 - 8;
        f64::from((i - 6).pow(2) + (j - 6).pow(2)) / 32.0 + f64::from(bump) / 64.0
    };
    Shape::Net(2.0, (0..13).map(|i| (0..13).map(|j| height(i, j)).collect()).collect())
}

/// How a surface is given to the engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chart {
    /// As it is written: a polynomial, or heights over a regular grid.
    Plain,
    /// The net of a polynomial.
    Net,
    /// x and y quadratic in u and v.
    Bent,
    /// x and y bilinear in u and v.
    Leaning,
}

impl Chart {
    /// What it adds to a case's name.
    pub const fn suffix(self) -> &'static str {
        match self {
            Self::Plain => "",
            Self::Net => "-net",
            Self::Bent => "-bent",
            Self::Leaning => "-leaning",
        }
    }

    /// The floor over at least [-half, half]^2.
    pub fn floor(self, shape: &Shape, half: f64) -> Floor {
        let border = [-half, half];
        match (self, shape) {
            (Self::Plain, Shape::Terms(list)) => {
                let degree = list.iter().map(|t| t.0.max(t.1)).max().unwrap_or(0);
                let mut terms = vec![vec![0.0; degree + 1]; degree + 1];
                list.iter().for_each(|(i, j, c)| terms[*i][*j] = *c);
                Floor::Polynomial { x: border, y: border, terms }
            }
            (Self::Plain, Shape::Net(half, heights)) => {
                let rows: Vec<Vec<f64>> =
                    (0..heights[0].len()).map(|j| heights.iter().map(|column| column[j]).collect()).collect();
                let border = [-half, *half];
                let patch = BezierPatch::from_heights(border, border, &rows).expect("a regular grid");
                Floor::Bezier(patch)
            }
            (Self::Net, _) => Floor::Bezier(shape.over(&bent(half, 0.0, true), &bent(half, 0.0, false))),
            (Self::Bent, _) => Floor::Bezier(shape.over(&bent(half, 0.45, true), &bent(half, -0.45, false))),
            (Self::Leaning, _) => {
                let wide = half / 0.55;
                Floor::Bezier(shape.over(&leaning(wide, 0.45, true), &leaning(wide, -0.45, false)))
            }
        }
    }
}
