"""Every attribute of MuJoCo's own schema, set away from its default on a small model: either the torques equal those of MuJoCo's inverse
dynamics, or our error names the attribute or its element. The table of the reader has the same elements and attributes as the schema.

MuJoCo's constraint forces are switched off: equality, limits and contacts are no part of the torques that are compared.
"""

import collections
import json
import multiprocessing
import os
import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree as ET

import mujoco
import numpy as np

# Both programs use double precision throughout, on models of three joints.
RELATIVE = 1e-10

BASE = """<mujoco model="m">
<compiler/><option/><size/><default><joint/><geom/></default>
<asset><mesh name="m1" vertex="0 0 0 .2 0 0 0 .3 0 0 0 .4" face="0 2 1 0 1 3 1 2 3 0 3 2"/><texture name="t1" type="2d" builtin="flat" width="4" height="4"/><material name="a1"/><hfield name="h1" nrow="2" ncol="2" size="1 1 1 1"/></asset>
<worldbody><site name="s0"/><camera name="c1"/>
<body name="l1" pos=".01 .02 .3" euler="5 10 15"><joint name="j1" axis="0 1 0" damping=".1" stiffness=".3" springref="7"/><inertial pos=".04 .01 .12" mass=".9" diaginertia=".011 .013 .007"/><geom name="g1" size=".05"/><site name="s1" pos=".1 0 .05"/>
<body name="l2" pos="0 0 .25"><joint name="j2" axis="1 0 0"/><geom name="g2" type="box" size=".02 .05 .1" pos=".01 .02 .05"/><site name="s2" pos="0 .1 .05"/>
<body name="l3" pos=".1 0 .2"><joint name="j3" type="slide" axis="0 .6 .8"/><geom name="g3" type="mesh" mesh="m1"/></body></body></body>
<body name="mocap" mocap="true"><geom size=".01" contype="0" conaffinity="0"/></body>
</worldbody>
<tendon><fixed name="k1"><joint joint="j1" coef="1"/></fixed></tendon>
<actuator><motor name="u1" joint="j1"/></actuator>
</mujoco>"""

