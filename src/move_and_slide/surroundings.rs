//! What a shape that moves may meet: the questions that all movers ask.

use std::cell::Cell;

use bevy::{
    math::bounding::{Aabb3d, AabbCast3d},
    prelude::*,
};
use smallvec::SmallVec;

use super::hit::MoveHit;
use crate::{
    broad_phase::ProxyId,
    collision_index::Body,
    narrow_phase::{Impact, NarrowPhase, Placed, Shape, ShapeCastOptions, Workspace},
    spatial_query::{SpatialQuery, SpatialQueryFilter, with_workspace},
};

/// At least so many tolerances of the exact tests is a shape kept off others.
const LEAST_SKIN: f32 = 4.0;
/// What rounding makes of a position, as a share of it.
pub const ROUNDING: f32 = 4.0 * f32::EPSILON;
/// The least cosine of the angle between a way and a surface that it comes to, for how far before it the way ends.
const STEEPEST: f32 = 1e-3;

/// The sine of the angle up to which a shape goes along another, and not against it.
const ALONG: f32 = 1e-3;

/// Others that move in the same tick, by handle, and that give way by half.
pub trait Crowd {
    /// How far one of them is to go, if this is one.
    fn way(&self, id: ProxyId) -> Option<Vec3>;
    /// How far any of them goes at most.
    fn reach(&self) -> f32;
}

/// A shape among others.
pub struct Surroundings<'a, 'w, 's, 'f> {
    pub spatial: &'a SpatialQuery<'w, 's>,
    pub shape: &'a Shape,
    filter: &'a SpatialQueryFilter<'f>,
    /// How far the shape is kept off others.
    pub skin: f32,
    /// Who is not seen any more.
    ignored: SmallVec<[Entity; 4]>,
    crowd: Option<&'a dyn Crowd>,
    /// Was anything in touch with the shape at the start of the last cast?
    is_touched: Cell<bool>,
}

/// What a shape meets on a way.
#[derive(Clone, Copy, Debug)]
pub struct Met {
    pub entity: Entity,
    pub point: Vec3,
    /// From the entity to the shape.
    pub normal: Vec3,
    /// How much of the way it goes, so that the skin is left.
    pub share: f32,
    /// How far it was from it at the start, along the normal, if that is known: of what is met further on it is not of interest.
    pub gap: f32,
    /// Does it start in touch, or in it?
    pub is_at_start: bool,
}

impl Met {
    /// What is told of it, if the shape comes to it after that time, by that velocity.
    pub const fn hit(&self, time: f32, velocity: Vec3) -> MoveHit {
        MoveHit {
            entity: self.entity,
            point: self.point,
            normal: self.normal,
            time,
            depth: 0.0,
            velocity,
        }
    }
}

/// What a shape is in contact with where it is.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    pub entity: Entity,
    pub point: Vec3,
    /// From the entity to the shape.
    pub normal: Vec3,
    pub depth: f32,
    /// How much of the way off is up to the shape.
    pub share: f32,
}

impl<'a, 'w, 's, 'f> Surroundings<'a, 'w, 's, 'f> {
    pub fn new(
        spatial: &'a SpatialQuery<'w, 's>,
        shape: &'a Shape,
        filter: &'a SpatialQueryFilter<'f>,
        skin: f32,
    ) -> Self {
        let least = LEAST_SKIN * spatial.tests().tolerance();
        Self {
            spatial,
            shape,
            filter,
            skin: if skin.is_finite() {
                skin.max(least)
            } else {
                least
            },
            ignored: SmallVec::new(),
            crowd: None,
            is_touched: Cell::new(false),
        }
    }

    /// Has others count as a crowd.
    pub fn among(self, crowd: &'a dyn Crowd) -> Self {
        Self {
            crowd: Some(crowd),
            ..self
        }
    }

    /// Has an entity not be seen any more.
    pub fn ignore(&mut self, entity: Entity) {
        if !self.ignores(entity) {
            self.ignored.push(entity);
        }
    }

    /// Does something without seeing an entity.
    pub fn without<T>(&mut self, entity: Entity, act: impl FnOnce(&mut Self) -> T) -> T {
        let known = self.ignored.len();
        self.ignored.push(entity);
        let done = act(self);
        self.ignored.truncate(known);
        done
    }

    fn ignores(&self, entity: Entity) -> bool {
        self.ignored.contains(&entity)
    }

    /// Is it known where the shape is, at this pose?
    pub fn is_somewhere(&self, pose: &Transform) -> bool {
        self.spatial
            .tests()
            .world_aabb(Placed::new(self.shape, pose))
            .is_ok()
    }

    /// Was the shape in touch with anything where its last [cast](Self::cast) started, whichever way that went?
    pub fn is_touched(&self) -> bool {
        self.is_touched.get()
    }

