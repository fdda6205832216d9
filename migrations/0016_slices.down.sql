ALTER TABLE data_sets DROP COLUMN public_slices;
ALTER TABLE data_set_links DROP COLUMN slices;
