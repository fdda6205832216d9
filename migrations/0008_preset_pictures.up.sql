-- Thumbnails of presets in the cache, reports about presets, and presets taken down by an administrator.
ALTER TABLE presets
  ADD COLUMN pictured_at        timestamptz,                                -- NULL: the thumbnail must be rendered
  ADD COLUMN picture_not_before timestamptz NOT NULL DEFAULT '-infinity',   -- time of the next attempt
  ADD COLUMN picture_tries      int NOT NULL DEFAULT 0,
  ADD COLUMN taken_down_at      timestamptz,                                -- then only its author and administrators see it
  ADD COLUMN taken_down_reason  text CHECK (length(taken_down_reason) <= 500);
CREATE INDEX presets_to_picture ON presets (picture_not_before) WHERE pictured_at IS NULL;

ALTER TABLE disposals DROP CONSTRAINT disposals_kind_check;
ALTER TABLE disposals ADD CONSTRAINT disposals_kind_check CHECK (kind IN ('upload', 'volume', 'export', 'pictures', 'preset'));

-- Schedules the thumbnail for deletion, in the same transaction, when its preset is deleted (also together with the data
-- set or the account of its author) or the thumbnail becomes outdated.
CREATE FUNCTION preset_changed() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF NEW.scene IS DISTINCT FROM OLD.scene THEN
    NEW.pictured_at := NULL;
    NEW.picture_tries := 0;
    NEW.picture_not_before := '-infinity';
  END IF;
  IF OLD.pictured_at IS NOT NULL AND NEW.pictured_at IS NULL THEN
    INSERT INTO disposals (kind, id) VALUES ('preset', OLD.id) ON CONFLICT DO NOTHING;
    NEW.picture_tries := 0;
    NEW.picture_not_before := '-infinity';
  END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER preset_changed BEFORE UPDATE ON presets FOR EACH ROW EXECUTE FUNCTION preset_changed();

CREATE FUNCTION preset_gone() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  INSERT INTO disposals (kind, id) VALUES ('preset', OLD.id) ON CONFLICT DO NOTHING;
  RETURN NULL;
END $$;
CREATE TRIGGER preset_gone AFTER DELETE ON presets FOR EACH ROW EXECUTE FUNCTION preset_gone();

-- A report concerns a data set or one of its presets.
ALTER TABLE reports ADD COLUMN preset_id uuid REFERENCES presets ON DELETE CASCADE;
DROP INDEX reports_one_open;
CREATE UNIQUE INDEX reports_one_open ON reports (data_set_id, reporter_id) WHERE closed_at IS NULL AND preset_id IS NULL;
CREATE UNIQUE INDEX reports_one_open_of_preset ON reports (preset_id, reporter_id) WHERE closed_at IS NULL AND preset_id IS NOT NULL;
-- The text of a report is deleted with the account of its author.
UPDATE reports SET words = '' WHERE reporter_id IS NULL;
