//! Meshes that are known to be convex.

use std::{f64::consts::PI, ops::Deref};

use bevy::math::{
    DVec3,
    primitives::{HalfSpace, ViewFrustum},
};

use super::{corners::Corners, polygon_mesh::PolygonMesh, topology::NO_NEIGHBOR};
use crate::narrow_phase::error::ShapeError;

/// How far a vertex may be outside the plane of a polygon, as a share of the mesh's radius.
const FLATNESS: f64 = 1e-4;
/// The smallest volume, as a share of the cube of the mesh's radius.
const SMALLEST_VOLUME: f64 = 1e-6;
/// How far the vertices of the mesh may have been moved, as a share of its radius, so that a sliver
/// may face anywhere. Six digits and welding leave as much.
const MOVED: f64 = 4e-6;
/// Less than this, in steps of 32-bit floats, is rounding.
const STEPS: f64 = 2.0 * f32::EPSILON as f64;
/// Polygons of more corners than this are known to their neighbours by their middle.
const LONG: usize = 8;

/// A closed [`PolygonMesh`] in one piece that encloses a convex solid, its polygons facing
/// outwards.
///
/// Knowing that a solid is convex buys contacts with the axis along which it and another such, or a
/// cuboid, overlap least.
#[doc(alias = "convex hull")]
#[doc(alias = "polyhedron")]
#[derive(Clone, Debug)]
pub struct ConvexMesh {
    mesh: PolygonMesh,
    corners: Corners,
}

impl ConvexMesh {
    /// Checks that the mesh is convex, and turns its polygons outwards.
    ///
    /// The time taken is that of looking at each edge once; where it bends inwards by more than
    /// rounding explains, and by less than is allowed, also that of a search for vertices outside of
    /// the polygons there.
    ///
    /// # Errors
    /// [`ShapeError::NotClosed`], [`ShapeError::NotConnected`], [`ShapeError::Flat`] without
    /// volume, [`ShapeError::NotConvex`] if a vertex is outside the plane of a polygon by more than
    /// a ten-thousandth of the mesh's radius: if the polygon is a sliver, which may face anywhere,
    /// by more than what a few millionths of the radius make of it. [`ShapeError::SurfaceOnly`] for
    /// a mesh that was made to have no inside.
    pub fn new(mut mesh: PolygonMesh) -> Result<Self, ShapeError> {
        if mesh.is_surface_only() {
            return Err(ShapeError::SurfaceOnly);
        }
        if let Some(edge) = mesh.open_edge() {
            let positions = edge.map(|vertex| mesh.vertices()[vertex as usize]);
            return Err(ShapeError::NotClosed { edge, positions });
        }
        let mut polygons = 0..mesh.polygon_count();
        if mesh.shells().len() != 1 && polygons.all(|p| !mesh.across(p).contains(&NO_NEIGHBOR)) {
            return Err(ShapeError::NotConnected(mesh.shells().len()));
        }
        let (volume, inner) = volume_and_middle(&mesh);
        if volume.abs() < SMALLEST_VOLUME {
            return Err(ShapeError::Flat);
        }
        if volume < 0.0 {
            mesh.flip();
        }
        match Check::new(&mesh).find_outside(inner) {
            None => Ok(Self::trusted(mesh)),
            Some(Outside {
                polygon,
                vertex,
                distance,
            }) => Err(ShapeError::NotConvex {
                polygon: mesh.polygon_number(polygon) as usize,
                vertex,
                position: mesh.vertices()[vertex as usize],
                distance: distance as f32,
            }),
        }
    }

    /// A mesh that is known to be convex already.
    pub(in crate::narrow_phase) fn trusted(mesh: PolygonMesh) -> Self {
        let corners = Corners::of(&mesh);
        Self { mesh, corners }
    }

    /// The corners of its polygons, for its support function.
    pub(in crate::narrow_phase) const fn corners(&self) -> &Corners {
        &self.corners
    }

    /// Returns the mesh without the knowledge.
    #[must_use]
    pub fn into_inner(self) -> PolygonMesh {
        self.mesh
    }
}

