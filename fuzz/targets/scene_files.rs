//! The target `scene_files` as a program.

#![cfg_attr(fuzzing, no_main)]

fuzz::program!(scene_files);
