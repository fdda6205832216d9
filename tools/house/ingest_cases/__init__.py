"""The table of cases of ingest: a generated series for each, what it must become, and what it became."""
