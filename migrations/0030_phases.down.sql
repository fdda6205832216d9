ALTER TABLE scan_exports DROP COLUMN phase;
ALTER TABLE data_sets DROP COLUMN phases;
