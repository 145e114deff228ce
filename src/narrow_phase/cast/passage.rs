//! Rays through solids: where they enter, and where they leave.

use bevy::math::{Dir3, Vec3};

use super::{
    local_ray::{LocalRay, limit},
    ray::is_askable,
};
use crate::narrow_phase::{
    answer::{Impact, Passage},
    cast_options::RayCastOptions,
    frame::{chord::Met, placed::Placed},
    mesh::polygon_mesh::PolygonMesh,
    settings::NarrowPhase,
    shape::Shape,
    support,
};

/// Of a mesh, what is nearer together along a ray than this share of its size is one place.
const TOGETHER: f64 = 1e-9;

impl NarrowPhase {
    /// Casts a ray through a shape: returns where it enters, as [`cast_ray`](Self::cast_ray) does,
    /// and where it then leaves. `None` if it meets nothing within `max_distance`.
    ///
    /// A ray that starts inside a solid only leaves it; one that starts on it enters at once, and
    /// leaves at once if it goes away. What it leaves is the whole solid: walls within it, where
    /// closed parts of a mesh overlap, are none, nor are those of the parts of a compound. From a mesh
    /// that is not closed, and from surfaces of Rapier's, it does not leave.
    ///
    /// Allocates nothing. Cuboids, spheres: O(1); convex meshes: linear in their polygons; meshes:
    /// O(log n) for each wall that the ray crosses.
    ///
    /// ```
    /// use bevy::{math::{Dir3, Vec3}, transform::components::Transform};
    /// use bevy_octree::narrow_phase::{NarrowPhase, Placed, Shape};
    ///
    /// let (tests, ball, at) = (NarrowPhase::default(), Shape::sphere(1.0), Transform::from_xyz(5.0, 0.0, 0.0));
    /// let through = |from: Vec3| tests.cast_ray_through(Placed::new(&ball, &at), from, Dir3::X, 100.0);
    /// let passage = through(Vec3::ZERO).unwrap();
    /// assert_eq!(passage.enter.unwrap().point, Vec3::X * 4.0);
    /// assert_eq!(passage.leave.unwrap().point, Vec3::X * 6.0);
    /// assert_eq!(through(Vec3::X * 5.0).unwrap().enter, None);
    /// ```
    #[doc(alias("exit point", "thickness", "penetration"))]
    #[must_use]
    pub fn cast_ray_through(
        &self,
        target: Placed,
        origin: Vec3,
        direction: Dir3,
        max_distance: f32,
    ) -> Option<Passage> {
        if target.shape.is_cast_by_support() {
            return match support::as_own(target) {
                Some((own, at)) => {
                    let own = Placed::new(&own, &at);
                    self.cast_ray_through(own, origin, direction, max_distance)
                }
                None => {
                    let enter = self.cast_ray(target, origin, direction, max_distance)?;
                    let found = support::passage(target, origin, direction, max_distance, enter);
                    Some(found.unwrap_or(Passage {
                        enter: Some(enter),
                        leave: None,
                    }))
                }
            };
        }
        if !is_askable(target, origin, direction, max_distance) {
            return None;
        }
        let ray = LocalRay::new(target, origin, direction)?;
        let impact = |met: Met| ray.impact(target, (origin, direction), max_distance, met);
        if let Shape::Mesh(mesh) = target.shape {
            return ray.through(mesh, limit(max_distance), impact);
        }
        let chord = ray.chord(target)?;
        let is_inside = chord.height < -ray.slack;
        let enter = if is_inside {
            None
        } else {
            Some(
                chord
                    .met(&RayCastOptions::DEFAULT, ray.slack)
                    .and_then(impact)?,
            )
        };
        // Of what it no more than touches, it goes away at once.
        let leave = chord.ends.map_or(chord.start, |[_, leaves]| leaves.ahead());
        Some(Passage {
            enter,
            leave: impact(leave),
        })
    }
}

impl LocalRay {
    fn through(
        &self,
        mesh: &PolygonMesh,
        max_distance: f64,
        impact: impl Fn(Met) -> Option<Impact>,
    ) -> Option<Passage> {
        let (reach, together) = (self.reach(mesh), self.together(mesh));
        let bounds = |met: &Met| {
            met.polygon
                .is_some_and(|polygon| mesh.bounds_solid(polygon as usize))
        };
        let on = |solid: bool| {
            self.first(mesh, reach, 0.0, |crossing, distance| {
                distance == 0.0 && mesh.bounds_solid(crossing.polygon as usize) == solid
            })
        };
        let starts_on = on(true).or_else(|| on(false));
        let is_inside = starts_on.is_none() && mesh.winds_around(self.origin);
        let enters = if is_inside {
            None
        } else {
            Some(starts_on.or_else(|| self.first(mesh, reach, max_distance, |_, _| true))?)
        };
        let enter = match enters {
            Some(met) => Some(impact(met)?),
            None => None,
        };
        // Behind what bounds no solid, there is none.
        let is_solid = is_inside || enters.as_ref().is_some_and(bounds);
        let leave = is_solid
            .then(|| self.leave(mesh, enters, together))
            .flatten();
        Some(Passage {
            enter,
            leave: leave.and_then(impact),
        })
    }

    /// How near two places along the ray are that count as one.
    fn together(&self, mesh: &PolygonMesh) -> f64 {
        let (center, _, radius) = mesh.local_bounds();
        let size = f64::from(radius) + (self.origin - center.as_dvec3()).length();
        (TOGETHER * size / self.direction.length()).max(f64::MIN_POSITIVE)
    }

    /// Where the ray leaves a solid that it enters at a place, or starts in: at the first wall behind
    /// which it is outside.
    fn leave(&self, mesh: &PolygonMesh, enters: Option<Met>, together: f64) -> Option<Met> {
        let reach = self.reach(mesh);
        let after = |place: f64| {
            self.first(mesh, reach, f64::INFINITY, |_, distance| {
                distance > place + together
            })
        };
        let mut wall = match enters {
            Some(enters) => enters,
            None => after(-2.0 * together)?,
        };
        loop {
            let next = after(wall.distance);
            let is_outside = next.is_none_or(|next| {
                let between = wall.distance.midpoint(next.distance);
                !mesh.winds_around(self.origin + self.direction * between)
            });
            match next {
                Some(next) if !is_outside => wall = next,
                _ => return Some(wall),
            }
        }
    }
}
