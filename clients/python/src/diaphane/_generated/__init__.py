"""Code that `./diaphane client` generates from the API contract."""
