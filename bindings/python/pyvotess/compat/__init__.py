"""Classes and functions with the names and shapes of other Voronoi packages, computed by votess.

Change the import line and keep the program. ``pyvotess.compat.scipy`` has Voronoi and Delaunay of scipy.spatial for
three dimensions; ``pyvotess.compat.pyvoro`` has compute_voronoi of pyvoro. Only SciPy is imported, for its QhullError.
Each module lists the differences.
"""
