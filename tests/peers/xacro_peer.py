#!/usr/bin/env python3
"""Robots of xacro as the program expands them beside xacro's own expansion.

    xacro_peer.py PROGRAM FOLDER

Each document is expanded by PyPI's xacro (pip install xacro); the program reads both, and the parameters and frames of both robots are
the same to the last digit. Where xacro is absent this says so and ends well.
"""

import pathlib
import subprocess
import sys

HEAD = '<robot name="r" xmlns:xacro="http://ros.org/wiki/xacro">\n<link name="base"/>\n'
MACROS = """
<xacro:macro name="body" params="name m:=1 *place"><link name="${name}"><inertial><xacro:insert_block name="place"/><mass value="${m}"/>
<inertia ixx="${m*0.01}" iyy="${m*0.02}" izz="${m*0.015}" ixy="0" ixz="0" iyz="0"/></inertial></link></xacro:macro>
<xacro:macro name="hinge" params="name parent child type:=revolute axis:='0 1 0' **more"><joint name="${name}" type="${type}">
<parent link="${parent}"/><child link="${child}"/><axis xyz="${axis}"/><limit lower="${-pi/2}" upper="${radians(90)}" effort="1" velocity="1"/>
<xacro:insert_block name="more"/></joint></xacro:macro>
"""
DOCUMENTS = {
    "properties": MACROS
    + """<xacro:property name="a" value="0.25"/><xacro:property name="b" value="${a * 2 + c}"/><xacro:property name="c" value="1e-3"/>
<xacro:body name="one" m="${b ** 2}"><origin xyz="${a} ${-a} ${a/3}" rpy="0 ${pi/7} 0"/></xacro:body>
<xacro:hinge name="j" parent="base" child="one"><more><origin xyz="0 0 ${sin(a) + cos(b) - sqrt(2)}"/></more></xacro:hinge>""",
    "lists_and_conditions": MACROS
    + """<xacro:property name="sizes" value="${[0.1, 0.2, 0.3]}"/><xacro:arg name="heavy" default="true"/>
<xacro:if value="$(arg heavy)"><xacro:property name="m" value="3"/></xacro:if><xacro:unless value="$(arg heavy)"><xacro:property name="m" value="1"/></xacro:unless>
<xacro:body name="one" m="${m if sizes[1] > 0.15 else 7}"><origin xyz="${sizes[0]} ${sizes[-1]} ${max(sizes[0], sizes[1])}"/></xacro:body>
<xacro:hinge name="j" parent="base" child="one" axis="${1 if m == 3 else 0} 0 1"><more><origin xyz="0 0 ${len(sizes)}"/></more></xacro:hinge>""",
    "macros_within_macros": MACROS
    + """<xacro:macro name="limb" params="side sign n:=3"><xacro:property name="own" value="${side}_limb"/>
<xacro:body name="${own}" m="${n // 2 + n % 2 + 7 // -2 + 5}"><origin xyz="0 ${sign*0.1} 0"/></xacro:body>
<xacro:hinge name="${own}_joint" parent="base" child="${own}"><more><origin xyz="0 ${sign*0.2} 0"/></more></xacro:hinge></xacro:macro>
<xacro:limb side="left" sign="1"/><xacro:limb side="right" sign="${-1}" n="5"/>""",
    "recursion": MACROS
    + """<xacro:macro name="chain" params="k last"><xacro:body name="l${k}"><origin xyz="${k*0.1} 0 0"/></xacro:body>
<xacro:hinge name="j${k}" parent="${'base' if k == 1 else 'l' + str(k-1)}" child="l${k}"><more><origin xyz="0 0 ${k*0.1}"/></more></xacro:hinge>
<xacro:if value="${k &lt; last}"><xacro:chain k="${k+1}" last="${last}"/></xacro:if></xacro:macro><xacro:chain k="1" last="6"/>""",
    "scopes": MACROS
    + """<xacro:property name="x" value="1"/><xacro:macro name="set" params=""><xacro:property name="x" value="2" scope="parent"/></xacro:macro>
<xacro:macro name="own" params="x:=^|9"><xacro:body name="one" m="${x}"><origin xyz="0 0 0.1"/></xacro:body></xacro:macro>
<xacro:set/><xacro:own/><xacro:hinge name="j" parent="base" child="one"><more/></xacro:hinge>
<xacro:property name="y" default="5"/><xacro:property name="y" default="6"/>
<link name="f${y}"/><joint name="f" type="fixed"><parent link="one"/><child link="f${y}"/><origin xyz="${round(1.2345, 2)} ${int(2.7)} $${x}"/></joint>""".replace(
        " $${x}", " 0"
    ),
    "names_of_numbers": MACROS
    + """<xacro:property name="n" value="${2*1.0}"/><xacro:property name="small" value="${1/100000}"/>
<xacro:body name="l${n}_${3}_${small}_${1 == 1}"><origin xyz="0 0 0.1"/></xacro:body>
<xacro:hinge name="j" parent="base" child="l2.0_3_1e-05_True"><more/></xacro:hinge>""",
}


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    try:
        import xacro
    except ImportError as missing:
        print(f"skipped: xacro_peer: pip install xacro ({missing})")
        return
    for name, document in DOCUMENTS.items():
        source = folder / f"{name}.xacro"
        source.write_text(HEAD + document + "</robot>\n")
        expanded = folder / f"{name}.urdf"
        expanded.write_text(xacro.process_file(str(source)).toprettyxml())
        tables = []
        for robot in (source, expanded):
            out = folder / f"{robot.name}.out.urdf"
            done = subprocess.run([program, "arm", "export", robot, "--out", out], capture_output=True, text=True)
            assert done.returncode == 0, (name, robot.name, done.stderr)
            tables.append([line for line in out.read_text().splitlines() if not line.startswith("<!--")])
        assert tables[0] == tables[1], (name, [pair for pair in zip(*tables) if pair[0] != pair[1]][:3])
        print(f"{name}: the same {len(tables[0])} lines")


if __name__ == "__main__":
    main()
