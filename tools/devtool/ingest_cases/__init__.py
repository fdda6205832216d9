"""The table of ingest cases: a generated series for each, its expected result, and the actual one."""
