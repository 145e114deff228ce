//! The target `operations` as a program.

#![cfg_attr(fuzzing, no_main)]

fuzz::program!(operations);
