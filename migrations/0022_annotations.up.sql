-- Sets of marks and measurements of a scan, each by one author, and those that a preset shows. They contain free
-- text, so anonymising the scan deletes them.
CREATE TABLE annotations (
  id          uuid PRIMARY KEY,
  data_set_id uuid NOT NULL REFERENCES data_sets ON DELETE CASCADE,
  author_id   uuid NOT NULL REFERENCES users ON DELETE CASCADE,
  name        text NOT NULL CHECK (length(name) BETWEEN 1 AND 60),
  content     text NOT NULL CHECK (octet_length(content) <= 131072),  -- validated Protobuf JSON of Annotations
  shown       boolean NOT NULL DEFAULT true,                          -- visible when the scan is opened
  shared      boolean NOT NULL DEFAULT false,                         -- visible to all who may view the scan; only the owner sets it
  created_at  timestamptz NOT NULL,
  updated_at  timestamptz NOT NULL
);
CREATE INDEX annotations_data_set ON annotations (data_set_id, created_at, id);
CREATE INDEX annotations_author ON annotations (author_id);

ALTER TABLE presets ADD COLUMN annotations text CHECK (octet_length(annotations) <= 131072);
