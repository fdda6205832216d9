-- Access to data sets for invited people, holders of a link, and everyone (the gallery), and reports of abuse.
ALTER TABLE users ADD COLUMN public_name text NOT NULL DEFAULT '' CHECK (length(public_name) <= 40);  -- chosen by the user; never the email address

ALTER TABLE data_sets
  ADD COLUMN description      text NOT NULL DEFAULT '' CHECK (length(description) <= 2000),
  ADD COLUMN body_part        text CHECK (body_part IN ('head', 'neck', 'chest', 'abdomen', 'pelvis', 'spine', 'arm', 'leg', 'whole', 'other')),
  ADD COLUMN visibility       text NOT NULL DEFAULT 'private' CHECK (visibility IN ('private', 'public')),
  ADD COLUMN published_at     timestamptz,        -- set while visibility is 'public'
  ADD COLUMN anonymised_at    timestamptz,        -- when the owner confirmed it; required for publishing
  ADD COLUMN taken_down_at    timestamptz,        -- by an administrator; private and not shared until restored
  ADD COLUMN taken_down_reason text CHECK (length(taken_down_reason) <= 500),
  ADD COLUMN words            tsvector GENERATED ALWAYS AS
    (setweight(to_tsvector('simple', title), 'A') || setweight(to_tsvector('simple', description), 'B')) STORED;
UPDATE data_sets SET visibility = 'public', published_at = created_at, anonymised_at = created_at WHERE is_public;
ALTER TABLE data_sets DROP COLUMN is_public,
  ADD CHECK ((visibility = 'public') = (published_at IS NOT NULL)),
  ADD CHECK (visibility = 'private' OR (anonymised_at IS NOT NULL AND taken_down_at IS NULL));
CREATE INDEX data_sets_gallery ON data_sets (published_at DESC, id DESC) WHERE visibility = 'public';
CREATE INDEX data_sets_words ON data_sets USING gin (words) WHERE visibility = 'public';

-- Invitations by email address. An invitation waits until an account confirms the address. From then on, it belongs to
-- that account, even if its address changes. The owner never learns which account that is.
CREATE TABLE data_set_people (
  id           uuid PRIMARY KEY,
  data_set_id  uuid NOT NULL REFERENCES data_sets ON DELETE CASCADE,
  email_key    text NOT NULL CHECK (length(email_key) BETWEEN 3 AND 254),
  may_save     boolean NOT NULL,                  -- may save presets; otherwise view only
  user_id      uuid REFERENCES users ON DELETE CASCADE,
  created_at   timestamptz NOT NULL,
  UNIQUE (data_set_id, email_key)
);
CREATE UNIQUE INDEX data_set_people_user ON data_set_people (user_id, data_set_id);
CREATE INDEX data_set_people_waiting ON data_set_people (email_key) WHERE user_id IS NULL;

CREATE TABLE data_set_links (
  id           uuid PRIMARY KEY,
  data_set_id  uuid NOT NULL REFERENCES data_sets ON DELETE CASCADE,
  token_hash   text NOT NULL UNIQUE,              -- BLAKE2b-256, hexadecimal
  created_at   timestamptz NOT NULL,
  expires_at   timestamptz NOT NULL
);
CREATE INDEX data_set_links_data_set ON data_set_links (data_set_id, created_at);
CREATE INDEX data_set_links_expiry ON data_set_links (expires_at);

-- Sessions of people without an account, who came by a link or view a sample.
CREATE TABLE visits (
  session_id   uuid PRIMARY KEY,
  data_set_id  uuid NOT NULL REFERENCES data_sets ON DELETE CASCADE,
  link_id      uuid REFERENCES data_set_links ON DELETE CASCADE,  -- NULL for a sample
  expires_at   timestamptz NOT NULL
);
CREATE INDEX visits_expiry ON visits (expires_at);

-- Reports of abuse. A user has at most one open report per data set.
CREATE TABLE reports (
  id           uuid PRIMARY KEY,
  data_set_id  uuid NOT NULL REFERENCES data_sets ON DELETE CASCADE,
  reporter_id  uuid REFERENCES users ON DELETE SET NULL,
  reason       text NOT NULL CHECK (reason IN ('identifies', 'not_theirs', 'offensive', 'other')),
  words        text NOT NULL DEFAULT '' CHECK (length(words) <= 1000),
  created_at   timestamptz NOT NULL,
  closed_at    timestamptz
);
CREATE UNIQUE INDEX reports_one_open ON reports (data_set_id, reporter_id) WHERE closed_at IS NULL;
CREATE INDEX reports_open ON reports (created_at, id) WHERE closed_at IS NULL;
