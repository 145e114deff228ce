//! The target `meshes` as a program.

#![cfg_attr(fuzzing, no_main)]

fuzz::program!(meshes);
