ALTER TABLE data_sets DROP COLUMN frame_of_reference;
ALTER TABLE users DROP COLUMN frame_key;
