-- The consent to the processing of health data: the version of the privacy notice, and when it was given. Accounts from
-- before have none and are asked at their next sign-in.
ALTER TABLE users
  ADD COLUMN consent_version text CHECK (consent_version ~ '^[a-z0-9_.-]{1,40}$'),
  ADD COLUMN consent_at timestamptz,
  ADD CONSTRAINT users_consent_check CHECK ((consent_version IS NULL) = (consent_at IS NULL));
