"""Small meshes written by Gmsh itself. `python make_samples.py` in this folder, with `pip install gmsh==4.15.2`."""

import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("General.NumThreads", 1)


def cylinder(name, order=1, binary=0, parametric=0, names=True, version=4.1):
    gmsh.clear()
    gmsh.model.add("cylinder")
    gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 20, 5)
    gmsh.model.occ.synchronize()
    by_z = {round(gmsh.model.occ.getCenterOfMass(2, t)[2]): t for _, t in gmsh.model.getEntities(2)}
    gmsh.model.addPhysicalGroup(2, [by_z[0]], 1, "clamped end" if names else "")
    gmsh.model.addPhysicalGroup(2, [by_z[20]], 2, "tip" if names else "")
    gmsh.model.addPhysicalGroup(3, [1], 1, "body" if names else "")
    gmsh.option.setNumber("Mesh.MeshSizeMin", 6)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 6)
    gmsh.option.setNumber("Mesh.SecondOrderLinear", 1)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.option.setNumber("Mesh.SaveParametric", parametric)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(order)
    gmsh.write(name)
    print(name, len(gmsh.model.mesh.getNodes()[0]), gmsh.model.mesh.getElements(3)[0])
    for d, t in gmsh.model.getPhysicalGroups():
        nodes = gmsh.model.mesh.getNodesForPhysicalGroup(d, t)[0]
        print("  group", d, t, gmsh.model.getPhysicalName(d, t), len(nodes))
    types, tags, _ = gmsh.model.mesh.getElements(3)
    print("  tets", len(tags[0]), "volume", sum(gmsh.model.mesh.getElementQualities(tags[0], "volume")))


cylinder("cylinder.msh")
cylinder("cylinder-binary.msh", binary=1)
cylinder("cylinder-parametric.msh", parametric=1)
cylinder("cylinder-unnamed.msh", names=False)
cylinder("cylinder-quadratic.msh", order=2)
cylinder("cylinder-quadratic-binary.msh", order=2, binary=1)
cylinder("cylinder-format22.msh", version=2.2)

gmsh.clear()
gmsh.model.add("box")
gmsh.option.setNumber("Mesh.Binary", 0)
gmsh.option.setNumber("Mesh.SaveParametric", 0)
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
gmsh.model.occ.extrude([(2, 1)], 0, 0, 1, numElements=[1], recombine=True)
gmsh.model.occ.synchronize()
gmsh.option.setNumber("Mesh.MeshSizeMin", 2)
gmsh.option.setNumber("Mesh.MeshSizeMax", 2)
gmsh.model.mesh.generate(3)
gmsh.write("prisms.msh")

# The rod in every version, encoding and partitioning.
for name, version, binary, partitions, ghosts in [
    ("rod-1", 1, 0, 0, 0),
    ("rod-22", 2.2, 0, 0, 0),
    ("rod-22-binary", 2.2, 1, 0, 0),
    ("rod-22-ghosts", 2.2, 0, 3, 1),
    ("rod-22-binary-ghosts", 2.2, 1, 3, 1),
    ("rod-40", 4.0, 0, 0, 0),
    ("rod-40-ghosts", 4.0, 0, 3, 1),
    ("rod-41-binary", 4.1, 1, 0, 0),
    ("rod-41-binary-ghosts", 4.1, 1, 3, 1),
]:
    gmsh.clear()
    gmsh.open("rod-41.msh")
    if partitions:
        gmsh.option.setNumber("Mesh.PartitionCreateGhostCells", ghosts)
        gmsh.model.mesh.partition(partitions)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.write(name + ".msh")

gmsh.clear()
gmsh.model.add("groups")
gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 20, 5)
gmsh.model.occ.synchronize()
gmsh.model.addPhysicalGroup(3, [1], 1, "body")
gmsh.model.addPhysicalGroup(3, [1], 2, "all")
gmsh.model.addPhysicalGroup(2, [3], 5, "base")
gmsh.option.setNumber("Mesh.MeshSizeMin", 8)
gmsh.option.setNumber("Mesh.MeshSizeMax", 8)
gmsh.model.mesh.generate(3)
for name, version, binary, parametric in [
    ("groups-22-parametric", 2.2, 0, 1),
    ("groups-22-parametric-binary", 2.2, 1, 1),
    ("groups-41", 4.1, 0, 0),
]:
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.option.setNumber("Mesh.SaveParametric", parametric)
    gmsh.write(name + ".msh")
