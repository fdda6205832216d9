ALTER TABLE users DROP CONSTRAINT users_password_check;
ALTER TABLE users ALTER COLUMN password_hash DROP DEFAULT;
