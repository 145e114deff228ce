//! An index with everything checked at every step, and random histories to put it through.

use bevy::math::{Vec3, bounding::Aabb3d, primitives::HalfSpace};
use proptest::prelude::*;

use super::{
    BroadPhase, LinearOctree, ObjectOctree, Pair, PairFilter, PairKinds, Proxies, ProxyId,
    SpatialIndex, check_box, overlap,
};

/// An index that is compared with brute force after every tick.
pub(super) struct Checked {
    pub(super) index: SpatialIndex,
}

impl Checked {
    pub(super) fn new(engine: Box<dyn BroadPhase>) -> Self {
        Self {
            index: SpatialIndex::with_engine(engine),
        }
    }

    pub(super) fn step(&mut self) {
        self.index.update();
        if let Some(octree) = self.index.engine_as::<ObjectOctree>() {
            octree.assert_well_formed(self.index.proxies());
        }
        if let Some(octree) = self.index.engine_as::<LinearOctree>() {
            octree.assert_well_formed(self.index.proxies());
        }
        self.assert_leaves();
        let mut found: Vec<Pair> = self.index.find_pairs().iter().collect();
        found.sort_unstable();
        assert_eq!(found, brute_force(self.index.proxies()));
    }

    /// The leaves are boxes, and list what the figures say.
    fn assert_leaves(&self) {
        let stats = self.index.stats();
        let mut leaves = Vec::new();
        self.index.for_each_leaf(|leaf| leaves.push(leaf));
        assert_eq!(
            leaves
                .iter()
                .map(|leaf| leaf.objects as usize)
                .sum::<usize>(),
            stats.entries
        );
        assert!(leaves.len() <= stats.leaves);
        for leaf in &leaves {
            assert_eq!(check_box(&leaf.bounds), Ok(()));
            assert!(leaf.generation <= stats.depth, "{leaf:?}");
        }
    }
}

fn brute_force(proxies: &Proxies) -> Vec<Pair> {
    let all: Vec<_> = proxies.iter().collect();
    let mut pairs = Vec::new();
    for (index, (a, box_a)) in all.iter().enumerate() {
        for (b, box_b) in &all[index + 1..] {
            if overlap(box_a, box_b) && make_a_pair(proxies, *a, *b) {
                pairs.push(Pair::new(*a, *b));
            }
        }
    }
    for unbounded in proxies.unbounded() {
        let side = proxies
            .unbounded
            .iter()
            .find(|other| other.id == unbounded)
            .and_then(|unbounded| unbounded.side);
        // Heights are in units that floats add without rounding.
        let reaches = |aabb: &Aabb3d| {
            let above = |side: HalfSpace, y: f32| side.normal().y * y + side.d() >= 0.0;
            side.is_none_or(|side| above(side, aabb.min.y) || above(side, aabb.max.y))
        };
        let meets =
            |(id, aabb): &&(ProxyId, &Aabb3d)| reaches(aabb) && proxies.admits(unbounded, *id);
        pairs.extend(
            all.iter()
                .filter(meets)
                .map(|(id, _)| Pair::new(unbounded, *id)),
        );
    }
    pairs.sort_unstable();
    pairs
}

fn make_a_pair(proxies: &Proxies, a: ProxyId, b: ProxyId) -> bool {
    let (a, b, kinds) = (proxies.filter(a), proxies.filter(b), proxies.pair_kinds());
    let is_sought = match (a.is_static, b.is_static) {
        (false, false) => kinds.moving_moving,
        (true, true) => kinds.static_static,
        _ => kinds.moving_static,
    };
    let (a_hears, b_hears) = (b.memberships & a.filters > 0, a.memberships & b.filters > 0);
    let is_wanted = (a_hears && (b_hears || a.is_detector)) || (b_hears && b.is_detector);
    let are_of_one_body = a.body == b.body && a.body != PairFilter::NO_BODY;
    is_sought && a.world == b.world && is_wanted && !are_of_one_body
}

/// One step of a random history. Places are in units of a 64th, so that borders are met exactly,
/// and often.
#[derive(Clone, Debug)]
pub(super) enum Step {
    Insert {
        at: [i16; 3],
        size: u16,
    },
    Shift {
        which: usize,
        by: [i8; 3],
    },
    Teleport {
        which: usize,
        to: [i16; 3],
    },
    Resize {
        which: usize,
        size: u16,
    },
    Touch {
        which: usize,
    },
    Filter {
        which: usize,
        bits: u8,
    },
    Kinds {
        bits: u8,
    },
    Remove {
        which: usize,
    },
    Unbounded {
        which: usize,
        side: Option<(bool, i16)>,
    },
    RemoveUnbounded {
        which: usize,
    },
    Tick,
}

