//! From descriptions to entities.

use bevy::prelude::*;

use super::{
    description::{Motion, ObjectDescription, SceneDescription},
    error::{SceneError, SceneProblem},
};
use crate::{components::CollisionShape, motion::Velocity, response::Bounce};

/// What every object has.
type Common = (Name, Transform, CollisionShape);

impl SceneDescription {
    /// Spawns an entity for each object, and returns them in the order of the objects.
    ///
    /// Each gets a [`Name`], a [`Transform`], a [`CollisionShape`], and what makes it move: a
    /// [`Velocity`] and a [`Bounce`], a [`PositionTrack`](crate::motion::PositionTrack), or
    /// neither.
    ///
    /// # Errors
    ///
    /// [`SceneError::Invalid`] if the scene is invalid or one of its shapes cannot be built.
    /// Nothing is spawned then.
    pub fn spawn(&self, commands: &mut Commands) -> Result<Vec<Entity>, SceneError> {
        let objects = self.build().map_err(|problem| SceneError::Invalid {
            origin: format!("scene \"{}\"", self.name),
            problem,
        })?;
        let entities = objects.into_iter().map(|(body, motion)| match motion {
            Motion::Static => commands.spawn(body).id(),
            Motion::Velocity(velocity) => commands
                .spawn((body, Velocity(velocity), Bounce::default()))
                .id(),
            Motion::Track(track) => commands.spawn((body, track)).id(),
        });
        Ok(entities.collect())
    }

    fn build(&self) -> Result<Vec<(Common, Motion)>, SceneProblem> {
        self.validate()?;
        let objects = self.objects().enumerate();
        objects
            .map(|(index, object)| object.into_owned().build(index))
            .collect()
    }
}

impl ObjectDescription {
    fn build(self, index: usize) -> Result<(Common, Motion), SceneProblem> {
        let name = self.name_at(index).into_owned();
        match self.shape.build() {
            Ok(shape) => {
                let body = (Name::new(name), self.transform(), shape.into());
                Ok((body, self.motion))
            }
            Err(problem) => Err(SceneProblem::Object {
                index,
                name,
                problem: problem.into(),
            }),
        }
    }
}

#[cfg(test)]
mod tests;
