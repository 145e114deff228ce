//! Histories of an index of boxes.

use std::collections::BTreeMap;

use bevy::{
    math::{
        Vec3A,
        bounding::{Aabb3d, AabbCast3d, BoundingSphere, RayCast3d},
        primitives::HalfSpace,
    },
    prelude::*,
};
use bevy_octree::broad_phase::{
    BoxError, BroadPhaseMethod, Hit, ObjectOctree, ObjectOctreeSettings, PairFilter, PairKinds,
    PairSearch, ProxyId, SpatialIndex, check_box, overlap,
};

use crate::source::Source;

const MOST_STEPS: usize = 120;
const MOST_OBJECTS: usize = 64;

/// What an object is.
#[derive(Clone, Copy, Debug)]
struct Object {
    /// None of what has no end, which may be anywhere.
    aabb: Option<Aabb3d>,
    filter: PairFilter,
    order: u64,
}

/// An index, and what was put into it.
struct History {
    index: SpatialIndex,
    objects: BTreeMap<ProxyId, Object>,
    kinds: PairKinds,
    /// Handles that were given back.
    gone: Vec<ProxyId>,
}

/// Has an index live through a history.
pub fn run(source: &mut Source) {
    source.may_go_wild();
    let mut history = History {
        index: SpatialIndex::new(&method(source)),
        objects: BTreeMap::new(),
        kinds: PairKinds::default(),
        gone: vec![],
    };
    let steps = source.below(MOST_STEPS);
    for _ in 0..steps {
        if source.is_empty() {
            break;
        }
        history.step(source);
    }
    history.check_pairs();
}

fn method(source: &mut Source) -> BroadPhaseMethod {
    match source.below(5) {
        0 => BroadPhaseMethod::Auto,
        1 => BroadPhaseMethod::LinearOctree,
        2 => BroadPhaseMethod::Exhaustive,
        few => {
            let search = if few == 3 {
                PairSearch::Leaves
            } else {
                PairSearch::Blocks
            };
            let objects = 1 + source.below(4);
            BroadPhaseMethod::ObjectOctree(ObjectOctreeSettings {
                search,
                ..ObjectOctreeSettings::with_max_objects(objects as _)
            })
        }
    }
}

fn a_box(source: &mut Source) -> Aabb3d {
    let (min, size) = (Vec3A::from(source.vector()), Vec3A::from(source.sizes()));
    match source.byte() {
        0..64 => Aabb3d { min, max: min },
        64..72 => Aabb3d { min, max: -size },
        _ => Aabb3d {
            min,
            max: min + size,
        },
    }
}

impl History {
    fn any(&self, source: &mut Source) -> Option<ProxyId> {
        let number = usize::from(source.byte()).checked_rem(self.objects.len())?;
        self.objects.keys().nth(number).copied()
    }

    fn step(&mut self, source: &mut Source) {
        match source.below(24) {
            0..6 => self.insert(source),
            6..10 => self.set(source),
            10 => self.remove(source),
            11 => {
                if let Some(id) = self.any(source) {
                    assert!(self.index.touch(id));
                }
            }
            12 => {
                let filter = PairFilter {
                    memberships: u32::from(source.byte() & 3),
                    filters: u32::from(source.byte() & 3),
                    is_static: source.bit(),
                    is_detector: source.bit(),
                    world: source.choose(&[PairFilter::DEFAULT_WORLD, 0, 1]),
                    body: source.choose(&[PairFilter::NO_BODY, PairFilter::NO_BODY, 0, 1]),
                };
                if let Some(id) = self.any(source) {
                    assert_eq!(self.index.set_filter(id, filter), Ok(()));
                    self.objects.get_mut(&id).expect("it is there").filter = filter;
                }
            }
            13 => {
                let order = u64::from(source.byte() & 3);
                if let Some(id) = self.any(source) {
                    assert_eq!(self.index.set_order(id, order), Ok(()));
                    self.objects.get_mut(&id).expect("it is there").order = order;
                }
            }
            14 => {
                if let Ok(id) = self.index.insert_unbounded(None) {
                    self.enlist(id, None);
                }
            }
            15 => {
                let method = method(source);
                self.index.set_method(&method);
            }
            16 => {
                let bits = source.byte();
                self.kinds = PairKinds {
                    moving_moving: bits & 1 == 0,
                    moving_static: bits & 2 == 0,
                    static_static: bits & 4 != 0,
                };
                self.index.set_pair_kinds(self.kinds);
            }
            17 => self.index.touch_all(),
            18 | 19 => self.index.update(),
            20 | 21 => self.check_pairs(),
            22 => self.check_unknown(source),
            _ => self.check_queries(source),
        }
        assert_eq!(
            self.index.proxies().len(),
            self.objects.values().filter(|o| o.aabb.is_some()).count()
        );
    }

    fn enlist(&mut self, id: ProxyId, aabb: Option<Aabb3d>) {
        let object = Object {
            aabb,
            filter: PairFilter::default(),
            order: 0,
        };
        assert!(
            self.objects.insert(id, object).is_none(),
            "{id:?} was handed out twice"
        );
        self.gone.retain(|other| *other != id);
    }

