//! Layers by name and by number, and sets of them.

use std::{
    fmt,
    ops::{BitAnd, BitAndAssign, BitOr, BitOrAssign, BitXor, BitXorAssign, Not},
};

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// One of 32 layers by name: for an enum of one's own.
/// [`collision_layers!`](crate::collision_layers) writes it.
pub trait CollisionLayer {
    /// Returns the layer's number, 0 to 31. Larger ones are no layer at all.
    fn index(self) -> u32;
}

/// A set of layers: a bit for each of 32.
///
/// Layers have numbers, or names by a [`CollisionLayer`]: wherever a mask is expected, a layer, an
/// array of up to 32 layers or the bits as a number do as well; `[]` is no layer.
///
/// ```
/// use bevy_octree::prelude::*;
///
/// collision_layers! {
///     enum Layer { Ground, Player, Enemy, Bullet }
/// }
///
/// let bodies = Layer::Player | Layer::Enemy;
/// assert_eq!(bodies, LayerMask::from([Layer::Player, Layer::Enemy]));
/// assert_eq!(bodies, LayerMask(0b0110));
/// assert!(bodies.contains(Layer::Enemy) && !bodies.contains(Layer::Enemy | Layer::Bullet));
/// assert!(bodies.intersects(Layer::Enemy | Layer::Bullet));
/// assert_eq!(LayerMask::ALL & !bodies & 0b1111, Layer::Ground | Layer::Bullet);
/// ```
///
/// Where it is reflected or in a file, it is a plain number: the bits.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Reflect, Serialize, Deserialize)]
#[reflect(Clone, Debug, Default, PartialEq, Hash, Serialize, Deserialize)]
#[serde(transparent)]
#[type_path = "bevy_octree"]
#[doc(alias("layer mask", "collision group", "bitmask"))]
pub struct LayerMask(pub u32);

impl LayerMask {
    /// The set of all 32 layers.
    pub const ALL: Self = Self(u32::MAX);
    /// The set of no layer.
    pub const NONE: Self = Self(0);
    /// The set of the first layer alone, which entities are on that say nothing else.
    pub const DEFAULT: Self = Self(1);

    /// Returns the set of one layer, by its number; of none, if there is no such layer.
    #[must_use]
    pub const fn layer(index: u32) -> Self {
        if index < u32::BITS {
            Self(1 << index)
        } else {
            Self::NONE
        }
    }

    /// Returns the layers that are in either set, as `|` does: for constants.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns the layers that are in both sets, as `&` does: for constants.
    #[must_use]
    pub const fn intersection(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Returns the layers of this set that are not in the other: for constants, and for all but
    /// some.
    ///
    /// ```
    /// # use bevy_octree::prelude::*;
    /// # collision_layers! { enum Layer { Ground, Player, Ghost } }
    /// const ALL_BUT_GHOSTS: LayerMask = LayerMask::ALL.difference(Layer::Ghost.mask());
    /// assert!(ALL_BUT_GHOSTS.contains([Layer::Ground, Layer::Player]));
    /// assert!(!ALL_BUT_GHOSTS.contains(Layer::Ghost));
    /// ```
    #[must_use]
    #[doc(alias("without", "except"))]
    pub const fn difference(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Returns `true` if no layer is in the set.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Returns `true` if each of these layers is in the set.
    #[must_use]
    pub fn contains(self, layers: impl Into<Self>) -> bool {
        let layers = layers.into();
        self & layers == layers
    }

    /// Returns `true` if at least one of these layers is in the set.
    #[must_use]
    pub fn intersects(self, layers: impl Into<Self>) -> bool {
        self & layers != Self::NONE
    }
}

impl Default for LayerMask {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl fmt::Debug for LayerMask {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "LayerMask({:#b})", self.0)
    }
}

impl From<u32> for LayerMask {
    fn from(bits: u32) -> Self {
        Self(bits)
    }
}

impl<L: CollisionLayer> From<L> for LayerMask {
    fn from(layer: L) -> Self {
        Self::layer(layer.index())
    }
}

impl From<[Self; 0]> for LayerMask {
    /// No layer, by `[]`: that there is no other array of this length leaves its type no choice.
    fn from(_: [Self; 0]) -> Self {
        Self::NONE
    }
}

/// Arrays of so many layers. One implementation for all lengths would take `[]` to be an array of a
/// type that nobody knows.
macro_rules! from_layers {
    ($($length:literal)+) => {
        $(
            impl<L: CollisionLayer> From<[L; $length]> for LayerMask {
                fn from(layers: [L; $length]) -> Self {
                    layers.into_iter().collect()
                }
            }
        )+
    };
}

from_layers!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16);
from_layers!(17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32);

