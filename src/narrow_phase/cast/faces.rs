//! Rays against meshes, by the faces that they are to meet: one search over the polygons for all
//! that options ask.

use std::ops::ControlFlow;

use bevy::math::{DVec3, Vec3A, bounding::Aabb3d};

use super::{
    local_ray::{BORDER, LocalRay, is_on_polygon, vertex},
    ray::{ALONG, First},
};
use crate::{
    broad_phase::Sweep,
    narrow_phase::{
        cast_options::{Faces, RayCastOptions},
        frame::chord::{ALONG_START, Met},
        mesh::polygon_mesh::PolygonMesh,
    },
};

/// So far ahead, by what is uncertain of a start, is looked whether a ray goes into a solid.
const AHEAD: f64 = 16.0;

/// What a ray is to a polygon.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    pub polygon: u32,
    pub normal: DVec3,
    /// How high the ray starts over the plane, in the world.
    height: f64,
    /// The sine of the angle by which it climbs.
    pub steep: f64,
    /// Does it start on the polygon?
    starts_on: bool,
}

/// The polygons that a ray starts on.
#[derive(Clone, Copy, Debug)]
struct Start {
    /// Where it starts, on their planes.
    origin: DVec3,
    /// The normal of one that it goes along.
    along: Option<DVec3>,
    /// The one of the others that it goes through the steepest.
    across: Option<Crossing>,
    /// Does one of them bound a solid?
    is_of_solid: bool,
}

/// The reach of questions about one mesh.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// How near to its border a point counts as on a polygon.
    border: f64,
    /// The same for the start.
    start: f64,
}

impl LocalRay {
    /// Where the ray meets a mesh, by its options.
    pub fn mesh_with(
        &self,
        mesh: &PolygonMesh,
        max_distance: f64,
        options: &RayCastOptions,
    ) -> Option<Met> {
        let reach = self.reach(mesh);
        let is_solid = mesh.has_inside() && options.meets_inside();
        let start = options
            .ignores_start
            .then(|| self.start(mesh, reach))
            .flatten();
        if let Some(start) = start
            && let Some(across) = start.across.filter(|_| self.goes_in(mesh, &start, options))
        {
            let met = Met::crossing(0.0, across.normal, Some(across.polygon));
            return match options.faces {
                // Where it leaves is further on.
                Faces::Back if mesh.bounds_solid(across.polygon as usize) => {
                    self.first(mesh, reach, max_distance, |crossing, _| {
                        crossing.steep > 0.0 && !self.is_left(crossing)
                    })
                }
                _ => Some(met),
            };
        }
        let is_on_border = start.as_ref().is_some_and(|start| start.is_of_solid);
        if is_solid && !is_on_border && mesh.winds_around(self.origin) {
            return Some(Met::INSIDE);
        }
        let meets_start = is_solid && start.is_none() && !options.ignores_start;
        let (ray, reach) = start
            .as_ref()
            .map_or((*self, reach), |start| self.levelled(mesh, start, reach));
        ray.first(mesh, reach, max_distance, |crossing, distance| {
            if meets_start && crossing.starts_on {
                return true;
            }
            // Edges of what it leaves, or goes along, lead nowhere.
            let counts = |start: &Start| {
                let way = if options.faces == Faces::Back {
                    -self.step()
                } else {
                    self.step()
                };
                !self.is_left(crossing)
                    && (!mesh.bounds_solid(crossing.polygon as usize)
                        || self.is_solid_at(mesh, start, distance + way))
            };
            options.meets(crossing.steep) && start.as_ref().is_none_or(counts)
        })
    }

    pub fn reach(&self, mesh: &PolygonMesh) -> Reach {
        let (center, _, radius) = mesh.local_bounds();
        let border = BORDER * (f64::from(radius) + (self.origin - center.as_dvec3()).length());
        Reach {
            border,
            start: border.max(self.slack_in_shape()),
        }
    }

