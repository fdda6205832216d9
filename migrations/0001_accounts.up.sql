-- Accounts, emailed tokens, and browser sessions. Only the BLAKE2b-256 hash of a token is stored, in hexadecimal.
CREATE TABLE users (
  id             uuid PRIMARY KEY,
  email          text NOT NULL CHECK (length(email) BETWEEN 3 AND 254),
  email_key      text NOT NULL UNIQUE,          -- in lower case, so that an address has one account
  password_hash  text NOT NULL,                 -- argon2id, encoded form
  verified_at    timestamptz,
  created_at     timestamptz NOT NULL DEFAULT now(),
  quota_bytes    bigint NOT NULL DEFAULT 21474836480 CHECK (quota_bytes >= 0)
);

CREATE TABLE email_tokens (
  token_hash  text PRIMARY KEY,
  user_id     uuid NOT NULL REFERENCES users ON DELETE CASCADE,
  purpose     text NOT NULL CHECK (purpose IN ('verify')),
  expires_at  timestamptz NOT NULL
);
CREATE INDEX email_tokens_user ON email_tokens (user_id);

CREATE TABLE web_sessions (
  token_hash   text PRIMARY KEY,
  user_id      uuid NOT NULL REFERENCES users ON DELETE CASCADE,
  csrf_token   text NOT NULL,
  created_at   timestamptz NOT NULL DEFAULT now(),
  expires_at   timestamptz NOT NULL
);
CREATE INDEX web_sessions_user ON web_sessions (user_id);
CREATE INDEX web_sessions_expiry ON web_sessions (expires_at);

-- Counters for rate limits: failed sign-ins per account and per address, sign-ups per address, emails per recipient.
CREATE TABLE attempts (
  key_hash     text NOT NULL,                   -- BLAKE2b-256 of the kind and the counted value ("account:..."), hexadecimal
  happened_at  timestamptz NOT NULL
);
CREATE INDEX attempts_key ON attempts (key_hash, happened_at);
CREATE INDEX attempts_age ON attempts (happened_at);

-- Outgoing emails. api sends them after the transaction that created them has committed.
CREATE TABLE mail_queue (
  id          bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  recipient   text NOT NULL,
  subject     text NOT NULL,
  body        text NOT NULL,
  attempts    int NOT NULL DEFAULT 0,
  not_before  timestamptz NOT NULL DEFAULT now()
);
CREATE INDEX mail_queue_due ON mail_queue (not_before, id);

-- Results of requests with an Idempotency-Key. A repeated request returns the same resource.
CREATE TABLE idempotency_keys (
  user_id      uuid NOT NULL REFERENCES users ON DELETE CASCADE,
  route        text NOT NULL,
  key          text NOT NULL CHECK (length(key) BETWEEN 1 AND 128),
  request_hash text NOT NULL,
  created_id   uuid NOT NULL,
  created_at   timestamptz NOT NULL,
  PRIMARY KEY (user_id, route, key)
);
CREATE INDEX idempotency_keys_age ON idempotency_keys (created_at);
