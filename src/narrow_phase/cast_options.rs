//! What casts are told beyond where they go.

use bevy::reflect::{Reflect, std_traits::ReflectDefault};

/// Which faces of a shape a ray meets, by the way that they face.
///
/// A face of a solid faces out of it: a ray meets front faces where it enters, and back faces where
/// it leaves. A polygon of a mesh faces as its [normal](super::PolygonMesh::normals) says,
/// whether the mesh is closed or not, and mirrored or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Clone, Debug, Default, PartialEq, Hash)]
#[type_path = "bevy_octree"]
#[doc(alias("culling", "backface culling", "cull mode"))]
pub enum Faces {
    /// All of them.
    #[default]
    Both,
    /// Those that face the ray.
    Front,
    /// Those that face away from it.
    Back,
}

/// Says what a ray meets of a shape. By default, that is what [`cast_ray`] meets: solids are solid,
/// and polygons that bound no solid are met from both sides.
///
/// Begin with [`DEFAULT`](Self::DEFAULT), or `default()`, and refine it:
///
/// | by | what is met |
/// |---|---|
/// | [`hollow`](Self::hollow) | the walls of solids, not what is inside |
/// | [`front_faces`](Self::front_faces) | what faces the ray: where it enters solids |
/// | [`back_faces`](Self::back_faces) | what faces away from it: where it leaves solids |
/// | [`ignore_start`](Self::ignore_start) | not what the ray starts on, and goes away from or along |
///
/// ```
/// use bevy::{math::{Dir3, Vec3}, transform::components::Transform};
/// use bevy_octree::narrow_phase::{NarrowPhase, Placed, RayCastOptions, Shape};
///
/// let (tests, ball, at) = (NarrowPhase::default(), Shape::sphere(1.0), Transform::IDENTITY);
/// let cast = |x: f32, options: RayCastOptions| {
///     let hit = tests.cast_ray_with(Placed::new(&ball, &at), Vec3::X * x, Dir3::X, 10.0, &options);
///     hit.map(|hit| hit.distance)
/// };
/// assert_eq!(cast(0.5, RayCastOptions::DEFAULT), Some(0.0)); // from inside
/// assert_eq!(cast(0.5, RayCastOptions::DEFAULT.hollow()), Some(0.5));
/// assert_eq!(cast(-3.0, RayCastOptions::DEFAULT.back_faces()), Some(4.0)); // where it leaves
/// assert_eq!(cast(1.0, RayCastOptions::DEFAULT), Some(0.0)); // from the surface
/// assert_eq!(cast(1.0, RayCastOptions::DEFAULT.ignore_start()), None);
/// ```
///
/// [`cast_ray`]: super::NarrowPhase::cast_ray
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Clone, Debug, Default, PartialEq, Hash)]
#[type_path = "bevy_octree"]
pub struct RayCastOptions {
    pub(in crate::narrow_phase) hollow: bool,
    pub(in crate::narrow_phase) faces: Faces,
    pub(in crate::narrow_phase) ignores_start: bool,
}

impl RayCastOptions {
    /// The options of a ray that meets solids as solids, and both sides of polygons.
    pub const DEFAULT: Self = Self {
        hollow: false,
        faces: Faces::Both,
        ignores_start: false,
    };

    /// Takes solids as hollow: a ray that starts inside goes on to the wall. One that starts on the
    /// wall still meets it there.
    #[must_use]
    #[doc(alias("solid", "hit from inside"))]
    pub const fn hollow(self) -> Self {
        Self {
            hollow: true,
            ..self
        }
    }

    /// Meets only what faces the ray: where it enters solids, and polygons from their front. A ray
    /// that starts inside a solid still meets it at once, unless solids are
    /// [hollow](Self::hollow). Replaces an earlier choice of faces.
    #[must_use]
    pub const fn front_faces(self) -> Self {
        Self {
            faces: Faces::Front,
            ..self
        }
    }

    /// Meets only what faces away from the ray: where it leaves solids, also those that it starts
    /// in, and polygons from behind. Replaces an earlier choice of faces.
    #[must_use]
    #[doc(alias("exit point", "hit back faces"))]
    pub const fn back_faces(self) -> Self {
        Self {
            faces: Faces::Back,
            ..self
        }
    }

    /// Ignores what the ray starts on, as far as it goes away from it or along it: as from a
    /// surface that was met before. What it goes into is met at once, and so is a solid that it
    /// starts deeper in. The rest of a shape is met as ever: further on along a floor, its wall.
    ///
    /// "On" is what is so but for the rounding of 32-bit floats, "along" up to an angle of 10⁻⁶. From
    /// a polygon that bounds no solid, a ray goes away on either side; with
    /// [`front_faces`](Self::front_faces), it goes into it from the front: what stands on a ground
    /// of loose polygons, and looks down, sees it then.
    #[must_use]
    #[doc(alias("ignore origin penetration", "initial overlap"))]
    pub const fn ignore_start(self) -> Self {
        Self {
            ignores_start: true,
            ..self
        }
    }

    /// Is a ray that starts inside a solid met at once?
    pub(in crate::narrow_phase) fn meets_inside(&self) -> bool {
        !self.hollow && self.faces != Faces::Back
    }

    /// Is a face met that a ray crosses as its normal says, or against it?
    pub(in crate::narrow_phase) fn meets(&self, steep: f64) -> bool {
        match self.faces {
            Faces::Both => true,
            Faces::Front => steep < 0.0,
            Faces::Back => steep > 0.0,
        }
    }
}

/// Says what a shape on its way meets of another, and what is told of it. By default, that is what
/// [`sweep`] does: shapes in contact at the start meet at once, whichever way they go.
///
/// Begin with [`DEFAULT`](Self::DEFAULT), or `default()`, and refine it.
///
/// [`sweep`]: super::NarrowPhase::sweep
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Clone, Debug, Default, PartialEq, Hash)]
#[type_path = "bevy_octree"]
pub struct ShapeCastOptions {
    pub(in crate::narrow_phase) ignores_start: bool,
    pub(in crate::narrow_phase) finds_polygon: bool,
}

impl ShapeCastOptions {
    /// The options of a shape that meets what it touches.
    pub const DEFAULT: Self = Self {
        ignores_start: false,
        finds_polygon: false,
    };

    /// Ignores what the shape starts in touch with, as far as it goes away from it or along it, by
    /// the normal of the contact: a thing on the ground may be cast along the ground. What it goes
    /// into is met at once, at a distance of 0; the rest of a mesh or compound, as ever.
    #[must_use]
    #[doc(alias("ignore origin penetration", "initial overlap", "stop at penetration"))]
    pub const fn ignore_start(self) -> Self {
        Self {
            ignores_start: true,
            ..self
        }
    }

    /// Tells which polygon of a mesh is met, and as [`Impact::face_normal`] the normal of that:
    /// costs a search for the one that the point of impact is on.
    ///
    /// [`Impact::face_normal`]: super::Impact::face_normal
    #[must_use]
    #[doc(alias("triangle", "feature"))]
    pub const fn find_polygon(self) -> Self {
        Self {
            finds_polygon: true,
            ..self
        }
    }
}