# Elements with attributes that they cannot do without: where they are not in BASE already, by their path.
SNIPPETS = {
    "body/inertial": '<inertial pos="0 0 0" mass="1" diaginertia=".1 .1 .1"/>',
    "body/geom": '<geom size=".05"/>',
    # MuJoCo 4.0.0 hangs on models of files that are not there; models within others are compared by tests of the reader.
    "asset/model": None,
    "body/attach": None,
    "asset/mesh": '<mesh name="m2" vertex="0 0 0 .2 0 0 0 .3 0 0 0 .4" face="0 2 1 0 1 3 1 2 3 0 3 2"/>',
    "asset/hfield": '<hfield name="h2" nrow="2" ncol="2" size="1 1 1 1"/>',
    "asset/texture": '<texture name="t2" type="2d" builtin="flat" width="4" height="4"/>',
    "asset/material": '<material name="a2"/>',
    "asset/material/layer": '<layer role="rgb" texture="t1"/>',
    "body/flexcomp": '<flexcomp name="f" type="grid" count="3 3 1" spacing=".1 .1 .1" dim="2" mass="1"/>',
    "contact/pair": '<pair geom1="g1" geom2="g3"/>',
    "contact/exclude": '<exclude body1="l1" body2="l3"/>',
    "tendon/fixed": '<fixed><joint joint="j1" coef="1"/></fixed>',
    "tendon/fixed/joint": '<joint joint="j2" coef="2"/>',
    "tendon/spatial": '<spatial><site site="s1"/><site site="s0"/></spatial>',
    "tendon/spatial/site": '<site site="s2"/>',
    "tendon/spatial/geom": None,
    "tendon/spatial/pulley": None,
    "equality/connect": '<connect body1="l3" anchor="0 0 0"/>',
    "equality/weld": '<weld body1="l3"/>',
    "equality/joint": '<joint joint1="j2" joint2="j1"/>',
    "equality/tendon": '<tendon tendon1="k1"/>',
    "sensor/touch": '<touch site="s1"/>',
    "custom/numeric": '<numeric name="n" data="1"/>',
    "custom/text": '<text name="n" data="1"/>',
    "custom/tuple": '<tuple name="n"><element objtype="body" objname="l1"/></tuple>',
    "custom/tuple/element": '<element objtype="body" objname="l2"/>',
    "keyframe/key": "<key/>",
    "actuator/cylinder": '<cylinder joint="j1"/>',
    "actuator/adhesion": '<adhesion body="l1" ctrlrange="0 1"/>',
    "actuator/damper": '<damper joint="j1" ctrlrange="0 1" kv="1"/>',
    "actuator/dcmotor": '<dcmotor joint="j1" motorconst="1 1" resistance="1"/>',
    "actuator/orientation": '<orientation site="s1" refsite="s0" kp="1"/>',
}
# More attributes without which another one says nothing.
WITH = {
    ("option", "wind"): {},
    ("option", "density"): {},
    ("body/geom", "fromto"): {"type": "capsule"},
    ("body/geom", "shellinertia"): {"type": "sphere"},
    ("body/geom", "mesh"): {"type": "mesh"},
    ("body/geom", "hfield"): {"type": "hfield"},
    ("body/geom", "fitscale"): {"type": "box", "mesh": "m1"},
    ("body/joint", "range"): {"limited": "true"},
    ("body/joint", "springyield"): {"stiffness": "1"},
    ("body/inertial", "fullinertia"): {"diaginertia": None},
    ("asset/mesh", "params"): {"builtin": "sphere", "vertex": None, "face": None},
    ("asset/mesh", "builtin"): {"params": "1", "vertex": None, "face": None},
    ("equality/connect", "site1"): {"body1": None, "anchor": None, "site2": "s1"},
    ("equality/connect", "site2"): {"body1": None, "anchor": None, "site1": "s1"},
    ("equality/weld", "site1"): {"body1": None, "site2": "s1"},
    ("equality/weld", "site2"): {"body1": None, "site1": "s1"},
    ("body/camera", "sensorsize"): {"resolution": "10 10", "focal": ".1 .1"},
    ("body/site", "mesh"): {"type": "mesh"},
}
TARGETS = {"site": "s1", "joint": "j1", "tendon": "k1", "actuator": "u1", "body": "l2", "geom": "g1", "camera": "c1", "geom1": "g1", "geom2": "g3",
           "joint1": "j1", "joint2": "j2", "objname": "l1", "objtype": "body", "refname": "l2", "reftype": "body", "mesh": "m1"}
VALUES = ["0.37", "3", "1", "2", "0.37 0.21", "1 2", "3 1", "0.3 0.2 0.5", "0.3 0.2 0.5 0.4", "0.1 0.2 0.3 0.4 0.5", ".3 .35 .4 .01 .02 .03", "0.1 0 0 0 0.2 0.3",
          "1 2 3 4 5 6 7", "4", "10", "20", "true", "false", "auto", "enable", "disable", "radian", "zyx", "XYZ", "global", "merge", "box", "slide", "ball", "free",
          "capsule", "ellipsoid", "mesh", "exact", "convex", "shell", "sphere", "never", "always", "2d", "cube", "checker", "elliptic", "RK4", "implicit", "CG", "sparse",
          "orthographic", "spot", "trackcom", "rgb", "pos", "integrator", "affine", "user", "linear", "textures", "none", "j2", "l1", "l2", "g1", "s1", "s2", "m1", "t1", "a1", "k1",
          "u1", "c1", "word", "body", "geom", "site", "joint"]


