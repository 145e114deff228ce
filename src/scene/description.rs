//! The description of a scene.

use std::{borrow::Cow, collections::HashMap, time::Duration};

use bevy::prelude::*;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _};

use super::{
    error::{ObjectProblem, SceneProblem},
    test_set::TestSet,
};
use crate::{motion::PositionTrack, shape_data::ShapeDescription};

/// A whole scene. See the [module](super) for the file format.
#[derive(Clone, Debug, PartialEq, Reflect, Serialize, Deserialize)]
#[cfg_attr(feature = "asset", derive(bevy::asset::Asset))]
#[reflect(Debug, PartialEq)]
#[type_path = "bevy_octree"]
#[serde(deny_unknown_fields)]
pub struct SceneDescription {
    /// The name, for people.
    pub name: String,
    /// How many ticks of the clock make a second.
    #[serde(default = "default_ticks_per_second")]
    pub ticks_per_second: f64,
    /// What is in it.
    pub content: Content,
}

/// The content of a scene.
#[derive(Clone, Debug, PartialEq, Reflect, Serialize, Deserialize)]
#[reflect(Debug, PartialEq)]
#[type_path = "bevy_octree"]
pub enum Content {
    /// The two planes of cubes of a test set, named `left_0`, `left_1`, … and `right_0`, `right_1`,
    /// …, from the centre outward; opposite cubes have the same number.
    TestSet(TestSet),
    /// Objects one by one.
    Objects(Vec<ObjectDescription>),
}

/// One object of a scene.
#[derive(Clone, Debug, PartialEq, Reflect, Serialize, Deserialize)]
#[reflect(Debug, PartialEq)]
#[type_path = "bevy_octree"]
// Derives inherent functions, which the trait implementations below wrap: reading checks the object
// while the reader still knows the line.
#[serde(deny_unknown_fields, remote = "Self")]
pub struct ObjectDescription {
    /// The name, unique in the scene; `object_` and the index if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What it is made of.
    pub shape: ShapeDescription,
    /// Where its origin starts. Stays zero if `motion` is a track.
    #[serde(default)]
    pub position: Vec3,
    /// Its orientation: turns about its own x, then y, then z axis, in degrees.
    #[serde(default)]
    pub rotation: Vec3,
    /// Its scale along its own axes. No component is zero.
    #[serde(default = "default_scale")]
    pub scale: Vec3,
    /// How it moves.
    #[serde(default)]
    pub motion: Motion,
}

/// The motion of an object of a scene.
#[derive(Clone, Debug, Default, PartialEq, Reflect, Serialize, Deserialize)]
#[reflect(Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub enum Motion {
    /// Not at all.
    #[default]
    Static,
    /// Straight on, in units per second.
    Velocity(Vec3),
    /// Along a track.
    Track(PositionTrack),
}

fn default_ticks_per_second() -> f64 {
    SceneDescription::TICKS_PER_SECOND
}

fn default_scale() -> Vec3 {
    Vec3::ONE
}

impl SceneDescription {
    /// The default of [`ticks_per_second`](Self::ticks_per_second), which is also Bevy's default
    /// fixed timestep.
    pub const TICKS_PER_SECOND: f64 = 64.0;

    /// Returns a scene of objects.
    #[must_use]
    pub fn new(
        name: impl Into<String>,
        objects: impl IntoIterator<Item = ObjectDescription>,
    ) -> Self {
        Self {
            name: name.into(),
            ticks_per_second: Self::TICKS_PER_SECOND,
            content: Content::Objects(objects.into_iter().collect()),
        }
    }

    /// Checks what the types alone do not: numbers in range, unique names, at least one object.
    ///
    /// # Errors
    ///
    /// The first problem found, with the object that has it.
    pub fn validate(&self) -> Result<(), SceneProblem> {
        self.tick_length()?;
        let objects = match &self.content {
            Content::TestSet(set) => return Ok(set.check()?),
            Content::Objects(objects) => objects,
        };
        if objects.is_empty() {
            return Err(SceneProblem::NoObjects);
        }
        let mut indices = HashMap::with_capacity(objects.len());
        for (index, object) in objects.iter().enumerate() {
            let name = object.name_at(index);
            if let Err(problem) = object.check() {
                let name = name.into_owned();
                return Err(SceneProblem::Object {
                    index,
                    name,
                    problem,
                });
            }
            if let Some(first) = indices.insert(name.clone(), index) {
                return Err(SceneProblem::SameName {
                    first,
                    second: index,
                    name: name.into_owned(),
                });
            }
        }
        Ok(())
    }

