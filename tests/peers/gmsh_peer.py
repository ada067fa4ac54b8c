"""Meshes written by Gmsh in every version, encoding, order and partitioning that it has, and by meshio, read by the program.

Then the files that the program does not read: the commands of its hints are run to the letter, and their mesh is checked.
"""

import json
import os
import pathlib
import re
import subprocess
import sys

try:
    import gmsh
    import meshio
except ImportError as missing:
    print(f"skipped: gmsh_peer: {missing}")
    sys.exit(0)

SCENE = """format = "hysteron-scene"
version = 1
name = "cylinder"
seed = 1
mesh = {{ file = "{file}", unit = "mm" }}
clamp = {{ box_min_mm = [-9, -9, -1e-6], box_max_mm = [9, 9, 1e-6] }}
material = {{ law = "corotational", youngs_modulus_mpa = 1.0, poisson_ratio = 0.4, density_kg_m3 = 1000.0 }}
gravity = {{ acceleration_m_s2 = [0, 0, 0] }}
tip = {{ point_mm = [0, 0, 20] }}
"""
# Sum of some hundred volumes.
RELATIVE = 1e-12


def check(program, folder, file):
    """What `hysteron check` says of a mesh: a process that ended."""
    (folder / "scene.toml").write_text(SCENE.format(file=file))
    return subprocess.run([program, "-q", "check", "scene.toml", "--json"], cwd=folder, capture_output=True, text=True)


def cylinder(order):
    gmsh.clear()
    gmsh.model.add("cylinder")
    gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 20, 5)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(3, [1], 1, "body")
    gmsh.model.addPhysicalGroup(2, [3], 2, "base")
    gmsh.option.setNumber("Mesh.MeshSizeMax", 5)
    gmsh.option.setNumber("Mesh.SecondOrderLinear", 1)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(order)


def expected():
    tags = gmsh.model.mesh.getElements(3)[1][0]
    base = len(gmsh.model.mesh.getNodesForPhysicalGroup(2, 2)[0])
    volume = sum(gmsh.model.mesh.getElementQualities(tags, "volume"))
    return len(gmsh.model.mesh.getNodes()[0]), len(tags), base, volume * 1e-9


def compare(name, done, nodes, tetrahedra, base, volume):
    assert done.returncode == 0, f"{name}: {done.stderr}"
    mesh = json.loads(done.stdout)["mesh"]
    assert (mesh["nodes"], mesh["tetrahedra"]) == (nodes, tetrahedra), (name, mesh)
    assert abs(mesh["volume_m3"] / volume - 1) < RELATIVE, (name, mesh["volume_m3"], volume)
    if base is not None:
        assert base in mesh["groups"].values(), (name, mesh["groups"])


def versions(program, folder):
    count = 0
    for order in (1, 2):
        for partitions in (0, 3):
            for ghosts in (0, 1) if partitions else (0,):
                cylinder(order)
                sizes = expected()
                if partitions:
                    gmsh.option.setNumber("Mesh.PartitionCreateGhostCells", ghosts)
                    gmsh.model.mesh.partition(partitions)
                for version in (1, 2.2, 4.0, 4.1):
                    for binary in (0, 1):
                        for parametric in (0, 1):
                            # Gmsh writes neither 1 nor 4.0 in bytes, and makes 2.2 of the former.
                            if version == 4.0 and binary:
                                continue
                            gmsh.option.setNumber("Mesh.MshFileVersion", version)
                            gmsh.option.setNumber("Mesh.Binary", binary)
                            gmsh.option.setNumber("Mesh.SaveParametric", parametric)
                            name = f"{version}-{binary}-{order}-{partitions}-{ghosts}-{parametric}.msh"
                            gmsh.write(str(folder / name))
                            compare(name, check(program, folder, name), *sizes)
                            count += 1
    print(f"{count} files of Gmsh {gmsh.__version__}")


def hints(program, folder):
    """Every command that a hint names, run to the letter."""
    cylinder(1)
    gmsh.model.removePhysicalGroups()
    binary = pathlib.Path(sys.executable).parent
    environment = {**os.environ, "PATH": f"{binary}:{os.environ['PATH']}"}
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.option.setNumber("Mesh.Binary", 0)
    gmsh.option.setNumber("Mesh.SaveParametric", 0)
    files = [f"part.{ending}" for ending in ("step", "brep", "stl", "off", "obj", "iges", "mesh", "bdf", "unv", "vtk", "inp", "su2")]
    for file in files:
        gmsh.write(str(folder / file))
    meshio.read(folder / "part.vtk").write(folder / "part.vtu")
    meshio.read(folder / "part.stl").write(folder / "part.ply")
    for file in [*files, "part.vtu", "part.ply"]:
        refused = check(program, folder, file)
        assert refused.returncode == 2, (file, refused.stdout)
        commands = [c for c in re.findall(r"`([^`]+)`", refused.stderr) if not c.startswith(("pip ", "hysteron "))]
        assert commands, refused.stderr
        (folder / "part.msh").unlink(missing_ok=True)
        for command in commands:
            done = subprocess.run(command, shell=True, cwd=folder, env=environment, capture_output=True, text=True)
            assert done.returncode == 0, (file, command, done.stderr)
        made = check(program, folder, "part.msh")
        assert made.returncode == 0, (file, commands, made.stderr)
        volume = json.loads(made.stdout)["mesh"]["volume_m3"]
        # The polygon of the mesh that each route makes: within 15 % of the cylinder.
        assert abs(volume / (3.14159265 * 25 * 20e-9) - 1) < 0.15, (file, volume)
    print(f"{len(files) + 2} other files, by the commands of their hints")


def main(program, folder):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    folder = pathlib.Path(folder)
    versions(program, folder)
    hints(program, folder)


main(sys.argv[1], sys.argv[2])
