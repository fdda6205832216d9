-- The owner of a scan chooses for each person, for each link and for the gallery whether slices and downloads (videos
-- and large pictures) are allowed. What people and the gallery could do before stays allowed.
ALTER TABLE data_set_people ADD COLUMN slices boolean NOT NULL DEFAULT true;
ALTER TABLE data_set_people ADD COLUMN downloads boolean NOT NULL DEFAULT true;
ALTER TABLE data_set_links ADD COLUMN downloads boolean NOT NULL DEFAULT false;
ALTER TABLE data_sets ADD COLUMN public_downloads boolean NOT NULL DEFAULT false;  -- always true for a sample
UPDATE data_sets SET public_downloads = true WHERE visibility = 'public';