    /// Returns how long a tick lasts.
    ///
    /// # Errors
    ///
    /// [`SceneProblem::TicksPerSecond`] if a tick would last less than a nanosecond, longer than a
    /// [`Duration`] can, or a negative time.
    pub fn tick_length(&self) -> Result<Duration, SceneProblem> {
        Duration::try_from_secs_f64(self.ticks_per_second.recip())
            .ok()
            .filter(|length| !length.is_zero())
            .ok_or(SceneProblem::TicksPerSecond(self.ticks_per_second))
    }

    /// Returns how many objects there are.
    #[must_use]
    pub fn object_count(&self) -> usize {
        match &self.content {
            Content::TestSet(set) => set.object_count(),
            Content::Objects(objects) => objects.len(),
        }
    }

    /// Returns the objects in order, those of a test set written out one by one.
    pub fn objects(&self) -> Box<dyn Iterator<Item = Cow<'_, ObjectDescription>> + '_> {
        match &self.content {
            Content::TestSet(set) => Box::new(self.test_objects(set).map(Cow::Owned)),
            Content::Objects(objects) => Box::new(objects.iter().map(Cow::Borrowed)),
        }
    }

    fn test_objects(&self, set: &TestSet) -> impl Iterator<Item = ObjectDescription> + use<> {
        let half_size = Vec3::splat(0.5 * set.side);
        let ticks_per_second = self.ticks_per_second as f32;
        set.cubes().map(move |cube| ObjectDescription {
            name: Some(format!("{}_{}", cube.plane.name(), cube.index)),
            position: cube.position,
            motion: Motion::Velocity(cube.velocity * ticks_per_second),
            ..ObjectDescription::new(ShapeDescription::Cuboid { half_size })
        })
    }
}

pub(super) fn register(app: &mut App) {
    app.register_type::<SceneDescription>();
}

impl From<TestSet> for SceneDescription {
    /// The scene of a test set, under the report's name for it.
    fn from(set: TestSet) -> Self {
        Self {
            name: set.name(),
            ticks_per_second: Self::TICKS_PER_SECOND,
            content: Content::TestSet(set),
        }
    }
}

impl ObjectDescription {
    /// Returns an unnamed object at rest at the origin.
    #[must_use]
    pub fn new(shape: ShapeDescription) -> Self {
        Self {
            name: None,
            shape,
            position: Vec3::ZERO,
            rotation: Vec3::ZERO,
            scale: Vec3::ONE,
            motion: Motion::Static,
        }
    }

    /// Returns its name, given that it is the scene's object number `index`, from 0.
    #[must_use]
    pub fn name_at(&self, index: usize) -> Cow<'_, str> {
        match &self.name {
            Some(name) => Cow::Borrowed(name),
            None => Cow::Owned(format!("object_{index}")),
        }
    }

    /// Returns its place at tick 0.
    #[must_use]
    pub fn transform(&self) -> Transform {
        let [x, y, z] = self.rotation.to_array().map(f32::to_radians);
        Transform {
            translation: match &self.motion {
                Motion::Track(track) => track.position(0),
                _ => self.position,
            },
            rotation: Quat::from_euler(EulerRot::XYZ, x, y, z),
            scale: self.scale,
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    ///
    /// The first problem found.
    pub fn check(&self) -> Result<(), ObjectProblem> {
        self.shape.build()?;
        let velocity = match self.motion {
            Motion::Velocity(velocity) => velocity,
            Motion::Static | Motion::Track(_) => Vec3::ZERO,
        };
        for (field, value) in [
            ("position", self.position),
            ("rotation", self.rotation),
            ("scale", self.scale),
            ("velocity", velocity),
        ] {
            if !value.is_finite() {
                return Err(ObjectProblem::NotFinite { field, value });
            }
        }
        if self.scale.cmpeq(Vec3::ZERO).any() {
            return Err(ObjectProblem::FlatScale(self.scale));
        }
        if matches!(self.motion, Motion::Track(_)) && self.position != Vec3::ZERO {
            return Err(ObjectProblem::PositionBesideTrack(self.position));
        }
        Ok(())
    }
}

impl Serialize for ObjectDescription {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

impl<'de> Deserialize<'de> for ObjectDescription {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let object = Self::deserialize(deserializer)?;
        object.check().map_err(|problem| match &object.name {
            Some(name) => D::Error::custom(format_args!("object \"{name}\": {problem}")),
            None => D::Error::custom(problem),
        })?;
        Ok(object)
    }
}
