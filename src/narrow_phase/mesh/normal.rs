//! What a polygon has to be like, and which way it faces.

use bevy::math::{DVec3, Vec3};

use crate::narrow_phase::error::ShapeError;

/// How far off its plane a corner may be, as a share of the polygon's size.
const PLANARITY: f64 = 1e-4;
/// The smallest area of a polygon, as a share of the square of its size.
const SMALLEST_AREA: f64 = 1e-6;
/// With so many corners or fewer, each is compared with each.
const FEW: usize = 8;

/// Checks a polygon and returns its unit normal, by Newell's sums over the corners.
#[inline]
pub fn checked_normal(
    vertices: &[Vec3],
    polygon: usize,
    indices: &[u32],
) -> Result<Vec3, ShapeError> {
    if let &[a, b, c] = indices
        && let [Some(&a), Some(&b), Some(&c)] = [a, b, c].map(|index| vertices.get(index as usize))
    {
        if indices[0] == indices[1] || indices[1] == indices[2] || indices[2] == indices[0] {
            let vertex = indices[usize::from(indices[0] != indices[1])];
            let vertex = if indices[0] == indices[2] {
                indices[0]
            } else {
                vertex
            };
            return Err(ShapeError::RepeatedVertex { polygon, vertex });
        }
        // Differences of 32-bit floats and their products are exact enough in 64 bits, however
        // small, far from the origin or thin the triangle is.
        let origin = a.as_dvec3();
        let (b, c) = (b.as_dvec3() - origin, c.as_dvec3() - origin);
        let size = b.abs().max(c.abs()).max_element();
        return normal_of(b.cross(c), size, polygon);
    }
    checked_normal_of_many(vertices, polygon, indices)
}

#[inline]
fn normal_of(area: DVec3, size: f64, polygon: usize) -> Result<Vec3, ShapeError> {
    let length = area.length();
    // Not for an area that is not a number, either.
    if length > SMALLEST_AREA * size * size {
        Ok((area / length).as_vec3())
    } else {
        Err(ShapeError::ZeroArea { polygon })
    }
}

fn checked_normal_of_many(
    vertices: &[Vec3],
    polygon: usize,
    indices: &[u32],
) -> Result<Vec3, ShapeError> {
    if indices.len() < 3 {
        let corners = indices.len();
        return Err(ShapeError::TooFewCorners { polygon, corners });
    }
    if let Some(&vertex) = indices.iter().find(|&&v| v as usize >= vertices.len()) {
        let vertices = vertices.len();
        return Err(ShapeError::IndexOutOfRange {
            polygon,
            vertex,
            vertices,
        });
    }
    if let Some(vertex) = repeated(indices) {
        return Err(ShapeError::RepeatedVertex { polygon, vertex });
    }

    let origin = vertices[indices[0] as usize].as_dvec3();
    let relative = |index: &u32| vertices[*index as usize].as_dvec3() - origin;
    let size = indices
        .iter()
        .map(|index| relative(index).abs().max_element())
        .fold(0.0, f64::max);
    let area: DVec3 = indices
        .windows(2)
        .map(|pair| relative(&pair[0]).cross(relative(&pair[1])))
        .sum();
    let normal = normal_of(area, size, polygon)?;
    let middle = indices.iter().map(relative).sum::<DVec3>() / indices.len() as f64;
    let off_plane = |index: &u32| (relative(index) - middle).dot(normal.as_dvec3()).abs();
    let worst = indices
        .iter()
        .max_by(|a, b| off_plane(a).total_cmp(&off_plane(b)))
        .expect("there are three corners at least");
    if off_plane(worst) > PLANARITY * size {
        return Err(ShapeError::NotPlanar {
            polygon,
            vertex: *worst,
            distance: off_plane(worst) as f32,
        });
    }
    Ok(normal)
}

fn repeated(indices: &[u32]) -> Option<u32> {
    if indices.len() <= FEW {
        let mut seen = indices.iter().enumerate();
        return seen.find_map(|(i, vertex)| indices[..i].contains(vertex).then_some(*vertex));
    }
    let mut sorted = indices.to_vec();
    sorted.sort_unstable();
    let pair = sorted.array_windows().find(|[one, next]| one == next);
    pair.map(|pair| pair[0])
}
