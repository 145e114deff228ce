//! Which parts of two shapes come near each other.

use bevy::math::DVec3;

use super::gap::Gap;
use super::parts::{Part, gap};
use super::posed::PosedShape;
use super::probe::Search;

/// Calls `visit` with all pairs of what two shapes consist of that are near each other: the two
/// boxes, or that of the first on its way and the other. False if there are such about which nothing
/// can be said.
pub fn pairs(
    search: &Search,
    a: &PosedShape,
    b: &PosedShape,
    visit: &mut dyn FnMut(&Part, &Part) -> bool,
) -> bool {
    match (a, b) {
        (PosedShape::Part(a), PosedShape::Part(b)) => visit(a, b),
        // A mesh of ours is searched for each part of the other.
        (PosedShape::Part(_), _)
        | (PosedShape::Mesh(_), PosedShape::Foreign(_) | PosedShape::Composite { .. }) => {
            let probe = a.probe(b.isometry(), search.direction);
            b.each(&probe, search, &mut |part| pairs(search, a, part, visit))
        }
        _ => {
            let probe = b.probe(a.isometry(), -search.direction);
            a.each(&probe, search, &mut |part| pairs(search, part, b, visit))
        }
    }
}

/// Where two shapes are closest to each other. `None` if nothing can be said about them, or one is
/// empty.
pub fn nearest(a: &PosedShape, b: &PosedShape) -> Option<Gap> {
    if let (PosedShape::Part(a), PosedShape::Part(b)) = (a, b) {
        return gap(a, b, f64::INFINITY, false).ok()?;
    }
    let sizes = [a.size(), b.size()].map(|size| if size.is_finite() { size } else { 0.0 });
    // As seen from one that has an end.
    let [of, from] = if a.local_box().is_some() {
        [a, b]
    } else {
        [b, a]
    };
    let apart = from
        .probe(of.isometry(), DVec3::ZERO)
        .distance(of.local_box());
    let everything = apart + 4.0 * (sizes[0] + sizes[1]);
    // What is found is the closest, if it is closer than where it was looked for: everywhere, where
    // near parts come first.
    let mut margin = match (a, b) {
        (PosedShape::Part(_), PosedShape::Mesh(_)) | (PosedShape::Mesh(_), PosedShape::Part(_)) => {
            f64::INFINITY
        }
        _ => apart + (0.25 * sizes[0].min(sizes[1])).max(1e-3 * sizes[0].max(sizes[1])),
    };
    loop {
        let search = Search::nearest(margin);
        let mut best: Option<Gap> = None;
        let is_known = pairs(&search, a, b, &mut |a, b| {
            let limit = best.map_or(f64::INFINITY, |best| best.distance);
            let Ok(found) = gap(a, b, limit, false) else {
                return false;
            };
            if let Some(found) = found.filter(|found| found.distance < limit) {
                best = Some(found);
                search.margin.set(search.margin.get().min(found.distance));
                if found.distance <= 0.0 {
                    search.end();
                }
            }
            true
        });
        match best {
            _ if !is_known => return None,
            Some(found) if found.distance <= margin => return best,
            Some(found) => margin = found.distance,
            // Of what is empty and no larger than a point, both are zero.
            None if margin < everything => margin *= 4.0,
            None => return None,
        }
    }
}
