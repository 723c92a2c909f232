//! The nets of S and its derivatives on boxes of the parameter square, and what they enclose.

use super::affine::Affine;
use super::bezier::{BezierPatch, MAX_DEGREE, Parameter};

/// Something for every derivative of S to second order, by component.
pub(super) struct Derivatives<T> {
    /// `S_u`.
    pub u: [T; 3],
    /// `S_v`.
    pub v: [T; 3],
    /// `S_uu`.
    pub uu: [T; 3],
    /// `S_uv`.
    pub uv: [T; 3],
    /// `S_vv`.
    pub vv: [T; 3],
}

impl<T> Derivatives<T> {
    fn map<R>(&self, f: impl Fn(&T) -> R) -> Derivatives<R> {
        let each = |vector: &[T; 3]| vector.each_ref().map(&f);
        Derivatives {
            u: each(&self.u),
            v: each(&self.v),
            uu: each(&self.uu),
            uv: each(&self.uv),
            vv: each(&self.vv),
        }
    }

    fn vectors(&self) -> [&[T; 3]; 5] {
        [&self.u, &self.v, &self.uu, &self.uv, &self.vv]
    }
}

/// Derivatives on one box.
impl Derivatives<ScalarNet> {
    /// Affine enclosures over the box.
    pub fn enclosures(&self) -> Derivatives<Affine> {
        self.map(ScalarNet::enclosure)
    }

    /// Values at a corner of the box.
    pub fn corner(&self, signs: [f64; 2]) -> Derivatives<Affine> {
        self.map(|net| net.corner(signs))
    }

    fn new(patch: &BezierPatch) -> Self {
        let first = |parameter| -> [ScalarNet; 3] {
            let (degree, net) = patch.derivative_net(parameter);
            std::array::from_fn(|k| ScalarNet {
                degree,
                coefficients: net.iter().map(|p| p[k]).collect(),
                slack: patch.net().iter().map(|p| p[k].abs()).fold(0.0, f64::max),
            })
        };
        let (u, v) = (first(Parameter::U), first(Parameter::V));
        let uu = u.each_ref().map(|net| net.derivative(Parameter::U));
        let uv = u.each_ref().map(|net| net.derivative(Parameter::V));
        let vv = v.each_ref().map(|net| net.derivative(Parameter::V));
        let [p, q] = patch.degree().map(|d| d as f64);
        let settle = |nets: [ScalarNet; 3], factor: f64| nets.map(|net| net.settled(factor));
        Self {
            u: settle(u, p),
            v: settle(v, q),
            uu: settle(uu, p * p),
            uv: settle(uv, p * q),
            vv: settle(vv, q * q),
        }
    }
}

/// Parts of a unit of u or v that a box can be as small as: 2^-26 is where second derivatives are rounding, and what is
/// undecided there is degenerate.
const PARTS: u32 = 1 << 26;

/// The box from `low` to `high` in u and v, in units of 2^-26; a line or a point where they are equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Rectangle {
    /// Smallest u and v.
    pub low: [u32; 2],
    /// Largest u and v.
    pub high: [u32; 2],
}

impl Rectangle {
    /// The whole parameter square.
    pub const WHOLE: Self = Self { low: [0; 2], high: [PARTS; 2] };

    /// The borders u = 0, u = 1, v = 0 and v = 1.
    pub const BORDERS: [Self; 4] = [
        Self { low: [0; 2], high: [0, PARTS] },
        Self { low: [PARTS, 0], high: [PARTS; 2] },
        Self { low: [0; 2], high: [PARTS, 0] },
        Self { low: [0, PARTS], high: [PARTS; 2] },
    ];

    fn range(&self, direction: usize) -> [f64; 2] {
        [self.low, self.high].map(|end| f64::from(end[direction]) / f64::from(PARTS))
    }

    /// Its middle.
    pub fn middle(&self) -> [f64; 2] {
        [0, 1].map(|direction| {
            let [low, high] = self.range(direction);
            0.5 * (low + high)
        })
    }

