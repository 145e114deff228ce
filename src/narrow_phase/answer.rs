//! What the exact tests answer.

use bevy::math::{DVec3, Dir3, Vec3, Vec3A};
use bevy::reflect::Reflect;

/// How far from a shape a point may be that is said to be on it, as a share of the lengths at hand:
/// what rounding leaves uncertain of a position in 32-bit floats.
const ON: f32 = f32::EPSILON;

/// Where two shapes are in contact: a point, a normal and a depth.
#[doc(alias = "penetration")]
#[doc(alias = "manifold")]
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[type_path = "bevy_octree"]
pub struct Contact {
    /// A unit vector from the first shape to the second: to part the two, push the second along it.
    pub normal: Vec3,
    /// A point where the two meet, in the world. Of two that overlap, one of those that they have in
    /// common: which one is up to the kinds of the two, and it need not move steadily as they do.
    pub point: Vec3,
    /// How far the shapes overlap along the normal, in world units. Zero if they touch, or are
    /// apart by no more than the tolerance.
    pub depth: f32,
}

impl Contact {
    /// Returns the contact as the other shape sees it: with the normal turned around.
    #[must_use]
    pub fn reversed(self) -> Self {
        Self {
            normal: -self.normal,
            ..self
        }
    }
}

/// A contact in the frame of a pair.
#[derive(Clone, Copy, Debug)]
pub struct LocalContact {
    pub normal: Vec3A,
    pub point: Vec3A,
    pub depth: f32,
}

impl LocalContact {
    /// That of the pair with its two shapes swapped.
    pub fn reversed(self) -> Self {
        let normal = -self.normal;
        Self { normal, ..self }
    }
}

/// Where something on its way, a ray or a shape, meets a shape.
#[doc(alias("time of impact", "toi", "hit"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// How far along the way; 0 if it starts in touch.
    pub distance: f32,
    /// A point of the shape that is met, in the world; for shapes that overlap from the start, one
    /// where they meet.
    pub point: Vec3,
    /// A unit vector that points away from the shape that is met, and never along the way: against
    /// the way itself if it starts inside, where nothing better is known.
    pub normal: Vec3,
    /// The unit normal of the face that is met: out of a solid, and of a polygon of a mesh [its
    /// own](super::PolygonMesh::normals), whichever side is met. So a face that faces away from
    /// what comes is one whose normal goes [along the way](Self::is_back_face). Where no face is
    /// known, as inside a solid, it is as `normal`; for shapes that overlap from the start, that of
    /// their [contact](super::NarrowPhase::contact), whichever way they go.
    pub face_normal: Vec3,
    /// Which polygon of a mesh is met: its number among those that the mesh was made from; of a
    /// Bevy mesh, that of the triangle. What a [`PolygonMesh`](super::PolygonMesh) is asked about
    /// it goes by its [index](super::PolygonMesh::polygon_index) among those that were kept. One of
    /// them, where several are. Of a height field, the number of its
    /// [triangle](super::HeightField::triangle); of a convex hull, that of the polygon of the hull. `None` where none is
    /// known, and for shapes without polygons of their own: cuboids, balls, voxels, all of Rapier's but
    /// meshes, and compounds, whatever their parts are: where the part counts, make it an entity of a
    /// [`CollisionBody`](crate::parts::CollisionBody). Of shapes on their way, only if [asked for](super::ShapeCastOptions::find_polygon).
    #[doc(alias("triangle", "primitive", "feature", "face id"))]
    pub polygon: Option<u32>,
    /// How deep two shapes are in each other at the start, along `face_normal`; 0 if they are not,
    /// or only touch, and of rays.
    #[doc(alias = "penetration")]
    pub depth: f32,
}

impl Impact {
    /// Returns `true` if the face that is met faces away from what comes: a polygon met from
    /// behind, or the wall of a solid from inside.
    #[must_use]
    pub fn is_back_face(&self) -> bool {
        self.face_normal.dot(self.normal) < 0.0
    }
}

/// Where a ray enters a solid, and where it leaves it.
#[doc(alias("exit point", "thickness"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// Where it enters; `None` if it starts inside.
    pub enter: Option<Impact>,
    /// Where it leaves for the first time; `None` if it does not within its length, or what it
    /// meets is a surface that bounds no solid.
    pub leave: Option<Impact>,
}

impl Passage {
    /// Returns how far the ray goes within the solid, if it leaves it.
    #[must_use]
    pub fn length(&self) -> Option<f32> {
        let start = self.enter.map_or(0.0, |enter| enter.distance);
        Some(self.leave?.distance - start)
    }
}

/// When and where two shapes on their way meet.
#[doc(alias = "toi")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedContact {
    /// The share of the way after which they do, 0 to 1.
    pub time: f32,
    /// Where they then touch.
    pub contact: Contact,
}

impl TimedContact {
    /// The contact on what was left of a way after a share of it, by the time of the whole way.
    pub(crate) fn after(self, time: f32) -> Self {
        Self {
            time: time + self.time * (1.0 - time),
            ..self
        }
    }
}

/// How far two shapes are apart, and where they are closest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proximity {
    /// The distance of the two, in world units. Zero if they overlap.
    pub distance: f32,
    /// A point of the first shape and one of the second, in the world, that are as close as any
    /// two. A common point, twice, if the shapes overlap.
    ///
    /// Rounded as all positions far from the world's origin are. `distance` and `offset` are not.
    pub points: [Vec3; 2],
    /// The way from the first point to the second; its length is the distance.
    pub offset: Vec3,
}

impl Proximity {
    pub(super) fn if_finite(self) -> Option<Self> {
        let is_finite =
            self.distance.is_finite() && self.points.iter().all(|point| point.is_finite());
        is_finite.then_some(self)
    }
}

/// A normal, turned against what comes along a direction.
pub fn against(normal: Vec3, direction: Dir3) -> Vec3 {
    if normal.dot(*direction) > 0.0 {
        -normal
    } else {
        normal
    }
}

/// How far off a shape something may start and count as on it: see [`ON`]. By where it starts in
/// the world, and by the way from the shape's position to there, from which it may come.
pub fn slack(origin: Vec3, from_shape: DVec3) -> f64 {
    f64::from(ON) * (f64::from(origin.abs().max_element()) + 2.0 * from_shape.length())
}
