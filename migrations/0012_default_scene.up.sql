-- The scene of the default preset at the time when the owner chose it. Its author may change the preset later, and the owner
-- has not approved those changes.
ALTER TABLE data_sets ADD COLUMN default_scene text CHECK (octet_length(default_scene) <= 524288);
UPDATE data_sets d SET default_scene = p.scene FROM presets p WHERE p.id = d.default_preset_id;