impl<L: Into<Self>> FromIterator<L> for LayerMask {
    fn from_iter<I: IntoIterator<Item = L>>(layers: I) -> Self {
        layers.into_iter().fold(Self::NONE, BitOr::bitor)
    }
}

impl<L: Into<Self>> BitOr<L> for LayerMask {
    type Output = Self;

    fn bitor(self, other: L) -> Self {
        Self(self.0 | other.into().0)
    }
}

impl<L: Into<Self>> BitAnd<L> for LayerMask {
    type Output = Self;

    fn bitand(self, other: L) -> Self {
        Self(self.0 & other.into().0)
    }
}

impl<L: Into<Self>> BitXor<L> for LayerMask {
    type Output = Self;

    fn bitxor(self, other: L) -> Self {
        Self(self.0 ^ other.into().0)
    }
}

impl<L: Into<Self>> BitOrAssign<L> for LayerMask {
    fn bitor_assign(&mut self, other: L) {
        *self = *self | other;
    }
}

impl<L: Into<Self>> BitAndAssign<L> for LayerMask {
    fn bitand_assign(&mut self, other: L) {
        *self = *self & other;
    }
}

impl<L: Into<Self>> BitXorAssign<L> for LayerMask {
    fn bitxor_assign(&mut self, other: L) {
        *self = *self ^ other;
    }
}

impl Not for LayerMask {
    type Output = Self;

    fn not(self) -> Self {
        Self(!self.0)
    }
}

