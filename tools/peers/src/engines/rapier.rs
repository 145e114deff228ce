//! Rapier's broad phase, driven through its public interface: [`BroadPhaseBvh::set_aabb`] for each
//! box that changed, then an update, whose events keep a list of candidates.
//!
//! The other way in, moving colliders of a set and naming them to the update, needs the whole
//! physics pipeline to reset their change flags, and computes boxes from shapes and poses on top.

use bevy::{math::bounding::Aabb3d, platform::collections::HashMap};
use parry3d::bounding_volume::Aabb;
use rapier3d::prelude::*;

use super::{Boxes, Engine, Pair};

/// The broad phase, the colliders that it insists on, and the candidates.
#[derive(Default)]
pub struct Rapier {
    broad_phase: BroadPhaseBvh,
    parameters: IntegrationParameters,
    colliders: ColliderSet,
    bodies: RigidBodySet,
    handles: Vec<ColliderHandle>,
    boxes: Boxes,
    events: Vec<BroadPhasePairEvent>,
    candidates: Vec<Pair>,
    place_of: HashMap<Pair, u32>,
}

fn numbers(pair: &ColliderPair) -> Pair {
    (
        pair.collider1.into_raw_parts().0,
        pair.collider2.into_raw_parts().0,
    )
}

impl Engine for Rapier {
    fn update(&mut self, boxes: &[Aabb3d]) {
        if self.handles.is_empty() {
            // Colliders come without bodies, and meet all others of the kind.
            let collider = ColliderBuilder::cuboid(0.5, 0.5, 0.5)
                .active_collision_types(ActiveCollisionTypes::all());
            self.handles = boxes
                .iter()
                .map(|_| self.colliders.insert(collider.clone()))
                .collect();
        }
        let Self {
            broad_phase,
            parameters,
            handles,
            ..
        } = self;
        self.boxes.take(boxes, |i, aabb| {
            let aabb = Aabb {
                mins: aabb.min.to_array().into(),
                maxs: aabb.max.to_array().into(),
            };
            broad_phase.set_aabb(parameters, handles[i as usize], aabb);
        });
        self.events.clear();
        broad_phase.update(
            parameters,
            &self.colliders,
            &self.bodies,
            &[],
            &[],
            &mut self.events,
        );
    }

    fn pairs(&mut self, pairs: &mut Vec<Pair>) {
        for event in &self.events {
            match event {
                BroadPhasePairEvent::AddPair(pair) => {
                    let pair = numbers(pair);
                    self.place_of.insert(pair, self.candidates.len() as u32);
                    self.candidates.push(pair);
                }
                BroadPhasePairEvent::DeletePair(pair) => {
                    if let Some(place) = self.place_of.remove(&numbers(pair)) {
                        self.candidates.swap_remove(place as usize);
                        if let Some(last) = self.candidates.get(place as usize) {
                            self.place_of.insert(*last, place);
                        }
                    }
                }
            }
        }
        self.events.clear();
        pairs.extend(
            self.candidates
                .iter()
                .filter(|&&(a, b)| self.boxes.overlap(a, b)),
        );
    }
}
