"""How well heads are detected: real and synthetic volumes, each labelled, and the table of results."""
