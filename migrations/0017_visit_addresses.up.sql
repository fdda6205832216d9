-- BLAKE2b hash of the address of a visitor, to limit the visits per address. It is deleted with the visit.
ALTER TABLE visits ADD COLUMN address_hash text NOT NULL DEFAULT '';
