DROP TABLE reports, visits, data_set_links, data_set_people;
ALTER TABLE data_sets ADD COLUMN is_public boolean NOT NULL DEFAULT false;
UPDATE data_sets SET is_public = (visibility = 'public');
CREATE INDEX data_sets_public ON data_sets (created_at DESC, id) WHERE is_public;
ALTER TABLE data_sets DROP COLUMN words, DROP COLUMN taken_down_reason, DROP COLUMN taken_down_at, DROP COLUMN anonymised_at,
  DROP COLUMN published_at, DROP COLUMN visibility, DROP COLUMN body_part, DROP COLUMN description;
ALTER TABLE users DROP COLUMN public_name;
