-- Panoramas that users light scans with. The picture is a file of the volume store, environments/<id>.hdr.
CREATE TABLE environments (
  id         uuid PRIMARY KEY,
  owner_id   uuid NOT NULL REFERENCES users ON DELETE CASCADE,
  name       text NOT NULL CHECK (length(name) BETWEEN 1 AND 60),
  content    text NOT NULL CHECK (content ~ '^[0-9a-f]{64}$'),   -- BLAKE2b of the uploaded file; an account stores it once
  preview    text NOT NULL CHECK (length(preview) <= 3072),      -- 32 x 16 pixels in sRGB, in hexadecimal
  bytes      bigint NOT NULL CHECK (bytes > 0),
  created_at timestamptz NOT NULL,
  UNIQUE (owner_id, content)
);

ALTER TABLE disposals DROP CONSTRAINT disposals_kind_check;
ALTER TABLE disposals ADD CONSTRAINT disposals_kind_check
  CHECK (kind IN ('upload', 'volume', 'export', 'pictures', 'preset', 'environment'));

-- Schedules the file for deletion in the same transaction, also when the account is deleted.
CREATE FUNCTION environment_gone() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  INSERT INTO disposals (kind, id) VALUES ('environment', OLD.id) ON CONFLICT DO NOTHING;
  RETURN NULL;
END $$;
CREATE TRIGGER environment_gone AFTER DELETE ON environments FOR EACH ROW EXECUTE FUNCTION environment_gone();
