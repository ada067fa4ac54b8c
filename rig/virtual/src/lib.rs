//! A virtual rig and a virtual arm with physics of their own, and emulators of their ports.
//!
//! They replace hardware: nothing here is shared with the twin that is fitted to their recordings.

#[cfg(unix)]
pub mod emulator;
pub mod virtual_arm;
pub mod virtual_rig;
