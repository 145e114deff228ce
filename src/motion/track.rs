//! Position tracks: an object's position at each tick, from keyframes.

use bevy::{
    math::{
        DVec3,
        curve::{Curve, EaseFunction, EasingCurve},
    },
    prelude::*,
};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::clock::CollisionClock;

/// Gives an entity's position at each tick of the clock, as the tracks of a keyframe animation do
/// (Swan, *Fast Collision Detection with an N-Objects Octree*, 1994, section 1.3).
///
/// The track has keyframes at some ticks; the positions between them are interpolated, and those
/// before the first and after the last follow from [`Outside`]. At a keyframe the position is
/// exactly the keyframe's. All positions are finite: what would be beyond the largest numbers,
/// where a curve swings out of its keyframes, stays at these.
///
/// The default is a single keyframe, at the origin.
///
/// ```
/// use bevy::math::Vec3;
/// use bevy_octree::motion::PositionTrack;
///
/// let track = PositionTrack::new([(0, Vec3::ZERO), (10, Vec3::X), (20, Vec3::ONE)])?;
/// assert_eq!(track.position(5), Vec3::X * 0.5);
/// assert_eq!(track.position(10), Vec3::X);
/// assert_eq!(track.position(99), Vec3::ONE);
/// # Ok::<(), bevy_octree::motion::TrackError>(())
/// ```
///
/// Ticks are those of the [`CollisionClock`], unless the track [starts](TrackStart) at another one:
/// what is spawned later in the game begins then.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::{motion::Outside, prelude::*};
///
/// /// A lift that goes up and down, from now on.
/// fn call_a_lift(mut commands: Commands) {
///     let way = [(0, Vec3::ZERO), (120, Vec3::Y * 6.0), (240, Vec3::ZERO)];
///     let way = PositionTrack::new(way).unwrap().with_outside(Outside::Loop).starting_now();
///     commands.spawn((CollisionShape::cuboid(2.0, 0.2, 2.0), way));
/// }
/// # bevy::ecs::system::assert_is_system(call_a_lift);
/// ```
#[derive(Component, Clone, Debug, PartialEq, Reflect, Serialize, Deserialize)]
#[reflect(Component, Debug, Default, PartialEq, Serialize, Deserialize)]
#[type_path = "bevy_octree"]
#[serde(try_from = "UncheckedTrack", into = "UncheckedTrack")]
#[require(Transform)]
pub struct PositionTrack {
    /// Not empty, ticks strictly increasing, positions finite.
    keyframes: Vec<(u64, Vec3)>,
    interpolation: Interpolation,
    outside: Outside,
    start: TrackStart,
}

/// The way in which a [`PositionTrack`] gets from one keyframe to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect, Serialize, Deserialize)]
#[reflect(Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub enum Interpolation {
    /// It stays at a keyframe's position until the tick of the next one.
    Step,
    /// Straight, at constant speed.
    #[default]
    Linear,
    /// Along a Catmull–Rom spline: without sudden turns, at a keyframe in the direction from the
    /// keyframe before to the one after.
    Smooth,
    /// Straight, at a speed that follows an easing function.
    Ease(EaseFunction),
}

/// The rule for where a [`PositionTrack`] is before its first and after its last keyframe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect, Serialize, Deserialize)]
#[reflect(Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
pub enum Outside {
    /// At the nearest keyframe.
    #[default]
    Hold,
    /// It repeats. The last keyframe stands for the same moment as the first, and its position is
    /// reached only if it is the same.
    Loop,
}

/// The tick of the [`CollisionClock`] at which a [`PositionTrack`] starts: its own tick 0. Before
/// that, it is where it is at its tick 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect, Serialize, Deserialize)]
#[reflect(Debug, Default, PartialEq)]
#[type_path = "bevy_octree"]
#[doc(alias("delay", "offset", "phase"))]
pub enum TrackStart {
    /// This one; by default the first of all, so that the track's ticks are those of the clock.
    At(u64),
    /// The first tick in which the entity is moved along it: of one that is spawned, the next. By
    /// then it says [`At`](Self::At).
    Now,
}

impl Default for TrackStart {
    fn default() -> Self {
        Self::At(0)
    }
}

/// What is wrong with the keyframes of a [`PositionTrack`].
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum TrackError {
    /// There are none.
    #[error("the track has no keyframes, expected at least one")]
    Empty,
    /// A keyframe is not later than the one before.
    #[error("keyframe {index} is at tick {tick}, expected a tick after {previous}")]
    Unsorted {
        /// The index of the keyframe, from 0.
        index: usize,
        /// Its tick.
        tick: u64,
        /// The tick of the keyframe before.
        previous: u64,
    },
    /// A position is NaN or infinite.
    #[error("keyframe {index} is at {position}, expected finite numbers")]
    NotFinite {
        /// The index of the keyframe, from 0.
        index: usize,
        /// Its position.
        position: Vec3,
    },
}

