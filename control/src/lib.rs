//! Command plans. Knows files, never the simulator.
