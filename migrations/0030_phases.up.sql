-- Scans with several phases (docs/contracts.md). An older `ingestd` stores none, so the defaults hold for it.
ALTER TABLE data_sets ADD COLUMN phases int NOT NULL DEFAULT 1 CHECK (phases >= 1);
-- The phase whose surface `above` encloses.
ALTER TABLE scan_exports ADD COLUMN phase int NOT NULL DEFAULT 0 CHECK (phase >= 0);