/// What a file holds of a [`PositionTrack`].
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "PositionTrack")]
struct UncheckedTrack {
    keyframes: Vec<(u64, Vec3)>,
    #[serde(default)]
    interpolation: Interpolation,
    #[serde(default)]
    outside: Outside,
    #[serde(default)]
    start: TrackStart,
}

impl PositionTrack {
    /// Returns a track through `keyframes`, each a tick and a position, that interpolates linearly
    /// and holds outside them.
    ///
    /// # Errors
    ///
    /// No keyframes, ticks that do not strictly increase, positions that are not finite.
    pub fn new(keyframes: impl IntoIterator<Item = (u64, Vec3)>) -> Result<Self, TrackError> {
        let keyframes: Vec<_> = keyframes.into_iter().collect();
        if keyframes.is_empty() {
            return Err(TrackError::Empty);
        }
        if let Some(index) = keyframes
            .iter()
            .position(|(_, position)| !position.is_finite())
        {
            let position = keyframes[index].1;
            return Err(TrackError::NotFinite { index, position });
        }
        if let Some(before) = keyframes.windows(2).position(|pair| pair[0].0 >= pair[1].0) {
            return Err(TrackError::Unsorted {
                index: before + 1,
                tick: keyframes[before + 1].0,
                previous: keyframes[before].0,
            });
        }
        Ok(Self {
            keyframes,
            interpolation: Interpolation::default(),
            outside: Outside::default(),
            start: TrackStart::default(),
        })
    }

    /// Returns the same track with another interpolation.
    #[must_use]
    pub fn with_interpolation(self, interpolation: Interpolation) -> Self {
        Self {
            interpolation,
            ..self
        }
    }

    /// Returns the same track with another rule for the ticks outside the keyframes.
    #[must_use]
    pub fn with_outside(self, outside: Outside) -> Self {
        Self { outside, ..self }
    }

    /// Returns the same track with another start.
    #[must_use]
    pub fn with_start(self, start: TrackStart) -> Self {
        Self { start, ..self }
    }

    /// Returns the same track, with a tick of the [`CollisionClock`] as its own tick 0. Until then
    /// it is where it is at its tick 0; from then on all is as ever, loops included.
    ///
    /// ```
    /// use bevy::math::Vec3;
    /// use bevy_octree::motion::PositionTrack;
    ///
    /// let track = PositionTrack::new([(0, Vec3::ZERO), (10, Vec3::X)])?.starting_at(100);
    /// assert_eq!(track.position(99), Vec3::ZERO);
    /// assert_eq!(track.position(105), Vec3::X * 0.5);
    /// # Ok::<(), bevy_octree::motion::TrackError>(())
    /// ```
    #[must_use]
    #[doc(alias("delay", "offset"))]
    pub fn starting_at(self, tick: u64) -> Self {
        self.with_start(TrackStart::At(tick))
    }

    /// Returns the same track, with the first tick in which an entity is moved along it as its own
    /// tick 0: for what is spawned later in the game. See [`TrackStart::Now`].
    ///
    /// Each entity for itself: of two that are spawned one after the other, the second follows the
    /// first. A component that is inserted anew starts anew.
    #[must_use]
    pub fn starting_now(self) -> Self {
        self.with_start(TrackStart::Now)
    }

    /// Returns when the track starts: of one that [starts now](TrackStart::Now), from the first tick
    /// on, when it did.
    #[must_use]
    pub const fn start(&self) -> TrackStart {
        self.start
    }

    /// Returns the keyframes: ticks, strictly increasing, and positions. The ticks are those of the
    /// track, counted from its [start](Self::start).
    #[must_use]
    pub fn keyframes(&self) -> &[(u64, Vec3)] {
        &self.keyframes
    }

    /// Returns the position at a tick of the clock, by binary search among the keyframes. One that
    /// [starts now](TrackStart::Now), and has not started, is where it starts.
    #[must_use]
    pub fn position(&self, tick: u64) -> Vec3 {
        let tick = match self.start {
            TrackStart::At(start) => tick.saturating_sub(start),
            TrackStart::Now => 0,
        };
        let tick = match self.outside {
            Outside::Hold => tick,
            Outside::Loop => self.wrap(tick),
        };
        let next = self.keyframes.partition_point(|&(at, _)| at <= tick);
        let previous = next.checked_sub(1);
        match (
            previous.and_then(|index| self.keyframes.get(index)),
            self.keyframes.get(next),
        ) {
            (Some(&(at, position)), Some(_)) if at == tick => position,
            (Some(&(start, _)), Some(&(end, _))) => {
                let t = (tick - start) as f32 / (end - start) as f32;
                self.interpolate(next - 1, t)
            }
            (Some(&(_, position)), None) | (None, Some(&(_, position))) => position,
            // Out of reach for a checked track; reflection can empty one.
            (None, None) => Vec3::ZERO,
        }
    }

