"""Classes and functions with the names and shapes of other Voronoi packages, computed by votess.

Change the import line and keep the program. ``pyvotess.compat.scipy`` has Voronoi and Delaunay of scipy.spatial, and
``pyvotess.compat.freud`` has Voronoi of freud.locality, both for two and three dimensions. ``pyvotess.compat.pyvoro`` has
compute_voronoi of pyvoro. SciPy is imported for its QhullError, freud for its boxes. Each module lists the differences.
"""
