ALTER TABLE exports DROP COLUMN waits, DROP COLUMN waiting, DROP COLUMN not_before;
DROP TABLE ingest_turns;
ALTER TABLE ingest_jobs DROP COLUMN waits, DROP COLUMN waiting_for, DROP COLUMN large;
