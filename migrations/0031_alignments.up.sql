-- Rigid alignments of two scans that share no frame of reference. ingestd computes them. The motion maps the patient
-- coordinates (mm, LPS) of `moving` to those of `fixed`.
CREATE TABLE alignments (
  moving        uuid NOT NULL REFERENCES data_sets ON DELETE CASCADE,
  fixed         uuid NOT NULL REFERENCES data_sets ON DELETE CASCADE,
  requested_by  uuid REFERENCES users ON DELETE SET NULL,
  state         text NOT NULL DEFAULT 'waiting' CHECK (state IN ('waiting', 'running', 'ready', 'failed')),
  matrix        double precision[],              -- row-major 4 x 4
  metric        text,                            -- how the result was measured, for researchers
  residual_mm   double precision,                -- expected remaining displacement
  overlap       double precision,                -- share of the smaller scan that lies in the other, 0 to 1
  reason        text,                            -- why it failed, as a code (ingest/registration/register.h)
  attempts      int NOT NULL DEFAULT 0,          -- claims that ended without a result
  waits         int NOT NULL DEFAULT 0,
  not_before    timestamptz NOT NULL DEFAULT now(),
  leased_by     text,
  leased_until  timestamptz,
  created_at    timestamptz NOT NULL DEFAULT now(),
  PRIMARY KEY (moving, fixed),
  CHECK (moving <> fixed),
  CHECK (matrix IS NULL OR array_length(matrix, 1) = 16),
  CHECK (state <> 'ready' OR (matrix IS NOT NULL AND residual_mm IS NOT NULL AND overlap IS NOT NULL))
);
CREATE INDEX alignments_fixed ON alignments (fixed);
CREATE INDEX alignments_requested_by ON alignments (requested_by);

-- A scan that is no longer ready is being anonymised, so its alignments came from voxels that will be removed.
CREATE FUNCTION end_alignments() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  DELETE FROM alignments WHERE moving = NEW.id OR fixed = NEW.id;
  RETURN NULL;
END $$;
CREATE TRIGGER alignments_of_changed_scans AFTER UPDATE OF state ON data_sets
  FOR EACH ROW WHEN (OLD.state = 'ready' AND NEW.state <> 'ready') EXECUTE FUNCTION end_alignments();
