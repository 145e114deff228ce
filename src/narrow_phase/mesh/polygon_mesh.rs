//! Meshes of planar polygons, checked when they are built.

use std::ops::Range;

use bevy::math::{DVec3, Vec3, Vec3A, bounding::Aabb3d};

use super::topology::Topology;
use crate::{
    broad_phase::linear_octree::StillOctree,
    narrow_phase::{error::ShapeError, length::length},
};

/// How far off its plane a corner may be, as a share of the polygon's size.
const PLANARITY: f32 = 1e-4;
/// The smallest area of a polygon, as a share of the square of its size.
const SMALLEST_AREA: f32 = 1e-6;

/// A mesh of so many polygons, or fewer, has no tree: they are looked at as quickly one by one.
const FEW: usize = 32;

/// A surface of planar polygons: what the report's system tests edge by edge against polygon.
///
/// * A polygon is a list of three or more vertex indices, convex or not, in one plane, without
///   holes. One that crosses itself is not refused; its inside is then by the even-odd rule.
/// * Neighbouring polygons are turned to the same orientation, where that can be done: the first
///   polygon of each shell decides. Polygons keep their order; vertices are never moved or merged.
/// * If every edge joins exactly two polygons, the mesh [is closed](Self::is_closed) and has an
///   inside: the points around which its surface winds. The wall of a cavity must face the other
///   way than the outer wall, or the cavity counts as filled.
///
/// ```
/// use bevy::math::Vec3;
/// use bevy_octree::narrow_phase::PolygonMesh;
///
/// let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
/// let tetrahedron = PolygonMesh::new(corners, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
/// assert_eq!(tetrahedron.edges().len(), 6);
/// assert!(tetrahedron.is_closed());
/// # Ok::<(), bevy_octree::narrow_phase::ShapeError>(())
/// ```
#[doc(alias = "trimesh")]
#[derive(Clone, Debug)]
pub struct PolygonMesh {
    vertices: Vec<Vec3>,
    /// The corners of all polygons, one polygon after the other.
    corners: Vec<u32>,
    /// Where each polygon ends in `corners`.
    ends: Vec<u32>,
    /// A unit normal per polygon, by the right-hand rule.
    normals: Vec<Vec3>,
    edges: Vec<[u32; 2]>,
    /// The polygons across the sides of all polygons, as `corners`.
    across: Vec<u32>,
    /// Where polygons are; none in a mesh of few.
    tree: Option<StillOctree>,
    /// A vertex of each connected part of the surface.
    shells: Vec<u32>,
    open_edge: Option<[u32; 2]>,
    center: Vec3A,
    half_size: Vec3A,
    radius: f32,
}

impl PolygonMesh {
    /// Builds a mesh from vertices and polygons, each a list of vertex indices.
    ///
    /// Linear in the number of corners. Vertices that no polygon names are kept, but are no part of
    /// the surface.
    ///
    /// # Errors
    /// [`ShapeError::Empty`] without polygons, [`ShapeError::NonFiniteVertex`], and for a polygon
    /// that has fewer than three corners, names a vertex that does not exist or names one twice,
    /// has no area (less than a millionth of its size squared) or is not planar (off by more than a
    /// ten-thousandth of its size).
    pub fn new<P: AsRef<[u32]>>(
        vertices: impl Into<Vec<Vec3>>,
        polygons: impl IntoIterator<Item = P>,
    ) -> Result<Self, ShapeError> {
        let vertices = vertices.into();
        if u32::try_from(vertices.len()).is_err() {
            return Err(ShapeError::TooLarge);
        }
        if let Some(vertex) = vertices.iter().position(|vertex| !vertex.is_finite()) {
            let position = vertices[vertex];
            return Err(ShapeError::NonFiniteVertex { vertex, position });
        }
        let (mut corners, mut ends, mut normals) = (Vec::new(), Vec::new(), Vec::new());
        for (polygon, indices) in polygons.into_iter().enumerate() {
            let indices = indices.as_ref();
            normals.push(checked_normal(&vertices, polygon, indices)?);
            corners.extend_from_slice(indices);
            ends.push(u32::try_from(corners.len()).map_err(|_| ShapeError::TooLarge)?);
        }
        if ends.is_empty() {
            return Err(ShapeError::Empty);
        }
        let mut mesh = Self {
            vertices,
            corners,
            ends,
            normals,
            edges: Vec::new(),
            across: Vec::new(),
            tree: None,
            shells: Vec::new(),
            open_edge: None,
            center: Vec3A::ZERO,
            half_size: Vec3A::ZERO,
            radius: 0.0,
        };
        mesh.connect();
        mesh.measure();
        Ok(mesh)
    }

    /// Returns the vertices, as given.
    #[must_use]
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// Returns how many polygons there are; at least one.
    #[must_use]
    pub fn polygon_count(&self) -> usize {
        self.ends.len()
    }

