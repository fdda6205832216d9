-- Jobs that wait for a condition that passes (a full disk, too little memory, a part that is away), and the order in
-- which accounts are served.
ALTER TABLE ingest_jobs
  ADD COLUMN waits       int NOT NULL DEFAULT 0,  -- how often in a row; the pause doubles each time
  ADD COLUMN waiting_for text CHECK (waiting_for IN ('room', 'memory', 'service')),  -- NULL: only for its turn
  ADD COLUMN large       boolean NOT NULL DEFAULT false;  -- needs more memory than the light worker has

-- When the jobs of an account were last taken up: the account that has waited longest is next.
CREATE TABLE ingest_turns (
  user_id    uuid PRIMARY KEY REFERENCES users ON DELETE CASCADE,
  served_at  timestamptz NOT NULL
);

ALTER TABLE exports
  ADD COLUMN waits      int NOT NULL DEFAULT 0,
  ADD COLUMN waiting    boolean NOT NULL DEFAULT false,  -- for room on the disk, or for a part that is away
  ADD COLUMN not_before timestamptz;
