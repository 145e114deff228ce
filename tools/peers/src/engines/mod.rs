//! The engines of the broad phase, behind one small trait.
//!
//! Each engine gets what a game has at hand each frame: the box of every object, in object order,
//! unchanged ones too; an engine that gains by skipping those does so itself. What it owes is every
//! pair of overlapping boxes, touching included. The time for both is taken, copies and filters
//! included.

mod flat;
mod grid;
pub mod obvhs;
mod ours;
pub mod parry;
mod rapier;
pub mod rstar;
mod sweep;

use bevy::math::bounding::Aabb3d;

/// The numbers of two objects, in either order.
pub type Pair = (u32, u32);

/// One way to find the overlapping pairs, frame after frame.
pub trait Engine {
    /// Takes over the box of every object: as many as in the first frame, in the same order.
    /// Whatever has to be maintained is maintained here.
    fn update(&mut self, boxes: &[Aabb3d]);

    /// Appends every pair of overlapping boxes to an empty list, each once.
    fn pairs(&mut self, pairs: &mut Vec<Pair>);
}

/// What an engine is to the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A way of this crate to search.
    Ours,
    /// Competition.
    Peer,
    /// No engine: what it takes to look at the boxes at all.
    Floor,
}

/// An engine to choose from.
#[derive(Clone, Copy)]
pub struct Entry {
    /// The name in tables and on the command line.
    pub name: &'static str,
    /// What it is to the comparison.
    pub role: Role,
    /// The largest number of objects that it is run at.
    pub most_objects: usize,
    /// Makes an empty one.
    pub make: fn() -> Box<dyn Engine>,
}

/// All engines, in the order of the tables.
pub fn all() -> Vec<Entry> {
    let entry = |name, role, make| Entry {
        name,
        role,
        most_objects: usize::MAX,
        make,
    };
    let up_to = |most_objects, entry: Entry| Entry {
        most_objects,
        ..entry
    };
    vec![
        entry("auto", Role::Ours, || Box::new(ours::Ours::new("auto"))),
        entry("linear", Role::Ours, || Box::new(ours::Ours::new("linear"))),
        entry("object", Role::Ours, || Box::new(ours::Ours::new("object"))),
        up_to(
            flat::MOST,
            entry("exhaustive", Role::Ours, || {
                Box::new(ours::Ours::new("exhaustive"))
            }),
        ),
        entry("parry", Role::Peer, || {
            Box::new(parry::Incremental::new(parry::NO_SKIN))
        }),
        entry("parry-skin", Role::Peer, || {
            Box::new(parry::Incremental::new(parry::SKIN))
        }),
        entry("parry-rebuild", Role::Peer, || {
            Box::<parry::Rebuilt>::default()
        }),
        entry("rapier", Role::Peer, || Box::<rapier::Rapier>::default()),
        entry("obvhs", Role::Peer, || Box::<obvhs::Obvhs>::default()),
        entry("rstar", Role::Peer, || Box::<rstar::Rstar>::default()),
        entry("sweep", Role::Peer, || Box::<sweep::Sweep>::default()),
        entry("grid", Role::Peer, || Box::<grid::Grid>::default()),
        up_to(
            flat::MOST,
            entry("brute", Role::Peer, || Box::<flat::Brute>::default()),
        ),
        entry("floor", Role::Floor, || Box::<flat::Floor>::default()),
    ]
}

/// Do two boxes overlap? Touching counts.
#[inline(always)]
fn overlap(a: &Aabb3d, b: &Aabb3d) -> bool {
    (a.min.cmple(b.max) & b.min.cmple(a.max)).all()
}

/// The boxes of the last frame, kept by engines that skip what did not change.
#[derive(Default)]
struct Boxes(Vec<Aabb3d>);

impl Boxes {
    /// Takes over a frame and calls `changed` with the number and the box of each object that is
    /// new or has moved.
    #[inline]
    fn take(&mut self, boxes: &[Aabb3d], mut changed: impl FnMut(u32, &Aabb3d)) {
        if self.0.is_empty() {
            self.0.extend_from_slice(boxes);
            for (i, aabb) in boxes.iter().enumerate() {
                changed(i as u32, aabb);
            }
            return;
        }
        for (i, (old, new)) in self.0.iter_mut().zip(boxes).enumerate() {
            if (old.min.cmpne(new.min) | old.max.cmpne(new.max)).any() {
                *old = *new;
                changed(i as u32, new);
            }
        }
    }

    #[inline(always)]
    fn overlap(&self, a: u32, b: u32) -> bool {
        overlap(&self.0[a as usize], &self.0[b as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::Vec3;

    /// Boxes on a lattice of quarters, so that many touch exactly, some of which rest.
    fn frames(objects: usize) -> Vec<Vec<Aabb3d>> {
        let mut random = fastrand::Rng::with_seed(7);
        let mut quarter = |steps: u32| random.u32(0..steps) as f32 * 0.25;
        let mut boxes: Vec<_> = (0..objects)
            .map(|i| {
                let low = Vec3::new(quarter(40), quarter(40), quarter(40));
                let side = if i % 50 == 0 { 4.0 } else { 0.25 + quarter(4) };
                Aabb3d {
                    min: low.into(),
                    max: (low + side).into(),
                }
            })
            .collect();
        let mut frames = vec![];
        for frame in 0..24 {
            frames.push(boxes.clone());
            for (i, aabb) in boxes.iter_mut().enumerate() {
                // All, some and none move, by turns.
                let moves = match frame % 12 {
                    0..4 => true,
                    4..10 => i % 20 == frame % 20,
                    _ => false,
                };
                if moves {
                    let step = Vec3::new(quarter(3), quarter(3), quarter(3)) - 0.25;
                    aabb.min += bevy::math::Vec3A::from(step);
                    aabb.max += bevy::math::Vec3A::from(step);
                }
            }
        }
        frames
    }

    fn sorted(pairs: &[Pair]) -> Vec<Pair> {
        let mut pairs: Vec<_> = pairs.iter().map(|&(a, b)| (a.min(b), a.max(b))).collect();
        pairs.sort_unstable();
        pairs
    }

    #[test]
    fn every_engine_finds_the_pairs_of_brute_force() {
        for objects in [1, 2, 3, 200] {
            for entry in all().iter().filter(|entry| entry.role != Role::Floor) {
                let (mut engine, mut brute) = ((entry.make)(), flat::Brute::default());
                for (number, boxes) in frames(objects).iter().enumerate() {
                    let (mut found, mut expected) = (vec![], vec![]);
                    engine.update(boxes);
                    engine.pairs(&mut found);
                    brute.update(boxes);
                    brute.pairs(&mut expected);
                    assert_eq!(
                        sorted(&found),
                        sorted(&expected),
                        "{} of {objects}, frame {number}",
                        entry.name
                    );
                }
            }
        }
    }
}
