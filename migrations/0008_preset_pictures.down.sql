DELETE FROM reports WHERE preset_id IS NOT NULL;
DROP INDEX reports_one_open, reports_one_open_of_preset;
ALTER TABLE reports DROP COLUMN preset_id;
CREATE UNIQUE INDEX reports_one_open ON reports (data_set_id, reporter_id) WHERE closed_at IS NULL;
DROP TRIGGER preset_changed ON presets;
DROP TRIGGER preset_gone ON presets;
DROP FUNCTION preset_changed();
DROP FUNCTION preset_gone();
DELETE FROM disposals WHERE kind = 'preset';
ALTER TABLE disposals DROP CONSTRAINT disposals_kind_check;
ALTER TABLE disposals ADD CONSTRAINT disposals_kind_check CHECK (kind IN ('upload', 'volume', 'export', 'pictures'));
-- Presets that were taken down must not reappear.
DELETE FROM presets WHERE taken_down_at IS NOT NULL;
DROP INDEX presets_to_picture;
ALTER TABLE presets DROP COLUMN pictured_at, DROP COLUMN picture_not_before, DROP COLUMN picture_tries,
  DROP COLUMN taken_down_at, DROP COLUMN taken_down_reason;
