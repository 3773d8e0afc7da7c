//! Candidate effects and the evidence for them: what the model lacks; file-unaware.
