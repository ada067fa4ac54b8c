//! The tracker: 6-DOF poses over OpenIGTLink.
