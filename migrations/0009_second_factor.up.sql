-- The second factor of an account: one-time codes by time (RFC 6238), and recovery codes for when their device is lost.
CREATE TABLE second_factors (
  user_id        uuid PRIMARY KEY REFERENCES users ON DELETE CASCADE,
  sealed_secret  text NOT NULL,                     -- XChaCha20-Poly1305 under a key that is not in the database, hexadecimal
  begun_at       timestamptz NOT NULL,
  confirmed_at   timestamptz,                       -- NULL: shown, and no code of it was given yet; it counts for nothing
  last_step      bigint NOT NULL DEFAULT 0          -- 30 s each since 1970: of the newest code that was taken; none up to it is again
);

-- 120 random bits each, so BLAKE2b-256 in hexadecimal is enough, as for every token. A row goes when its code is used.
CREATE TABLE recovery_codes (
  user_id    uuid NOT NULL REFERENCES users ON DELETE CASCADE,
  code_hash  text NOT NULL,
  PRIMARY KEY (user_id, code_hash)
);
