"""Integrals over the cells, and Lloyd's method."""