def schema():
    """Attributes of every element of the schema, by its path without the root."""
    stack, found = [], {}
    for line in mujoco.mj_printSchema(False, False).splitlines():
        if not line.strip():
            continue
        head = re.match(r"^( *)(\(world\)body|[a-z_0-9]+) \((.)\)(.*)$", line)
        if head:
            depth = len(head[1]) // 3
            stack = stack[:depth] + [head[2].removeprefix("(world)")]
            path = "/".join(stack[1:])
            found[path] = head[4].split()
        else:
            found[path] += line.split()
    return found


def table(example):
    """Attributes of every element of our table, by element."""
    found = {}
    for line in subprocess.run([example, "--table"], check=True, capture_output=True, text=True).stdout.splitlines()[2:]:
        path, names, said = [cell.strip() for cell in line.strip("|").split("|", 2)]
        found.setdefault(path.strip("`"), {}).update(dict.fromkeys([] if names == "the element" else names.split(", "), said))
    return found


def element_of(root, path, parent_of_new):
    """The element to set an attribute of: one of BASE, or a new one."""
    parts = path.split("/")
    if path == "":
        return root
    tag = parts[-1]
    if parts[0] == "body":
        parts = ["worldbody", "body"] + parts[1:]
    where = root
    for part in parts[:-1]:
        inner = where.find(part)
        where = inner if inner is not None else ET.SubElement(where, part, {"name": "p"} if part in parent_of_new else {})
    snippet = SNIPPETS.get(path)
    if path not in SNIPPETS:
        inner = where.find(tag)
        if path == "body/joint":
            return where.find(tag)
        if inner is not None and parts[0] != "sensor":
            return inner
        inner = ET.SubElement(where, tag)
        return inner
    if snippet is None:
        return None
    if path == "body/inertial":
        where = root.find("worldbody/body/body")
        for joint in where.findall("body"):
            pass
    if path == "body/geom":
        where = root.find("worldbody/body/body")
    new = ET.fromstring(snippet)
    where.append(new)
    return new


def variants(path, attribute, known):
    """Texts of models in which the attribute has one value after the other, `known` ones first."""
    for value in dict.fromkeys([TARGETS.get(attribute), *known, *VALUES]):
        if value is None:
            continue
        root = ET.fromstring(BASE)
        element = element_of(root, path, ())
        if element is None:
            return
        required = [a for a in ("site", "joint", "body", "camera") if path.startswith(("sensor/", "actuator/")) and a == first_target(path)]
        for name in required:
            element.attrib.setdefault(name, TARGETS[name])
        for name, text in WITH.get((path, attribute), {}).items():
            element.attrib.pop(name, None) if text is None else element.set(name, text)
        if element.get(attribute) == value:
            continue
        for way in ("quat", "axisangle", "euler", "xyaxes", "zaxis"):
            if attribute in ("quat", "axisangle", "euler", "xyaxes", "zaxis"):
                element.attrib.pop(way, None)
        element.set(attribute, value)
        yield value, ET.tostring(root, encoding="unicode")


SCHEMA = schema()


def first_target(path):
    for name in ("joint", "site", "tendon", "actuator", "body", "camera"):
        if name in SCHEMA[path]:
            return name
    return None


def states(model, seed):
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(3):
        q = model.qpos0 + rng.uniform(-0.3, 0.3, model.nq)
        rows.append({"q": q.tolist(), "dq": rng.uniform(-1, 1, model.nv).tolist(), "ddq": rng.uniform(-2, 2, model.nv).tolist()})
    return rows


def inverse(model, rows):
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data, found = mujoco.MjData(model), []
    for row in rows:
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:], data.qacc[:] = row["q"], row["dq"], row["ddq"]
        mujoco.mj_inverse(model, data)
        found.append(data.qfrc_inverse.copy())
    return np.array(found)


# Values that MuJoCo took for an attribute of some element, the last one first: it is likely to take them elsewhere.
TAKEN = collections.defaultdict(list)
# Values that are tried of an attribute: of one that the table reads, and of others.
N_READ, N_OTHER = 4, 1
# Time for the attributes of one element; MuJoCo hangs on some files.
SECONDS = 60


