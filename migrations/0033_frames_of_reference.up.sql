-- Tells whether two scans of one account have the same frame of reference. The hash is keyed by the account, so it links no
-- scans of different accounts, and the files of a volume contain none that could be compared (volume/frame_of_reference.h).
ALTER TABLE users ADD COLUMN frame_key uuid NOT NULL DEFAULT gen_random_uuid();
-- NULL: unknown, as for scans that an older ingestd built.
ALTER TABLE data_sets ADD COLUMN frame_of_reference text CHECK (frame_of_reference ~ '^[0-9a-f]{64}$');
