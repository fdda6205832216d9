-- Where a visitor asked from (BLAKE2b of the address), to bound the visits of one address. Gone with the visit.
ALTER TABLE visits ADD COLUMN address_hash text NOT NULL DEFAULT '';
