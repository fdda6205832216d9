-- People without an account see exact slices, and public scans show them, only if the owner allows it.
ALTER TABLE data_set_links ADD COLUMN slices boolean NOT NULL DEFAULT false;
ALTER TABLE data_sets ADD COLUMN public_slices boolean NOT NULL DEFAULT false;  -- always true for a sample
