//! The part of the table for the robot itself: settings, classes, assets, bodies, tendons, equality.

use super::MjcfEntry;
use super::Use::{Only, Read, Refused, Without};

const NAMES: &str = "names and numbers of the user's own";
const VISUAL: &str = "how it is drawn";
const CONTACT: &str = "contacts are not computed";
const SOLVER: &str = "settings of MuJoCo's solvers and integrators, which are not ours";
const ACTUATOR: &str = "joints are driven by torques, not by MuJoCo's actuators";
const SENSOR: &str = "sensors and outputs of MuJoCo";
const COMPILE: &str = "how MuJoCo compiles and saves, with the same dynamics";
const DECLARED: &str = "a declaration; an element that uses a plugin is refused";
const TENDON: &str = "a tendon without stiffness, damping, armature or friction moves nothing";
const TENDON_LIMIT: &str = "ends of tendons are not simulated";
const MOCAP: &str = "a body that is placed by hand does not move";
const FLUID_AT_REST: &str = "the medium has no density and no viscosity here";
const GLOBAL: &str = "MuJoCo has removed global coordinates: save the model with an older version of it";
const CONFLICT: &str = "settings of attached models are not merged: those of the first file hold";
const FLUID: &str = "forces of a medium are not computed";
const DISCRETE: &str = "accelerations are those of continuous time";
const GENERATED: &str =
    "meshes that MuJoCo generates are not made here: save the compiled model (mj_saveLastXML)";
const HULL: &str = "hulls of fewer vertices are not computed";
const PLUGIN: &str = "what a plugin of MuJoCo does is not known here";
const PLASTIC: &str = "springs that yield are not computed";
const FLEX: &str = "deformable bodies are not computed";
const TENDON_FORCE: &str = "forces of tendons are not computed";
const LOOP: &str = "closed loops are not computed";

