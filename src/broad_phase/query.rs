//! Queries, written once for every broad phase.

use bevy::math::{
    Dir3, Vec3,
    bounding::{Aabb3d, RayCast3d},
};

use super::{ProxyId, SpatialIndex, Visitor, overlap};

/// The first box that a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Whose box it is.
    pub proxy: ProxyId,
    /// How far along the ray it begins; 0 if the ray starts inside.
    pub distance: f32,
}

impl SpatialIndex {
    /// Calls `found` with every object whose box overlaps `region`, touching included, each once, as of the last
    /// update. Nothing is allocated.
    pub fn overlapping(&self, region: &Aabb3d, found: impl FnMut(ProxyId)) {
        struct Overlapping<'a, F> {
            region: &'a Aabb3d,
            found: F,
        }
        impl<F: FnMut(ProxyId)> Visitor for Overlapping<'_, F> {
            fn enter(&mut self, bounds: &Aabb3d) -> bool {
                overlap(self.region, bounds)
            }
            fn object(&mut self, id: ProxyId, aabb: &Aabb3d, cell: &Aabb3d) {
                // An object listed in several cells is found in the one that holds the lower corner of the overlap.
                let corner = self.region.min.max(aabb.min);
                if overlap(self.region, aabb)
                    && corner.cmpge(cell.min).all()
                    && (corner.cmplt(cell.max) | cell.max.cmpeq(bevy::math::Vec3A::INFINITY)).all()
                {
                    (self.found)(id);
                }
            }
        }
        self.traverse(&mut Overlapping { region, found });
    }

    /// The first box along a ray, no farther than `max_distance`; of several at the same distance, that of the lowest
    /// handle. `None` too if `origin` or `max_distance` is not a number.
    #[must_use]
    pub fn ray_cast(&self, origin: Vec3, direction: Dir3, max_distance: f32) -> Option<RayHit> {
        struct First {
            ray: RayCast3d,
            hit: Option<RayHit>,
        }
        impl Visitor for First {
            fn enter(&mut self, bounds: &Aabb3d) -> bool {
                self.ray.aabb_intersection_at(bounds).is_some()
            }
            fn object(&mut self, id: ProxyId, aabb: &Aabb3d, _: &Aabb3d) {
                let Some(distance) = self.ray.aabb_intersection_at(aabb) else { return };
                let nearer = self.hit.is_none_or(|hit| (distance, id) < (hit.distance, hit.proxy));
                if nearer {
                    self.hit = Some(RayHit { proxy: id, distance });
                    self.ray.max = distance;
                }
            }
        }
        if !origin.is_finite() || max_distance.is_nan() {
            return None;
        }
        let mut first = First { ray: RayCast3d::new(origin, direction, max_distance), hit: None };
        self.traverse(&mut first);
        first.hit
    }
}
