-- Recorded interactions (docs/contracts.md, "Recorded interaction"), made with the user's consent. The row names the
-- user, so that they can export and delete the recording. The recording itself identifies nobody.
ALTER TABLE users ADD COLUMN recording_consent_at timestamptz;  -- NULL: no consent

CREATE TABLE recordings (
  id          uuid PRIMARY KEY,
  user_id     uuid NOT NULL REFERENCES users ON DELETE CASCADE,
  body        text NOT NULL CHECK (octet_length(body) <= 1048576),
  events      integer NOT NULL CHECK (events > 0),
  duration_ms bigint NOT NULL CHECK (duration_ms >= 0),
  created_at  timestamptz NOT NULL,
  expires_at  timestamptz NOT NULL
);
CREATE INDEX recordings_user ON recordings (user_id, created_at);
CREATE INDEX recordings_expiry ON recordings (expires_at);
