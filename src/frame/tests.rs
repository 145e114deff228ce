use super::*;
use proptest::prelude::*;

fn vectors(reach: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-reach..reach).prop_map(Vec3::from)
}

/// Turned, stretched, mirrored; with a child of its own, sheared.
fn places() -> impl Strategy<Value = Transform> {
    let scale = prop::array::uniform3(prop_oneof![0.25f32..4.0, -4f32..-0.25]).prop_map(Vec3::from);
    (vectors(10.0), vectors(2.0), scale).prop_map(|(translation, turn, scale)| Transform {
        translation,
        rotation: Quat::from_scaled_axis(turn),
        scale,
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// What moves for a moment, together with all that it hangs on, moves as far in the world
    /// as the velocity says.
    #[test]
    fn a_velocity_in_the_world_is_what_moves_there(
        chain in prop::collection::vec((places(), vectors(5.0)), 1..4),
        (place, own) in (vectors(3.0), vectors(5.0)),
    ) {
        let mut world = World::new();
        let mut parent = None;
        for (transform, velocity) in &chain {
            let entity = world.spawn((*transform, Velocity(*velocity))).id();
            if let Some(parent) = parent.replace(entity) {
                world.entity_mut(entity).insert(ChildOf(parent));
            }
        }
        let frame = Frame::of(parent.unwrap(), |entity| Ancestor::of(entity, &world));
        let in_world = |seconds: f64| chain.iter().rev().fold(place.as_dvec3() + own.as_dvec3() * seconds, |at, (t, v)| {
            let turned = t.rotation.as_dquat() * (t.scale.as_dvec3() * at);
            turned + t.translation.as_dvec3() + v.as_dvec3() * seconds
        });
        let moved = (in_world(1.0) - in_world(0.0)).as_vec3();
        let size = 1.0 + moved.length();
        prop_assert!(frame.velocity_in_world(own).distance(moved) < 1e-4 * size);
        let back = [frame.own_velocity(moved), frame.own_position(in_world(0.0).as_vec3())].map(Option::unwrap);
        prop_assert!(back[0].distance(own) < 1e-2 && back[1].distance(place) < 1e-2, "{back:?}");
    }
}

#[test]
fn what_goes_round_in_circles_or_is_flat_has_an_answer() {
    let mut world = World::new();
    let round = Ancestor {
        transform: Transform::IDENTITY,
        velocity: Vec3::X,
        parent: None,
    };
    let parent = world
        .spawn(Transform::from_scale(Vec3::new(1.0, 0.0, 1.0)))
        .id();
    let look = |_| {
        Some(Ancestor {
            parent: Some(parent),
            ..round
        })
    };
    assert!(Frame::of(parent, look).depth() < 4);
    let flat = Frame::of(parent, |entity| Ancestor::of(entity, &world));
    assert_eq!(
        (flat.leads_back(), flat.own_velocity(Vec3::X)),
        (false, None)
    );
    assert_eq!(flat.velocity_in_world(Vec3::ONE), Vec3::new(1.0, 0.0, 1.0));
}
