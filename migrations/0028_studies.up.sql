-- Studies of perception. Researchers compose them, and people without an account take part through a link.
ALTER TABLE users ADD COLUMN is_researcher boolean NOT NULL DEFAULT false;  -- granted by an administrator

CREATE TABLE studies (
  id           uuid PRIMARY KEY,
  owner_id     uuid NOT NULL REFERENCES users ON DELETE CASCADE,
  definition   text NOT NULL CHECK (octet_length(definition) <= 1000000),  -- JSON, checked by api
  title        text NOT NULL CHECK (octet_length(title) <= 8000),          -- the definition's title, as JSON
  places       int NOT NULL CHECK (places BETWEEN 1 AND 1000),
  ends_at      timestamptz NOT NULL,
  version      int NOT NULL DEFAULT 1,          -- the ETag of the definition
  state        text NOT NULL CHECK (state IN ('draft', 'open', 'closed')),
  token_hash   text UNIQUE,                     -- BLAKE2b-256 of the link's token; NULL without a link
  next_number  int NOT NULL DEFAULT 1,          -- of the next participant
  withdrawn    int NOT NULL DEFAULT 0,          -- all that remains of the participants who withdrew
  opened_at    timestamptz,
  closed_at    timestamptz,
  created_at   timestamptz NOT NULL
);
CREATE INDEX studies_owner ON studies (owner_id, created_at DESC, id DESC);
CREATE INDEX studies_end ON studies (ends_at) WHERE state = 'open';

-- A participant is a random key, of which the server stores a hash, and what they answered. Nothing here says who or
-- where they are, and no time is more precise than a day.
CREATE TABLE study_participants (
  id                  uuid PRIMARY KEY,
  study_id            uuid NOT NULL REFERENCES studies ON DELETE CASCADE,
  number              int NOT NULL,
  key_hash            text NOT NULL UNIQUE,
  language            text NOT NULL CHECK (language IN ('en', 'de')),
  seed                bigint NOT NULL,
  day                 date NOT NULL,            -- on which they joined, in UTC
  recorded            boolean NOT NULL,         -- agreed to the recording of how they move
  finished            boolean NOT NULL DEFAULT false,
  preview_until       timestamptz,              -- set for the researcher's own preview, which is never exported
  session_id          uuid,                     -- of their render session
  session_expires_at  timestamptz,
  UNIQUE (study_id, number)
);
CREATE INDEX study_participants_preview ON study_participants (preview_until) WHERE preview_until IS NOT NULL;
CREATE INDEX study_participants_session ON study_participants (session_expires_at) WHERE session_id IS NOT NULL;

CREATE TABLE study_answers (
  participant_id  uuid NOT NULL REFERENCES study_participants ON DELETE CASCADE,
  step            text NOT NULL,
  value           text NOT NULL CHECK (octet_length(value) <= 16384),
  duration_ms     bigint NOT NULL CHECK (duration_ms >= 0),
  sequence        bigint NOT NULL,              -- the answer with the highest one stays
  PRIMARY KEY (participant_id, step)
);

CREATE TABLE study_recordings (
  participant_id  uuid NOT NULL REFERENCES study_participants ON DELETE CASCADE,
  step            text NOT NULL,
  body            text NOT NULL CHECK (octet_length(body) <= 1048576),
  PRIMARY KEY (participant_id, step)
);

CREATE TABLE study_pictures (
  study_id    uuid NOT NULL REFERENCES studies ON DELETE CASCADE,
  picture_id  text NOT NULL,
  type        text NOT NULL CHECK (type IN ('image/jpeg', 'image/png')),
  bytes       bytea NOT NULL CHECK (octet_length(bytes) <= 524288),
  PRIMARY KEY (study_id, picture_id)
);

-- The differences in comfort that the page uses in place of published ones, from a study of this installation.
CREATE TABLE perception_comfort (
  only_row    boolean PRIMARY KEY DEFAULT true CHECK (only_row),
  comfort     text NOT NULL CHECK (octet_length(comfort) <= 16384)   -- JSON, as GET /v1/perception returns it
);
