//! The program `frettrace`.

fn main() {}
