-- Deletes pending cuts. Completed cuts cannot be undone.
UPDATE data_sets SET state = 'ready' FROM ingest_jobs j WHERE j.data_set_id = data_sets.id AND j.cut IS NOT NULL;
DELETE FROM ingest_jobs WHERE cut IS NOT NULL;
DELETE FROM disposals WHERE kind = 'pictures';
ALTER TABLE disposals DROP CONSTRAINT disposals_kind_check;
ALTER TABLE disposals ADD CONSTRAINT disposals_kind_check CHECK (kind IN ('upload', 'volume', 'export'));
ALTER TABLE ingest_jobs
  DROP CONSTRAINT ingest_jobs_kind, DROP COLUMN cut, DROP COLUMN cut_of, DROP COLUMN cut_result, DROP COLUMN cut_shift,
  DROP COLUMN asked_by, ALTER COLUMN upload_id SET NOT NULL;
ALTER TABLE data_sets DROP COLUMN cut_problem, DROP COLUMN head;
