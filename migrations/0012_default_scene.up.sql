-- The scene of the default preset as it was when the owner chose it: its author may change the preset afterwards, and the
-- owner has not seen that.
ALTER TABLE data_sets ADD COLUMN default_scene text CHECK (octet_length(default_scene) <= 524288);
UPDATE data_sets d SET default_scene = p.scene FROM presets p WHERE p.id = d.default_preset_id;