    fn insert(&mut self, source: &mut Source) {
        if self.objects.len() >= MOST_OBJECTS {
            return;
        }
        let aabb = a_box(source);
        let found = self.index.insert(aabb);
        assert_eq!(found.is_ok(), check_box(&aabb).is_ok(), "{aabb:?}");
        if let Ok(id) = found {
            self.enlist(id, Some(aabb));
        }
    }

    fn set(&mut self, source: &mut Source) {
        let Some(id) = self.any(source) else {
            return;
        };
        let known = self.objects.get_mut(&id).expect("it is there");
        let aabb = match (source.bit(), known.aabb) {
            (true, Some(own)) => {
                let by = Vec3A::from(source.vector()) / 32.0;
                Aabb3d {
                    min: own.min + by,
                    max: own.max + by,
                }
            }
            _ => a_box(source),
        };
        let found = self.index.set(id, &aabb);
        if known.aabb.is_some() && check_box(&aabb).is_ok() {
            assert_eq!(found, Ok(()));
            known.aabb = Some(aabb);
        } else {
            assert!(found.is_err(), "{id:?} {aabb:?}");
        }
    }

    fn remove(&mut self, source: &mut Source) {
        let Some(id) = self.any(source) else {
            return;
        };
        assert!(self.index.remove(id));
        self.objects.remove(&id);
        self.gone.push(id);
    }

    /// What is gone is unknown.
    fn check_unknown(&mut self, source: &mut Source) {
        let aabb = a_box(source);
        for id in self.gone.clone() {
            assert!(!self.index.remove(id) && !self.index.touch(id));
            assert!(self.index.set(id, &aabb).is_err());
            let unknown = Err(BoxError::UnknownProxy(id));
            assert_eq!(self.index.set_filter(id, PairFilter::default()), unknown);
            assert_eq!(self.index.set_order(id, 1), unknown);
            assert!(self.index.set_unbounded(id, None::<HalfSpace>).is_err());
        }
    }

    fn check_pairs(&mut self) {
        let mut found: Vec<[ProxyId; 2]> = self
            .index
            .find_pairs()
            .iter()
            .map(|pair| [pair.a, pair.b])
            .collect();
        found.sort_unstable();
        let mut expected = vec![];
        for (a, one) in &self.objects {
            for (b, other) in self.objects.range(*a..).skip(1) {
                let overlap = match (one.aabb, other.aabb) {
                    (Some(one), Some(other)) => overlap(&one, &other),
                    (None, None) => false,
                    _ => true,
                };
                let are_sought = self.kinds.include(&one.filter, &other.filter);
                if overlap && are_sought && one.filter.admits(&other.filter) {
                    expected.push([*a, *b]);
                }
            }
        }
        assert_eq!(found, expected, "{:?}\n{:?}", self.index, self.objects);
        self.check_tree();
    }

    /// The report's octree is as it is said to be.
    fn check_tree(&self) {
        if let Some(octree) = self.index.engine_as::<ObjectOctree>() {
            octree.assert_well_formed(self.index.proxies());
        }
        if let Some(octree) = self
            .index
            .engine_as::<bevy_octree::broad_phase::LinearOctree>()
        {
            octree.assert_well_formed(self.index.proxies());
        }
    }

    /// Of those with a box, how far each is; those without are everywhere.
    fn by_distance(&self, distance: impl Fn(&Aabb3d) -> Option<f32>) -> Vec<Hit> {
        let mut hits: Vec<Hit> = self
            .objects
            .iter()
            .filter_map(|(proxy, object)| {
                let distance = object.aabb.map_or(Some(0.0), |aabb| distance(&aabb))?;
                Some(Hit {
                    proxy: *proxy,
                    distance,
                })
            })
            .collect();
        hits.sort_by(|a, b| {
            let order = |hit: &Hit| (self.objects[&hit.proxy].order, hit.proxy);
            a.distance
                .total_cmp(&b.distance)
                .then(order(a).cmp(&order(b)))
        });
        hits
    }

    fn check_queries(&mut self, source: &mut Source) {
        self.index.update();
        let region = a_box(source);
        let is_box = check_box(&region).is_ok();
        let mut found = vec![];
        self.index
            .for_each_overlapping(&region, |id| found.push(id));
        found.sort_unstable();
        let expected: Vec<ProxyId> = self
            .by_distance(|aabb| (is_box && overlap(aabb, &region)).then_some(0.0))
            .iter()
            .map(|hit| hit.proxy)
            .filter(|id| is_box || self.objects[id].aabb.is_some())
            .collect();
        let mut expected = expected;
        expected.sort_unstable();
        if is_box {
            assert_eq!(found, expected, "{region:?} {:?}", self.objects);
        }
        let point = source.vector();
        if point.is_finite() {
            self.check_near(point, source.size());
        }
        let direction = source.direction();
        let length = source.size();
        let (index, ray) = (&self.index, RayCast3d::new(point, direction, length));
        self.check_first(index.cast(&ray), |visit| {
            index.for_each_hit(&ray, visit);
        });
        if is_box && point.is_finite() && length >= 0.0 {
            let cast = AabbCast3d::new(region, point, direction, length);
            self.check_first(index.cast(&cast), |visit| {
                index.for_each_hit(&cast, visit);
            });
            let mut seen = vec![];
            index.for_each_hit(&cast, |hit| seen.push(hit));
            self.check_cast(&cast, &seen);
        }
    }

