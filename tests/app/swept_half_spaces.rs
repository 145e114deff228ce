//! Half-spaces that move: looked at all along their way. Needs the feature `rapier`.
use crate::common;

use bevy::prelude::*;
use bevy_octree::{narrow_phase::Shape, prelude::*};
use bevy_rapier3d::prelude::Collider;
use common::*;

fn half_space() -> CollisionShape {
    Shape::from(&Collider::halfspace(Vec3::Y).unwrap()).into()
}

/// A roof that comes by: at the start it falls to the left, at the end to the right, and on the way
/// it is flat.
#[test]
fn a_half_space_meets_what_it_passes_as_it_turns() {
    for swept in [false, true] {
        let mut app = app(BroadPhaseMethod::default());
        let at = |side: f32| {
            Transform::from_xyz(5.0 * side, 0.0, 0.0).with_rotation(Quat::from_rotation_z(side))
        };
        let roof = app.world_mut().spawn((half_space(), at(-1.0))).id();
        if swept {
            app.world_mut().entity_mut(roof).insert(Swept::default());
        }
        let ball = |app: &mut App, y: f32| {
            app.world_mut()
                .spawn((
                    CollisionShape::sphere(0.1),
                    Transform::from_xyz(0.0, y, 0.0),
                ))
                .id()
        };
        let [below, _above] = [-1.0, 1.0].map(|y| ball(&mut app, y));
        tick(&mut app, 1);
        assert!(contacts(&app).is_empty());
        *get_mut::<Transform>(&mut app, roof) = at(1.0);
        tick(&mut app, 1);
        let expected = if swept { vec![[roof, below]] } else { vec![] };
        assert_eq!(contacts(&app), expected);
        tick(&mut app, 1);
        assert!(contacts(&app).is_empty());
        assert_eq!(
            messages_about(&app, [roof, below]),
            (usize::from(swept), usize::from(swept))
        );
    }
}

/// A floor that sinks and rises in one go meets what is where it ends.
#[test]
fn a_half_space_meets_what_it_comes_to() {
    let mut app = app(BroadPhaseMethod::default());
    let floor = app
        .world_mut()
        .spawn((
            half_space(),
            Swept::default(),
            Transform::from_xyz(0.0, -10.0, 0.0),
        ))
        .id();
    let ball = app
        .world_mut()
        .spawn((
            CollisionShape::sphere(0.1),
            Transform::from_xyz(3.0, 0.0, 0.0),
        ))
        .id();
    tick(&mut app, 1);
    get_mut::<Transform>(&mut app, floor).translation.y = 10.0;
    tick(&mut app, 1);
    assert_eq!(contacts(&app), [[floor, ball]]);
    let time = app
        .world()
        .resource::<Contacts>()
        .iter()
        .next()
        .unwrap()
        .time;
    assert!((time - 9.9 / 20.0).abs() < 1e-3, "{time}");
}
