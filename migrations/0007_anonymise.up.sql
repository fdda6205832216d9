-- Anonymising: what is outside a region that the owner chose is overwritten and cropped away, for good.
ALTER TABLE data_sets
  ADD COLUMN cut_problem  text,                        -- why the last cut was not made
  ADD COLUMN head         jsonb;                       -- ingest/head: is there one, and a proposed cut of the face

-- A job that cuts has no upload.
ALTER TABLE ingest_jobs
  ALTER COLUMN upload_id DROP NOT NULL,
  ADD COLUMN cut        jsonb,                         -- volume/region.h
  ADD COLUMN cut_of     text,                          -- hash of the volume that was seen
  ADD COLUMN cut_result text,                          -- of the new one, before it is put in place
  ADD COLUMN cut_shift  double precision[],            -- mm: what was at p is at p - shift
  ADD COLUMN asked_by   uuid,
  ADD CONSTRAINT ingest_jobs_kind CHECK ((cut IS NULL) = (upload_id IS NOT NULL) AND (cut IS NULL) = (cut_of IS NULL));

ALTER TABLE disposals DROP CONSTRAINT disposals_kind_check;
ALTER TABLE disposals ADD CONSTRAINT disposals_kind_check CHECK (kind IN ('upload', 'volume', 'export', 'pictures'));
