"""The commands of `./diaphane`. Standard library only, so that `up` needs no virtual environment. Each module makes a plan as
plain data (what to install, build, start or run), which a thin second half executes."""
