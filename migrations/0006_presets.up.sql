-- Presets, and the votes on them.
CREATE TABLE presets (
  id           uuid PRIMARY KEY,
  data_set_id  uuid NOT NULL REFERENCES data_sets ON DELETE CASCADE,
  author_id    uuid NOT NULL REFERENCES users ON DELETE CASCADE,
  name         text NOT NULL CHECK (length(name) BETWEEN 1 AND 60),
  scene        text NOT NULL CHECK (octet_length(scene) <= 524288),     -- validated Protobuf JSON of Scene
  kept_xml     text CHECK (octet_length(kept_xml) <= 262144),           -- imported file, kept because it may contain unknown elements
  version      int NOT NULL DEFAULT 1,                                  -- increases with each change; the ETag
  created_at   timestamptz NOT NULL,
  updated_at   timestamptz NOT NULL
);
CREATE INDEX presets_data_set ON presets (data_set_id, created_at, id);
CREATE INDEX presets_author ON presets (author_id);

CREATE TABLE preset_votes (
  preset_id  uuid NOT NULL REFERENCES presets ON DELETE CASCADE,
  user_id    uuid NOT NULL REFERENCES users ON DELETE CASCADE,
  value      int NOT NULL CHECK (value IN (-1, 1)),
  PRIMARY KEY (preset_id, user_id)
);
CREATE INDEX preset_votes_user ON preset_votes (user_id);

ALTER TABLE data_sets ADD COLUMN default_preset_id uuid REFERENCES presets ON DELETE SET NULL;  -- chosen by the owner
CREATE INDEX data_sets_default_preset ON data_sets (default_preset_id) WHERE default_preset_id IS NOT NULL;
