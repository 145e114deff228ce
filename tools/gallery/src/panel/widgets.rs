//! What buttons, sliders and radio buttons do, and how they follow what is chosen by keys.

use bevy::{
    picking::hover::Hovered,
    prelude::*,
    ui::{Checked, Pressed},
    ui_widgets::{Activate, SliderDragState, SliderThumb, SliderValue, ValueChange},
};

use super::layout::RAISED;
use crate::{
    play::Play,
    scene::{Gallery, Scene},
    settings::{Leaves, Search, Settings},
};

/// What a button does.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[require(Hovered)]
pub enum Press {
    /// Shows the scene before.
    Before,
    /// Stops, or goes on.
    Pause,
    /// Runs a tick.
    Step,
    /// Begins anew.
    Restart,
    /// Shows the scene after.
    Next,
}

impl Press {
    /// All of them, with what stands on them.
    pub const ALL: [(Self, &str); 5] = [
        (Self::Before, "<"),
        (Self::Pause, "pause"),
        (Self::Step, "step"),
        (Self::Restart, "reset"),
        (Self::Next, ">"),
    ];
}

/// What a slider is for.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knob {
    /// How fast ticks follow each other.
    Speed,
    /// How many objects a leaf lists before it splits.
    MaxObjects,
    /// The number of objects.
    Objects,
}

/// The words above a slider.
#[derive(Component, Clone, Copy, Debug)]
pub struct KnobLabel(pub Knob);

impl Knob {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Speed, Self::MaxObjects, Self::Objects];

    /// From where to where it goes; in between by factors.
    fn limits(self, scene: &Scene) -> [f32; 2] {
        match self {
            Self::Speed => Play::SPEEDS,
            Self::MaxObjects => [1.0, Settings::MOST_MAX_OBJECTS as f32],
            Self::Objects => {
                let most = scene.objects.map_or(0, |objects| objects.most);
                [Settings::LEAST_OBJECTS, most.max(Settings::LEAST_OBJECTS)].map(|n| n as f32)
            }
        }
    }

    fn value(self, play: &Play, settings: &Settings) -> f32 {
        match self {
            Self::Speed => play.speed,
            Self::MaxObjects => settings.max_objects as f32,
            Self::Objects => settings.objects as f32,
        }
    }

    /// The place of the thumb, from 0 to 1.
    fn place(self, play: &Play, settings: &Settings, scene: &Scene) -> f32 {
        let [least, most] = self.limits(scene);
        if most <= least {
            return 0.0;
        }
        let value = self.value(play, settings).clamp(least, most);
        (value / least).ln() / (most / least).ln()
    }

    fn label(self, play: &Play, settings: &Settings, scene: &Scene) -> String {
        match self {
            Self::Speed => format!("Speed: {}", play.speed),
            Self::MaxObjects => format!("N, objects per leaf: {}", settings.max_objects),
            Self::Objects if scene.objects.is_some() => format!("Objects: {}", settings.objects),
            Self::Objects => "Objects: as the scene has it".to_owned(),
        }
    }
}

/// What a radio button chooses.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[require(Hovered)]
pub enum Choice {
    /// How pairs are searched for.
    Search(Search),
    /// Which leaves are drawn.
    Leaves(Leaves),
}

impl Choice {
    fn is_chosen(self, settings: &Settings) -> bool {
        match self {
            Self::Search(search) => settings.search == search,
            Self::Leaves(leaves) => settings.leaves == leaves,
        }
    }
}

/// Adds what the widgets do.
pub fn plugin(app: &mut App) {
    app.add_observer(press)
        .add_observer(choose)
        .add_observer(turn_knob)
        .add_systems(
            Update,
            (follow_choices, follow_knobs, label_knobs, show_pointer),
        );
}

fn press(
    activate: On<Activate>,
    presses: Query<&Press>,
    mut play: ResMut<Play>,
    mut gallery: ResMut<Gallery>,
) {
    match presses.get(activate.entity) {
        Ok(Press::Before) => gallery.turn(-1),
        Ok(Press::Next) => gallery.turn(1),
        Ok(Press::Restart) => gallery.restart(),
        Ok(Press::Pause) => play.is_paused = !play.is_paused,
        Ok(Press::Step) => {
            play.is_paused = true;
            play.pending += 1;
        }
        Err(_) => {}
    }
}