pub(super) const ENTRIES: &[MjcfEntry] = &[
    MjcfEntry { id: "mujoco", tag: "mujoco", within: "", role: Read, attributes: &[(Read, "model")] },
    MjcfEntry {
        id: "compiler",
        tag: "compiler",
        within: "mujoco",
        role: Read,
        attributes: &[
            (
                Without(COMPILE),
                "alignfree discardvisual fusestatic passthrough savecanonical savecompiled saveinertial \
         texturedir usethread",
            ),
            (
                Read,
                "angle assetdir autolimits balanceinertia boundinertia boundmass eulerseq fitaabb \
         inertiafromgeom inertiagrouprange meshdir settotalmass strippath",
            ),
            (Only("warning", CONFLICT), "conflict"),
            (Only("local", GLOBAL), "coordinate"),
        ],
    },
    MjcfEntry {
        id: "option",
        tag: "option",
        within: "mujoco",
        role: Read,
        attributes: &[
            (
                Without(SOLVER),
                "actuatorgroupdisable ccd_iterations ccd_tolerance cone impratio integrator iterations \
         jacobian ls_iterations ls_tolerance magnetic noslip_iterations noslip_tolerance \
         o_friction o_margin o_solimp o_solref sdf_initpoints sdf_iterations sleep_tolerance \
         solver timestep tolerance",
            ),
            (Only("0", FLUID), "density viscosity"),
            (Read, "gravity"),
            (Without(FLUID_AT_REST), "wind"),
        ],
    },
    MjcfEntry {
        id: "option/flag",
        tag: "flag",
        within: "option",
        role: Read,
        attributes: &[
            (Without(ACTUATOR), "actuation clampctrl"),
            (
                Without(SOLVER),
                "autoreset diagexact eulerdamp fwdinv ipc island refsafe sleep speculative warmstart",
            ),
            (Read, "constraint damper equality frictionloss gravity limit spring"),
            (Without(CONTACT), "contact filterparent midphase multiccd nativeccd override"),
            (Without(SENSOR), "energy sensor"),
            (Only("disable", DISCRETE), "invdiscrete"),
        ],
    },
    MjcfEntry {
        id: "default",
        tag: "default",
        within: "mujoco default",
        role: Read,
        attributes: &[(Read, "class")],
    },
    MjcfEntry { id: "asset", tag: "asset", within: "mujoco", role: Read, attributes: &[] },
    MjcfEntry {
        id: "asset/mesh",
        tag: "mesh",
        within: "asset default",
        role: Read,
        attributes: &[
            (Refused(GENERATED), "builtin params"),
            (Read, "class content_type face file inertia name refpos refquat scale vertex"),
            (Without(VISUAL), "material normal smoothnormal texcoord"),
            (Only("-1", HULL), "maxhullvert"),
        ],
    },
    MjcfEntry {
        id: "asset/plugin",
        tag: "plugin",
        within: "asset/mesh",
        role: Refused(PLUGIN),
        attributes: &[(Without(DECLARED), "instance plugin")],
    },
    MjcfEntry {
        id: "asset/model",
        tag: "model",
        within: "asset",
        role: Read,
        attributes: &[(Without(NAMES), "content_type"), (Read, "file name")],
    },
    MjcfEntry { id: "worldbody", tag: "worldbody", within: "mujoco", role: Read, attributes: &[] },
    MjcfEntry {
        id: "body",
        tag: "body",
        within: "worldbody body frame replicate",
        role: Read,
        attributes: &[
            (Read, "axisangle childclass euler gravcomp name pos quat xyaxes zaxis"),
            (Without(COMPILE), "fuse simple"),
            (Without(MOCAP), "mocap"),
            (Without(SOLVER), "sleep"),
            (Without(NAMES), "user"),
        ],
    },
    MjcfEntry {
        id: "frame",
        tag: "frame",
        within: "worldbody body frame replicate",
        role: Read,
        attributes: &[(Without(NAMES), "name"), (Read, "childclass pos axisangle euler quat xyaxes zaxis")],
    },
    MjcfEntry {
        id: "replicate",
        tag: "replicate",
        within: "worldbody body frame replicate",
        role: Read,
        attributes: &[(Read, "count sep offset euler")],
    },
    MjcfEntry { id: "include", tag: "include", within: "*", role: Read, attributes: &[(Read, "file")] },
    MjcfEntry {
        id: "body/inertial",
        tag: "inertial",
        within: "worldbody body frame replicate",
        role: Read,
        attributes: &[(Read, "axisangle diaginertia euler fullinertia mass pos quat xyaxes zaxis")],
    },
    MjcfEntry {
        id: "body/joint",
        tag: "joint",
        within: "worldbody body frame replicate default",
        role: Read,
        attributes: &[
            (
                Read,
                "actuatorfrclimited actuatorfrcrange actuatorgravcomp armature axis class damping \
         frictionloss limited name pos range ref springdamper springref stiffness type",
            ),
            (Without(NAMES), "group user"),
            (Without(SOLVER), "margin solimpfriction solimplimit solreffriction solreflimit"),
            (Only("0", PLASTIC), "springyield"),
        ],
    },
    MjcfEntry {
        id: "body/freejoint",
        tag: "freejoint",
        within: "worldbody body frame replicate",
        role: Read,
        attributes: &[(Without(NAMES), "align group name")],
    },
    MjcfEntry {
        id: "body/geom",
        tag: "geom",
        within: "worldbody body frame replicate default",
        role: Read,
        attributes: &[
            (
                Without(CONTACT),
                "adhesion conaffinity condim contype friction gap hfield margin priority solimp solmix \
         solref surfacevel",
            ),
            (
                Read,
                "axisangle class density euler fitscale fromto group mass mesh pos quat shellinertia size \
         type xyaxes zaxis",
            ),
            (Without(VISUAL), "castshadow material rgba"),
            (Without(FLUID_AT_REST), "fluidcoef fluidshape"),
            (Without(NAMES), "name user"),
        ],
    },
    MjcfEntry {
        id: "geom/plugin",
        tag: "plugin",
        within: "body/geom",
        role: Refused(PLUGIN),
        attributes: &[(Without(DECLARED), "instance plugin")],
    },
    MjcfEntry {
        id: "body/attach",
        tag: "attach",
        within: "worldbody body frame replicate",
        role: Read,
        attributes: &[(Read, "body frame model prefix")],
    },
    MjcfEntry {
        id: "body/site",
        tag: "site",
        within: "worldbody body frame replicate default",
        role: Read,
        attributes: &[
            (Read, "axisangle class euler fromto name pos quat xyaxes zaxis"),
            (Without(NAMES), "group user"),
            (Without(VISUAL), "material mesh rgba size type"),
        ],
    },
    MjcfEntry {
        id: "body/plugin",
        tag: "plugin",
        within: "worldbody body frame replicate",
        role: Refused(PLUGIN),
        attributes: &[(Without(DECLARED), "instance plugin")],
    },
    MjcfEntry {
        id: "body/flexcomp",
        tag: "flexcomp",
        within: "worldbody body frame replicate",
        role: Refused(FLEX),
        attributes: &[(
            Without(FLEX),
            "axisangle cellcount count dim dof element euler file flatskin group inertiabox mass \
         material mesh name origin point pos quat radius rgba rigid scale spacing texcoord type \
         xyaxes zaxis",
        )],
    },
    MjcfEntry {
        id: "flexcomp/edge",
        tag: "edge",
        within: "body/flexcomp",
        role: Without(FLEX),
        attributes: &[(Without(FLEX), "damping equality solimp solref stiffness")],
    },
    MjcfEntry {
        id: "flexcomp/elasticity",
        tag: "elasticity",
        within: "body/flexcomp",
        role: Without(FLEX),
        attributes: &[(
            Without(FLEX),
            "damping elastic2d poisson section sectionsize shear thickness yield young",
        )],
    },
    MjcfEntry {
        id: "flexcomp/contact",
        tag: "contact",
        within: "body/flexcomp",
        role: Without(FLEX),
        attributes: &[(
            Without(FLEX),
            "activelayers conaffinity condim contype friction gap margin passive priority selfcollide \
         solimp solmix solref",
        )],
    },
    MjcfEntry {
        id: "flexcomp/pin",
        tag: "pin",
        within: "body/flexcomp",
        role: Without(FLEX),
        attributes: &[(Without(FLEX), "grid gridrange id range")],
    },
    MjcfEntry {
        id: "flexcomp/plugin",
        tag: "plugin",
        within: "body/flexcomp",
        role: Without(FLEX),
        attributes: &[(Without(FLEX), "instance plugin")],
    },
    MjcfEntry { id: "deformable", tag: "deformable", within: "mujoco", role: Read, attributes: &[] },
    MjcfEntry {
        id: "deformable/flex",
        tag: "flex",
        within: "deformable",
        role: Refused(FLEX),
        attributes: &[(
            Without(FLEX),
            "body cellcount dim dof element elemtexcoord flatskin group material name node nodecoord \
         radius rgba texcoord vertex",
        )],
    },
    MjcfEntry {
        id: "flex/contact",
        tag: "contact",
        within: "deformable/flex",
        role: Without(FLEX),
        attributes: &[(
            Without(FLEX),
            "activelayers conaffinity condim contype friction gap margin passive priority selfcollide \
         solimp solmix solref",
        )],
    },
    MjcfEntry {
        id: "flex/edge",
        tag: "edge",
        within: "deformable/flex",
        role: Without(FLEX),
        attributes: &[(Without(FLEX), "damping stiffness")],
    },
    MjcfEntry {
        id: "flex/elasticity",
        tag: "elasticity",
        within: "deformable/flex",
        role: Without(FLEX),
        attributes: &[(
            Without(FLEX),
            "damping elastic2d poisson section sectionsize shear thickness yield young",
        )],
    },
    MjcfEntry { id: "tendon", tag: "tendon", within: "mujoco", role: Read, attributes: &[] },
    MjcfEntry {
        id: "default/tendon",
        tag: "tendon",
        within: "default",
        role: Read,
        attributes: &[
            (Without(TENDON), "actuatorfrclimited actuatorfrcrange springlength springyield"),
            (Only("0", TENDON_FORCE), "armature damping frictionloss stiffness"),
            (Without(NAMES), "group user"),
            (Without(TENDON_LIMIT), "limited margin range"),
            (Without(VISUAL), "material rgba width"),
            (Without(SOLVER), "solimpfriction solimplimit solreffriction solreflimit"),
        ],
    },
    MjcfEntry {
        id: "tendon/spatial",
        tag: "spatial",
        within: "tendon",
        role: Read,
        attributes: &[
            (Without(TENDON), "actuatorfrclimited actuatorfrcrange springlength springyield"),
            (Only("0", TENDON_FORCE), "armature damping frictionloss stiffness"),
            (Read, "class"),
            (Without(NAMES), "group name user"),
            (Without(TENDON_LIMIT), "limited margin range"),
            (Without(VISUAL), "material rgba width"),
            (Without(SOLVER), "solimpfriction solimplimit solreffriction solreflimit"),
        ],
    },
    MjcfEntry {
        id: "spatial/site",
        tag: "site",
        within: "tendon/spatial",
        role: Without(TENDON),
        attributes: &[(Without(TENDON), "site")],
    },
    MjcfEntry {
        id: "spatial/geom",
        tag: "geom",
        within: "tendon/spatial",
        role: Without(TENDON),
        attributes: &[(Without(TENDON), "geom sidesite")],
    },
    MjcfEntry {
        id: "spatial/pulley",
        tag: "pulley",
        within: "tendon/spatial",
        role: Without(TENDON),
        attributes: &[(Without(TENDON), "divisor")],
    },
    MjcfEntry {
        id: "tendon/fixed",
        tag: "fixed",
        within: "tendon",
        role: Read,
        attributes: &[
            (Without(TENDON), "actuatorfrclimited actuatorfrcrange springlength springyield"),
            (Only("0", TENDON_FORCE), "armature damping frictionloss stiffness"),
            (Read, "class"),
            (Without(NAMES), "group name user"),
            (Without(TENDON_LIMIT), "limited margin range"),
            (Without(SOLVER), "solimpfriction solimplimit solreffriction solreflimit"),
        ],
    },
    MjcfEntry {
        id: "fixed/joint",
        tag: "joint",
        within: "tendon/fixed",
        role: Read,
        attributes: &[(Read, "coef joint")],
    },
    MjcfEntry {
        id: "default/equality",
        tag: "equality",
        within: "default",
        role: Read,
        attributes: &[(Read, "active"), (Without(SOLVER), "solimp solref")],
    },
    MjcfEntry { id: "equality", tag: "equality", within: "mujoco", role: Read, attributes: &[] },
    MjcfEntry {
        id: "equality/joint",
        tag: "joint",
        within: "equality",
        role: Read,
        attributes: &[
            (Read, "active class joint1 joint2 polycoef"),
            (Without(NAMES), "name"),
            (Without(SOLVER), "solimp solref"),
        ],
    },
    MjcfEntry {
        id: "equality/connect",
        tag: "connect",
        within: "equality",
        role: Refused(LOOP),
        attributes: &[
            (Read, "active class"),
            (Without(LOOP), "anchor body1 body2 site1 site2"),
            (Without(NAMES), "name"),
            (Without(SOLVER), "solimp solref"),
        ],
    },
    MjcfEntry {
        id: "equality/weld",
        tag: "weld",
        within: "equality",
        role: Refused(LOOP),
        attributes: &[
            (Read, "active class"),
            (Without(LOOP), "anchor body1 body2 relpose site1 site2 torquescale"),
            (Without(NAMES), "name"),
            (Without(SOLVER), "solimp solref"),
        ],
    },
    MjcfEntry {
        id: "equality/tendon",
        tag: "tendon",
        within: "equality",
        role: Read,
        attributes: &[
            (Read, "active class polycoef tendon1 tendon2"),
            (Without(NAMES), "name"),
            (Without(SOLVER), "solimp solref"),
        ],
    },
    MjcfEntry {
        id: "equality/flex",
        tag: "flex",
        within: "equality",
        role: Refused(LOOP),
        attributes: &[
            (Read, "active class"),
            (Without(LOOP), "flex"),
            (Without(NAMES), "name"),
            (Without(SOLVER), "solimp solref"),
        ],
    },
    MjcfEntry {
        id: "equality/flexstrain",
        tag: "flexstrain",
        within: "equality",
        role: Refused(LOOP),
        attributes: &[
            (Read, "active class"),
            (Without(LOOP), "cell flex"),
            (Without(NAMES), "name"),
            (Without(SOLVER), "solimp solref"),
        ],
    },
];
