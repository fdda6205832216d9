-- The password is chosen when the mailed link is opened (docs/adr/0034), so an unconfirmed account has none. Whoever typed
-- one at sign-up may not be the owner of the address.
ALTER TABLE users ALTER COLUMN password_hash SET DEFAULT '';
UPDATE users SET password_hash = '' WHERE verified_at IS NULL;
ALTER TABLE users ADD CONSTRAINT users_password_check CHECK (verified_at IS NULL OR password_hash <> '');
