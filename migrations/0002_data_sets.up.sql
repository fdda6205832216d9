-- A data set: one uploaded series and the volume built from it. No text from the scan itself is stored.
CREATE TABLE data_sets (
  id            uuid PRIMARY KEY,               -- also the name of the volume's directory
  owner_id      uuid REFERENCES users ON DELETE CASCADE,  -- NULL for the sample
  title         text NOT NULL DEFAULT '' CHECK (length(title) <= 80),  -- typed by the owner, never read from the scan
  state         text NOT NULL CHECK (state IN ('uploading', 'queued', 'building', 'ready', 'refused', 'expired')),
  refusal_code  text,                           -- such as 'too_few_slices'; only in the state 'refused'
  refusal_text  text,                           -- a sentence for the owner
  is_public     boolean NOT NULL DEFAULT false,
  is_sample     boolean NOT NULL DEFAULT false,
  modality      text,                           -- of the built volume: 'CT', 'MR', 'PT', 'OTHER'
  size_x int, size_y int, size_z int,
  spacing_x double precision, spacing_y double precision, spacing_z double precision,
  repairs       text[] NOT NULL DEFAULT '{}',
  volume_bytes  bigint,
  created_at    timestamptz NOT NULL DEFAULT now(),
  updated_at    timestamptz NOT NULL DEFAULT now()
);
CREATE INDEX data_sets_owner ON data_sets (owner_id, created_at DESC, id);
CREATE INDEX data_sets_public ON data_sets (created_at DESC, id) WHERE is_public;

-- Uploads (tus 1.0). The upload directory contains their bytes, as <id>.tar.
CREATE TABLE uploads (
  id            uuid PRIMARY KEY,
  data_set_id   uuid NOT NULL UNIQUE REFERENCES data_sets ON DELETE CASCADE,
  length        bigint NOT NULL CHECK (length > 0),
  received      bigint NOT NULL DEFAULT 0 CHECK (received BETWEEN 0 AND length),
  expires_at    timestamptz NOT NULL
);
CREATE INDEX uploads_expiry ON uploads (expires_at);

-- Jobs for ingestd, which claims them with FOR UPDATE SKIP LOCKED and holds them with a lease that it renews.
CREATE TABLE ingest_jobs (
  data_set_id   uuid PRIMARY KEY REFERENCES data_sets ON DELETE CASCADE,
  upload_id     uuid NOT NULL,
  attempts      int NOT NULL DEFAULT 0,
  leased_by     text,
  leased_until  timestamptz,
  not_before    timestamptz NOT NULL DEFAULT now(),
  created_at    timestamptz NOT NULL DEFAULT now()
);
CREATE INDEX ingest_jobs_free ON ingest_jobs (not_before, created_at);

-- IDs of files and directories to delete from disk, because their rows were deleted.
CREATE TABLE disposals (
  kind        text NOT NULL CHECK (kind IN ('upload', 'volume')),
  id          uuid NOT NULL,
  created_at  timestamptz NOT NULL DEFAULT now(),
  PRIMARY KEY (kind, id)
);
