//! Rays.

use bevy::{math::DAffine3, prelude::*};

use super::{
    cast::{self, Caster},
    filter::CasterFilter,
    hits::RayHits,
};
use crate::{
    narrow_phase::RayCastOptions,
    spatial_query::{RayHit, SpatialQuery, SpatialQueryFilter},
};

/// Casts a ray in each tick, and lists what it meets in the entity's [`RayHits`].
///
/// The default is a ray from the entity's origin forwards, along its negative z axis, to the first
/// that it meets, however far away. See the [module](super) for where rays start, and when.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// #[derive(Component)]
/// struct Player;
///
/// fn spawn(mut commands: Commands) {
///     // Is there ground below the feet?
///     let feet = RayCaster::new(Vec3::ZERO, Dir3::NEG_Y)
///         .with_length(1.1)
///         .with_filter(CasterFilter::default().without_sensors());
///     commands.spawn((Player, CollisionShape::cuboid(0.6, 2.0, 0.6), feet));
/// }
///
/// fn jump(player: Single<(&RayHits, &mut Velocity), With<Player>>) {
///     let (below, mut velocity) = player.into_inner();
///     if !below.is_empty() {
///         velocity.y = 5.0;
///     }
/// }
/// # bevy::ecs::system::assert_is_system(spawn);
/// # bevy::ecs::system::assert_is_system(jump);
/// ```
#[doc(alias("raycast", "ray cast", "laser", "line of sight", "RayCast3D"))]
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
#[require(Transform, RayHits)]
pub struct RayCaster {
    /// Whether the ray is cast at all. One that is not meets nothing.
    pub enabled: bool,
    /// Where the ray starts, in the entity's own space.
    pub origin: Vec3,
    /// Where it goes to, in the entity's own space.
    pub direction: Dir3,
    /// How far it reaches, in units of the world: [`f32::MAX`] by default.
    #[doc(alias = "max_distance")]
    pub length: f32,
    /// How many entities it meets at most, the nearest: 1 by default, which is the quickest. What is
    /// behind is met as though nothing were in front.
    pub max_hits: u32,
    /// Which faces it meets, whether solids are hollow, and whether what it starts on counts.
    pub options: RayCastOptions,
    /// Which entities it sees.
    #[entities]
    pub filter: CasterFilter,
}

impl Default for RayCaster {
    fn default() -> Self {
        Self {
            enabled: true,
            origin: Vec3::ZERO,
            direction: Dir3::NEG_Z,
            length: f32::MAX,
            max_hits: 1,
            options: RayCastOptions::DEFAULT,
            filter: CasterFilter::default(),
        }
    }
}

impl RayCaster {
    /// Makes one that casts from a point along a direction, both in the entity's own space.
    #[must_use]
    pub fn new(origin: Vec3, direction: Dir3) -> Self {
        Self {
            origin,
            direction,
            ..default()
        }
    }

    /// Returns the same with a ray that reaches this far.
    #[must_use]
    pub fn with_length(self, length: f32) -> Self {
        Self { length, ..self }
    }

    /// Returns the same with a ray that meets so many entities at most, the nearest; all of them by
    /// [`u32::MAX`].
    #[must_use]
    pub fn with_max_hits(self, max_hits: u32) -> Self {
        Self { max_hits, ..self }
    }

    /// Returns the same with these options.
    #[must_use]
    pub fn with_options(self, options: RayCastOptions) -> Self {
        Self { options, ..self }
    }

    /// Returns the same with this filter.
    #[must_use]
    pub fn with_filter(self, filter: CasterFilter) -> Self {
        Self { filter, ..self }
    }

    /// Returns the ray in the world, given where the entity is: for drawing it, and the like. `None`
    /// if that is nowhere.
    #[must_use]
    pub fn global_ray(&self, at: &GlobalTransform) -> Option<Ray3d> {
        self.ray(&at.affine().as_daffine3())
    }

    /// The same, given what the hierarchy does to the entity.
    pub(crate) fn ray(&self, pose: &DAffine3) -> Option<Ray3d> {
        ray(self.origin, self.direction, pose)
    }
}

/// A ray of an entity's own space in the world.
fn ray(origin: Vec3, direction: Dir3, pose: &DAffine3) -> Option<Ray3d> {
    let start = pose.transform_point3(origin.as_dvec3()).as_vec3();
    let direction = cast::direction(direction, pose)?;
    start.is_finite().then(|| Ray3d::new(start, direction))
}

impl Caster for RayCaster {
    type Hits = RayHits;

    fn filter(&self) -> Option<&CasterFilter> {
        (self.enabled && self.max_hits > 0).then_some(&self.filter)
    }

    fn find(
        &self,
        pose: &DAffine3,
        spatial: &SpatialQuery,
        filter: &SpatialQueryFilter,
        hits: &mut Vec<RayHit>,
    ) {
        let Some(ray) = ray(self.origin, self.direction, pose) else {
            return;
        };
        if self.max_hits == 1 {
            hits.extend(spatial.cast_ray_with(ray, self.length, filter, &self.options));
        } else {
            spatial.ray_hits_with(ray, self.length, filter, &self.options, hits);
            hits.truncate(self.max_hits as usize);
        }
    }
}

pub(super) fn register(app: &mut App) {
    app.register_type::<RayCaster>();
}
