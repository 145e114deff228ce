//! Convex meshes around points.

use bevy::math::{DVec3, Vec3};

use super::{
    convex_mesh::ConvexMesh,
    normal::checked_normal,
    polygon_mesh::PolygonMesh,
    quickhull::{self, NoHull},
};
use crate::narrow_phase::error::ShapeError;

/// Points that are so near to a plane are in it, as a share of how far points are from their middle
/// and that from the origin, for that is how they are rounded; but no farther than the second
/// number, as a share of the first alone.
const NEAR: f64 = 3.0 * f32::EPSILON as f64;
const NEAR_AT_MOST: f64 = 2e-5;
/// How many times as much is tried where a mesh comes out that is not accepted as convex.
const COARSER: [f64; 3] = [1.0, 8.0, 64.0];

impl ConvexMesh {
    /// Makes the convex hull of points: the smallest convex solid in which all of them are.
    ///
    /// Its vertices are points that were given, in their order. Points in a plane make one polygon.
    /// What is within a few millionths of the size of a polygon's plane, or of its rounding where
    /// the points are far from the origin, is in that plane: so no point is outside by more than
    /// that, and repeated points and such as are nearly in a plane do no harm. O(n log n) for most points.
    ///
    /// ```
    /// use bevy::math::Vec3;
    /// use bevy_octree::narrow_phase::ConvexMesh;
    ///
    /// // A grid of points: of these, the eight at the corners are left.
    /// let grid = (0..27).map(|i| Vec3::new((i % 3) as f32, (i / 3 % 3) as f32, (i / 9) as f32));
    /// let cube = ConvexMesh::hull_of(grid)?;
    /// assert_eq!((cube.vertices().len(), cube.polygon_count()), (8, 6));
    /// # Ok::<(), bevy_octree::narrow_phase::ShapeError>(())
    /// ```
    ///
    /// # Errors
    /// [`ShapeError::FewPoints`] for less than four, [`ShapeError::NonFiniteVertex`] for a point,
    /// [`ShapeError::Flat`] if all are in a plane, on a line or in one place, or nearly so,
    /// [`ShapeError::TooLarge`] if 32 bits cannot number them.
    pub fn hull_of(points: impl IntoIterator<Item = Vec3>) -> Result<Self, ShapeError> {
        let points: Vec<Vec3> = points.into_iter().collect();
        if points.len() < 4 {
            return Err(ShapeError::FewPoints(points.len()));
        }
        if u32::try_from(points.len()).is_err() {
            return Err(ShapeError::TooLarge);
        }
        if let Some(vertex) = points.iter().position(|point| !point.is_finite()) {
            let position = points[vertex];
            return Err(ShapeError::NonFiniteVertex { vertex, position });
        }
        // At one size, in 64 bits: nothing overflows, and differences are exact.
        let exact = || points.iter().map(|point| point.as_dvec3());
        let (low, high) = exact().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |ends, point| {
            (ends.0.min(point), ends.1.max(point))
        });
        let (middle, radius) = ((low + high) * 0.5, (high - low).max_element() * 0.5);
        if radius == 0.0 {
            return Err(ShapeError::Flat);
        }
        let unit: Vec<DVec3> = exact().map(|point| (point - middle) / radius).collect();
        let far = middle.abs().max_element() / radius;
        let tolerance = (NEAR * (1.0 + far)).min(NEAR_AT_MOST);
        let mut outcome = Err(ShapeError::Flat);
        for coarser in COARSER {
            outcome = match quickhull::hull(&unit, coarser * tolerance) {
                Ok(polygons) => mesh_of(&points, polygons),
                // What is flat is no less so at a greater tolerance.
                Err(NoHull::Flat) => break,
                Err(NoHull::Broken) => continue,
            };
            if outcome.is_ok() {
                break;
            }
        }
        outcome
    }
}

/// The mesh of some polygons, with no other vertices than theirs.
fn mesh_of(points: &[Vec3], polygons: Vec<Vec<u32>>) -> Result<ConvexMesh, ShapeError> {
    let mut used: Vec<u32> = polygons.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let index_of = |point: u32| used.partition_point(|used| *used < point) as u32;
    let vertices: Vec<Vec3> = used.iter().map(|point| points[*point as usize]).collect();
    let mut planar = Vec::with_capacity(polygons.len());
    for mut polygon in polygons {
        for corner in &mut polygon {
            *corner = index_of(*corner);
        }
        match checked_normal(&vertices, 0, &polygon) {
            // Small for what is rounded at the size of all.
            Err(ShapeError::NotPlanar { .. }) => planar.extend(triangles(&vertices, &polygon)),
            _ => planar.push(polygon),
        }
    }
    ConvexMesh::new(PolygonMesh::new(vertices, planar)?)
}

/// The triangles of a convex polygon around one of its corners: that for which the thinnest of them
/// is thickest.
fn triangles(vertices: &[Vec3], polygon: &[u32]) -> Vec<Vec<u32>> {
    let count = polygon.len();
    let fan = |first: usize| {
        let corner = move |i: usize| polygon[(first + i) % count];
        (1..count - 1).map(move |i| [corner(0), corner(i), corner(i + 1)])
    };
    let thickness = |triangle: [u32; 3]| {
        let [a, b, c] = triangle.map(|corner| vertices[corner as usize].as_dvec3());
        let size = (b - a).length().max((c - b).length()).max((a - c).length());
        (b - a).cross(c - a).length() / (size * size)
    };
    let thinnest = |first: &usize| fan(*first).map(thickness).fold(f64::INFINITY, f64::min);
    let best = (0..count).max_by(|a, b| thinnest(a).total_cmp(&thinnest(b)));
    fan(best.unwrap_or(0)).map(Vec::from).collect()
}

#[cfg(test)]
mod tests;
