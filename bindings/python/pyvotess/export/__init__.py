"""Results as files, as pictures, and as objects of other packages, which are imported only when they are called for."""
