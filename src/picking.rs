//! What is under the pointer: a backend of `bevy_picking` that asks shapes instead of meshes. With
//! the feature `picking`.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! App::new()
//!     .add_plugins((DefaultPlugins, OctreePlugins::default(), CollisionPickingPlugin))
//!     .add_systems(Startup, |mut commands: Commands| {
//!         commands.spawn((CollisionShape::default(), Transform::from_xyz(0.0, 0.0, -5.0))).observe(
//!             |click: On<Pointer<Click>>| println!("{} was hit at {:?}", click.entity, click.hit.position),
//!         );
//!     })
//!     .run();
//! ```
//!
//! Each entity with a [`CollisionShape`](crate::components::CollisionShape) can be picked, by the
//! exact shape, where it was at the last tick. Which ones are, from the cheapest way to say so to
//! the finest:
//!
//! | | |
//! |---|---|
//! | [`CollisionPickingSettings::require_markers`] | only those with a [`CollisionPickable`], through cameras with one |
//! | [`InCollisionWorld`] on a camera | only those in the same world; without it, those of all worlds |
//! | [`CollisionLayers`] on a camera | only those on a layer that the camera may meet; without it, all |
//! | [`Pickable`] on an entity | as everywhere: [`Pickable::IGNORE`] is not seen, and `should_block_lower: false` lets what is behind be picked too |
//!
//! # What a hit tells
//!
//! The `depth` of a [`HitData`] is the distance along the ray, `position` and `normal` are in the
//! world. All else that is known comes as its `extra`: the [`RayHit`], with the polygon of a mesh
//! that was met, which is the triangle of a Bevy mesh, and the normal of that face.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_octree::prelude::*;
//!
//! fn paint(click: On<Pointer<Click>>) {
//!     let Some(hit) = click.hit.extra_as::<RayHit>() else { return }; // of another backend
//!     if let Some(triangle) = hit.polygon {
//!         println!("triangle {triangle} of {}, {} away", hit.entity, hit.distance);
//!     }
//! }
//! App::new().add_observer(paint);
//! ```

use bevy::{
    camera::Camera,
    picking::{
        Pickable, PickingSystems,
        backend::{HitData, PointerHits, ray::RayMap},
    },
    prelude::*,
};

use crate::{
    filters::CollisionLayers,
    spatial_query::{RayHit, SpatialQuery, SpatialQueryFilter},
    worlds::InCollisionWorld,
};

/// Writes [`PointerHits`] for what the rays of pointers meet, in [`PickingSystems::Backend`]. Not
/// part of [`OctreePlugins`](crate::OctreePlugins): add it after them. Bevy's picking plugins make
/// the rays and read the hits.
///
/// See the [module's documentation](self) for an example.
#[doc(alias("mouse picking", "pointer", "click"))]
#[derive(Clone, Copy, Debug, Default)]
pub struct CollisionPickingPlugin;

impl Plugin for CollisionPickingPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<CollisionPickingSettings>()
            // Those of Bevy's plugins, which may come later, or not at all.
            .init_resource::<RayMap>()
            .add_message::<PointerHits>()
            .register_type::<CollisionPickingSettings>()
            .register_type::<CollisionPickable>()
            .add_systems(PreUpdate, pick.in_set(PickingSystems::Backend));
    }
}

/// The settings of picking: which entities can be picked at all. May be changed at any time.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub struct CollisionPickingSettings {
    /// Only entities with a [`CollisionPickable`], and only through cameras with one. By default,
    /// all.
    pub require_markers: bool,
}

/// Marks cameras to pick through, and entities to be picked, where
/// [`require_markers`](CollisionPickingSettings::require_markers) is set. Without that it has no
/// meaning.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Clone, Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub struct CollisionPickable;

/// What a camera says about what can be picked through it.
type Picking<'a> = (
    &'a Camera,
    Has<CollisionPickable>,
    Option<&'a CollisionLayers>,
    Option<&'a InCollisionWorld>,
);

fn pick(
    rays: Res<RayMap>,
    settings: Res<CollisionPickingSettings>,
    cameras: Query<Picking>,
    targets: Query<(Option<&Pickable>, Has<CollisionPickable>)>,
    spatial: SpatialQuery,
    mut found: Local<Vec<RayHit>>,
    mut output: MessageWriter<PointerHits>,
) {
    for (&id, &ray) in rays.iter() {
        let Ok((camera, marked, layers, world)) = cameras.get(id.camera) else {
            continue;
        };
        if !camera.is_active || (settings.require_markers && !marked) {
            continue;
        }
        let is_seen = |entity| {
            let Ok((pickable, marked)) = targets.get(entity) else {
                return false;
            };
            pickable.is_none_or(|pickable| pickable.should_block_lower || pickable.is_hoverable)
                && (marked || !settings.require_markers)
        };
        let blocks = |hit: &RayHit| {
            let pickable = targets
                .get(hit.entity)
                .ok()
                .and_then(|(pickable, _)| pickable);
            pickable.is_none_or(|pickable| pickable.should_block_lower)
        };
        let all = SpatialQueryFilter::DEFAULT;
        let all = world.map_or(all.in_any_world(), |world| all.in_world(world.0));
        let filter = layers
            .map_or(all, |layers| all.on(layers.filters))
            .only(&is_seen);
        let Some(first) = spatial.cast_ray(ray, f32::INFINITY, &filter) else {
            continue;
        };
        found.clear();
        if blocks(&first) {
            found.push(first);
        } else {
            // What is behind may be picked too, up to the first that blocks.
            spatial.ray_hits(ray, f32::INFINITY, &filter, &mut found);
            let end = found
                .iter()
                .position(blocks)
                .map_or(found.len(), |blocking| blocking + 1);
            found.truncate(end);
        }
        let picks = found.iter().map(|hit| {
            let (point, normal) = (Some(hit.point), Some(hit.normal));
            let data = HitData::new_with_extra(id.camera, hit.distance, point, normal, *hit);
            (hit.entity, data)
        });
        output.write(PointerHits::new(
            id.pointer,
            picks.collect(),
            camera.order as f32,
        ));
    }
}
