//! Scene files: read or refused with the place of the fault, written and read again, and spawned.

use bevy::prelude::*;
use bevy_octree::{
    motion::{Interpolation, MotionSettings, Outside, Step, TrackStart},
    narrow_phase::{NarrowPhase, Placed, Workspace},
    prelude::*,
    scene::{Content, Motion, ObjectDescription, SceneDescription, SceneError, TestSet},
};

use crate::{data, source::Source};

/// Scenes of more objects are not spawned.
const MOST_OBJECTS: usize = 20;
/// In an app, so many ticks.
const TICKS: usize = 3;

/// Reads the bytes as a scene file; or, by the first one, writes a scene made of them.
pub fn run(bytes: &[u8]) {
    let mut source = Source::new(bytes);
    if source.byte() & 1 == 0 {
        check_text(&String::from_utf8_lossy(source.rest()));
    } else {
        check_scene(&scene(&mut source));
    }
}

fn scene(source: &mut Source) -> SceneDescription {
    source.may_go_wild();
    let content = match source.byte() {
        0..40 => Content::TestSet(TestSet {
            rings: match source.byte() {
                255 => source.bits(),
                few => u32::from(few & 3),
            },
            side: source.size(),
            spacing: source.size(),
            gap: source.size(),
            setback: source.size(),
            speed: source.size(),
        }),
        _ => Content::Objects(source.list(6, object)),
    };
    SceneDescription {
        name: name(source),
        ticks_per_second: match source.byte() {
            0..128 => 64.0,
            128..192 => f64::from(source.size()),
            _ => f64::from_bits(u64::from(source.bits()) << 32),
        },
        content,
    }
}

fn name(source: &mut Source) -> String {
    let name = source.list(8, Source::byte);
    String::from_utf8_lossy(&name).into_owned()
}

fn object(source: &mut Source) -> ObjectDescription {
    let motion = match source.below(4) {
        0 | 1 => Motion::Static,
        2 => Motion::Velocity(source.vector()),
        _ => track(source).map_or(Motion::Static, Motion::Track),
    };
    let is_on_track = matches!(motion, Motion::Track(_));
    ObjectDescription {
        name: source.bit().then(|| name(source)),
        position: if is_on_track && source.byte() != 255 {
            Vec3::ZERO
        } else {
            source.vector()
        },
        rotation: source.vector() * 20.0,
        scale: source.scale(),
        motion,
        ..ObjectDescription::new(data::description(source, 0))
    }
}

fn track(source: &mut Source) -> Option<PositionTrack> {
    let mut tick = 0;
    let keyframes = source.list(5, |source| {
        let step = match source.byte() {
            255 => u64::from(source.bits()) << (source.byte() & 31),
            step => u64::from(step & 15),
        };
        tick = u64::saturating_add(tick, step);
        (tick, source.vector())
    });
    let ease = [
        EaseFunction::QuadraticInOut,
        EaseFunction::ElasticOut,
        EaseFunction::Steps(3, JumpAt::Both),
    ];
    let interpolation = match source.below(4) {
        0 => Interpolation::Step,
        1 => Interpolation::Linear,
        2 => Interpolation::Smooth,
        _ => Interpolation::Ease(source.choose(&ease)),
    };
    let outside = source.choose(&[Outside::Hold, Outside::Loop]);
    let start = match source.below(4) {
        0 => TrackStart::Now,
        1 => TrackStart::At(u64::MAX - u64::from(source.byte())),
        _ => TrackStart::At(u64::from(source.byte() & 3)),
    };
    let track = PositionTrack::new(keyframes).ok()?;
    let track = track
        .with_interpolation(interpolation)
        .with_outside(outside);
    Some(track.with_start(start))
}

/// A text is a scene that is valid, or the error says where it is not.
fn check_text(text: &str) {
    match SceneDescription::parse(text) {
        Ok(scene) => {
            assert_eq!(scene.validate(), Ok(()));
            check_scene(&scene);
        }
        Err(error) => {
            let told = error.to_string();
            assert!(told.starts_with("scene text:"), "{told}");
            if let SceneError::Parse {
                line,
                column,
                message,
                ..
            } = error
            {
                assert!(!message.is_empty());
                assert!(line >= 1 && column >= 1, "{told}");
                let lines = text.split('\n').count();
                assert!(line <= lines, "{told}: there are {lines} lines");
            }
        }
    }
}

fn check_scene(scene: &SceneDescription) {
    let is_valid = scene.validate().is_ok();
    let text = scene.to_ron().expect("all scenes can be written");
    match SceneDescription::parse(&text) {
        Ok(again) => {
            assert!(is_valid, "was read, though it is not valid:\n{text}");
            assert_eq!(again, *scene, "\n{text}");
        }
        Err(error) => assert!(!is_valid, "{error}\n{text}"),
    }
    if scene.object_count() <= MOST_OBJECTS {
        check_spawned(scene, is_valid);
    }
}

/// An app with the scene in it: each object is there, and the contacts are those of all pairs.
fn check_spawned(scene: &SceneDescription, is_valid: bool) {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(MotionSettings {
            step: Step::Seconds(1.0 / 64.0),
        });
    let spawned = scene.spawn(&mut app.world_mut().commands());
    app.world_mut().flush();
    let entities = match spawned {
        Ok(entities) => entities,
        Err(error) => return assert!(!is_valid, "{error}"),
    };
    assert!(is_valid);
    assert_eq!(entities.len(), scene.object_count());
    for (entity, object) in entities.iter().zip(scene.objects()) {
        let at = app.world().get::<Transform>(*entity);
        assert_eq!(at, Some(&object.transform()));
    }
    for _ in 0..TICKS {
        app.update();
        check_contacts(&app, &entities);
    }
}

/// Within the tolerance, nothing is promised.
fn check_contacts(app: &App, entities: &[Entity]) {
    let world = app.world();
    let tolerance = world.resource::<NarrowPhase>().tolerance();
    let [strict, loose] = [0.5, 2.0]
        .map(|share| NarrowPhase::new(tolerance * share).expect("a share of a tolerance is one"));
    let contacts = world.resource::<Contacts>();
    let mut workspace = Workspace::default();
    let placed = |entity| {
        let shape = world.get::<CollisionShape>(entity)?;
        Some(Placed::new(&shape.0, world.get::<Transform>(entity)?))
    };
    for (number, a) in entities.iter().enumerate() {
        for b in &entities[number + 1..] {
            let (Some(at_a), Some(at_b)) = (placed(*a), placed(*b)) else {
                continue;
            };
            // What bounces has moved on since.
            let have_bounced = [*a, *b]
                .iter()
                .any(|end| world.get::<Bounce>(*end).is_some());
            if have_bounced {
                continue;
            }
            if contacts.contains(*a, *b) {
                assert!(
                    loose.intersects(at_a, at_b, &mut workspace),
                    "{at_a:?}\n{at_b:?}"
                );
            } else {
                assert!(
                    !strict.intersects(at_a, at_b, &mut workspace),
                    "{at_a:?}\n{at_b:?}"
                );
            }
        }
    }
}
