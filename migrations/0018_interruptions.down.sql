UPDATE ingest_jobs SET waiting_for = 'service' WHERE waiting_for = 'interruption';
ALTER TABLE ingest_jobs
  DROP COLUMN interruptions,
  DROP CONSTRAINT ingest_jobs_waiting_for_check,
  ADD CONSTRAINT ingest_jobs_waiting_for_check CHECK (waiting_for IN ('room', 'memory', 'service'));
