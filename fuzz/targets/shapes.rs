//! The target `shapes` as a program.

#![cfg_attr(fuzzing, no_main)]

fuzz::program!(shapes);