pub(super) fn a_step() -> impl Strategy<Value = Step> {
    let at = || prop::array::uniform3(-640_i16..640);
    // 1:1000, the small ones more often.
    let size = || (0_u32..1000).prop_map(|s| (s * s / 1000).max(1) as u16);
    prop_oneof![
        4 => (at(), size()).prop_map(|(at, size)| Step::Insert { at, size }),
        8 => (any::<usize>(), prop::array::uniform3(-40_i8..40)).prop_map(|(which, by)| Step::Shift { which, by }),
        2 => (any::<usize>(), at()).prop_map(|(which, to)| Step::Teleport { which, to }),
        1 => (any::<usize>(), size()).prop_map(|(which, size)| Step::Resize { which, size }),
        1 => any::<usize>().prop_map(|which| Step::Touch { which }),
        1 => (any::<usize>(), any::<u8>()).prop_map(|(which, bits)| Step::Filter { which, bits }),
        // Most often the default.
        1 => (0_u8..16).prop_map(|bits| Step::Kinds { bits: if bits < 8 { bits } else { 3 } }),
        2 => any::<usize>().prop_map(|which| Step::Remove { which }),
        1 => (any::<usize>(), prop::option::of((any::<bool>(), -640_i16..640)))
            .prop_map(|(which, side)| Step::Unbounded { which, side }),
        1 => any::<usize>().prop_map(|which| Step::RemoveUnbounded { which }),
        4 => Just(Step::Tick),
    ]
}

/// Goes through a history, checked at each tick.
pub(super) fn replay(mut checked: Checked, steps: &[Step]) {
    const UNIT: f32 = 1.0 / 64.0;
    let place = |at: [i16; 3]| Vec3::from(at.map(f32::from)) * UNIT;
    let mut objects: Vec<(ProxyId, Vec3, f32)> = Vec::new();
    let mut unbounded: Vec<ProxyId> = Vec::new();
    for step in steps {
        let count = objects.len().max(1);
        let any = |which: &usize, objects: &[(ProxyId, Vec3, f32)]| {
            let ids: Vec<_> = objects
                .iter()
                .map(|(id, ..)| *id)
                .chain(unbounded.iter().copied())
                .collect();
            ids.get(which % ids.len().max(1)).copied()
        };
        let mut change = |which: &usize, f: &mut dyn FnMut(&mut Vec3, &mut f32)| {
            if let Some((id, center, half)) = objects.get_mut(which % count) {
                f(center, half);
                checked
                    .index
                    .set(*id, &Aabb3d::new(*center, Vec3::splat(*half)))
                    .unwrap();
            }
        };
        match step {
            Step::Insert { at, size } => {
                let (center, half) = (place(*at), f32::from(*size) * UNIT);
                let id = checked
                    .index
                    .insert(Aabb3d::new(center, Vec3::splat(half)))
                    .unwrap();
                objects.push((id, center, half));
            }
            Step::Shift { which, by } => {
                change(which, &mut |center, _| {
                    *center += Vec3::from(by.map(f32::from)) * UNIT;
                });
            }
            Step::Teleport { which, to } => change(which, &mut |center, _| *center = place(*to)),
            Step::Resize { which, size } => {
                change(which, &mut |_, half| *half = f32::from(*size) * UNIT);
            }
            Step::Touch { which } => {
                if let Some(id) = any(which, &objects) {
                    checked.index.touch(id);
                }
            }
            Step::Filter { which, bits } => {
                if let Some(id) = any(which, &objects) {
                    let [memberships, filters] = [bits & 3, bits >> 2 & 3].map(u32::from);
                    let world = if bits >> 5 == 0 {
                        7
                    } else {
                        PairFilter::DEFAULT_WORLD
                    };
                    let filter = PairFilter {
                        memberships,
                        filters,
                        is_static: bits >> 4 & 1 == 1,
                        is_detector: bits >> 6 & 1 == 1,
                        world,
                        body: if bits % 3 == 0 {
                            u32::from(bits % 2)
                        } else {
                            PairFilter::NO_BODY
                        },
                    };
                    checked.index.set_filter(id, filter).unwrap();
                }
            }
            Step::Kinds { bits } => {
                let [moving_moving, moving_static, static_static] =
                    [0, 1, 2].map(|bit| bits >> bit & 1 == 1);
                checked.index.set_pair_kinds(PairKinds {
                    moving_moving,
                    moving_static,
                    static_static,
                });
            }
            Step::Remove { which } => {
                if !objects.is_empty() {
                    let (id, ..) = objects.swap_remove(which % count);
                    assert!(checked.index.remove(id));
                }
            }
            Step::Unbounded { which, side } => {
                // Below a height, or above it.
                let side = side.map(|(below, height)| {
                    let y = if below { -1.0 } else { 1.0 };
                    HalfSpace::new(Vec3::new(0.0, y, 0.0).extend(f32::from(height) * UNIT))
                });
                match unbounded.get(which % 4) {
                    Some(id) => checked.index.set_unbounded(*id, side).unwrap(),
                    None => unbounded.push(checked.index.insert_unbounded(side).unwrap()),
                }
            }
            Step::RemoveUnbounded { which } => {
                if !unbounded.is_empty() {
                    assert!(
                        checked
                            .index
                            .remove(unbounded.swap_remove(which % unbounded.len()))
                    );
                }
            }
            Step::Tick => checked.step(),
        }
    }
    checked.step();
}