    /// A corner; signs are -1 or +1.
    pub fn corner(&self, signs: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|direction| self.range(direction)[usize::from(signs[direction] > 0.0)])
    }

    /// That corner as a box of its own.
    pub fn corner_box(&self, signs: [f64; 2]) -> Self {
        let end = [0, 1].map(|d| if signs[d] > 0.0 { self.high[d] } else { self.low[d] });
        Self { low: end, high: end }
    }

    /// Its two halves, unless it is too small to be cut.
    pub fn halves(&self, direction: usize) -> Option<[Self; 2]> {
        let middle = self.low[direction].midpoint(self.high[direction]);
        if middle == self.low[direction] {
            return None;
        }
        let [mut lower, mut upper] = [*self; 2];
        lower.high[direction] = middle;
        upper.low[direction] = middle;
        Some([lower, upper])
    }

    /// The smallest box around both.
    pub fn hull(&self, other: &Self) -> Self {
        Self {
            low: [0, 1].map(|d| self.low[d].min(other.low[d])),
            high: [0, 1].map(|d| self.high[d].max(other.high[d])),
        }
    }

    /// A box around this one, at most a quarter larger each way, of which there are few, so that many share one.
    pub fn rounded(&self) -> Self {
        let mut round = *self;
        for d in 0..2 {
            let unit = ((self.high[d] - self.low[d]).next_power_of_two() / 8).max(1);
            round.low[d] -= self.low[d] % unit;
            round.high[d] = self.high[d].next_multiple_of(unit);
        }
        round
    }

    /// Whether both are so close that a box of twice the size holds them.
    pub fn is_near(&self, other: &Self) -> bool {
        let hull = self.hull(other);
        let width = |r: &Self, d: usize| r.high[d] - r.low[d];
        (0..2).all(|d| width(&hull, d) <= 8 * width(self, d).max(width(other, d)))
    }

    /// A place of this box, given by (s, t) in [-1, 1]^2, in the (s, t) of a box around it: `[middle, half width]` in
    /// each direction.
    pub fn within(&self, hull: &Self) -> [[f64; 2]; 2] {
        [0, 1].map(|d| {
            let sum = |r: &Self| f64::from(r.low[d]) + f64::from(r.high[d]);
            let width = |r: &Self| f64::from(r.high[d] - r.low[d]);
            let whole = width(hull).max(1.0);
            [(sum(self) - sum(hull)) / whole, width(self) / whole]
        })
    }
}

/// The nets of a patch and of its derivatives.
pub(super) struct DerivativeNets {
    /// S - S(0, 0).
    point: [ScalarNet; 3],
    nets: Derivatives<ScalarNet>,
    /// Largest absolute coefficient of each derivative, to compare variations by.
    sizes: [f64; 5],
}

impl DerivativeNets {
    /// Of a patch.
    pub fn new(patch: &BezierPatch) -> Self {
        let nets = Derivatives::new(patch);
        let sizes = nets.vectors().map(|vector| vector.iter().map(ScalarNet::size).fold(0.0, f64::max));
        // Far from the origin differences of places would drown in rounding.
        let origin = patch.point(0, 0);
        let point = std::array::from_fn(|k| {
            let coefficients = patch.net().iter().map(|p| p[k] - origin[k]).collect();
            let slack = patch.net().iter().map(|p| p[k].abs()).fold(0.0, f64::max);
            ScalarNet { degree: patch.degree(), coefficients, slack }.settled(1.0)
        });
        Self { point, nets, sizes }
    }

    /// The two halves of a box, cut across the parameter along which the derivatives change more; None if it is too
    /// small to be cut.
    pub fn halves(&self, place: &Rectangle) -> Option<[(Rectangle, Derivatives<ScalarNet>); 2]> {
        let nets = self.nets.map(|net| net.restricted(place));
        let mut variation = [0.0_f64; 2];
        for (vector, size) in nets.vectors().into_iter().zip(self.sizes) {
            for net in vector.iter().filter(|_| size > 0.0) {
                let own = net.variation();
                variation = [0, 1].map(|d| variation[d].max(own[d] / size));
            }
        }
        let direction = usize::from(variation[1] > variation[0]);
        let [lower, upper] = place.halves(direction)?;
        Some([
            (lower, nets.map(|net| net.half(direction, false))),
            (upper, nets.map(|net| net.half(direction, true))),
        ])
    }

    /// Enclosures of S - S(0, 0), `S_u` and `S_v` over a box.
    pub fn first(&self, place: &Rectangle) -> [[Affine; 3]; 3] {
        [&self.point, &self.nets.u, &self.nets.v]
            .map(|vector| vector.each_ref().map(|net| net.restricted(place).enclosure()))
    }

