-- Consent to the processing of health data: the version of the privacy notice, and the time. Existing accounts have none,
-- and their users are asked at the next sign-in.
ALTER TABLE users
  ADD COLUMN consent_version text CHECK (consent_version ~ '^[a-z0-9_.-]{1,40}$'),
  ADD COLUMN consent_at timestamptz,
  ADD CONSTRAINT users_consent_check CHECK ((consent_version IS NULL) = (consent_at IS NULL));
