-- Exact slices are shown to people without an account, and of public scans, only where the owner says so.
ALTER TABLE data_set_links ADD COLUMN slices boolean NOT NULL DEFAULT false;
ALTER TABLE data_sets ADD COLUMN public_slices boolean NOT NULL DEFAULT false;  -- of a sample it is always so
