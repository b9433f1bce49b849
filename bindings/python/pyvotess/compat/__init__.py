"""Classes and functions with the names and shapes of other Voronoi packages, computed by votess.

Change the import line and keep the program: ``pyvotess.compat.scipy`` has Voronoi and Delaunay of scipy.spatial for
three dimensions, ``pyvotess.compat.pyvoro`` has pyvoro's compute_voronoi. Neither of
the packages is imported, except SciPy for its QhullError. Each module lists what differs.
"""