    /// Enclosures of the derivatives over a box. On all but the smallest boxes the second ones are had from the first
    /// ones' nets there: at a third of the work the loss is a few thousand roundings.
    pub fn enclosures(&self, place: &Rectangle) -> Derivatives<Affine> {
        let width = [0, 1].map(|d| f64::from(place.high[d] - place.low[d]) / f64::from(PARTS));
        if width.iter().any(|width| *width < DIFFERENCED_WIDTH_MIN) {
            return self.nets.map(|net| net.restricted(place).enclosure());
        }
        let restricted = |vector: &[ScalarNet; 3]| vector.each_ref().map(|net| net.restricted(place));
        let [u, v] = [restricted(&self.nets.u), restricted(&self.nets.v)];
        let enclosure = |vector: &[ScalarNet; 3]| vector.each_ref().map(ScalarNet::enclosure);
        let slope = |vector: &[ScalarNet; 3], parameter, width| {
            vector.each_ref().map(|net| net.slope(parameter, width).enclosure())
        };
        Derivatives {
            uu: slope(&u, Parameter::U, width[0]),
            uv: slope(&u, Parameter::V, width[1]),
            vv: slope(&v, Parameter::V, width[1]),
            u: enclosure(&u),
            v: enclosure(&v),
        }
    }
}

/// Narrowest box whose second derivatives are had by differences, 2^-12.
const DIFFERENCED_WIDTH_MIN: f64 = 1.0 / 4096.0;

/// Bernstein coefficients of one component of one derivative; `coefficients[i * (q + 1) + j]`.
#[derive(Clone, Debug)]
pub(super) struct ScalarNet {
    degree: [usize; 2],
    coefficients: Vec<f64>,
    /// Every coefficient, also on every box, is this close to that of the exact surface.
    slack: f64,
}

/// Rounding of a derivative net: a second difference of numbers of size B is off by at most 24 * 2^-53 B times the degrees.
const DIFFERENCE_ROUNDING: f64 = 1.0 / (1_u64 << 47) as f64;
/// Rounding of a restriction to a box and of a half: fewer than 60 roundings and two rounded parameters, each worth at
/// most 12 ulp of the largest coefficient.
const RESTRICTION_ROUNDING: f64 = 1.0 / (1_u64 << 43) as f64;

impl ScalarNet {
    fn derivative(&self, parameter: Parameter) -> Self {
        let [p, q] = self.degree;
        let at = |i: usize, j: usize| self.coefficients[i * (q + 1) + j];
        let (degree, coefficients): ([usize; 2], Vec<f64>) = match parameter {
            Parameter::U if p > 0 => {
                let places = (0..p).flat_map(|i| (0..=q).map(move |j| (i, j)));
                ([p - 1, q], places.map(|(i, j)| (at(i + 1, j) - at(i, j)) * p as f64).collect())
            }
            Parameter::V if q > 0 => {
                let places = (0..=p).flat_map(|i| (0..q).map(move |j| (i, j)));
                ([p, q - 1], places.map(|(i, j)| (at(i, j + 1) - at(i, j)) * q as f64).collect())
            }
            _ => ([0, 0], vec![0.0]),
        };
        Self { degree, coefficients, slack: self.slack }
    }

    /// The derivative of a net on a box of this width; its coefficients are off by twice those of the net times the degree,
    /// whatever is left of that.
    fn slope(&self, parameter: Parameter, width: f64) -> Self {
        let mut net = self.derivative(parameter);
        net.coefficients.iter_mut().for_each(|c| *c /= width);
        net.slack = 2.0 * MAX_DEGREE as f64 * self.slack / width + DIFFERENCE_ROUNDING * net.size();
        net
    }