    /// The first hit is the first of all.
    fn check_first(&self, first: Option<Hit>, all: impl Fn(&mut dyn FnMut(Hit))) {
        let mut hits = vec![];
        all(&mut |hit| hits.push(hit));
        let key = |hit: &Hit| (self.objects[&hit.proxy].order, hit.proxy);
        hits.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(key(a).cmp(&key(b))));
        assert_eq!(first, hits.first().copied(), "{hits:?}");
    }

    /// What a moving box meets, and what it does not, in 64-bit numbers.
    fn check_cast(&self, cast: &AabbCast3d, hits: &[Hit]) {
        let wide = |v: Vec3A| Vec3::from(v).as_dvec3();
        let (origin, way) = (wide(cast.ray.origin), wide(cast.ray.direction.into()));
        let (own_min, own_max) = (wide(cast.aabb.min) + origin, wide(cast.aabb.max) + origin);
        for (id, object) in &self.objects {
            let Some(aabb) = object.aabb else {
                continue;
            };
            let (low, high) = (wide(aabb.min) - own_max, wide(aabb.max) - own_min);
            let size = [own_min, own_max, wide(aabb.min), wide(aabb.max)];
            let size = size
                .iter()
                .map(|at| at.abs().max_element())
                .fold(1.0, f64::max);
            let slack = 1e-5 * size;
            // In touch for certain, or perhaps, while the way is between these.
            let interval = |slack: f64| {
                let (mut enter, mut leave) = (0.0_f64, f64::from(cast.ray.max));
                for axis in 0..3 {
                    let (low, high) = (low[axis] - slack, high[axis] + slack);
                    if way[axis] == 0.0 {
                        if low > 0.0 || high < 0.0 {
                            return None;
                        }
                    } else {
                        let ends = [low / way[axis], high / way[axis]];
                        enter = enter.max(ends[0].min(ends[1]));
                        leave = leave.min(ends[0].max(ends[1]));
                    }
                }
                (enter <= leave).then_some(enter)
            };
            let hit = hits.iter().find(|hit| hit.proxy == *id);
            if interval(-slack).is_some() {
                assert!(hit.is_some(), "{cast:?} misses {aabb:?}");
            }
            if let Some(hit) = hit {
                let may = interval(slack);
                assert!(
                    may.is_some_and(|enter| f64::from(hit.distance) >= enter - slack),
                    "{cast:?} meets {aabb:?} at {}",
                    hit.distance
                );
            }
        }
    }

    fn check_near(&self, point: Vec3, radius: f32) {
        let here = Vec3A::from(point);
        let distance = |aabb: &Aabb3d| {
            let off = here.clamp(aabb.min, aabb.max).as_dvec3() - here.as_dvec3();
            off.length() as f32
        };
        let all = self.by_distance(|aabb| Some(distance(aabb)));
        let near = |a: f32, b: f32| (a - b).abs() <= 1e-5 * a.max(b) || a == b;
        let first = self.index.nearest(point, f32::INFINITY);
        match (first, all.first()) {
            (Some(found), Some(first)) => {
                assert!(near(found.distance, first.distance), "{found:?} {first:?}");
            }
            (found, first) => assert!(found.is_none() && first.is_none(), "{found:?} {first:?}"),
        }
        let mut few = vec![];
        self.index.k_nearest(point, 5, f32::INFINITY, &mut few);
        assert_eq!(few.len(), all.len().min(5));
        for (found, expected) in few.iter().zip(&all) {
            assert!(near(found.distance, expected.distance), "{few:?} {all:?}");
        }
        if !radius.is_finite() {
            return;
        }
        let mut within = vec![];
        self.index
            .for_each_within(point, radius, |hit| within.push(hit.proxy));
        let mut ball = vec![];
        if radius >= 0.0 {
            let region = BoundingSphere::new(point, radius);
            self.index.for_each_overlapping(&region, |id| ball.push(id));
        }
        for hit in &all {
            if self.objects[&hit.proxy].aabb.is_none() {
                continue;
            }
            let slack = 1e-5 * radius.abs();
            for found in [&within, &ball] {
                if hit.distance < radius - slack {
                    assert!(
                        found.contains(&hit.proxy),
                        "{hit:?} is within {radius} of {point}"
                    );
                }
                if hit.distance > radius + slack {
                    assert!(
                        !found.contains(&hit.proxy),
                        "{hit:?} is not within {radius} of {point}"
                    );
                }
            }
        }
    }
}
