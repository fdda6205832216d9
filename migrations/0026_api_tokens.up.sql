-- API tokens, with which programs use an account. The token itself has 256 random bits, so its BLAKE2b-256 hash is enough.
CREATE TABLE api_tokens (
  id          uuid PRIMARY KEY,
  user_id     uuid NOT NULL REFERENCES users ON DELETE CASCADE,
  token_hash  text NOT NULL UNIQUE,
  name        text NOT NULL CHECK (length(name) BETWEEN 1 AND 60),
  scopes      text NOT NULL CHECK (scopes ~ '^(read|write|share)( (read|write|share)){0,2}$'),   -- separated by spaces, as in OAuth
  created_at  timestamptz NOT NULL,
  expires_at  timestamptz NOT NULL,                 -- 'epoch' for a revoked token, whose row remains until its streams have ended
  used_at     timestamptz                           -- NULL: never; updated every ten minutes
);
CREATE INDEX api_tokens_user ON api_tokens (user_id);
CREATE INDEX api_tokens_expiry ON api_tokens (expires_at);
