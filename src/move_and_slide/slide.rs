//! Along what is in the way.

use bevy::prelude::*;
use smallvec::SmallVec;

use super::{
    hit::{AtHit, MoveEnd, MoveHit, Moved},
    planes::{self, Plane, Planes},
    push_out::push_out,
    surroundings::{Met, ROUNDING, Surroundings, Touch},
};

/// Of less than this share of the skin, nobody knows that it was a way.
const NOWHERE: f32 = 1e-3;
/// Of a way that is longer, this much counts: its square is a number.
const LONGEST: f64 = 1e18;
/// How far a shape goes before what it met earlier may be left behind, in skins.
const ELSEWHERE: f32 = 4.0;

/// What a shape came to, in the course of one move.
pub type Surfaces = SmallVec<[Surface; planes::MOST_PLANES]>;

/// A surface that a shape slides along.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// From the surface to the shape.
    pub normal: Vec3,
    /// May one stand on it?
    pub is_floor: bool,
}

/// How a shape answers to what it meets.
pub trait Answer {
    /// Is told of each, in their order.
    fn at(&mut self, hit: &MoveHit) -> AtHit;

    /// What becomes of its velocity on surfaces, of which it has met the last right now.
    fn velocity(&mut self, velocity: Vec3, surfaces: &[Surface]) -> Vec3 {
        along_all(velocity, surfaces)
    }

    /// May it stand on what it met, when it came by this velocity?
    fn is_floor(&mut self, _around: &Surroundings, _velocity: Vec3, _met: &Met) -> bool {
        false
    }

    /// May it be elsewhere, without having slid there, as on top of the step that it met? And how much of the way that
    /// was left has brought it there, 0 to 1?
    fn detour(
        &mut self,
        _around: &Surroundings,
        _pose: &Transform,
        _way: Vec3,
        _met: &Met,
    ) -> Option<(Transform, f32)> {
        None
    }
}

/// The answer of what just slides.
pub struct Plain<F>(pub F);

impl<F: FnMut(&MoveHit) -> AtHit> Answer for Plain<F> {
    fn at(&mut self, hit: &MoveHit) -> AtHit {
        (self.0)(hit)
    }
}

/// What is left of a velocity that goes against none of some surfaces.
pub fn along_all(velocity: Vec3, surfaces: &[Surface]) -> Vec3 {
    let normals: SmallVec<[Vec3; planes::MOST_PLANES]> =
        surfaces.iter().map(|surface| surface.normal).collect();
    project_velocity(velocity, &normals)
}

/// A move.
#[derive(Clone, Copy, Debug)]
pub struct Slide {
    pub start: Transform,
    pub velocity: Vec3,
    pub time: f32,
    /// So often it may change its way.
    pub most_slides: u32,
}

impl Slide {
    /// Does it, from surfaces that are known already.
    pub fn along(
        self,
        around: &mut Surroundings,
        known: Option<Surface>,
        answer: &mut impl Answer,
    ) -> Moved {
        let (mut pose, mut velocity) = (self.start, self.velocity);
        let mut left = self.time;
        let mut surfaces: Surfaces = known.into_iter().collect();
        let (mut is_looked_after, mut is_free) = (false, true);
        let mut end = MoveEnd::Done;
        // What is ignored does not count.
        let mut slides = 0;
        while slides <= self.most_slides {
            let way = bounded(velocity, left);
            let far = pose.translation.abs().max_element();
            let is_going = way.length() > NOWHERE * around.skin + ROUNDING * far;
            let met = is_going.then(|| around.cast(&pose, way)).flatten();
            if !is_looked_after && (!is_going || around.is_touched()) {
                is_looked_after = true;
                let mut is_stopped = false;
                let time = self.time - left;
                let out = push_out(around, &pose, |touch| {
                    let decided = answer.at(&start_hit(touch, time, velocity));
                    is_stopped |= decided == AtHit::Stop;
                    decided != AtHit::Ignore
                });
                (pose, is_free) = (out.pose, out.is_free);
                if is_stopped {
                    end = MoveEnd::Stopped;
                    break;
                }
                if is_going {
                    continue;
                }
            }
            if !is_going {
                break;
            }
            let Some(met) = met else {
                pose.translation += way;
                break;
            };
            let there = Transform {
                translation: pose.translation + way * met.share,
                ..pose
            };
            let time = self.time - left * (1.0 - met.share);
            match answer.at(&met.hit(time, velocity)) {
                AtHit::Ignore => {
                    around.ignore(met.entity);
                    continue;
                }
                AtHit::Stop => {
                    pose = there;
                    end = MoveEnd::Stopped;
                    break;
                }
                AtHit::Slide => slides += 1,
            }
            if (way * met.share).length() > ELSEWHERE * around.skin {
                surfaces.retain(|surface| is_near(around, &there, surface));
            }
            pose = there;
            left *= 1.0 - met.share;
            if met.share == 0.0 && met.gap < 0.5 * around.skin && !met.is_at_start {
                let off = met.normal * (around.skin - met.gap);
                pose.translation += around.free(&pose, off);
            }
            if let Some((over, share)) = answer.detour(around, &pose, bounded(velocity, left), &met)
            {
                pose = over;
                left *= 1.0 - share;
                continue;
            }
            let surface = Surface {
                normal: met.normal,
                is_floor: answer.is_floor(around, velocity, &met),
            };
            if surfaces.len() == surfaces.inline_size() {
                surfaces.remove(0);
            }
            surfaces.push(surface);
            velocity = answer.velocity(velocity, &surfaces);
        }
        if !is_free && end == MoveEnd::Done && is_in_something(around, &pose) {
            (velocity, end) = (Vec3::ZERO, MoveEnd::Stuck);
        }
        Moved {
            pose,
            velocity,
            end,
        }
    }
}

