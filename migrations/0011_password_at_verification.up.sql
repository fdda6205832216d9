-- Users choose their password when they open the emailed link (docs/adr/0034), so an unconfirmed account has none. Someone
-- who chose a password at sign-up might not own the address.
ALTER TABLE users ALTER COLUMN password_hash SET DEFAULT '';
UPDATE users SET password_hash = '' WHERE verified_at IS NULL;
ALTER TABLE users ADD CONSTRAINT users_password_check CHECK (verified_at IS NULL OR password_hash <> '');
