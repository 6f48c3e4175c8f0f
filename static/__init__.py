"""Files that ship with the package: robot description, meshes, example motions, icons."""
