//! What is looked for among the parts of a shape, and where.

use std::cell::Cell;

use bevy::math::DVec3;

/// What is still looked for.
#[derive(Debug)]
pub struct Search {
    /// Up to which distance parts are near each other.
    pub margin: Cell<f64>,
    /// Where the first of the two goes.
    pub direction: DVec3,
    /// How far it goes.
    pub limit: Cell<f64>,
    /// Whether the margin shrinks to what is nearest, so that near parts come first.
    pub is_for_nearest: bool,
    /// Which triangle of a mesh of Rapier's is visited, or which polygon of one of ours.
    pub triangle: Cell<Option<u32>>,
}

impl Search {
    pub fn within(margin: f64) -> Self {
        Self {
            margin: Cell::new(margin),
            direction: DVec3::ZERO,
            limit: Cell::new(0.0),
            is_for_nearest: false,
            triangle: Cell::new(None),
        }
    }

    /// What is nearest, if it is within the margin.
    pub fn nearest(margin: f64) -> Self {
        Self {
            is_for_nearest: true,
            ..Self::within(margin)
        }
    }

    /// Nothing is looked for any more.
    pub fn end(&self) {
        self.margin.set(f64::NEG_INFINITY);
    }

    pub fn goes_on(&self) -> bool {
        self.margin.get() > f64::NEG_INFINITY
    }
}

/// Where parts are looked for, in the coordinates of the whole.
#[derive(Clone, Copy, Debug)]
pub enum Probe {
    Everywhere,
    /// A box on its way.
    Box {
        center: DVec3,
        half: DVec3,
        direction: DVec3,
    },
    HalfSpace {
        normal: DVec3,
        offset: f64,
        approach: f64,
    },
}

impl Probe {
    /// Whether what is in a box may be near.
    pub fn admits(&self, low: DVec3, high: DVec3, search: &Search) -> bool {
        let margin = search.margin.get();
        match *self {
            Self::Everywhere => search.goes_on(),
            Self::HalfSpace {
                normal,
                offset,
                approach,
            } => {
                let lowest =
                    DVec3::select(normal.cmpge(DVec3::ZERO), low, high).dot(normal) - offset;
                lowest <= margin + approach * search.limit.get()
            }
            Self::Box {
                center,
                half,
                direction,
            } => {
                let (low, high) = (low - half - center, high + half - center);
                let away = low.max(-high).max(DVec3::ZERO);
                let limit = search.limit.get();
                if limit == 0.0 {
                    return margin >= 0.0 && away.length_squared() <= margin * margin;
                }
                passes(low - margin, high + margin, direction, limit)
            }
        }
    }

    /// How far a box is from it.
    pub fn distance(&self, bounds: Option<[DVec3; 2]>) -> f64 {
        let Some([center, half]) = bounds else {
            return 0.0;
        };
        match *self {
            Self::Everywhere => 0.0,
            Self::HalfSpace { normal, offset, .. } => {
                (normal.dot(center) - normal.abs().dot(half) - offset).max(0.0)
            }
            Self::Box {
                center: other,
                half: reach,
                ..
            } => ((other - center).abs() - half - reach)
                .max(DVec3::ZERO)
                .length(),
        }
    }
}

/// Does a way from the origin meet a box?
fn passes(low: DVec3, high: DVec3, direction: DVec3, limit: f64) -> bool {
    passage(low, high, direction, limit).is_some()
}

/// From where to where a way from the origin is in a box.
pub fn passage(low: DVec3, high: DVec3, direction: DVec3, limit: f64) -> Option<[f64; 2]> {
    let (mut start, mut end) = (0f64, limit);
    for axis in 0..3 {
        let (low, high, along) = (low[axis], high[axis], direction[axis]);
        if along == 0.0 || limit == 0.0 {
            if !(low <= 0.0 && high >= 0.0) {
                return None;
            }
            continue;
        }
        let (one, other) = (low / along, high / along);
        start = start.max(one.min(other));
        end = end.min(one.max(other));
    }
    (start <= end).then_some([start, end])
}