    /// Returns the vertex indices of the polygons, in the order given; each polygon
    /// counter-clockwise around its [normal](Self::normals).
    #[must_use]
    pub fn polygons(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        (0..self.ends.len()).map(|polygon| self.polygon(polygon))
    }

    /// Returns the unit normals of the polygons.
    #[must_use]
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Returns each edge once, as the indices of its ends.
    #[must_use]
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// Returns `true` if every edge joins exactly two polygons which can be oriented alike, so that
    /// the mesh has an inside.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.open_edge.is_none()
    }

    /// Returns an edge that keeps the mesh from being closed, if there is one.
    #[must_use]
    pub fn open_edge(&self) -> Option<[u32; 2]> {
        self.open_edge
    }

    /// The polygons across the sides of a polygon, of which side i is that from corner i to the
    /// next; [`NO_NEIGHBOR`](super::topology::NO_NEIGHBOR) where no other polygon shares the side,
    /// or more than one.
    pub(in crate::narrow_phase) fn across(&self, polygon: usize) -> &[u32] {
        &self.across[self.corners_of(polygon)]
    }

    /// The tree of the polygons' boxes, in the mesh's own space, if there are enough of them.
    pub(in crate::narrow_phase) const fn tree(&self) -> Option<&StillOctree> {
        self.tree.as_ref()
    }

    /// The same mesh, to be looked at polygon by polygon.
    #[cfg(test)]
    pub(in crate::narrow_phase) fn without_tree(mut self) -> Self {
        self.tree = None;
        self
    }

    /// Returns `true` if the mesh, which is closed, winds around a point that is not on its surface.
    ///
    /// Counts how often a ray along x comes out of it more often than in. A side that two polygons
    /// share is seen alike from both, so that none can slip through between them.
    pub(in crate::narrow_phase) fn winds_around(&self, point: DVec3) -> bool {
        if !self.is_closed() {
            return false;
        }
        let mut winding = 0;
        self.for_each_along_x(point, |polygon| winding += self.crossing(polygon, point));
        winding != 0
    }

    /// Calls `found` with each polygon whose box a ray along x may meet.
    fn for_each_along_x(&self, point: DVec3, mut found: impl FnMut(usize)) {
        let Some(tree) = &self.tree else {
            return (0..self.polygon_count()).for_each(found);
        };
        // As 32-bit floats, it may be a little off.
        let near = point.as_vec3a();
        let ray = Aabb3d {
            min: near.map(f32::next_down),
            max: near.map(f32::next_up).with_x(f32::MAX),
        };
        tree.for_each_overlapping(&ray, |polygon| found(polygon as usize));
    }

    /// Which way a ray along x, from a point on, crosses a polygon: 1 or -1; 0 if it does not.
    fn crossing(&self, polygon: usize, point: DVec3) -> i32 {
        let at = |vertex: &u32| self.vertices[*vertex as usize].as_dvec3();
        let corners = self.polygon(polygon);
        let mut winding = 0;
        for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let (a, b) = (at(a), at(b));
            if (a.y > point.y) != (b.y > point.y) {
                // From the lower end up, whichever polygon asks.
                let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
                let share = (point.y - low.y) / (high.y - low.y);
                if low.z + (high.z - low.z) * share > point.z {
                    winding += if b.y > a.y { 1 } else { -1 };
                }
            }
        }
        if winding == 0 {
            return 0;
        }
        let origin = at(&corners[0]);
        let normal: DVec3 = corners[1..]
            .windows(2)
            .map(|pair| (at(&pair[0]) - origin).cross(at(&pair[1]) - origin))
            .sum();
        let (first, last) = corners.iter().map(at).fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(first, last), corner| (first.min(corner.x), last.max(corner.x)),
        );
        let aside = (point - origin).with_x(0.0);
        // Where it is along x cannot be told of one that is seen from its side.
        let x = (origin.x - normal.dot(aside) / normal.x).clamp(first, last);
        if x > point.x { winding } else { 0 }
    }

    /// Whether a triangle would be accepted as a polygon.
    #[cfg(feature = "mesh")]
    pub(in crate::narrow_phase) fn has_area(vertices: &[Vec3], triangle: [u32; 3]) -> bool {
        use ShapeError::{RepeatedVertex, ZeroArea};
        let checked = checked_normal(vertices, 0, &triangle);
        !matches!(checked, Err(RepeatedVertex { .. } | ZeroArea { .. }))
    }

    pub(in crate::narrow_phase) fn polygon(&self, polygon: usize) -> &[u32] {
        debug_assert!(
            polygon < self.ends.len(),
            "polygon {polygon} of {}",
            self.ends.len()
        );
        &self.corners[self.corners_of(polygon)]
    }

    fn corners_of(&self, polygon: usize) -> Range<usize> {
        let start = polygon.checked_sub(1).map_or(0, |last| self.ends[last]);
        start as usize..self.ends[polygon] as usize
    }

    /// A vertex of each connected part of the surface.
    pub(in crate::narrow_phase) fn shells(&self) -> &[u32] {
        &self.shells
    }

    pub(in crate::narrow_phase) fn local_bounds(&self) -> (Vec3A, Vec3A, f32) {
        (self.center, self.half_size, self.radius)
    }

    /// The same polygons elsewhere: vertices and normals are mapped, which has to keep
    /// orientations.
    pub(in crate::narrow_phase) fn turned(
        &self,
        vertex: impl Fn(Vec3) -> Vec3,
        normal: impl Fn(Vec3) -> Vec3,
    ) -> Self {
        let mut turned = Self {
            vertices: self.vertices.iter().copied().map(vertex).collect(),
            normals: self.normals.iter().copied().map(normal).collect(),
            ..self.clone()
        };
        turned.measure();
        turned
    }

    /// Turns every polygon around.
    pub(in crate::narrow_phase) fn flip(&mut self) {
        for polygon in 0..self.ends.len() {
            self.flip_polygon(polygon);
        }
    }

    fn flip_polygon(&mut self, polygon: usize) {
        let corners = self.corners_of(polygon);
        self.corners[corners.clone()].reverse();
        // The last side is the one that is still between the same two places.
        self.across[corners.start..corners.end - 1].reverse();
        self.normals[polygon] = -self.normals[polygon];
    }

    /// Finds edges and shells, and orients neighbours alike.
    fn connect(&mut self) {
        let topology = Topology::of(self.polygons());
        self.across = topology.across;
        for polygon in topology.flipped {
            self.flip_polygon(polygon);
        }
        self.edges = topology.edges;
        self.open_edge = topology.open_edge;
        self.shells = topology
            .shells
            .iter()
            .map(|&polygon| self.polygon(polygon)[0])
            .collect();
    }

    /// Finds the bounding box and, around its centre, the bounding sphere.
    fn measure(&mut self) {
        let corners = || self.corners.iter().map(|&v| self.vertices[v as usize]);
        let min = corners().fold(Vec3::INFINITY, Vec3::min);
        let max = corners().fold(Vec3::NEG_INFINITY, Vec3::max);
        // Halving first cannot overflow.
        let center = min * 0.5 + max * 0.5;
        let radius = corners()
            .map(|v| length((v - center).into()))
            .fold(0.0, f32::max);
        self.center = center.into();
        // Not (max - min) / 2, so that both ends are inside whatever the rounding.
        self.half_size = (max - center).max(center - min).into();
        self.radius = radius;
        self.tree = (self.ends.len() > FEW).then(|| {
            let boxes: Vec<_> = self
                .polygons()
                .map(|corners| self.bounds_of(corners))
                .collect();
            StillOctree::new(&boxes)
        });
    }

    fn bounds_of(&self, corners: &[u32]) -> Aabb3d {
        let at = |vertex: &u32| Vec3A::from(self.vertices[*vertex as usize]);
        let first = at(&corners[0]);
        let (min, max) = corners[1..]
            .iter()
            .map(at)
            .fold((first, first), |(min, max), corner| {
                (min.min(corner), max.max(corner))
            });
        Aabb3d { min, max }
    }
}

