-- Anonymising: everything outside a region that the owner chose is overwritten and cropped permanently.
ALTER TABLE data_sets
  ADD COLUMN cut_problem  text,                        -- reason why the last cut failed
  ADD COLUMN head         jsonb;                       -- whether the scan shows a head, and a proposed crop of the face (ingest/head)

-- Jobs that cut have no upload.
ALTER TABLE ingest_jobs
  ALTER COLUMN upload_id DROP NOT NULL,
  ADD COLUMN cut        jsonb,                         -- volume/region.h
  ADD COLUMN cut_of     text,                          -- hash of the volume that the owner saw
  ADD COLUMN cut_result text,                          -- hash of the new volume, before it replaces the old one
  ADD COLUMN cut_shift  double precision[],            -- in mm; a point p moves to p - shift
  ADD COLUMN asked_by   uuid,
  ADD CONSTRAINT ingest_jobs_kind CHECK ((cut IS NULL) = (upload_id IS NOT NULL) AND (cut IS NULL) = (cut_of IS NULL));

ALTER TABLE disposals DROP CONSTRAINT disposals_kind_check;
ALTER TABLE disposals ADD CONSTRAINT disposals_kind_check CHECK (kind IN ('upload', 'volume', 'export', 'pictures'));
