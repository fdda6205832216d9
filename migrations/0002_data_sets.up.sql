-- A data set: one series of slices on its way to a volume. Nothing of the scan's own texts is here.
CREATE TABLE data_sets (
  id            uuid PRIMARY KEY,               -- also the volume's directory
  owner_id      uuid REFERENCES users ON DELETE CASCADE,  -- NULL: the sample
  title         text NOT NULL DEFAULT '' CHECK (length(title) <= 80),  -- typed by the owner, never read from the scan
  state         text NOT NULL CHECK (state IN ('uploading', 'queued', 'building', 'ready', 'refused', 'expired')),
  refusal_code  text,                           -- 'too_few_slices', ... : set with state refused
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

-- The bytes of a data set while they arrive (tus 1.0), as one tar file `<id>.tar` in the upload directory.
CREATE TABLE uploads (
  id            uuid PRIMARY KEY,
  data_set_id   uuid NOT NULL UNIQUE REFERENCES data_sets ON DELETE CASCADE,
  length        bigint NOT NULL CHECK (length > 0),
  received      bigint NOT NULL DEFAULT 0 CHECK (received BETWEEN 0 AND length),
  expires_at    timestamptz NOT NULL
);
CREATE INDEX uploads_expiry ON uploads (expires_at);

-- Work for ingestd: claimed by FOR UPDATE SKIP LOCKED, held by a lease that the claimer renews.
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

-- Directories and files to be removed from disk after the row that named them has gone (ids only).
CREATE TABLE disposals (
  kind        text NOT NULL CHECK (kind IN ('upload', 'volume')),
  id          uuid NOT NULL,
  created_at  timestamptz NOT NULL DEFAULT now(),
  PRIMARY KEY (kind, id)
);
