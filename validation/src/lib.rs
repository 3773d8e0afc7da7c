//! How far to trust frettrace.

pub mod architecture;
