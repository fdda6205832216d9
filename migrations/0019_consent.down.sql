ALTER TABLE users DROP CONSTRAINT users_consent_check, DROP COLUMN consent_at, DROP COLUMN consent_version;
