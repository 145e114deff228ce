//! Skins: where an object may go before the index has to know.

use bevy::math::{Vec3, Vec3A, bounding::Aabb3d};

use super::EMPTY;
use crate::broad_phase::{Proxies, ProxyId};

/// How much larger than boxes skins may be, by volume. More makes skins last longer, and more of them overlap.
const GROWTH: f32 = 1.6;

/// The fewest ticks that skins are worth making for, and how much larger they may be for these.
const SHORTEST: f32 = 2.0;
const GROWTH_FOR_SHORTEST: f32 = 2.1;

/// The most ticks that skins are made for.
const LONGEST: f32 = 32.0;

/// Share of the way ahead that is added on all sides: rounding must not carry an object out of a skin along its way.
const MARGIN: f32 = 0.02;

/// The skin of each object, and when it was made.
#[derive(Clone, Debug, Default)]
pub(super) struct Skins {
    tick: u32,
    skins: Vec<Aabb3d>,
    anchors: Vec<Anchor>,
}

/// The lower corner of an object's box when its skin was made, and the tick; 0 if there is none.
#[derive(Clone, Copy, Debug, Default)]
struct Anchor {
    corner: Vec3,
    tick: u32,
}

impl Skins {
    /// Makes room for so many objects, and counts the ticks.
    pub(super) fn begin_tick(&mut self, objects: usize) {
        // 0 is kept for anchors that are none.
        self.tick = self.tick.checked_add(1).unwrap_or(1);
        self.skins.resize(objects, EMPTY);
        self.anchors.resize(objects, Anchor::default());
    }

    #[inline]
    pub(super) fn get(&self, id: ProxyId) -> &Aabb3d {
        &self.skins[id.index()]
    }

    /// Is a box within the object's skin?
    #[inline]
    pub(super) fn holds(&self, id: ProxyId, aabb: &Aabb3d) -> bool {
        let skin = &self.skins[id.index()];
        (skin.min.cmple(aabb.min) & skin.max.cmpge(aabb.max)).all()
    }

    pub(super) fn remove(&mut self, id: ProxyId) {
        self.skins[id.index()] = EMPTY;
        self.anchors[id.index()] = Anchor::default();
    }

    /// Gives some objects new skins.
    pub(super) fn renew(&mut self, proxies: &Proxies, objects: &[u32]) {
        let horizon = self.horizon(proxies, objects);
        for id in objects.iter().map(|id| ProxyId::new(*id)) {
            self.make(id, &proxies.boxes()[id.index()], horizon);
        }
    }

    /// Gives all objects new skins, for as many ticks as suits those that have left theirs. True if they are the boxes
    /// themselves.
    pub(super) fn renew_all(&mut self, proxies: &Proxies, escaped: &[u32]) -> bool {
        self.skins.resize(proxies.capacity(), EMPTY);
        self.anchors.resize(proxies.capacity(), Anchor::default());
        let horizon = self.horizon(proxies, escaped);
        let mut tight = true;
        for (id, aabb) in proxies.iter() {
            tight &= self.make(id, aabb, if proxies.is_moved(id) { horizon } else { 0.0 });
        }
        tight
    }

    /// True if the skin is the box itself.
    #[inline]
    fn make(&mut self, id: ProxyId, aabb: &Aabb3d, horizon: f32) -> bool {
        let way = if horizon > 0.0 { self.step(id, aabb) * horizon } else { Vec3A::ZERO };
        let margin = way.abs() * MARGIN;
        let min = aabb.min + way.min(Vec3A::ZERO) - margin;
        let max = aabb.max + way.max(Vec3A::ZERO) + margin;
        // A way that overflows is not worth a skin.
        let fits = min.is_finite() && max.is_finite();
        self.skins[id.index()] = if fits { Aabb3d { min, max } } else { *aabb };
        self.anchors[id.index()] = Anchor { corner: aabb.min.into(), tick: self.tick };
        way == Vec3A::ZERO
    }

    /// How an object moves in a tick: the mean since its skin was made.
    #[inline]
    fn step(&self, id: ProxyId, aabb: &Aabb3d) -> Vec3A {
        let anchor = self.anchors[id.index()];
        match self.tick.wrapping_sub(anchor.tick) {
            age if anchor.tick != 0 && age != 0 => (aabb.min - Vec3A::from(anchor.corner)) / age as f32,
            _ => Vec3A::ZERO,
        }
    }

    /// For how many ticks ahead skins should be made, given the objects that left theirs; 0 if that does not pay.
    ///
    /// The mean over a sample, of the steps in parts of the objects' sizes, says how fast skins would grow.
    fn horizon(&self, proxies: &Proxies, objects: &[u32]) -> f32 {
        const SAMPLE: usize = 1024;
        let (mut sum, mut count) = (Vec3A::ZERO, 0.0);
        for id in objects.iter().step_by(objects.len() / SAMPLE + 1).map(|id| ProxyId::new(*id)) {
            let aabb = &proxies.boxes()[id.index()];
            let step = self.step(id, aabb).abs();
            if step != Vec3A::ZERO {
                // The share is 1 at most, also for points.
                sum += step / (aabb.max - aabb.min).max(step).max(Vec3A::splat(f32::MIN_POSITIVE));
                count += 1.0;
            }
        }
        if count == 0.0 {
            return SHORTEST;
        }
        let share = sum / count;
        let growth = |ticks: f32| (Vec3A::ONE + share * ticks).to_array().into_iter().product::<f32>();
        if growth(SHORTEST) > GROWTH_FOR_SHORTEST {
            return 0.0;
        }
        let mut ticks = SHORTEST;
        while ticks < LONGEST && growth(ticks + 1.0) <= GROWTH {
            ticks += 1.0;
        }
        ticks
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.skins.capacity() * size_of::<Aabb3d>() + self.anchors.capacity() * size_of::<Anchor>()
    }
}
