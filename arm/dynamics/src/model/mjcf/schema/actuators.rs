//! The part of the table for actuators.

use super::MjcfEntry;
use super::Use::{Only, Read, Without};

const NAMES: &str = "names and numbers of the user's own";
const ACTUATOR: &str = "joints are driven by torques, not by MuJoCo's actuators";
const ACTUATOR_INERTIA: &str =
    "what an actuator adds to its joint is read from the joint alone: set armature and damping of the joint";

pub(super) const ENTRIES: &[MjcfEntry] = &[
    MjcfEntry { id: "actuator", tag: "actuator", within: "mujoco", role: Read, attributes: &[] },
    MjcfEntry {
        id: "actuator/general",
        tag: "general",
        within: "actuator default",
        role: Read,
        attributes: &[
            (
                Without(ACTUATOR),
                "actdim actearly actlimited actrange biasprm biastype body cranklength cranksite \
         ctrllimited ctrlrange delay dynprm dyntype ffrange forcelimited forcerange gainprm \
         gaintype gear inheritrange input interp joint jointinparent lengthrange nsample refsite \
         site slidersite tendon velrange",
            ),
            (Only("0", ACTUATOR_INERTIA), "armature damping"),
            (Read, "class"),
            (Without(NAMES), "group name user"),
        ],
    },
    MjcfEntry {
        id: "actuator/motor",
        tag: "motor",
        within: "actuator default",
        role: Read,
        attributes: &[
            (Only("0", ACTUATOR_INERTIA), "armature damping"),
            (Read, "class"),
            (
                Without(ACTUATOR),
                "cranklength cranksite ctrllimited ctrlrange delay forcelimited forcerange gear interp \
         joint jointinparent lengthrange nsample refsite site slidersite tendon",
            ),
            (Without(NAMES), "group name user"),
        ],
    },
    MjcfEntry {
        id: "actuator/position",
        tag: "position",
        within: "actuator default",
        role: Read,
        attributes: &[
            (Only("0", ACTUATOR_INERTIA), "armature damping"),
            (Read, "class"),
            (
                Without(ACTUATOR),
                "cranklength cranksite ctrllimited ctrlrange dampratio delay forcelimited forcerange gear \
         inheritrange interp joint jointinparent kp kv lengthrange nsample refsite site \
         slidersite tendon timeconst",
            ),
            (Without(NAMES), "group name user"),
        ],
    },
    MjcfEntry {
        id: "actuator/velocity",
        tag: "velocity",
        within: "actuator default",
        role: Read,
        attributes: &[
            (Only("0", ACTUATOR_INERTIA), "armature damping"),
            (Read, "class"),
            (
                Without(ACTUATOR),
                "cranklength cranksite ctrllimited ctrlrange delay forcelimited forcerange gear interp \
         joint jointinparent kv lengthrange nsample refsite site slidersite tendon",
            ),
            (Without(NAMES), "group name user"),
        ],
    },
    MjcfEntry {
        id: "actuator/intvelocity",
        tag: "intvelocity",
        within: "actuator default",
        role: Read,
        attributes: &[
            (
                Without(ACTUATOR),
                "actlimited actrange cranklength cranksite ctrllimited ctrlrange dampratio delay \
         forcelimited forcerange gear inheritrange interp joint jointinparent kp kv lengthrange \
         nsample refsite site slidersite tendon",
            ),
            (Only("0", ACTUATOR_INERTIA), "armature damping"),
            (Read, "class"),
            (Without(NAMES), "group name user"),
        ],
    },
    MjcfEntry {
        id: "actuator/orientation",
        tag: "orientation",
        within: "actuator default",
        role: Read,
        attributes: &[
            (Read, "class"),
            (
                Without(ACTUATOR),
                "ctrlrange dampratio delay forcelimited forcerange input interp joint kp kv nsample \
         refsite site",
            ),
            (Without(NAMES), "group name user"),
        ],
    },
    MjcfEntry {
        id: "actuator/pid",
        tag: "pid",
        within: "actuator default",
        role: Read,
        attributes: &[
            (Only("0", ACTUATOR_INERTIA), "armature damping"),
            (Read, "class"),
            (
                Without(ACTUATOR),
                "cranklength cranksite ctrllimited ctrlrange dampratio delay ffrange forcelimited \
         forcerange gear imax inheritrange input interp joint jointinparent ki kp kv lengthrange \
         nsample posrange refsite site slewmax slidersite tendon velrange",
            ),
            (Without(NAMES), "group name user"),
        ],
    },
    MjcfEntry {
        id: "actuator/damper",
        tag: "damper",
        within: "actuator default",
        role: Read,
        attributes: &[
            (Only("0", ACTUATOR_INERTIA), "armature damping"),
            (Read, "class"),
            (
                Without(ACTUATOR),
                "cranklength cranksite ctrlrange delay forcelimited forcerange gear interp joint \
         jointinparent kv lengthrange nsample refsite site slidersite tendon",
            ),
            (Without(NAMES), "group name user"),
        ],
    },
    MjcfEntry {
        id: "actuator/cylinder",
        tag: "cylinder",
        within: "actuator default",
        role: Read,
        attributes: &[
            (
                Without(ACTUATOR),
                "area bias cranklength cranksite ctrllimited ctrlrange delay diameter forcelimited \
         forcerange gear interp joint jointinparent lengthrange nsample refsite site slidersite \
         tendon timeconst",
            ),
            (Only("0", ACTUATOR_INERTIA), "armature damping"),
            (Read, "class"),
            (Without(NAMES), "group name user"),
        ],
    },
    MjcfEntry {
        id: "actuator/muscle",
        tag: "muscle",
        within: "actuator default",
        role: Read,
        attributes: &[
            (Only("0", ACTUATOR_INERTIA), "armature damping"),
            (Read, "class"),
            (
                Without(ACTUATOR),
                "cranklength cranksite ctrllimited ctrlrange delay force forcelimited forcerange fpmax \
         fvmax gear interp joint jointinparent lengthrange lmax lmin nsample range scale \
         slidersite tausmooth tendon timeconst vmax",
            ),
            (Without(NAMES), "group name user"),
        ],
    },
    MjcfEntry {
        id: "actuator/adhesion",
        tag: "adhesion",
        within: "actuator default",
        role: Read,
        attributes: &[
            (Without(ACTUATOR), "body ctrlrange delay forcelimited forcerange gain interp nsample"),
            (Read, "class"),
            (Without(NAMES), "group name user"),
        ],
    },
    MjcfEntry {
        id: "actuator/dcmotor",
        tag: "dcmotor",
        within: "actuator default",
        role: Read,
        attributes: &[
            (Only("0", ACTUATOR_INERTIA), "armature damping"),
            (Read, "class"),
            (
                Without(ACTUATOR),
                "cogging controller cranklength cranksite ctrllimited ctrlrange delay gear inductance \
         input interp joint jointinparent lengthrange lugre motorconst nominal nsample refsite \
         resistance saturation site slidersite tendon thermal",
            ),
            (Without(NAMES), "group name user"),
        ],
    },
    MjcfEntry {
        id: "actuator/plugin",
        tag: "plugin",
        within: "actuator",
        role: Read,
        attributes: &[
            (
                Without(ACTUATOR),
                "actdim actearly actlimited actrange cranklength cranksite ctrllimited ctrlrange delay \
         dynprm dyntype forcelimited forcerange gear instance interp joint jointinparent \
         lengthrange nsample plugin site slidersite tendon",
            ),
            (Only("0", ACTUATOR_INERTIA), "armature damping"),
            (Read, "class"),
            (Without(NAMES), "group name user"),
        ],
    },
];
