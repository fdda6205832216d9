ALTER TABLE visits DROP COLUMN address_hash;
