//! Inverse harmonic balance: accelerations to contact forces and slip; friction-law-free.
