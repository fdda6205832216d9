-- Exports of scans: one file per person, in the cache directory like the exports of accounts. ingestd makes it.
CREATE TABLE scan_exports (
  id            uuid PRIMARY KEY,               -- also the name of the file
  user_id       uuid NOT NULL UNIQUE REFERENCES users ON DELETE CASCADE,
  data_set_id   uuid NOT NULL REFERENCES data_sets ON DELETE CASCADE,
  format        text NOT NULL CHECK (format IN ('nifti', 'stl', 'glb')),
  label         bigint,                         -- number of the label whose surface it is, or
  above         int,                            -- smallest value that the surface encloses
  state         text NOT NULL CHECK (state IN ('queued', 'ready', 'failed')),
  bytes         bigint,                         -- of the file, or reserved for it while it is queued
  problem_code  text,                           -- why it failed
  problem_text  text,
  attempts      int NOT NULL DEFAULT 0,         -- claims that ended without a result
  waits         int NOT NULL DEFAULT 0,
  waiting       boolean NOT NULL DEFAULT false, -- for disk space or memory
  not_before    timestamptz NOT NULL DEFAULT now(),
  leased_by     text,
  leased_until  timestamptz,
  created_at    timestamptz NOT NULL,
  expires_at    timestamptz NOT NULL,
  CHECK (CASE WHEN format = 'nifti' THEN label IS NULL AND above IS NULL ELSE (label IS NULL) <> (above IS NULL) END)
);
CREATE INDEX scan_exports_data_set ON scan_exports (data_set_id);
CREATE INDEX scan_exports_expiry ON scan_exports (expires_at);

ALTER TABLE disposals DROP CONSTRAINT disposals_kind_check;
ALTER TABLE disposals ADD CONSTRAINT disposals_kind_check
  CHECK (kind IN ('upload', 'volume', 'export', 'pictures', 'preset', 'environment', 'scan-export'));

-- Schedules the file for deletion, whatever deletes the row: expiry, a new request, or the scan's or the account's end.
CREATE FUNCTION dispose_of_scan_export() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  INSERT INTO disposals (kind, id) VALUES ('scan-export', OLD.id) ON CONFLICT DO NOTHING;
  RETURN NULL;
END $$;
CREATE TRIGGER files_of_scan_exports AFTER DELETE ON scan_exports
  FOR EACH ROW EXECUTE FUNCTION dispose_of_scan_export();

-- A scan that is no longer ready is being anonymised, so its exports contain what will be removed. A trigger also covers
-- an api of an earlier version, which does not know of exports.
CREATE FUNCTION end_scan_exports() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  DELETE FROM scan_exports WHERE data_set_id = NEW.id;
  RETURN NULL;
END $$;
CREATE TRIGGER exports_of_changed_scans AFTER UPDATE OF state ON data_sets
  FOR EACH ROW WHEN (OLD.state = 'ready' AND NEW.state <> 'ready') EXECUTE FUNCTION end_scan_exports();