    /// How far off a shape the ray may start and count as on it, in the shape's coordinates.
    fn slack_in_shape(&self) -> f64 {
        self.slack / self.scale.abs().max_element()
    }

    /// A distance that is more than what is uncertain of the start.
    fn step(&self) -> f64 {
        AHEAD * self.slack
    }

    /// The ray on its way along what it starts on, but for rounding; and what is uncertain of the
    /// borders that it then meets, as where a floor ends at a wall.
    fn levelled(&self, mesh: &PolygonMesh, start: &Start, reach: Reach) -> (Self, Reach) {
        let Some(normal) = start.along else {
            return (*self, reach);
        };
        let (_, _, radius) = mesh.local_bounds();
        let rounding = f64::from(f32::EPSILON) * f64::from(radius);
        let ray = Self {
            origin: start.origin,
            direction: self.direction - normal * normal.dot(self.direction),
            ..*self
        };
        let border = 4.0 * rounding.max(self.slack_in_shape());
        (ray, Reach { border, ..reach })
    }

    /// Does the ray leave behind what it starts on, or go along it, with what is level with it?
    fn is_left(&self, crossing: Crossing) -> bool {
        crossing.starts_on
            || (crossing.height.abs() <= self.slack && crossing.steep.abs() <= ALONG_START)
    }

    /// What the ray starts on.
    fn start(&self, mesh: &PolygonMesh, reach: Reach) -> Option<Start> {
        let mut start = Start {
            origin: self.origin,
            along: None,
            across: None,
            is_of_solid: false,
        };
        let mut look = |polygon: u32| {
            let crossing = self.crossing(mesh, polygon, reach);
            if !crossing.starts_on {
                return;
            }
            start.is_of_solid |= mesh.bounds_solid(polygon as usize);
            if crossing.steep.abs() <= ALONG_START {
                start.along = Some(crossing.normal);
            } else if start
                .across
                .is_none_or(|across| crossing.steep.abs() > across.steep.abs())
            {
                start.across = Some(crossing);
            }
            let corner = vertex(mesh, mesh.polygon(polygon as usize)[0]);
            let height = crossing.normal.dot(start.origin - corner);
            start.origin -= crossing.normal * height;
        };
        match mesh.tree() {
            None => (0..mesh.polygon_count() as u32).for_each(look),
            Some(tree) => {
                let (center, around) = (self.origin.as_vec3a(), self.around(mesh, reach));
                let near = Aabb3d {
                    min: center - around,
                    max: center + around,
                };
                tree.for_each_overlapping(&near, &mut look);
            }
        }
        (start.along.is_some() || start.across.is_some()).then_some(start)
    }

    /// How far around the start polygons are that it may be on.
    fn around(&self, mesh: &PolygonMesh, reach: Reach) -> Vec3A {
        let (center, _, radius) = mesh.local_bounds();
        let rounding = f64::from(f32::EPSILON) * (center.as_dvec3().length() + f64::from(radius));
        // Across a plane, it may be further by the scale.
        let across = DVec3::splat(self.slack) / self.scale.abs();
        (across.max(DVec3::splat(reach.start)) + 8.0 * rounding).as_vec3a()
    }

    /// Does the ray go into what it starts on? Into a solid, if there is one; into a polygon that
    /// bounds none, from the side that it is to be met from.
    fn goes_in(&self, mesh: &PolygonMesh, start: &Start, options: &RayCastOptions) -> bool {
        let Some(across) = start.across else {
            return false;
        };
        if !mesh.bounds_solid(across.polygon as usize) {
            return options.faces != Faces::Both && options.meets(across.steep);
        }
        self.is_solid_at(mesh, start, self.step())
    }

