-- Jobs that wait for a temporary condition to end (a full disk, too little memory, an unavailable service), and fair
-- scheduling of accounts.
ALTER TABLE ingest_jobs
  ADD COLUMN waits       int NOT NULL DEFAULT 0,  -- consecutive waits; the delay doubles each time
  ADD COLUMN waiting_for text CHECK (waiting_for IN ('room', 'memory', 'service')),  -- NULL: waits only for its turn
  ADD COLUMN large       boolean NOT NULL DEFAULT false;  -- needs more memory than the light worker has

-- Last time that a job of the account was claimed. The account that has waited longest is next.
CREATE TABLE ingest_turns (
  user_id    uuid PRIMARY KEY REFERENCES users ON DELETE CASCADE,
  served_at  timestamptz NOT NULL
);

ALTER TABLE exports
  ADD COLUMN waits      int NOT NULL DEFAULT 0,
  ADD COLUMN waiting    boolean NOT NULL DEFAULT false,  -- for disk space or an unavailable service
  ADD COLUMN not_before timestamptz;
