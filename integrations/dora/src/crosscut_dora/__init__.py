"""Stages of crosscut as nodes of a dora dataflow; ``crosscut-dora --help`` and the README say how."""

__version__ = "0.3.0"