    /// What is met first on a way from a pose, such that the shape does not go all of it.
    pub fn cast(&self, pose: &Transform, way: Vec3) -> Option<Met> {
        self.is_touched.set(false);
        let (direction, length) = Dir3::new_and_length(way).ok()?;
        let (tests, moving) = (self.spatial.tests(), Placed::new(self.shape, pose));
        let Aabb3d { min, max } = tests.world_aabb(moving).ok()?;
        let reach = self.crowd.map_or(0.0, Crowd::reach);
        let aabb = Aabb3d {
            min: min - reach,
            max: max + reach,
        };
        // What is met a little further on may be too near already.
        let seen = length + 2.0 * self.skin;
        let cast = AabbCast3d::new(aabb, Vec3::ZERO, direction, seen);
        let met = self
            .spatial
            .first_met(&cast, seen, self.filter, |id, body, limit| {
                if self.ignores(body.entity) {
                    return None;
                }
                let come = |direction: Dir3, limit: f32| {
                    let (met, is_touched) = with_workspace(|workspace| {
                        meet(tests, moving, direction, limit, body, workspace)
                    });
                    self.is_touched.set(self.is_touched.get() | is_touched);
                    met
                };
                // As seen by another that is on its way too. What that alone brings about, is its own to avoid.
                let other = self.crowd.and_then(|crowd| crowd.way(id));
                if let Some(other) = other.filter(|other| *other != Vec3::ZERO)
                    && let Ok((towards, nearer)) = Dir3::new_and_length(way - other)
                    // As far as anything is met, whatever has been met before: it may be further away than where the
                    // other was, which does not count then.
                    && let Some(hit) = come(towards, seen * nearer / length)
                    && hit.normal.dot(*direction) < -ALONG
                {
                    let distance = hit.distance * length / nearer;
                    return Some((distance, self.met(body, &hit, towards, nearer)));
                }
                let hit = come(direction, limit)?;
                Some((hit.distance, self.met(body, &hit, direction, length)))
            })?;
        (met.share < 1.0).then_some(met)
    }

    /// As [`cast`](Self::cast), but for what the shape is in at the start.
    pub fn cast_past(&mut self, pose: &Transform, way: Vec3) -> Option<Met> {
        let known = self.ignored.len();
        let met = loop {
            match self.cast(pose, way) {
                Some(met) if met.is_at_start => self.ignored.push(met.entity),
                met => break met,
            }
        };
        self.ignored.truncate(known);
        met
    }

    fn met(&self, body: &Body, hit: &Impact, direction: Dir3, length: f32) -> Met {
        let steep = -hit.normal.dot(*direction);
        let before = self.skin / steep.max(STEEPEST);
        Met {
            entity: body.entity,
            point: hit.point,
            normal: hit.normal,
            share: ((hit.distance - before) / length).max(0.0),
            gap: hit.distance * steep,
            is_at_start: hit.distance == 0.0,
        }
    }

    /// Calls `found` with all that the shape is in contact with at a pose.
    pub fn for_each_touch(&self, pose: &Transform, mut found: impl FnMut(Touch)) {
        let (tests, placed) = (self.spatial.tests(), Placed::new(self.shape, pose));
        self.spatial
            .for_each_near_shape(placed, self.filter, |id, body| {
                if self.ignores(body.entity) {
                    return true;
                }
                let contact =
                    with_workspace(|workspace| tests.contact(body.placed(), placed, workspace));
                if let Some(contact) = contact {
                    let is_of_crowd = self.crowd.is_some_and(|crowd| crowd.way(id).is_some());
                    found(Touch {
                        entity: body.entity,
                        point: contact.point,
                        normal: contact.normal,
                        depth: contact.depth,
                        share: if is_of_crowd { 0.5 } else { 1.0 },
                    });
                }
                true
            });
    }

    /// How far the shape may go along a way.
    pub fn free(&self, pose: &Transform, way: Vec3) -> Vec3 {
        way * self.cast(pose, way).map_or(1.0, |met| met.share)
    }
}

/// What is met on the way, but for what the shape starts in touch with and does not go into; and whether there is such.
fn meet(
    tests: &NarrowPhase,
    moving: Placed,
    direction: Dir3,
    limit: f32,
    body: &Body,
    workspace: &mut Workspace,
) -> (Option<Impact>, bool) {
    const AWAY: ShapeCastOptions = ShapeCastOptions::DEFAULT.ignore_start();
    match tests.sweep(moving, direction, limit, body.placed(), workspace) {
        Some(hit) if hit.distance == 0.0 => {
            let met = tests.sweep_with(moving, direction, limit, body.placed(), &AWAY, workspace);
            (met, true)
        }
        met => (met, false),
    }
}
