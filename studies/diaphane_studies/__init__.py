"""The analysis of studies: pure functions of an exported study (docs/researchers.md, ADR 0038)."""
