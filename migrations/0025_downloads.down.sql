ALTER TABLE data_sets DROP COLUMN public_downloads;
ALTER TABLE data_set_links DROP COLUMN downloads;
ALTER TABLE data_set_people DROP COLUMN downloads;
ALTER TABLE data_set_people DROP COLUMN slices;
