DROP TRIGGER uploads_of_labels ON uploads;
DROP FUNCTION dispose_of_label_upload();
DELETE FROM ingest_jobs WHERE for_labels;
DELETE FROM uploads WHERE for_labels;
ALTER TABLE ingest_jobs DROP COLUMN for_labels;
ALTER TABLE uploads DROP COLUMN for_labels;
ALTER TABLE data_sets
  DROP COLUMN label_bytes,
  DROP COLUMN label_count,
  DROP COLUMN label_refusal_code,
  DROP COLUMN label_refusal_text;
