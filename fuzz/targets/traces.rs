//! The target `traces` as a program.

#![cfg_attr(fuzzing, no_main)]

fuzz::program!(traces);