def tried(task):
    """Of each attribute of an element some values away from its default that MuJoCo takes: text, states, torques."""
    path, names, read = task
    found = []
    for attribute in names:
        models, wanted, known = [], N_READ if attribute in read else N_OTHER, TAKEN[attribute]
        for value, text in variants(path, attribute, known):
            try:
                model = mujoco.MjModel.from_xml_string(text)
            except (ValueError, RuntimeError, mujoco.FatalError):
                continue
            rows = states(model, 0)
            torques = inverse(model, rows)
            if not np.isfinite(torques).all():
                continue
            models.append((value, text, rows, torques))
            if value not in known:
                known.insert(0, value)
            if len(models) >= wanted:
                break
        found.append((path, attribute, models))
    return found


def main():
    program, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    example = program.parent / "examples" / "robot_torques"
    ours, failed = table(example), []
    # Elements that stand in several places have one entry; sections of MuJoCo's own.
    known = {name.split("/")[-1]: set() for name in ours}
    for path, names in ours.items():
        known[path.split("/")[-1]] |= set(names)
    refused = {name for name, said in ours.items() if not said}
    for path, names in SCHEMA.items():
        # What is refused wherever it stands has one row without attributes.
        if path in refused:
            continue
        missing = set(names) - known.get(path.split("/")[-1] or "mujoco", set())
        if missing:
            failed.append(f"{path}: not in the table: {sorted(missing)}")
    plain = mujoco.MjModel.from_xml_string(BASE)
    of_plain = inverse(plain, states(plain, 0))
    cases, silent = [], []
    n_attributes = sum(len(names) for names in SCHEMA.values())
    with multiprocessing.get_context("spawn").Pool(os.cpu_count()) as pool:
        kept = [{name for name, said in names.items() if said == "read"} for names in ours.values()]
        read = set().union(*kept)
        results = [pool.apply_async(tried, ((path, names, read),)) for path, names in SCHEMA.items()]
        for result in results:
            for path, attribute, models in result.get(SECONDS):
                if not models:
                    silent.append(f"{path}/{attribute}")
                for value, text, rows, torques in models:
                    file = folder / f"{len(cases)}.xml"
                    file.write_text(text)
                    changes = torques.shape != of_plain.shape or np.abs(torques - of_plain).max() > 1e-9
                    cases.append((path, attribute, value, file, rows, torques, changes))
    lines = "".join(json.dumps({"file": str(file), "rows": rows}) + "\n" for *_, file, rows, _, _ in cases)
    done = subprocess.run([example], input=lines.encode(), check=True, stdout=subprocess.PIPE)
    equal, refused, effects, worst = 0, 0, 0, 0.0
    for (path, attribute, value, file, _, expected, changes), line in zip(cases, done.stdout.splitlines(), strict=True):
        answer = json.loads(line)
        at, effects = f"{path} {attribute}=\"{value}\"", effects + changes
        if "error" in answer:
            refused += 1
            words = set(re.findall(r"[a-z0-9_]+", answer["error"].lower()))
            if not words & {attribute, path.split("/")[-1], value.lower()}:
                failed.append(f"{at}: {answer['error']}")
            continue
        if answer["tau"] is None or np.shape(answer["tau"]) != expected.shape:
            failed.append(f"{at}: joints {answer['joints']}")
            continue
        error = np.abs(np.array(answer["tau"]) - expected).max() / np.abs(expected).max()
        worst = max(worst, error)
        equal += 1
        if not error <= RELATIVE:
            failed.append(f"{at}: {error:.1e} from MuJoCo's torques ({file.name})")
    print(f"mjcf_schema_peer: MuJoCo {mujoco.__version__}: {n_attributes} attributes, {len(cases)} models ({effects} of other torques than without): {equal} equal "
          f"(worst {worst:.1e}), {refused} refused by name; {len(silent)} attributes with no value that MuJoCo takes alone")
    if "--silent" in sys.argv:
        print("\n".join(silent))
    print("\n".join(failed[:60]))
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
