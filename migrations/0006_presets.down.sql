ALTER TABLE data_sets DROP COLUMN default_preset_id;
DROP TABLE preset_votes, presets;
