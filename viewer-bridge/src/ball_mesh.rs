//! A beach ball of radius 1: stripes of its colour and of white, so that rolling is seen.

use crate::palette;
use rerun::{Color, Mesh3D};
use std::f32::consts::{PI, TAU};

const WHITE: [u8; 3] = [245, 243, 236];
const NIGHT: [u8; 3] = [36, 38, 50];

/// Latitude bands and longitude sectors per stripe, for a number of balls: few are drawn round, many cheaply.
pub const fn detail(balls: usize) -> [usize; 2] {
    match balls {
        0..=64 => [24, 8],
        65..=400 => [14, 4],
        _ => [8, 2],
    }
}

/// Stripes from pole to pole: an even number, every other one white.
const STRIPES: usize = 6;

/// The ball's mesh in `tint`; `marked` balls are striped with night instead of white.
pub fn mesh(tint: [u8; 3], marked: bool, [bands, sectors]: [usize; 2]) -> Mesh3D {
    let other = if marked { NIGHT } else { WHITE };
    let (mut positions, mut colors, mut triangles) =
        (Vec::new(), Vec::<Color>::new(), Vec::<[u32; 3]>::new());
    for stripe in 0..STRIPES {
        // Stripes share no corners, so that colours do not run into each other.
        let first = positions.len() as u32;
        let shade = palette::color(if stripe % 2 == 0 { tint } else { other });
        for sector in 0..=sectors {
            let longitude = TAU * (stripe as f32 + sector as f32 / sectors as f32) / STRIPES as f32;
            for band in 0..=bands {
                let latitude = PI * (band as f32 / bands as f32 - 0.5);
                positions.push([
                    latitude.cos() * longitude.cos(),
                    latitude.cos() * longitude.sin(),
                    latitude.sin(),
                ]);
                colors.push(shade);
            }
        }
        let corner = |sector: usize, band: usize| first + (sector * (bands + 1) + band) as u32;
        for (sector, band) in (0..sectors).flat_map(|s| (0..bands).map(move |b| (s, b))) {
            let [a, b] = [corner(sector, band), corner(sector + 1, band)];
            let [c, d] = [corner(sector + 1, band + 1), corner(sector, band + 1)];
            // At the poles one of the two triangles has no area.
            triangles.extend(
                (band > 0).then_some([a, b, c]).into_iter().chain((band + 1 < bands).then_some([a, c, d])),
            );
        }
    }
    Mesh3D::new(positions.clone())
        .with_vertex_normals(positions)
        .with_vertex_colors(colors)
        .with_triangle_indices(triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_detail_is_a_closed_valid_mesh() {
        for balls in [1, 100, 2000] {
            let [bands, sectors] = detail(balls);
            let mesh = mesh([200, 30, 30], false, [bands, sectors]);
            assert!(mesh.sanity_check().is_ok());
            assert_eq!(mesh.num_triangles(), 2 * STRIPES * sectors * (bands - 1));
        }
    }
}
