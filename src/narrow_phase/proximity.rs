//! Distances of placed shapes from a point.

use bevy::math::{Vec3, Vec3A};
use bevy::transform::components::Transform;

use super::edge_polygon;
use super::pair::Pair;
use super::{NarrowPhase, Placed, Shape, Workspace};

impl NarrowPhase {
    /// The point of a shape that is closest to `point`; `point` itself, if it is inside.
    ///
    /// Exact for every kind of shape; parry answers for Rapier's. `None` if anything is not finite.
    ///
    /// Cuboids, spheres: O(1); meshes: linear in their polygons. Allocates nothing once the workspace is warm.
    ///
    /// ```
    /// use bevy::{math::Vec3, transform::components::Transform};
    /// use bevy_octree::narrow_phase::{NarrowPhase, Placed, Shape, Workspace};
    ///
    /// let (brick, at) = (Shape::cuboid(Vec3::new(2.0, 1.0, 1.0))?, Transform::from_xyz(5.0, 0.0, 0.0));
    /// let brick = Placed::new(&brick, &at);
    /// let closest = NarrowPhase::default().closest_point(brick, Vec3::Y, &mut Workspace::default());
    /// assert_eq!(closest, Some(Vec3::new(3.0, 1.0, 0.0)));
    /// # Ok::<(), bevy_octree::narrow_phase::ShapeError>(())
    /// ```
    #[must_use]
    pub fn closest_point(&self, target: Placed, point: Vec3, workspace: &mut Workspace) -> Option<Vec3> {
        #[cfg(feature = "rapier")]
        if let Shape::Rapier(shape) = target.shape {
            let is_finite = point.is_finite() && target.transform.is_finite();
            return is_finite.then(|| super::parry::closest_point(shape, target.transform, point));
        }
        let (at_point, here) = (Shape::Sphere { radius: 0.0 }, Transform::from_translation(point));
        let pair = Pair::new(Placed::new(&at_point, &here), target, self.tolerance()).ok()?;
        // The frame of the pair has its origin at the point.
        let from_point = match target.shape {
            Shape::Cuboid { .. } => pair.box_b.closest_point(Vec3A::ZERO),
            Shape::Sphere { .. } => {
                let distance = pair.box_b.center.length();
                pair.box_b.center * (1.0 - (pair.box_b.radius / distance).min(1.0))
            }
            _ => match edge_polygon::sphere_closest(&pair, workspace)? {
                (_, true) => Vec3A::ZERO,
                (closest, false) => closest.point,
            },
        };
        let closest = point + Vec3::from(from_point);
        closest.is_finite().then_some(closest)
    }
}
