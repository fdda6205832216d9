DROP TABLE recordings;
ALTER TABLE users DROP COLUMN recording_consent_at;
