DROP TABLE environments;
DROP FUNCTION environment_gone;
DELETE FROM disposals WHERE kind = 'environment';
ALTER TABLE disposals DROP CONSTRAINT disposals_kind_check;
ALTER TABLE disposals ADD CONSTRAINT disposals_kind_check CHECK (kind IN ('upload', 'volume', 'export', 'pictures', 'preset'));