fn choose(
    change: On<ValueChange<Entity>>,
    choices: Query<&Choice>,
    mut settings: ResMut<Settings>,
) {
    match choices.get(change.value) {
        Ok(Choice::Search(search)) => settings.search = *search,
        Ok(Choice::Leaves(leaves)) => settings.leaves = *leaves,
        Err(_) => {}
    }
}

fn turn_knob(
    change: On<ValueChange<f32>>,
    knobs: Query<&Knob>,
    mut play: ResMut<Play>,
    mut settings: ResMut<Settings>,
    mut gallery: ResMut<Gallery>,
    mut commands: Commands,
) {
    let Ok(knob) = knobs.get(change.source) else {
        return;
    };
    commands
        .entity(change.source)
        .insert(SliderValue(change.value));
    let scene = gallery.scene();
    let [least, most] = knob.limits(scene);
    let value = least * (most / least).powf(change.value);
    match knob {
        // By steps that can be read.
        Knob::Speed => play.speed = value.log2().round().exp2(),
        Knob::MaxObjects => settings.max_objects = value.round() as u32,
        Knob::Objects if scene.objects.is_some() => {
            let objects = value.round() as usize;
            // A click on the track has no end that would be final.
            if std::mem::replace(&mut settings.objects, objects) != objects || change.is_final {
                gallery.restart();
            }
        }
        Knob::Objects => {}
    }
}

fn follow_choices(
    settings: Res<Settings>,
    choices: Query<(Entity, &Choice, Has<Checked>)>,
    mut commands: Commands,
) {
    for (entity, choice, is_checked) in &choices {
        match (choice.is_chosen(&settings), is_checked) {
            (true, false) => _ = commands.entity(entity).insert(Checked),
            (false, true) => _ = commands.entity(entity).remove::<Checked>(),
            _ => {}
        }
    }
}

fn follow_knobs(
    play: Res<Play>,
    settings: Res<Settings>,
    gallery: Res<Gallery>,
    sliders: Query<(Entity, &Knob, &Children, &SliderValue, &SliderDragState)>,
    mut commands: Commands,
    reaches: Query<&Children>,
    mut thumbs: Query<&mut Node, With<SliderThumb>>,
) {
    let scene = gallery.scene();
    for (slider, knob, children, value, drag) in &sliders {
        let share = knob.place(&play, &settings, scene);
        // Where the next drag begins.
        if !drag.dragging && *value != SliderValue(share) {
            commands.entity(slider).insert(SliderValue(share));
        }
        let place = percent(100.0 * share);
        for thumb in children
            .iter()
            .flat_map(|reach| reaches.get(reach))
            .flatten()
        {
            if let Ok(mut thumb) = thumbs.get_mut(*thumb)
                && thumb.left != place
            {
                thumb.left = place;
            }
        }
    }
}

fn label_knobs(
    play: Res<Play>,
    settings: Res<Settings>,
    gallery: Res<Gallery>,
    mut labels: Query<(&KnobLabel, &mut Text)>,
) {
    for (KnobLabel(knob), mut text) in &mut labels {
        text.set_if_neq(Text(knob.label(&play, &settings, gallery.scene())));
    }
}

type Raised = Or<(With<Press>, With<Choice>)>;

type Looks = (
    &'static Hovered,
    Has<Pressed>,
    Has<Checked>,
    &'static mut BackgroundColor,
);

/// What is under the pointer, pressed or chosen looks so.
fn show_pointer(mut widgets: Query<Looks, Raised>) {
    for (hovered, is_pressed, is_checked, mut color) in &mut widgets {
        let wanted = match (is_pressed, is_checked, hovered.get()) {
            (true, ..) => RAISED.lighter(0.25),
            (_, true, _) => Color::srgb(0.10, 0.36, 0.52),
            (.., true) => RAISED.lighter(0.1),
            _ => RAISED,
        };
        color.set_if_neq(BackgroundColor(wanted));
    }
}
