-- The labels of a scan: structures that someone has marked in it. Their voxels and names are in the file
-- `label_set` of the volume.
ALTER TABLE data_sets
  ADD COLUMN label_bytes        bigint NOT NULL DEFAULT 0,  -- counts towards the quota
  ADD COLUMN label_count        int NOT NULL DEFAULT 0,
  ADD COLUMN label_refusal_code text,                       -- why the last file of labels was refused
  ADD COLUMN label_refusal_text text;

-- While labels are uploaded and placed, their scan stays in the state 'ready'.
ALTER TABLE uploads ADD COLUMN for_labels boolean NOT NULL DEFAULT false;
ALTER TABLE ingest_jobs ADD COLUMN for_labels boolean NOT NULL DEFAULT false;

-- Unlike the upload of a scan, an upload of labels has its own ID, which is lost with its row. The trigger
-- schedules its file for deletion, whatever deletes the row.
CREATE FUNCTION dispose_of_label_upload() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  INSERT INTO disposals (kind, id) VALUES ('upload', OLD.id) ON CONFLICT DO NOTHING;
  RETURN NULL;
END $$;
CREATE TRIGGER uploads_of_labels AFTER DELETE ON uploads
  FOR EACH ROW WHEN (OLD.for_labels) EXECUTE FUNCTION dispose_of_label_upload();