    /// The tick between the first keyframe and, exclusively, the last one, that stands for `tick`
    /// in a loop.
    fn wrap(&self, tick: u64) -> u64 {
        let (Some(&(first, _)), Some(&(last, _))) = (self.keyframes.first(), self.keyframes.last())
        else {
            return tick;
        };
        let period = last.saturating_sub(first);
        if period == 0 {
            first
        } else if tick >= first {
            first + (tick - first) % period
        } else {
            last - 1 - (first - tick - 1) % period
        }
    }

    /// The position at `t`, between 0 and 1, of the way from a keyframe to the next.
    fn interpolate(&self, index: usize, t: f32) -> Vec3 {
        let ((start, from), (end, to)) = (self.keyframes[index], self.keyframes[index + 1]);
        let position = match self.interpolation {
            Interpolation::Step => from,
            Interpolation::Linear => from.lerp(to, t),
            Interpolation::Ease(ease) => EasingCurve::new(from, to, ease).sample_unchecked(t),
            Interpolation::Smooth => {
                let (t, third) = (f64::from(t), (end - start) as f64 / 3.0);
                let (from, to) = (from.as_dvec3(), to.as_dvec3());
                let controls = [
                    from,
                    from + self.tangent(index) * third,
                    to - self.tangent(index + 1) * third,
                    to,
                ];
                // A Bézier curve, by halves of halves.
                let [a, b, c] = [0, 1, 2].map(|index| controls[index].lerp(controls[index + 1], t));
                a.lerp(b, t).lerp(b.lerp(c, t), t).as_vec3()
            }
        };
        position.clamp(Vec3::MIN, Vec3::MAX)
    }

    /// The velocity at a keyframe, in units per tick, when moving smoothly: that of the straight
    /// line from the keyframe before to the one after, across the seam of a closed loop, and
    /// one-sided at the ends of an open track. In double precision, in which no difference of
    /// positions overflows.
    fn tangent(&self, index: usize) -> DVec3 {
        let keyframes = &self.keyframes;
        let last = keyframes.len() - 1;
        let closed = self.outside == Outside::Loop && keyframes[0].1 == keyframes[last].1;
        if closed && (index == 0 || index == last) {
            let ((start, _), (second, after)) = (keyframes[0], keyframes[1]);
            let ((second_last, before), (end, _)) = (keyframes[last - 1], keyframes[last]);
            let ticks = (second - start) as f64 + (end - second_last) as f64;
            return (after.as_dvec3() - before.as_dvec3()) / ticks;
        }
        let (start, before) = keyframes[index.saturating_sub(1)];
        let (end, after) = keyframes[(index + 1).min(last)];
        (after.as_dvec3() - before.as_dvec3()) / (end - start) as f64
    }
}

impl Default for PositionTrack {
    fn default() -> Self {
        Self {
            keyframes: vec![(0, Vec3::ZERO)],
            interpolation: Interpolation::default(),
            outside: Outside::default(),
            start: TrackStart::default(),
        }
    }
}

impl TryFrom<UncheckedTrack> for PositionTrack {
    type Error = TrackError;

    fn try_from(track: UncheckedTrack) -> Result<Self, TrackError> {
        Ok(Self::new(track.keyframes)?
            .with_interpolation(track.interpolation)
            .with_outside(track.outside)
            .with_start(track.start))
    }
}

impl From<PositionTrack> for UncheckedTrack {
    fn from(track: PositionTrack) -> Self {
        Self {
            keyframes: track.keyframes,
            interpolation: track.interpolation,
            outside: track.outside,
            start: track.start,
        }
    }
}

/// Entities on a track go where the track says, whatever their velocity.
pub(super) fn follow_tracks(
    mut followers: Query<(&mut PositionTrack, &mut Transform)>,
    clock: Res<CollisionClock>,
) {
    for (mut track, mut transform) in &mut followers {
        if track.start == TrackStart::Now {
            track.start = TrackStart::At(clock.tick());
        }
        let position = track.position(clock.tick());
        // What does not move must not count as changed.
        if transform.translation != position {
            transform.translation = position;
        }
    }
}

pub(super) fn register(app: &mut App) {
    app.register_type::<PositionTrack>();
}

#[cfg(test)]
mod tests;
