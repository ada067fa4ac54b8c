//! The part of the table for all that is around a robot: drawing, contacts, sensors, states.

use super::Entry;
use super::Use::Without;

const NAMES: &str = "names and numbers of the user's own";
const VISUAL: &str = "how it is drawn";
const CONTACT: &str = "contacts are not computed";
const ACTUATOR: &str = "joints are driven by torques, not by MuJoCo's actuators";
const STATE: &str = "states, not the robot";
const MEMORY: &str = "sizes that MuJoCo allocates";
const DECLARED: &str = "a declaration; what uses a plugin is refused where it stands";

pub(super) const ENTRIES: &[Entry] = &[
    Entry {
        id: "compiler/lengthrange",
        tag: "lengthrange",
        within: "compiler",
        role: Without(ACTUATOR),
        attributes: &[(
            Without(ACTUATOR),
            "accel interval inttotal maxforce mode timeconst timestep tolrange useexisting uselimit",
        )],
    },
    Entry {
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
    Entry {
        id: "statistic",
        tag: "statistic",
        within: "mujoco",
        role: Without(VISUAL),
        attributes: &[(Without(VISUAL), "center extent meaninertia meanmass meansize")],
    },
    Entry { id: "visual", tag: "visual", within: "mujoco", role: Without(VISUAL), attributes: &[] },
    Entry {
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
    Entry {
        id: "visual/quality",
        tag: "quality",
        within: "visual",
        role: Without(VISUAL),
        attributes: &[(Without(VISUAL), "numquads numslices numstacks offsamples shadowsize")],
    },
    Entry {
        id: "visual/headlight",
        tag: "headlight",
        within: "visual",
        role: Without(VISUAL),
        attributes: &[(Without(VISUAL), "active ambient diffuse specular")],
    },
    Entry {
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
    Entry {
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
    Entry {
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
    Entry { id: "extension", tag: "extension", within: "mujoco", role: Without(DECLARED), attributes: &[] },
    Entry {
        id: "extension/plugin",
        tag: "plugin",
        within: "extension",
        role: Without(DECLARED),
        attributes: &[(Without(DECLARED), "plugin")],
    },
    Entry {
        id: "plugin/instance",
        tag: "instance",
        within: "extension/plugin",
        role: Without(DECLARED),
        attributes: &[(Without(DECLARED), "name")],
    },
    Entry {
        id: "plugin/config",
        tag: "config",
        within: "plugin/instance asset/plugin geom/plugin body/plugin flexcomp/plugin actuator/plugin sensor/plugin",
        role: Without(DECLARED),
        attributes: &[(Without(DECLARED), "key value")],
    },
    Entry {
        id: "asset/hfield",
        tag: "hfield",
        within: "asset",
        role: Without(CONTACT),
        attributes: &[(Without(CONTACT), "content_type elevation file name ncol nrow size")],
    },
    Entry {
        id: "asset/skin",
        tag: "skin",
        within: "asset deformable",
        role: Without(VISUAL),
        attributes: &[(Without(VISUAL), "face file group inflate material name rgba texcoord vertex")],
    },
    Entry {
        id: "skin/bone",
        tag: "bone",
        within: "asset/skin",
        role: Without(VISUAL),
        attributes: &[(Without(VISUAL), "bindpos bindquat body vertid vertweight")],
    },
    Entry {
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
    Entry {
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
    Entry {
        id: "material/layer",
        tag: "layer",
        within: "asset/material",
        role: Without(VISUAL),
        attributes: &[(Without(VISUAL), "role texture")],
    },
    Entry {
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
    Entry {
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
    Entry { id: "contact", tag: "contact", within: "mujoco", role: Without(CONTACT), attributes: &[] },
    Entry {
        id: "contact/pair",
        tag: "pair",
        within: "contact default",
        role: Without(CONTACT),
        attributes: &[(
            Without(CONTACT),
            "adhesion class condim friction gap geom1 geom2 margin name solimp solref solreffriction",
        )],
    },
    Entry {
        id: "contact/exclude",
        tag: "exclude",
        within: "contact",
        role: Without(CONTACT),
        attributes: &[(Without(CONTACT), "body1 body2 name")],
    },
    Entry { id: "custom", tag: "custom", within: "mujoco", role: Without(NAMES), attributes: &[] },
    Entry {
        id: "custom/numeric",
        tag: "numeric",
        within: "custom",
        role: Without(NAMES),
        attributes: &[(Without(NAMES), "data name size")],
    },
    Entry {
        id: "custom/text",
        tag: "text",
        within: "custom",
        role: Without(NAMES),
        attributes: &[(Without(NAMES), "data name")],
    },
    Entry {
        id: "custom/tuple",
        tag: "tuple",
        within: "custom",
        role: Without(NAMES),
        attributes: &[(Without(NAMES), "name")],
    },
    Entry {
        id: "tuple/element",
        tag: "element",
        within: "custom/tuple",
        role: Without(NAMES),
        attributes: &[(Without(NAMES), "objname objtype prm")],
    },
    Entry { id: "keyframe", tag: "keyframe", within: "mujoco", role: Without(STATE), attributes: &[] },
    Entry {
        id: "keyframe/key",
        tag: "key",
        within: "keyframe",
        role: Without(STATE),
        attributes: &[(Without(STATE), "act ctrl mpos mquat name plastic qpos qvel time")],
    },
];