    /// Turns `slack`, so far the size of S's own coefficients, into the bound on the error. What is constant within it
    /// along a parameter loses that parameter: on a height field little but z is then left to subdivide.
    fn settled(mut self, factor: f64) -> Self {
        self.slack = DIFFERENCE_ROUNDING * factor * self.slack + RESTRICTION_ROUNDING * self.size();
        for direction in [0, 1] {
            let [p, q] = self.degree;
            let (n, stride, lines, line_stride) =
                if direction == 0 { (p, q + 1, q + 1, 1) } else { (q, 1, p + 1, q + 1) };
            let line = |k: usize| (0..=n).map(move |i| k * line_stride + i * stride);
            let bounds: Vec<[f64; 2]> = (0..lines)
                .map(|k| {
                    line(k)
                        .map(|at| self.coefficients[at])
                        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], c| [low.min(c), high.max(c)])
                })
                .collect();
            let widest = bounds.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
            if widest <= self.slack {
                self.slack += 0.5 * widest;
                self.coefficients = bounds.iter().map(|[low, high]| 0.5 * (low + high)).collect();
                self.degree[direction] = 0;
            }
        }
        self
    }

    fn size(&self) -> f64 {
        self.coefficients.iter().map(|c| c.abs()).fold(0.0, f64::max)
    }

    /// Largest difference of neighbours along u and along v, times the number of steps.
    fn variation(&self) -> [f64; 2] {
        let [p, q] = self.degree;
        let at = |i: usize, j: usize| self.coefficients[i * (q + 1) + j];
        let mut largest = [0.0_f64; 2];
        for i in 0..=p {
            for j in 0..=q {
                if i < p {
                    largest[0] = largest[0].max((at(i + 1, j) - at(i, j)).abs());
                }
                if j < q {
                    largest[1] = largest[1].max((at(i, j + 1) - at(i, j)).abs());
                }
            }
        }
        [largest[0] * p as f64, largest[1] * q as f64]
    }

    /// The affine function through the corners' mean slopes, and the hull of what the coefficients differ from it: an
    /// affine function's coefficients are its values at evenly spaced places, so the difference is a net too.
    fn enclosure(&self) -> Affine {
        let [p, q] = self.degree;
        let [south_west, north_west, south_east, north_east] =
            [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]].map(|signs| self.corner(signs).center);
        let slope = [
            0.25 * ((south_east - south_west) + (north_east - north_west)),
            0.25 * ((north_west - south_west) + (north_east - south_east)),
        ];
        let ordinate = |k: usize, n: usize| if n == 0 { 0.0 } else { (2.0 * k as f64 - n as f64) / n as f64 };
        let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
        for (i, row) in self.coefficients.chunks_exact(q + 1).enumerate() {
            let across = slope[0] * ordinate(i, p);
            for (j, coefficient) in row.iter().enumerate() {
                let rest = coefficient - (across + slope[1] * ordinate(j, q));
                low = low.min(rest);
                high = high.max(rest);
            }
        }
        // The slack has room for the roundings here: a few ulp of the largest coefficient.
        Affine { center: 0.5 * (low + high), slope, radius: 0.5 * (high - low) + self.slack }
    }

    fn corner(&self, signs: [f64; 2]) -> Affine {
        let [p, q] = self.degree;
        let i = if signs[0] > 0.0 { p } else { 0 };
        let j = if signs[1] > 0.0 { q } else { 0 };
        Affine::number(self.coefficients[i * (q + 1) + j], self.slack)
    }

    fn restricted(&self, place: &Rectangle) -> Self {
        let mut net = self.clone();
        for direction in [0, 1] {
            let [low, high] = place.range(direction);
            if high < 1.0 {
                net.keep(direction, high, false);
            }
            if low > 0.0 {
                net.keep(direction, low / high, true);
            }
        }
        net
    }

    fn half(&self, direction: usize, upper: bool) -> Self {
        let mut net = self.clone();
        net.keep(direction, 0.5, upper);
        net
    }

    /// Keeps the part above or below `t` of one parameter, by de Casteljau.
    fn keep(&mut self, direction: usize, t: f64, upper: bool) {
        let [p, q] = self.degree;
        if direction == 0 {
            // Whole rows at a time.
            let rows = p + 1;
            for k in 1..rows {
                for m in 0..rows - k {
                    // The lower part's first k coefficients are final, as are the upper part's last ones.
                    let [into, from] = if upper { [m, m + 1] } else { [rows - 1 - m, rows - 2 - m] };
                    mix(&mut self.coefficients, q + 1, into, from, if upper { t } else { 1.0 - t });
                }
            }
        } else {
            for row in self.coefficients.chunks_exact_mut(q + 1) {
                for k in 1..=q {
                    if upper {
                        for i in 0..=q - k {
                            row[i] = (1.0 - t) * row[i] + t * row[i + 1];
                        }
                    } else {
                        for i in (k..=q).rev() {
                            row[i] = (1.0 - t) * row[i - 1] + t * row[i];
                        }
                    }
                }
            }
        }
    }
}

/// Row `into` becomes (1 - share) of itself and `share` of row `from`.
fn mix(coefficients: &mut [f64], width: usize, into: usize, from: usize, share: f64) {
    let (low, high) = coefficients.split_at_mut(into.max(from) * width);
    let [own, other] = if into < from {
        [&mut low[into * width..][..width], &mut high[..width]]
    } else {
        [&mut high[..width], &mut low[from * width..][..width]]
    };
    for (a, b) in own.iter_mut().zip(other.iter()) {
        *a = (1.0 - share) * *a + share * *b;
    }
}
