ALTER TABLE presets DROP COLUMN annotations;
DROP TABLE annotations;
