ALTER TABLE data_sets DROP COLUMN default_scene;
