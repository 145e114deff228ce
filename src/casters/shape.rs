//! Shapes on their way.

use bevy::{math::DAffine3, prelude::*};

use super::{
    cast::{Caster, direction},
    filter::CasterFilter,
    hits::ShapeHits,
};
use crate::{
    components::CollisionShape,
    narrow_phase::{Placed, ShapeCastOptions},
    shear,
    spatial_query::{ShapeHit, SpatialQuery, SpatialQueryFilter},
};

/// Casts a shape in each tick, and lists what it touches on its way in the entity's [`ShapeHits`].
/// The shape does not turn on its way.
///
/// The default is that of a [`CollisionShape`], a cube of side 1, which goes from the entity's
/// origin forwards, along its negative z axis, to the first that it touches, however far away. See
/// the [module](super) for where shapes start, and when.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// # let mut app = App::new();
/// # app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)));
/// # let mut commands = app.world_mut().commands();
/// // How far may it go? It stands on a floor, which is not in its way.
/// commands.spawn((CollisionShape::cuboid(20.0, 1.0, 20.0), Transform::from_xyz(0.0, -1.0, 0.0)));
/// commands.spawn((CollisionShape::cuboid(9.0, 9.0, 1.0), Transform::from_xyz(0.0, 0.0, -4.0)));
/// let ahead = ShapeCaster::new(Sphere::new(0.5), Vec3::ZERO, Dir3::NEG_Z)
///     .with_length(10.0)
///     .with_options(ShapeCastOptions::DEFAULT.ignore_start());
/// let walker = commands.spawn((CollisionShape::sphere(0.5), ahead)).id();
/// app.update();
/// let wall = app.world().get::<ShapeHits>(walker).unwrap().nearest().unwrap();
/// assert!((wall.distance - 3.0).abs() < 1e-3);
/// ```
#[doc(alias("shapecast", "shape cast", "sweep", "ShapeCast3D", "sphere cast"))]
#[derive(Component, Clone, Debug, Reflect)]
#[reflect(Component, Clone, Debug, Default)]
#[type_path = "bevy_octree"]
#[require(Transform, ShapeHits)]
pub struct ShapeCaster {
    /// Whether the shape is cast at all. One that is not touches nothing.
    pub enabled: bool,
    /// The shape, which is scaled as that of the entity would be.
    pub shape: CollisionShape,
    /// Where the shape starts, in the entity's own space.
    pub origin: Vec3,
    /// How it is turned, in the entity's own space. It need not be of unit length; what is no turn at
    /// all casts nothing.
    pub rotation: Quat,
    /// Where it goes to, in the entity's own space.
    pub direction: Dir3,
    /// How far it goes, in units of the world: [`f32::MAX`] by default.
    #[doc(alias = "max_distance")]
    pub length: f32,
    /// How many entities it touches at most, the nearest: 1 by default, which is the quickest. What
    /// is behind is touched as though nothing were in front.
    pub max_hits: u32,
    /// Whether what it starts in touch with counts, and what is told of polygons.
    pub options: ShapeCastOptions,
    /// Which entities it sees.
    #[entities]
    pub filter: CasterFilter,
}

impl Default for ShapeCaster {
    fn default() -> Self {
        Self {
            enabled: true,
            shape: CollisionShape::default(),
            origin: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            direction: Dir3::NEG_Z,
            length: f32::MAX,
            max_hits: 1,
            options: ShapeCastOptions::DEFAULT,
            filter: CasterFilter::default(),
        }
    }
}

impl ShapeCaster {
    /// Makes one that casts a shape from a point along a direction, both in the entity's own space.
    #[must_use]
    pub fn new(shape: impl Into<CollisionShape>, origin: Vec3, direction: Dir3) -> Self {
        Self {
            shape: shape.into(),
            origin,
            direction,
            ..default()
        }
    }

    /// Returns the same with a shape that is turned this way, in the entity's own space.
    #[must_use]
    pub fn with_rotation(self, rotation: Quat) -> Self {
        Self { rotation, ..self }
    }

    /// Returns the same with a shape that goes this far.
    #[must_use]
    pub fn with_length(self, length: f32) -> Self {
        Self { length, ..self }
    }

    /// Returns the same with a shape that touches so many entities at most, the nearest; all of them
    /// by [`u32::MAX`].
    #[must_use]
    pub fn with_max_hits(self, max_hits: u32) -> Self {
        Self { max_hits, ..self }
    }

    /// Returns the same with these options.
    #[must_use]
    pub fn with_options(self, options: ShapeCastOptions) -> Self {
        Self { options, ..self }
    }

    /// Returns the same with this filter.
    #[must_use]
    pub fn with_filter(self, filter: CasterFilter) -> Self {
        Self { filter, ..self }
    }

    /// Returns where the shape starts and where it goes to in the world, given where the entity is:
    /// for drawing it, and the like. `None` if that is nowhere. What shears the entity is left out.
    #[must_use]
    pub fn global_start(&self, at: &GlobalTransform) -> Option<(Transform, Dir3)> {
        self.start(&at.affine().as_daffine3())
    }

    /// The same, given what the hierarchy does to the entity.
    pub(crate) fn start(&self, pose: &DAffine3) -> Option<(Transform, Dir3)> {
        let Self {
            origin, rotation, ..
        } = self;
        // In 64 bits, lest its length be beyond the numbers.
        let rotation = rotation.as_dquat();
        if !(rotation.length_recip().is_finite() && rotation.length() > 0.0) {
            return None;
        }
        let own = DAffine3::from_rotation_translation(rotation.normalize(), origin.as_dvec3());
        let there = *pose * own;
        let put = shear::put(&self.shape, &there, None);
        let start = if put.is_sheared {
            let (scale, rotation, translation) = there.to_scale_rotation_translation();
            Transform {
                translation: translation.as_vec3(),
                rotation: rotation.as_quat(),
                scale: scale.as_vec3(),
            }
        } else {
            // What is flat is somewhere, too.
            put.transform
        };
        start
            .is_finite()
            .then_some((start, direction(self.direction, pose)?))
    }
}

impl Caster for ShapeCaster {
    type Hits = ShapeHits;

    fn filter(&self) -> Option<&CasterFilter> {
        (self.enabled && self.max_hits > 0).then_some(&self.filter)
    }

    fn find(
        &self,
        pose: &DAffine3,
        spatial: &SpatialQuery,
        filter: &SpatialQueryFilter,
        hits: &mut Vec<ShapeHit>,
    ) {
        let Some((start, direction)) = self.start(pose) else {
            return;
        };
        let (moving, options) = (Placed::new(&self.shape, &start), &self.options);
        if self.max_hits == 1 {
            hits.extend(spatial.cast_shape_with(moving, direction, self.length, filter, options));
        } else {
            spatial.shape_hits(moving, direction, self.length, filter, options, hits);
            hits.truncate(self.max_hits as usize);
        }
    }
}

pub(super) fn register(app: &mut App) {
    app.register_type::<ShapeCaster>();
}
