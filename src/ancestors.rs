//! The way up from an entity, through its parents.

use bevy::prelude::*;

/// The entity is its own ancestor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Circle;

/// Walks up from an entity, itself included: what `look` finds of each, and its parent. Ends at the
/// first of which it finds nothing, or, in a circle, with an error.
pub(crate) fn up<T>(
    from: Entity,
    mut look: impl FnMut(Entity) -> Option<(T, Option<Entity>)>,
) -> impl Iterator<Item = Result<T, Circle>> {
    let (mut next, mut mark, mut steps) = (Some(Ok(from)), from, 0_u64);
    std::iter::from_fn(move || {
        let entity = match next.take()? {
            Ok(entity) => entity,
            Err(circle) => return Some(Err(circle)),
        };
        let (found, parent) = look(entity)?;
        steps += 1;
        // Who walks in a circle comes back to where it was when the steps were last a power of two.
        next = parent.map(|parent| {
            if parent == mark {
                Err(Circle)
            } else {
                Ok(parent)
            }
        });
        if steps.is_power_of_two() {
            mark = parent.unwrap_or(mark);
        }
        Some(Ok(found))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entities by index, and their parents.
    fn walk(parents: &[Option<usize>]) -> Result<Vec<usize>, Circle> {
        let mut world = World::new();
        let all: Vec<_> = parents.iter().map(|_| world.spawn_empty().id()).collect();
        let look = |entity| {
            let index = all.iter().position(|other| *other == entity)?;
            Some((index, parents[index].map(|parent| all[parent])))
        };
        up(all[0], look).collect()
    }

    #[test]
    fn the_way_up_ends_whatever_it_leads_to() {
        assert_eq!(walk(&[None]), Ok(vec![0]));
        assert_eq!(walk(&[Some(2), None, Some(1)]), Ok(vec![0, 2, 1]));
        assert_eq!(walk(&[Some(0)]), Err(Circle));
        for length in 2..40 {
            for back_to in 0..length {
                let parents: Vec<_> = (1..length).chain([back_to]).map(Some).collect();
                assert_eq!(walk(&parents), Err(Circle), "{length} {back_to}");
            }
        }
    }
}