/// Makes an enum whose variants are collision layers.
///
/// The first is the layer of all entities without
/// [`CollisionLayers`](crate::filters::CollisionLayers), unless it says otherwise. Up to 32
/// variants, numbered from 0, or as you say; more, or larger numbers, do not compile. The enum is
/// `Copy`, `Debug`, `Eq` and `Hash`, and implements
/// [`CollisionLayer`](crate::filters::CollisionLayer); layers joined by `|` are a
/// [`LayerMask`](crate::filters::LayerMask), and so is `mask()` of one, which is `const`. It may
/// have attributes and derives of your own, and so may its variants, `cfg` among them; its `repr`
/// is the macro's.
///
/// ```
/// use bevy_octree::prelude::*;
///
/// collision_layers! {
///     /// Who can run into whom.
///     #[derive(PartialOrd)]
///     pub enum Layer {
///         /// What says nothing else.
///         Scenery,
///         Red,
///         Blue,
///         Debris = 31,
///     }
/// }
///
/// // Red ones meet the blue and what stands around.
/// let red = CollisionLayers::new(Layer::Red, Layer::Blue | Layer::Scenery);
/// const BLUE: CollisionLayers = CollisionLayers::from_masks(Layer::Blue.mask(), LayerMask::ALL);
/// assert_eq!((red.memberships, BLUE.memberships), (LayerMask(0b10), LayerMask(0b100)));
/// // Debris is there to be seen.
/// let debris = CollisionLayers::new([Layer::Debris], []);
/// assert!(debris.filters.is_empty());
/// ```
///
/// ```compile_fail
/// bevy_octree::collision_layers! {
///     enum Layer { TooFar = 32 }
/// }
/// ```
#[macro_export]
macro_rules! collision_layers {
    (
        $(#[$attribute:meta])*
        $visibility:vis enum $name:ident {
            $($(#[$($layer_attribute:tt)*])* $layer:ident $(= $index:expr)?),+ $(,)?
        }
    ) => {
        $(#[$attribute])*
        #[derive(
            ::core::clone::Clone,
            ::core::marker::Copy,
            ::core::fmt::Debug,
            ::core::cmp::PartialEq,
            ::core::cmp::Eq,
            ::core::hash::Hash,
        )]
        #[repr(u32)]
        $visibility enum $name {
            $($(#[$($layer_attribute)*])* $layer $(= $index)?),+
        }

        $($crate::__check_layer! { $(#[$($layer_attribute)*])* $name $layer })+

        impl $name {
            /// Returns the set of this layer alone.
            #[allow(dead_code, reason = "for constants, which not everyone has")]
            #[must_use]
            $visibility const fn mask(self) -> $crate::filters::LayerMask {
                $crate::filters::LayerMask::layer(self as u32)
            }
        }

        impl $crate::filters::CollisionLayer for $name {
            fn index(self) -> u32 {
                self as u32
            }
        }

        impl<__Layers> ::core::ops::BitOr<__Layers> for $name
        where
            __Layers: ::core::convert::Into<$crate::filters::LayerMask>,
        {
            type Output = $crate::filters::LayerMask;

            fn bitor(self, other: __Layers) -> $crate::filters::LayerMask {
                self.mask() | other
            }
        }
    };
}

/// Asserts that a variant has the number of a layer, where it is compiled at all: of its
/// attributes, `cfg` counts here too.
#[doc(hidden)]
#[macro_export]
macro_rules! __check_layer {
    (#[cfg($($condition:tt)*)] $($rest:tt)+) => {
        #[cfg($($condition)*)]
        $crate::__check_layer! { $($rest)+ }
    };
    (#[$($attribute:tt)*] $($rest:tt)+) => {
        $crate::__check_layer! { $($rest)+ }
    };
    ($name:ident $layer:ident) => {
        const _: () = ::core::assert!(
            ($name::$layer as u32) < 32,
            "a collision layer has a number from 0 to 31"
        );
    };
}

pub(super) fn register(app: &mut App) {
    app.register_type::<LayerMask>();
}

#[cfg(test)]
mod tests {
    use bevy::reflect::{
        TypeRegistry,
        serde::{TypedReflectDeserializer, TypedReflectSerializer},
    };
    use serde::de::{
        DeserializeSeed,
        value::{Error, MapDeserializer},
    };

    use super::*;
    use crate::filters::CollisionLayers;

    #[test]
    fn masks_are_sets() {
        let (a, b) = (LayerMask(0b0110), LayerMask(0b0011));
        assert_eq!(
            [a | b, a & b, a ^ b, !!a],
            [0b0111, 0b0010, 0b0101, 0b0110].map(LayerMask)
        );
        assert!(
            a.contains(LayerMask::layer(2))
                && !a.contains(b)
                && a.contains(LayerMask::NONE)
                && a.intersects(b)
        );
        assert!(LayerMask::ALL.contains(a) && !LayerMask::NONE.intersects(LayerMask::ALL));
        let mut c = a;
        c |= b;
        c &= !LayerMask::layer(0);
        c ^= LayerMask::layer(31);
        assert_eq!(c, LayerMask(1 << 31 | 0b0110));
        assert_eq!(
            [32, 33, u32::MAX].map(LayerMask::layer),
            [LayerMask::NONE; 3]
        );
        assert_eq!([a, b].into_iter().collect::<LayerMask>(), LayerMask(0b0111));
        assert_eq!(format!("{a:?}"), "LayerMask(0b110)");
    }

    #[test]
    fn sets_are_constants() {
        const A: LayerMask = LayerMask(0b0110);
        const ALL: [LayerMask; 3] = [
            A.union(LayerMask(0b0011)),
            A.intersection(LayerMask(0b0011)),
            A.difference(LayerMask(0b0011)),
        ];
        assert_eq!(ALL, [0b0111, 0b0010, 0b0100].map(LayerMask));
        assert!(LayerMask::NONE.is_empty() && !A.is_empty());
    }

    /// As a scene saves it, and an editor writes it.
    #[test]
    fn layers_are_numbers_where_they_are_reflected() {
        let mut registry = TypeRegistry::new();
        registry.register::<CollisionLayers>();
        let registration = registry
            .get_with_type_path("bevy_octree::CollisionLayers")
            .unwrap();
        let bits = [("memberships", 2_u32), ("filters", 5)].into_iter();
        let read = TypedReflectDeserializer::new(registration, &registry)
            .deserialize(MapDeserializer::<_, Error>::new(bits))
            .unwrap();
        let layers = CollisionLayers::from_reflect(&*read).unwrap();
        assert_eq!(layers, CollisionLayers::from_bits(2, 5));
        let written =
            fmt::from_fn(|f| TypedReflectSerializer::new(&layers.filters, &registry).serialize(f));
        assert_eq!(written.to_string(), "5");
    }
}
