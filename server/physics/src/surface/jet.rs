//! A surface near one point: derivatives to second order, normal, fundamental forms.

use nalgebra::Vector3;

/// S and its derivatives with respect to u and v at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// S, m.
    pub point: Vector3<f64>,
    /// `S_u`.
    pub du: Vector3<f64>,
    /// `S_v`.
    pub dv: Vector3<f64>,
    /// `S_uu`.
    pub duu: Vector3<f64>,
    /// `S_uv`.
    pub duv: Vector3<f64>,
    /// `S_vv`.
    pub dvv: Vector3<f64>,
}

/// The fundamental forms I = [E F; F G] and II = [L M; M N].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FundamentalForms {
    /// First form: E, F, G.
    pub first: [f64; 3],
    /// Second form: L, M, N; positive where the surface curves towards the normal.
    pub second: [f64; 3],
}

impl Jet {
    /// Unit normal on the balls' side: `orientation` (+1 or -1) times `S_u x S_v / |S_u x S_v|`. None where the chart is
    /// singular.
    pub fn normal(&self, orientation: f64) -> Option<Vector3<f64>> {
        let cross = self.du.cross(&self.dv);
        let length = cross.norm();
        (length > 0.0).then(|| cross * (orientation / length))
    }

    /// The forms with respect to a unit normal.
    pub fn fundamental_forms(&self, normal: &Vector3<f64>) -> FundamentalForms {
        FundamentalForms {
            first: [self.du.dot(&self.du), self.du.dot(&self.dv), self.dv.dot(&self.dv)],
            second: [self.duu.dot(normal), self.duv.dot(normal), self.dvv.dot(normal)],
        }
    }
}

impl FundamentalForms {
    /// The principal curvatures, larger first, 1/m: eigenvalues of I^-1 II. The shape operator is taken in the
    /// orthonormal frame that begins with `S_u`, where it is symmetric and its discriminant a sum of squares.
    pub fn principal_curvatures(&self) -> [f64; 2] {
        let [e, f, g] = self.first;
        let [l, m, n] = self.second;
        let det = e * g - f * f;
        let a = l / e;
        let b = (m * e - f * l) / (e * det.sqrt());
        let d = (e * n - 2.0 * f * m + f * f / e * l) / det;
        let mean = 0.5 * (a + d);
        let spread = (0.25 * (a - d) * (a - d) + b * b).sqrt();
        [mean + spread, mean - spread]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curvatures_of_a_paraboloid_do_not_depend_on_the_chart() {
        // z = a x^2 / 2 + b y^2 / 2 at its vertex, in a sheared and stretched chart x = 2u + v, y = 3v.
        let (a, b) = (1.5, 0.25);
        let jet = Jet {
            point: Vector3::zeros(),
            du: Vector3::new(2.0, 0.0, 0.0),
            dv: Vector3::new(1.0, 3.0, 0.0),
            duu: Vector3::new(0.0, 0.0, 4.0 * a),
            duv: Vector3::new(0.0, 0.0, 2.0 * a),
            dvv: Vector3::new(0.0, 0.0, a + 9.0 * b),
        };
        let normal = jet.normal(1.0).unwrap();
        let [larger, smaller] = jet.fundamental_forms(&normal).principal_curvatures();
        assert!((larger - a).abs() < 1e-15 && (smaller - b).abs() < 1e-15);
        let under = jet.fundamental_forms(&-normal).principal_curvatures();
        assert!((under[0] + b).abs() < 1e-15 && (under[1] + a).abs() < 1e-15);
    }
}
