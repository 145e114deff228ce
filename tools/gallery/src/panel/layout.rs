//! What stands where.

use bevy::{
    prelude::*,
    ui_widgets::{
        Button, RadioButton, RadioGroup, Slider, SliderRange, SliderStep, SliderThumb, SliderValue,
        TrackClick,
    },
};

use super::{
    Root,
    figures::Said,
    graph::Graph,
    widgets::{Choice, Knob, KnobLabel, Press},
};
use crate::{
    controls::KEYS,
    look::State,
    settings::{Leaves, Search},
};

/// The width of the panel.
pub const WIDTH: f32 = 292.0;
/// What is written large, and small.
const LARGE: f32 = 17.0;
const SMALL: f32 = 11.5;
/// The colours of the panel.
const GROUND: Color = Color::srgba(0.05, 0.06, 0.08, 0.88);
const WORDS: Color = Color::srgb(0.86, 0.88, 0.92);
const QUIET: Color = Color::srgb(0.58, 0.62, 0.70);
pub const RAISED: Color = Color::srgb(0.16, 0.19, 0.25);
const ACCENT: Color = Color::srgb(0.34, 0.71, 0.91);

/// Spawns the panel.
pub fn spawn(mut commands: Commands, graph: Res<Graph>) {
    let root = (
        Root,
        Node {
            position_type: PositionType::Absolute,
            left: px(0.0),
            top: px(0.0),
            width: px(WIDTH),
            height: percent(100.0),
            padding: UiRect::all(px(10.0)),
            flex_direction: FlexDirection::Column,
            row_gap: px(4.0),
            overflow: Overflow::clip(),
            ..default()
        },
        BackgroundColor(GROUND),
    );
    commands.spawn(root).with_children(|panel| {
        panel.spawn((Said::Title, words("", LARGE, WORDS)));
        panel.spawn((Said::About, words("", SMALL, QUIET)));
        panel.spawn(row(4.0)).with_children(|row| {
            for (press, label) in Press::ALL {
                button(row, press, label);
            }
        });
        for knob in Knob::ALL {
            slider(panel, knob);
        }
        panel.spawn(words("Broad phase", SMALL, QUIET));
        panel.spawn((RadioGroup, row(4.0))).with_children(|group| {
            for (search, label) in Search::ALL {
                radio(group, Choice::Search(search), label);
            }
        });
        panel.spawn(words("Leaves of the octree", SMALL, QUIET));
        panel.spawn((RadioGroup, row(4.0))).with_children(|group| {
            for (leaves, label) in Leaves::ALL {
                radio(group, Choice::Leaves(leaves), label);
            }
        });
        panel.spawn((Said::Counts, words("", SMALL, WORDS)));
        panel.spawn((
            ImageNode::new(graph.image.clone()),
            Node {
                width: percent(100.0),
                height: px(Graph::HEIGHT as f32),
                flex_shrink: 0.0,
                ..default()
            },
        ));
        panel.spawn(row(7.0)).with_children(|legend| {
            for (name, color) in Graph::STAGES {
                legend.spawn(words(
                    name,
                    SMALL - 1.5,
                    Color::srgb_u8(color[0], color[1], color[2]),
                ));
            }
        });
        panel.spawn((Said::Times, words("", SMALL, WORDS)));
        panel.spawn((Said::Caption, words("", SMALL, ACCENT)));
        panel.spawn(row(8.0)).with_children(|legend| {
            for (state, name) in State::ALL {
                legend.spawn(words(
                    name,
                    SMALL - 1.0,
                    state.color().with_alpha(1.0).lighter(0.1),
                ));
            }
        });
        panel.spawn(words(KEYS, SMALL - 1.5, QUIET));
    });
}

fn words(text: &str, size: f32, color: Color) -> impl Bundle {
    (
        Text::new(text),
        TextFont::from_font_size(size),
        TextColor(color),
        Node {
            flex_shrink: 0.0,
            ..default()
        },
    )
}

fn row(gap: f32) -> Node {
    Node {
        flex_wrap: FlexWrap::Wrap,
        column_gap: px(gap),
        row_gap: px(3.0),
        flex_shrink: 0.0,
        ..default()
    }
}

fn raised(grow: f32) -> impl Bundle {
    (
        Node {
            padding: UiRect::axes(px(7.0), px(3.0)),
            flex_grow: grow,
            justify_content: JustifyContent::Center,
            border_radius: BorderRadius::all(px(4.0)),
            ..default()
        },
        BackgroundColor(RAISED),
    )
}

fn button(row: &mut ChildSpawnerCommands, press: Press, label: &str) {
    row.spawn((Button, press, raised(1.0)))
        .with_child(words(label, SMALL, WORDS));
}

fn radio(group: &mut ChildSpawnerCommands, choice: Choice, label: &str) {
    group
        .spawn((RadioButton, choice, raised(0.0)))
        .with_child(words(label, SMALL, WORDS));
}

fn slider(panel: &mut ChildSpawnerCommands, knob: Knob) {
    panel.spawn((KnobLabel(knob), words("", SMALL, QUIET)));
    let slider = Slider {
        track_click: TrackClick::Snap,
        ..default()
    };
    let widget = (
        slider,
        SliderValue(0.0),
        SliderRange::new(0.0, 1.0),
        SliderStep(1.0 / 16.0),
        knob,
    );
    let track = Node {
        width: percent(100.0),
        height: px(12.0),
        flex_shrink: 0.0,
        ..default()
    };
    panel.spawn((widget, track)).with_children(|slider| {
        slider.spawn((
            Node {
                position_type: PositionType::Absolute,
                top: px(4.0),
                height: px(4.0),
                left: px(0.0),
                right: px(0.0),
                border_radius: BorderRadius::all(px(2.0)),
                ..default()
            },
            BackgroundColor(RAISED),
        ));
        // As far as the thumb can go: its left edge is at a share of this.
        let reach = Node {
            position_type: PositionType::Absolute,
            left: px(0.0),
            right: px(12.0),
            top: px(0.0),
            bottom: px(0.0),
            ..default()
        };
        slider.spawn(reach).with_child((
            SliderThumb,
            Node {
                position_type: PositionType::Absolute,
                width: px(12.0),
                height: px(12.0),
                border_radius: BorderRadius::all(px(6.0)),
                ..default()
            },
            BackgroundColor(ACCENT),
        ));
    });
}