impl Deref for ConvexMesh {
    type Target = PolygonMesh;

    fn deref(&self) -> &PolygonMesh {
        &self.mesh
    }
}

impl TryFrom<PolygonMesh> for ConvexMesh {
    type Error = ShapeError;

    fn try_from(mesh: PolygonMesh) -> Result<Self, ShapeError> {
        Self::new(mesh)
    }
}

/// Six times the enclosed volume in units of the radius cubed, positive if the polygons face
/// outwards; and the middle of what is enclosed.
fn volume_and_middle(mesh: &PolygonMesh) -> (f64, DVec3) {
    let (center, _, radius) = mesh.local_bounds();
    let (center, radius) = (center.as_dvec3(), f64::from(radius));
    let at = |vertex: u32| (mesh.vertices()[vertex as usize].as_dvec3() - center) / radius;
    let (mut volume, mut moment) = (0.0, DVec3::ZERO);
    mesh.for_each_solid(|corners| {
        let a = at(corners[0]);
        for pair in corners[1..].windows(2) {
            let (b, c) = (at(pair[0]), at(pair[1]));
            let part = a.dot(b.cross(c));
            volume += part;
            moment += (a + b + c) * part;
        }
    });
    (volume, center + moment / (4.0 * volume) * radius)
}

/// A vertex outside the plane of a polygon.
#[derive(Clone, Copy, Debug)]
struct Outside {
    polygon: usize,
    vertex: u32,
    distance: f64,
}

/// The plane of a polygon, and how far it can be trusted.
#[derive(Clone, Copy, Debug)]
struct Plane {
    middle: DVec3,
    normal: DVec3,
    /// Twice the area.
    area: f64,
    perimeter: f64,
}

/// The question whether a closed mesh that faces outwards is convex.
///
/// It is if (1) it bends outwards at every edge, (2) a point is on the inner side of all of its
/// polygons, and (3) these are seen from there under 4π of solid angle in all, that is once in each
/// direction. For by (2) each polygon faces away from the point, so that none is seen over another
/// by (3), and the mesh is the border of a solid that is star-shaped around the point. By (1) that
/// solid is convex around each point of an edge, and around each vertex, where a simple cone with
/// no edge bent inwards is convex; and a connected closed set that is convex around each of its
/// points is convex (Tietze 1928, Nakajima 1928).
///
/// With vertices of 32 bits, edges between polygons of one plane bend either way. What bends inwards
/// by no more than that is flat. What bends inwards by more, but not by too much, is not known to be
/// harmless together with others: all vertices are compared with the polygons there.
struct Check<'a> {
    mesh: &'a PolygonMesh,
    planes: Vec<Plane>,
    /// How far outside of a plane a vertex may be.
    flatness: f64,
    /// How far vertices may have been moved, and what they are rounded to.
    moved: f64,
    rounding: f64,
}

