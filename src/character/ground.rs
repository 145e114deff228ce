//! What a character stands on.

use bevy::{ecs::entity::MapEntities, prelude::*};

use super::settings::WalkSettings;
use crate::{
    move_and_slide::{Met, Surroundings},
    spatial_query::{SpatialQuery, SpatialQueryFilter},
};

/// How far behind an edge is looked for what is on top, in skins.
const BEHIND: f32 = 3.0;
/// What leans out so far, as part of its normal along `up`, is no edge to stand on.
const OUTMOST: f32 = 0.15;

/// What a character stands on.
#[derive(Clone, Copy, Debug, PartialEq, MapEntities, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Clone, Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub struct Ground {
    /// The entity.
    #[entities]
    pub entity: Entity,
    /// A point where the two touch, in the world.
    pub point: Vec3,
    /// The unit normal of the ground: on an edge, that of the flatter side of it.
    pub normal: Vec3,
    /// How fast the ground moves there, in the world: as far as it carried the character in this move, by the time. Who
    /// jumps off may add it.
    pub velocity: Vec3,
    /// Where the entity is: what it does by the next move, it does to who stands on it.
    pub pose: Transform,
}

/// How a platform has gone on since somebody stood on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carried {
    pub way: Vec3,
    pub turn: Quat,
}

impl Ground {
    /// How far, and around `up`, this ground has carried who stands on it. `None` if it is gone, or has stayed.
    pub(super) fn carried(&self, spatial: &SpatialQuery, up: Vec3) -> Option<Carried> {
        let now = spatial.entry_of(self.entity)?.pose;
        if now == self.pose {
            return None;
        }
        let back = |v: Vec3| self.pose.rotation.inverse() * v / self.pose.scale;
        // What was scaled to nothing has no places.
        let own = back(self.point - self.pose.translation);
        let way = now.transform_point(own) - self.point;
        let turned = now.rotation * self.pose.rotation.inverse();
        let turn = around(turned, up);
        way.is_finite().then_some(Carried { way, turn })
    }
}

/// The part of a turn that is around an axis.
fn around(turn: Quat, axis: Vec3) -> Quat {
    let along = axis * turn.xyz().dot(axis);
    let twist = Quat::from_xyzw(along.x, along.y, along.z, turn.w);
    if twist.length_squared() > 1e-12 {
        twist.normalize()
    } else {
        Quat::IDENTITY
    }
}

/// Whoever asks what is ground.
#[derive(Clone, Copy, Debug)]
pub struct Footing {
    pub up: Vec3,
    pub flattest: f32,
}

impl Footing {
    pub fn of(settings: &WalkSettings) -> Self {
        Self {
            up: settings.upwards(),
            flattest: settings.flattest(),
        }
    }

    /// The normal of what one stands on, if that is ground: that of the surface, or of the top that an edge belongs to.
    pub fn normal(&self, around: &Surroundings, met: &Met) -> Option<Vec3> {
        let steep = met.normal.dot(self.up);
        if steep >= self.flattest {
            Some(met.normal)
        } else if steep > OUTMOST {
            self.top(around.spatial, around.skin, met)
        } else {
            None
        }
    }

    /// The normal of the top of an edge, if that is ground: by a ray that goes down just behind it.
    fn top(&self, spatial: &SpatialQuery, skin: f32, met: &Met) -> Option<Vec3> {
        let aside = met.normal.reject_from(self.up).try_normalize()?;
        let behind = BEHIND * skin;
        let origin = met.point + self.up * (2.0 * behind) - aside * behind;
        let ray = Ray3d::new(origin, Dir3::new(-self.up).ok()?);
        let is_met = |entity| entity == met.entity;
        let filter = SpatialQueryFilter::DEFAULT.in_any_world().only(&is_met);
        let hit = spatial.cast_ray(ray, 4.0 * behind, &filter)?;
        // From within, the ray has met no top.
        let is_top = hit.distance > 0.0 && hit.normal.dot(self.up) >= self.flattest;
        is_top.then_some(hit.normal)
    }
}