/// Checks a polygon and returns its unit normal, by Newell's sums over the corners.
fn checked_normal(vertices: &[Vec3], polygon: usize, indices: &[u32]) -> Result<Vec3, ShapeError> {
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
    let mut sorted = indices.to_vec();
    sorted.sort_unstable();
    if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        let vertex = pair[0];
        return Err(ShapeError::RepeatedVertex { polygon, vertex });
    }

    // Relative to a corner and to the polygon's size, so that neither cancellation nor underflow
    // hide the area of a polygon that is small or far from the origin.
    let origin = vertices[indices[0] as usize];
    let relative = |index: &u32| vertices[*index as usize] - origin;
    let size = indices
        .iter()
        .map(|index| relative(index).abs().max_element())
        .fold(0.0, f32::max);
    let area: Vec3 = indices
        .windows(2)
        .map(|pair| (relative(&pair[0]) / size).cross(relative(&pair[1]) / size))
        .sum();
    let Some(normal) = area
        .try_normalize()
        .filter(|_| area.length() > SMALLEST_AREA)
    else {
        return Err(ShapeError::ZeroArea { polygon });
    };
    let middle = indices.iter().map(relative).sum::<Vec3>() / indices.len() as f32;
    let off_plane = |index: &u32| (relative(index) - middle).dot(normal).abs();
    let worst = indices
        .iter()
        .max_by(|a, b| off_plane(a).total_cmp(&off_plane(b)))
        .expect("there are three corners at least");
    if off_plane(worst) > PLANARITY * size {
        return Err(ShapeError::NotPlanar {
            polygon,
            vertex: *worst,
            distance: off_plane(worst),
        });
    }
    Ok(normal)
}

#[cfg(test)]
pub(in crate::narrow_phase) mod tests;