    /// Is there solid at a place along the ray, and beside it, where it goes along what it starts
    /// on: not on the edge of what that is.
    fn is_solid_at(&self, mesh: &PolygonMesh, start: &Start, distance: f64) -> bool {
        let place = start.origin + self.direction * distance;
        match start.along {
            None => mesh.winds_around(place),
            Some(normal) => {
                let aside = normal * (AHEAD * self.slack_in_shape());
                mesh.winds_around(place + aside) && mesh.winds_around(place - aside)
            }
        }
    }

    fn crossing(&self, mesh: &PolygonMesh, polygon: u32, reach: Reach) -> Crossing {
        let corners = mesh.polygon(polygon as usize);
        let normal = mesh.normals()[polygon as usize].as_dvec3();
        let height = normal.dot(self.origin - vertex(mesh, corners[0]));
        let height = self.height(height, normal);
        Crossing {
            polygon,
            normal,
            height,
            steep: self.height(normal.dot(self.direction), normal),
            starts_on: height.abs() <= self.slack
                && is_on_polygon(mesh, corners, normal, self.origin, reach.start),
        }
    }

    /// What the ray meets first of the polygons that are accepted, by their distance too.
    pub fn first(
        &self,
        mesh: &PolygonMesh,
        reach: Reach,
        max_distance: f64,
        accepts: impl Fn(Crossing, f64) -> bool,
    ) -> Option<Met> {
        let mut first = First::within(max_distance);
        let look = |polygon: u32, first: &mut First| {
            let crossing = self.crossing(mesh, polygon, reach);
            if let Some(met) = self.meeting(mesh, crossing, reach)
                && met.distance <= first.limit
                && accepts(crossing, met.distance)
            {
                first.meet(met);
            }
        };
        let Some(tree) = mesh.tree() else {
            for polygon in 0..mesh.polygon_count() as u32 {
                look(polygon, &mut first);
            }
            return first.met;
        };
        let (center, _, radius) = mesh.local_bounds();
        let (radius, speed) = (f64::from(radius), self.direction.length());
        // The tree's numbers are of 32 bits: from near the mesh, they are exact enough.
        let away = (self.origin - center.as_dvec3()).length();
        let skipped = ((away - 2.0 * radius) / speed).max(0.0);
        let origin = self.origin + self.direction * skipped;
        let around = self.around(mesh, reach)
            + Vec3A::splat((8.0 * f64::from(f32::EPSILON) * 4.0 * radius) as f32);
        // It is a little off.
        let left = |limit: f64| ((limit - skipped) as f32).next_up() * (1.0 + 4.0 * f32::EPSILON);
        if left(max_distance) < 0.0 {
            return None;
        }
        let (origin, way) = (origin.as_vec3a(), self.direction.as_vec3a());
        let (measure, limit) = Sweep::along(origin, way, -around, around, left(max_distance));
        tree.search(&measure, limit, |polygon, _| {
            look(polygon, &mut first);
            ControlFlow::Continue(left(first.limit))
        });
        first.met
    }

    /// Where the ray meets a polygon.
    fn meeting(&self, mesh: &PolygonMesh, crossing: Crossing, reach: Reach) -> Option<Met> {
        let Crossing {
            polygon,
            normal,
            height,
            steep,
            starts_on,
        } = crossing;
        if starts_on {
            return Some(Met::crossing(0.0, normal, Some(polygon)));
        }
        let corners = mesh.polygon(polygon as usize);
        if height.abs() <= self.slack && steep.abs() <= ALONG {
            let distance = self.border(mesh, corners, normal, reach.border)?;
            return Some(Met::touching(distance, normal, Some(polygon)));
        }
        // Not for a ray within the plane, for which this is not a number, or infinite.
        let distance = -height / steep;
        let is_ahead = distance >= 0.0 && distance.is_finite();
        let point = self.origin + self.direction * distance;
        (is_ahead && is_on_polygon(mesh, corners, normal, point, reach.border))
            .then(|| Met::crossing(distance, normal, Some(polygon)))
    }
}

#[cfg(test)]
mod tests;
