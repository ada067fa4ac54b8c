//! The part of the table for all that is around a robot: drawing, contacts, sensors, states.

use super::MjcfEntry;
use super::Use::Without;

const NAMES: &str = "names and numbers of the user's own";
const VISUAL: &str = "how it is drawn";
const CONTACT: &str = "contacts are not computed";
const ACTUATOR: &str = "joints are driven by torques, not by MuJoCo's actuators";
const STATE: &str = "states, not the robot";
const MEMORY: &str = "sizes that MuJoCo allocates";
const DECLARED: &str = "a declaration; an element that uses a plugin is refused";

pub(super) const ENTRIES: &[MjcfEntry] = &[
    MjcfEntry {
        id: "compiler/lengthrange",
        tag: "lengthrange",
        within: "compiler",
        role: Without(ACTUATOR),
        attributes: &[(
            Without(ACTUATOR),
            "accel interval inttotal maxforce mode timeconst timestep tolrange useexisting uselimit",
        )],
    },
    MjcfEntry {
        id: "size",
        tag: "size",
        within: "mujoco",
        role: Without(MEMORY),
        attributes: &[(
            Without(MEMORY),
            "memory nconmax njmax nkey nstack nuser_actuator nuser_body nuser_cam nuser_geom \
         nuser_jnt nuser_sensor nuser_site nuser_tendon nuserdata",
        )],
    },
    MjcfEntry {
        id: "statistic",
        tag: "statistic",
        within: "mujoco",
        role: Without(VISUAL),
        attributes: &[(Without(VISUAL), "center extent meaninertia meanmass meansize")],
    },
    MjcfEntry { id: "visual", tag: "visual", within: "mujoco", role: Without(VISUAL), attributes: &[] },
    MjcfEntry {
        id: "visual/global",
        tag: "global",
        within: "visual",
        role: Without(VISUAL),
        attributes: &[(
            Without(VISUAL),
            "azimuth bvactive cameraid elevation ellipsoidinertia fovy glow ipd linewidth offheight \
         offwidth orthographic realtime",
        )],
    },
    MjcfEntry {
        id: "visual/quality",
        tag: "quality",
        within: "visual",
        role: Without(VISUAL),
        attributes: &[(Without(VISUAL), "numquads numslices numstacks offsamples shadowsize")],
    },
    MjcfEntry {
        id: "visual/headlight",
        tag: "headlight",
        within: "visual",
        role: Without(VISUAL),
        attributes: &[(Without(VISUAL), "active ambient diffuse specular")],
    },
    MjcfEntry {
        id: "visual/map",
        tag: "map",
        within: "visual",
        role: Without(VISUAL),
        attributes: &[(
            Without(VISUAL),
            "actuatortendon alpha fogend fogstart force haze shadowclip shadowscale stiffness \
         stiffnessrot torque zfar znear",
        )],
    },
    MjcfEntry {
        id: "visual/scale",
        tag: "scale",
        within: "visual",
        role: Without(VISUAL),
        attributes: &[(
            Without(VISUAL),
            "actuatorlength actuatorwidth camera com connect constraint contactheight contactwidth \
         forcewidth framelength framewidth frustum jointlength jointwidth light selectpoint \
         slidercrank",
        )],
    },
    MjcfEntry {
        id: "visual/rgba",
        tag: "rgba",
        within: "visual",
        role: Without(VISUAL),
        attributes: &[(
            Without(VISUAL),
            "actuator actuatornegative actuatorpositive bv bvactive camera com connect constraint \
         contactforce contactfriction contactgap contactpoint contacttorque crankbroken fog force \
         frustum haze inertia joint light rangefinder selectpoint slidercrank",
        )],
    },
    MjcfEntry {
        id: "extension",
        tag: "extension",
        within: "mujoco",
        role: Without(DECLARED),
        attributes: &[],
    },
    MjcfEntry {
        id: "extension/plugin",
        tag: "plugin",
        within: "extension",
        role: Without(DECLARED),
        attributes: &[(Without(DECLARED), "plugin")],
    },
    MjcfEntry {
        id: "plugin/instance",
        tag: "instance",
        within: "extension/plugin",
        role: Without(DECLARED),
        attributes: &[(Without(DECLARED), "name")],
    },
    MjcfEntry {
        id: "plugin/config",
        tag: "config",
        within: "plugin/instance asset/plugin geom/plugin body/plugin flexcomp/plugin actuator/plugin sensor/plugin",
        role: Without(DECLARED),
        attributes: &[(Without(DECLARED), "key value")],
    },
    MjcfEntry {
        id: "asset/hfield",
        tag: "hfield",
        within: "asset",
        role: Without(CONTACT),
        attributes: &[(Without(CONTACT), "content_type elevation file name ncol nrow size")],
    },
    MjcfEntry {
        id: "asset/skin",
        tag: "skin",
        within: "asset deformable",
        role: Without(VISUAL),
        attributes: &[(Without(VISUAL), "face file group inflate material name rgba texcoord vertex")],
    },
    MjcfEntry {
        id: "skin/bone",
        tag: "bone",
        within: "asset/skin",
        role: Without(VISUAL),
        attributes: &[(Without(VISUAL), "bindpos bindquat body vertid vertweight")],
    },
    MjcfEntry {
        id: "asset/texture",
        tag: "texture",
        within: "asset default",
        role: Without(VISUAL),
        attributes: &[(
            Without(VISUAL),
            "builtin class colorspace content_type embed file fileback filedown filefront fileleft \
         fileright fileup gridlayout gridsize height hflip mark markrgb name nchannel random rgb1 \
         rgb2 type vflip width",
        )],
    },
    MjcfEntry {
        id: "asset/material",
        tag: "material",
        within: "asset default",
        role: Without(VISUAL),
        attributes: &[(
            Without(VISUAL),
            "class emission metallic name reflectance rgba roughness shininess specular texrepeat \
         texture texuniform",
        )],
    },
    MjcfEntry {
        id: "material/layer",
        tag: "layer",
        within: "asset/material",
        role: Without(VISUAL),
        attributes: &[(Without(VISUAL), "role texture")],
    },
    MjcfEntry {
        id: "body/camera",
        tag: "camera",
        within: "worldbody body frame replicate default",
        role: Without(VISUAL),
        attributes: &[(
            Without(VISUAL),
            "axisangle class euler focal focalpixel fovy ipd mode name output pos principal \
         principalpixel projection quat resolution sensorsize target user xyaxes zaxis",
        )],
    },
    MjcfEntry {
        id: "body/light",
        tag: "light",
        within: "worldbody body frame replicate default",
        role: Without(VISUAL),
        attributes: &[(
            Without(VISUAL),
            "active ambient attenuation bulbradius castshadow class cutoff diffuse dir directional \
         exponent intensity mode name pos range softness specular target texture type",
        )],
    },
    MjcfEntry { id: "contact", tag: "contact", within: "mujoco", role: Without(CONTACT), attributes: &[] },
    MjcfEntry {
        id: "contact/pair",
        tag: "pair",
        within: "contact default",
        role: Without(CONTACT),
        attributes: &[(
            Without(CONTACT),
            "adhesion class condim friction gap geom1 geom2 margin name solimp solref solreffriction",
        )],
    },
    MjcfEntry {
        id: "contact/exclude",
        tag: "exclude",
        within: "contact",
        role: Without(CONTACT),
        attributes: &[(Without(CONTACT), "body1 body2 name")],
    },
    MjcfEntry { id: "custom", tag: "custom", within: "mujoco", role: Without(NAMES), attributes: &[] },
    MjcfEntry {
        id: "custom/numeric",
        tag: "numeric",
        within: "custom",
        role: Without(NAMES),
        attributes: &[(Without(NAMES), "data name size")],
    },
    MjcfEntry {
        id: "custom/text",
        tag: "text",
        within: "custom",
        role: Without(NAMES),
        attributes: &[(Without(NAMES), "data name")],
    },
    MjcfEntry {
        id: "custom/tuple",
        tag: "tuple",
        within: "custom",
        role: Without(NAMES),
        attributes: &[(Without(NAMES), "name")],
    },
    MjcfEntry {
        id: "tuple/element",
        tag: "element",
        within: "custom/tuple",
        role: Without(NAMES),
        attributes: &[(Without(NAMES), "objname objtype prm")],
    },
    MjcfEntry { id: "keyframe", tag: "keyframe", within: "mujoco", role: Without(STATE), attributes: &[] },
    MjcfEntry {
        id: "keyframe/key",
        tag: "key",
        within: "keyframe",
        role: Without(STATE),
        attributes: &[(Without(STATE), "act ctrl mpos mquat name plastic qpos qvel time")],
    },
];
