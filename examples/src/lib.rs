//! How to use frettrace, in reading order.
