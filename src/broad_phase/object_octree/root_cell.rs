//! The root cell: how it is laid, and how it grows.

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::settings::{ObjectOctreeSettings, RootPolicy};
use crate::broad_phase::boxes::NOWHERE;

/// A cube, and how often it has doubled.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RootCell {
    pub(super) center: Vec3A,
    pub(super) half_size: f32,
    pub(super) doublings: u32,
}

impl RootCell {
    /// Half sizes end here, so that no arithmetic on cells overflows.
    const LARGEST: f32 = f32::MAX / 8.0;

    /// Lays the root around the bounding box of the first objects.
    pub(super) fn lay(policy: RootPolicy, bounds: &Aabb3d) -> Self {
        match policy {
            RootPolicy::Cube { center, half_size } => Self {
                center: center.into(),
                half_size: half_size.min(Self::LARGEST),
                doublings: 0,
            },
            RootPolicy::Fit { scale } => {
                // Halves first: the difference of two large numbers may overflow.
                let center = bounds.min * 0.5 + bounds.max * 0.5;
                let half_extent = (bounds.max * 0.5 - bounds.min * 0.5).max_element();
                // Objects in a single point, or as good as, get a root that still divides.
                let smallest = center.abs().max_element() * f32::EPSILON * 1024.0;
                let half_size = match (half_extent * scale).max(smallest) {
                    0.0 => 1.0,
                    half_size => half_size.min(Self::LARGEST),
                };
                Self {
                    center,
                    half_size,
                    doublings: 0,
                }
            }
        }
    }

    pub(super) fn bounds(&self) -> Aabb3d {
        Aabb3d {
            min: self.center - self.half_size,
            max: self.center + self.half_size,
        }
    }

    pub(super) fn contains(&self, aabb: &Aabb3d) -> bool {
        let bounds = self.bounds();
        aabb.min.cmpge(bounds.min).all() && aabb.max.cmple(bounds.max).all()
    }

    /// Doubles toward a box until the root contains it or the limit is reached. Each doubling keeps
    /// the old cube as one of the eight children of the new.
    pub(super) fn grow_to(&mut self, aabb: &Aabb3d, max_doublings: u32) {
        while self.doublings < max_doublings
            && self.half_size < Self::LARGEST
            && !self.contains(aabb)
        {
            let downward = aabb.min.cmplt(self.bounds().min);
            self.center += Vec3A::select(
                downward,
                Vec3A::splat(-self.half_size),
                Vec3A::splat(self.half_size),
            );
            self.half_size *= 2.0;
            self.doublings += 1;
        }
    }

    /// Returns in how many generations, from the root down, a cell is at least as large as the
    /// box's longest side.
    #[inline]
    pub(super) fn levels(&self, aabb: &Aabb3d, settings: &ObjectOctreeSettings) -> u8 {
        let half_extent = (aabb.max * 0.5 - aabb.min * 0.5).max_element();
        let ratio = self.half_size / half_extent;
        if ratio >= 1.0 {
            // The exponent is the number of halvings; for a box without extent it is that of
            // infinity.
            ((ratio.to_bits() >> 23) - 126).min(settings.max_depth + 1) as u8
        } else {
            0
        }
    }
}

/// The smallest box around some boxes; inverted if there are none.
pub(super) fn bounding_box<'a>(boxes: impl Iterator<Item = &'a Aabb3d>) -> Aabb3d {
    boxes.fold(NOWHERE, |sum, aabb| Aabb3d {
        min: sum.min.min(aabb.min),
        max: sum.max.max(aabb.max),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::Vec3;

    fn lay(bounds: &Aabb3d) -> RootCell {
        RootCell::lay(RootPolicy::default(), bounds)
    }

    #[test]
    fn the_root_is_half_as_large_again_as_the_bounding_box() {
        let root = lay(&Aabb3d::new(
            Vec3::new(3.0, 0.0, 0.0),
            Vec3::new(4.0, 1.0, 2.0),
        ));
        assert_eq!(
            root.bounds(),
            Aabb3d::new(Vec3::new(3.0, 0.0, 0.0), Vec3::splat(6.0))
        );
    }

    #[test]
    fn the_root_doubles_toward_what_leaves_it() {
        let mut root = lay(&Aabb3d::new(Vec3::ZERO, Vec3::splat(2.0)));
        let old = root.bounds();
        let leaver = Aabb3d::new(Vec3::new(-7.0, 2.0, 0.0), Vec3::splat(0.5));
        root.grow_to(&leaver, 16);
        assert_eq!(root.doublings, 1);
        assert_eq!(
            root.bounds(),
            Aabb3d {
                min: Vec3A::new(-9.0, -3.0, -3.0),
                max: Vec3A::new(3.0, 9.0, 9.0)
            }
        );
        assert!(root.contains(&old) && root.contains(&leaver));
        root.grow_to(&Aabb3d::new(Vec3::splat(1e30), Vec3::ONE), 5);
        assert_eq!(root.doublings, 5);
    }

    #[test]
    fn a_point_and_the_largest_numbers_have_roots_too() {
        let point = lay(&Aabb3d {
            min: Vec3A::ZERO,
            max: Vec3A::ZERO,
        });
        assert!(point.half_size > 0.0);
        let vast = lay(&Aabb3d {
            min: Vec3A::MIN,
            max: Vec3A::MAX,
        });
        assert!(vast.half_size.is_finite() && vast.bounds().max.is_finite());
    }

    #[test]
    fn levels_count_the_generations_that_an_object_fits_in() {
        let root = lay(&Aabb3d::new(Vec3::ZERO, Vec3::splat(4.0 / 1.5)));
        let settings = ObjectOctreeSettings::default();
        let levels =
            |side: f32| root.levels(&Aabb3d::new(Vec3::ZERO, Vec3::splat(side * 0.5)), &settings);
        assert_eq!(root.half_size, 4.0);
        assert_eq!([16.0, 8.0, 5.0, 4.0, 1.0].map(levels), [0, 1, 1, 2, 4]);
        assert_eq!(u32::from(levels(0.0)), settings.max_depth + 1);
    }
}
