//! Quasi-static twin of a tendon-driven robot.
