//! Fits any model that gives residual and Jacobian; the contact-level friction fit; beam-unaware.