/// The way that a velocity leads in a time, as far as lengths can be told.
fn bounded(velocity: Vec3, time: f32) -> Vec3 {
    let way = (velocity.as_dvec3() * f64::from(time)).clamp_length_max(LONGEST);
    way.as_vec3()
}

fn start_hit(touch: &Touch, time: f32, velocity: Vec3) -> MoveHit {
    MoveHit {
        entity: touch.entity,
        point: touch.point,
        normal: touch.normal,
        time,
        depth: touch.depth,
        velocity,
    }
}

/// Is a surface still there, by which a shape has come this far?
fn is_near(around: &Surroundings, pose: &Transform, surface: &Surface) -> bool {
    let back = surface.normal * -ELSEWHERE * around.skin;
    around.cast(pose, back).is_some()
}

fn is_in_something(around: &Surroundings, pose: &Transform) -> bool {
    let mut is_in = false;
    around.for_each_touch(pose, |touch| is_in |= touch.depth > NOWHERE * around.skin);
    is_in
}

/// Returns what is left of a velocity that goes against no surface: the nearest of all those that lead away from each of
/// them, or along it.
///
/// `normals` are unit vectors, from the surfaces to what moves; those that are not finite do not count. On one surface, it is
/// what the velocity has along it; on two, along their crease, if it goes against both; in a corner of three, nothing. So
/// it never turns back, and grows no faster. Of more than ten, those that are most alike count as one. A velocity that
/// is not finite is zero.
///
/// ```
/// use bevy::math::Vec3;
/// use bevy_octree::move_and_slide::project_velocity;
///
/// let (floor, wall) = (Vec3::Y, Vec3::NEG_X);
/// assert_eq!(project_velocity(Vec3::new(2.0, -3.0, 1.0), &[floor]), Vec3::new(2.0, 0.0, 1.0));
/// assert_eq!(project_velocity(Vec3::new(2.0, -3.0, 1.0), &[floor, wall]), Vec3::Z);
/// assert_eq!(project_velocity(Vec3::Y, &[floor, wall]), Vec3::Y); // away
/// ```
#[must_use]
#[doc(alias("slide", "clip velocity", "clip vector"))]
pub fn project_velocity(velocity: Vec3, normals: &[Vec3]) -> Vec3 {
    if !velocity.is_finite() {
        return Vec3::ZERO;
    }
    let before = velocity.as_dvec3();
    let mut planes = Planes::new();
    for normal in normals.iter().filter(|normal| normal.is_finite()) {
        let normal = normal.as_dvec3();
        let offset = -normal.dot(before);
        planes::add(&mut planes, Plane { normal, offset });
    }
    // There always is one: to stand still.
    planes::shortest(&planes).map_or(Vec3::ZERO, |change| (before + change).as_vec3())
}
