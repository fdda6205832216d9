-- Two-factor authentication: TOTP secrets (RFC 6238), and recovery codes for users who lost their device.
CREATE TABLE second_factors (
  user_id        uuid PRIMARY KEY REFERENCES users ON DELETE CASCADE,
  sealed_secret  text NOT NULL,                     -- XChaCha20-Poly1305 under a key that is not in the database, hexadecimal
  begun_at       timestamptz NOT NULL,
  confirmed_at   timestamptz,                       -- NULL: not confirmed with a code yet, so not in effect
  last_step      bigint NOT NULL DEFAULT 0          -- TOTP time step of the newest accepted code; earlier codes are rejected
);

-- Each code has 120 random bits, so its BLAKE2b-256 hash is enough, as for every token. Using a code deletes its row.
CREATE TABLE recovery_codes (
  user_id    uuid NOT NULL REFERENCES users ON DELETE CASCADE,
  code_hash  text NOT NULL,
  PRIMARY KEY (user_id, code_hash)
);