impl<'a> Check<'a> {
    fn new(mesh: &'a PolygonMesh) -> Self {
        let (center, _, radius) = mesh.local_bounds();
        let radius = f64::from(radius);
        let step = STEPS * (radius + f64::from(center.abs().max_element()));
        let mut check = Self {
            mesh,
            planes: Vec::with_capacity(mesh.polygon_count()),
            flatness: FLATNESS * radius,
            moved: MOVED * radius + step,
            rounding: step,
        };
        for corners in mesh.polygons() {
            let middle = corners
                .iter()
                .map(|corner| check.at(*corner))
                .sum::<DVec3>();
            let middle = middle / corners.len() as f64;
            let (mut area, mut perimeter) = (DVec3::ZERO, 0.0);
            for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                let (a, b) = (check.at(*a) - middle, check.at(*b) - middle);
                area += a.cross(b);
                perimeter += a.distance(b);
            }
            check.planes.push(Plane {
                middle,
                normal: area.normalize_or_zero(),
                area: area.length(),
                perimeter,
            });
        }
        check
    }

    fn at(&self, vertex: u32) -> DVec3 {
        self.mesh.vertices()[vertex as usize].as_dvec3()
    }

    /// A vertex that keeps the mesh from being convex.
    fn find_outside(&self, inner: DVec3) -> Option<Outside> {
        let mut angle = 0.0;
        for polygon in 0..self.planes.len() {
            if self.height(polygon, inner) > -self.rounding {
                // Something is outside of it at least as far as the inner point.
                if let found @ Some(_) = self.outside_of(polygon) {
                    return found;
                }
            }
        }
        self.mesh.for_each_solid(|corners| {
            let to = |corner: u32| (self.at(corner) - inner).normalize_or_zero();
            let a = to(corners[0]);
            for pair in corners[1..].windows(2) {
                let (b, c) = (to(pair[0]), to(pair[1]));
                let cosines = 1.0 + a.dot(b) + b.dot(c) + c.dot(a);
                angle += 2.0 * a.dot(b.cross(c)).atan2(cosines);
            }
        });
        if (angle - 4.0 * PI).abs() > PI {
            // It winds around the point more than once: some polygons are within others.
            return (0..self.planes.len()).find_map(|polygon| self.outside_of(polygon));
        }
        for polygon in 0..self.planes.len() {
            let mut is_suspect = false;
            for &other in self.mesh.across(polygon) {
                if other == NO_NEIGHBOR {
                    // Vertices are on that side, or more than one polygon is across it.
                    is_suspect = true;
                    continue;
                }
                let corners = self.mesh.polygon(other as usize);
                if corners.len() > LONG {
                    let middle = self.planes[other as usize].middle;
                    is_suspect |= self.thickness(polygon, middle) > self.rounding;
                    continue;
                }
                for &vertex in corners {
                    let thickness = self.thickness(polygon, self.at(vertex));
                    if thickness > self.rounding {
                        if let found @ Some(_) = self.judge(polygon, vertex) {
                            return found;
                        }
                        is_suspect = true;
                    }
                }
            }
            if is_suspect && let found @ Some(_) = self.outside_of(polygon) {
                return found;
            }
        }
        None
    }

    /// How far a point is outside the plane of a polygon.
    fn height(&self, polygon: usize, point: DVec3) -> f64 {
        let plane = &self.planes[polygon];
        plane.normal.dot(point - plane.middle)
    }

    /// How far the corners of a polygon and a point have to be moved, about, so that it is not
    /// outside: less than it is, where the polygon is small or a sliver and the point far away.
    fn thickness(&self, polygon: usize, point: DVec3) -> f64 {
        let plane = &self.planes[polygon];
        let sides = plane.perimeter * point.distance(plane.middle);
        self.height(polygon, point) * plane.area / (plane.area + sides).max(f64::MIN_POSITIVE)
    }

    /// Whether a vertex is too far outside of a polygon.
    fn judge(&self, polygon: usize, vertex: u32) -> Option<Outside> {
        let point = self.at(vertex);
        let distance = self.height(polygon, point);
        let is_outside = distance > self.flatness && self.thickness(polygon, point) > self.moved;
        is_outside.then_some(Outside {
            polygon,
            vertex,
            distance,
        })
    }

    /// A vertex too far outside of a polygon, of all that there are.
    fn outside_of(&self, polygon: usize) -> Option<Outside> {
        let mesh = self.mesh;
        let corners = |other: usize| mesh.polygon(other).iter();
        let Some(tree) = mesh.tree() else {
            let mut all = (0..mesh.polygon_count()).flat_map(corners);
            return all.find_map(|vertex| self.judge(polygon, *vertex));
        };
        let plane = &self.planes[polygon];
        let distance = plane.normal.dot(plane.middle) + self.flatness - 8.0 * self.rounding;
        let beyond = HalfSpace::new(plane.normal.as_vec3().extend(-distance as f32));
        let mut found = None;
        let region = ViewFrustum {
            half_spaces: [beyond; 6],
        };
        tree.for_each_overlapping(&region, |other| {
            let first = || corners(other as usize).find_map(|v| self.judge(polygon, *v));
            found = found.or_else(first);
        });
        found
    }
}

#[cfg(test)]
mod tests;
