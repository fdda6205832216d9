"""The accuracy of head detection: labelled real and synthetic volumes, and the table of results."""
