//! How far to trust frettrace.
