"""Integrals over the cells, and what is made with them."""
