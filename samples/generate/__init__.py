"""Generators of the sample meshes; samples/make_meshes.py runs them."""
