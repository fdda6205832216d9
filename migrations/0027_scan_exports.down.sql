-- Deletes the rows but not the files: delete exports/*.scan in the cache directory by hand.
DROP TRIGGER exports_of_changed_scans ON data_sets;
DROP FUNCTION end_scan_exports();
DROP TABLE scan_exports;
DROP FUNCTION dispose_of_scan_export();
DELETE FROM disposals WHERE kind = 'scan-export';
ALTER TABLE disposals DROP CONSTRAINT disposals_kind_check;
ALTER TABLE disposals ADD CONSTRAINT disposals_kind_check
  CHECK (kind IN ('upload', 'volume', 'export', 'pictures', 'preset', 'environment'));
