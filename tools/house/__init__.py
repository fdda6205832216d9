"""The house of Diaphane: what `./diaphane` does. Standard library only, so that `up` needs no virtual environment.

Each module makes a plan as plain data (what to install, build, start, run) and carries it out in a thin second half.
"""
