-- Jobs that were interrupted because ingestd ended. The upload need not be the cause, so the job is retried with a growing
-- delay.
ALTER TABLE ingest_jobs
  ADD COLUMN interruptions int NOT NULL DEFAULT 0,  -- how often its lease ran out
  DROP CONSTRAINT ingest_jobs_waiting_for_check,
  ADD CONSTRAINT ingest_jobs_waiting_for_check CHECK (waiting_for IN ('room', 'memory', 'service', 'interruption'));
